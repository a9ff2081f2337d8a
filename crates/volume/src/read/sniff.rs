//! Which kind of file it is, by its first bytes. What a file begins with counts before what stands further in, which
//! may be samples.
//!
//! | kind      | offset | bytes                                                              |
//! |-----------|--------|--------------------------------------------------------------------|
//! | gzip      | 0      | 1F 8B                                                              |
//! | bzip2     | 0      | `BZh`                                                              |
//! | NIfTI-1   | 0, 344 | i32 348 in either byte order, `n+1\0` or `ni1\0`                   |
//! | NIfTI-2   | 0, 4   | i32 540 in either byte order, `n+2\0` or `ni2\0`                   |
//! | Analyze   | 0, 40  | i32 348, i16 1 to 7 in the same byte order (weak: name decides)    |
//! | NRRD      | 0      | `NRRD000`                                                          |
//! | MetaImage | 0      | text, first key one of the format's, with `=`                      |
//! | DICOM     | 128    | `DICM`                                                             |
//! | DICOM     | 0      | an element of group 0002 or 0008 (no preamble; weak: name decides) |
//! | TIFF      | 0      | `II` 2A 00, `MM` 00 2A; BigTIFF `II` 2B 00, `MM` 00 2B             |
//! | PNG       | 0      | 89 `PNG\r\n` 1A `\n`                                               |
//! | BMP       | 0      | `BM`, and a known length of the header at 14                       |
//! | JPEG      | 0      | FF D8 FF                                                           |
//! | npy       | 0      | 93 `NUMPY`                                                         |
//! | PVM       | 0      | `PVM\n`, `PVM2\n`, `PVM3\n`, `DDS v3d\n`, `DDS v3e\n`              |
//! | .dat      | 0      | text, a key of the format with `:` in one of the first lines       |
//! | npz       | 0      | `PK` 03 04 (and arrays in it)                                      |
//! | VTK       | 0      | `# vtk DataFile`; XML: `<VTKFile` among the first bytes            |
//! | MRC       | 208    | `MAP `                                                             |
//! | MGH       | 0      | i32 1, lengths, a type and a flag that make sense, big endian      |

use super::foreign::{self, Foreign};
use super::header_lines::BYTE_ORDER_MARK;
use super::mgh;
use super::{Bytes, block::Encoding};
use crate::error::Error;

/// How many first bytes decide.
pub(crate) const HEAD_BYTES: usize = 1024;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A whole file packed with gzip or bzip2.
    Packed(Encoding),
    Nifti,
    /// Begins like Analyze 7.5, but so may raw samples.
    MaybeAnalyze,
    Nrrd,
    MetaImage,
    Dicom,
    /// Begins like DICOM without its preamble, but so may raw samples.
    MaybeDicom,
    Tiff,
    Png,
    Bmp,
    Jpeg,
    Npy,
    Pvm,
    Dat,
    Mgh,
    /// VTK's legacy files.
    Vtk,
    /// VTK's files in XML.
    Vti,
    Mrc,
    /// A ZIP archive, which may hold arrays of NumPy.
    Zip,
    /// Known, but not a volume that can be read.
    Foreign(Foreign),
}

impl Kind {
    /// Whether one file of this kind is a whole volume, or its header.
    pub(crate) fn is_volume(&self) -> bool {
        matches!(
            self,
            Kind::Nifti
                | Kind::Nrrd
                | Kind::MetaImage
                | Kind::Npy
                | Kind::Pvm
                | Kind::Dat
                | Kind::Mgh
                | Kind::Vtk
                | Kind::Vti
                | Kind::Mrc
        )
    }
}

/// The kind of a file, if its content shows it.
///
/// # Errors
/// What the system says.
pub(crate) fn kind(bytes: &dyn Bytes) -> Result<Option<Kind>, Error> {
    let mut head = [0; HEAD_BYTES];
    let head = &mut head[..bytes.len().min(HEAD_BYTES as u64) as usize];
    bytes.read_at(0, head)?;
    Ok(kind_of(head))
}

fn kind_of(head: &[u8]) -> Option<Kind> {
    if let Some(text) = head.strip_prefix(BYTE_ORDER_MARK) {
        let is_text = |kind: &Kind| matches!(kind, Kind::Nrrd | Kind::MetaImage | Kind::Dat);
        return kind_of(text).filter(is_text);
    }
    let begins = |magic: &[u8]| head.starts_with(magic);
    let at = |offset: usize, magic: &[u8]| head.get(offset..).is_some_and(|h| h.starts_with(magic));
    let header_size = head
        .first_chunk()
        .map(|&b| (i32::from_le_bytes(b), i32::from_be_bytes(b)));
    let has_size = |size| header_size.is_some_and(|(le, be)| le == size || be == size);

    let at_most_7_axes = |number: fn([u8; 2]) -> i16| {
        let axes = head.get(40..).and_then(|h| h.first_chunk());
        axes.is_some_and(|&axes| (1..=7).contains(&number(axes)))
    };

    if begins(&[0x1f, 0x8b]) {
        Some(Kind::Packed(Encoding::Gzip))
    } else if begins(b"BZh") {
        Some(Kind::Packed(Encoding::Bzip2))
    } else if (has_size(348) && (at(344, b"n+1\0") || at(344, b"ni1\0")))
        || (has_size(540) && (at(4, b"n+2\0") || at(4, b"ni2\0")))
    {
        Some(Kind::Nifti)
    } else if begins(b"NRRD000") {
        Some(Kind::Nrrd)
    } else if begins(b"\x89PNG\r\n\x1a\n") {
        Some(Kind::Png)
    } else if begins(b"\x93NUMPY") {
        Some(Kind::Npy)
    } else if [
        &b"PVM\n"[..],
        b"PVM2\n",
        b"PVM3\n",
        b"DDS v3d\n",
        b"DDS v3e\n",
    ]
    .iter()
    .any(|m| begins(m))
    {
        Some(Kind::Pvm)
    } else if at(128, b"DICM") && begins_with_dicom_element(&head[132..]) {
        // Its preamble may be the head of a TIFF file (PS3.10, section 7.1).
        Some(Kind::Dicom)
    } else if [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"]
        .iter()
        .any(|m| begins(*m))
    {
        Some(Kind::Tiff)
    } else if let Some(found) = foreign::of_bytes(head) {
        Some(Kind::Foreign(found))
    } else if begins(b"PK\x03\x04") {
        Some(Kind::Zip)
    } else if begins(b"\xff\xd8\xff") {
        Some(Kind::Jpeg)
    } else if begins(b"BM")
        && matches!(
            head.get(14..18),
            Some([12 | 40 | 56 | 64 | 108 | 124, 0, 0, 0])
        )
    {
        Some(Kind::Bmp)
    } else if begins(b"# vtk DataFile") {
        Some(Kind::Vtk)
    } else if at(128, b"DICM") {
        Some(Kind::Dicom)
    } else if head.windows(8).any(|word| word == b"<VTKFile") {
        Some(Kind::Vti)
    } else if at(208, b"MAP ") || at(208, b"MAP\0") {
        Some(Kind::Mrc)
    } else if let Some(kind) = text_kind(head) {
        Some(kind)
    } else if (at(0, &348i32.to_le_bytes()) && at_most_7_axes(i16::from_le_bytes))
        || (at(0, &348i32.to_be_bytes()) && at_most_7_axes(i16::from_be_bytes))
    {
        Some(Kind::MaybeAnalyze)
    } else if mgh::begins_like_mgh(head) {
        Some(Kind::Mgh)
    } else if begins_with_dicom_element(head) {
        Some(Kind::MaybeDicom)
    } else {
        None
    }
}

/// MetaImage and `.dat` headers: `Key = value` and `Key: value` lines.
fn text_kind(head: &[u8]) -> Option<Kind> {
    const META: [&str; 14] = [
        "objecttype",
        "objectsubtype",
        "transformtype",
        "ndims",
        "name",
        "id",
        "comment",
        "binarydata",
        "compresseddata",
        "dimsize",
        "elementtype",
        "elementspacing",
        "elementdatafile",
        "transformmatrix",
    ];
    const DAT: [&str; 6] = [
        "objectfilename",
        "taggedfilename",
        "resolution",
        "slicethickness",
        "format",
        "objectmodel",
    ];
    for line in head.split(|&c| c == b'\n').take(16) {
        let line = std::str::from_utf8(line).ok()?.trim();
        let Some(end) = line.find(['=', ':']) else {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            return None;
        };
        let key = line[..end].trim().to_ascii_lowercase();
        if line[end..].starts_with('=') {
            return META.contains(&key.as_str()).then_some(Kind::MetaImage);
        }
        if DAT.contains(&key.as_str()) {
            return Some(Kind::Dat);
        }
    }
    None
}

/// An element of group 0002 or 0008, little endian: tag, then VR and 16-bit length (explicit) or a
/// 32-bit length (implicit).
fn begins_with_dicom_element(head: &[u8]) -> bool {
    let Some(&[group, 0, element, high, a, b, c, d]) = head.first_chunk::<8>() else {
        return false;
    };
    let explicit = a.is_ascii_uppercase() && b.is_ascii_uppercase();
    let implicit = b == 0 && c == 0 && d == 0 && a % 2 == 0 && a > 0;
    match group {
        2 => high == 0 && element <= 0x18 && explicit,
        8 => high == 0 && element <= 0x70 && (explicit || implicit),
        _ => false,
    }
}

/// The first bytes in words, for a file that nobody knows.
///
/// # Errors
/// What the system says.
pub(crate) fn describe(bytes: &dyn Bytes) -> Result<String, Error> {
    if bytes.is_empty() {
        return Ok("the file is empty".into());
    }
    let mut head = [0; 16];
    let head = &mut head[..bytes.len().min(16) as usize];
    bytes.read_at(0, head)?;
    Ok(format!(
        "it begins with the bytes `{}`; samples without a header need their dimensions and type",
        head.escape_ascii()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(at: &[(usize, &[u8])]) -> Vec<u8> {
        let mut head = vec![0; 600];
        for &(offset, magic) in at {
            head.splice(offset..offset + <[u8]>::len(magic), magic.iter().copied());
        }
        head
    }

    #[test]
    fn every_kind_is_known_by_its_bytes() {
        let text = |s: &str| s.as_bytes().to_vec();
        let cases: Vec<(Vec<u8>, Option<Kind>)> = vec![
            (with(&[(0, &[0x5c, 1]), (344, b"n+1\0")]), Some(Kind::Nifti)),
            (
                with(&[(0, &[0, 0, 1, 0x5c]), (344, b"ni1\0")]),
                Some(Kind::Nifti),
            ),
            (
                with(&[(0, &[0x1c, 2]), (4, b"n+2\0\r\n\x1a\n")]),
                Some(Kind::Nifti),
            ),
            (
                with(&[(0, &[0, 0, 2, 0x1c]), (4, b"ni2\0\r\n\x1a\n")]),
                Some(Kind::Nifti),
            ),
            (
                with(&[(0, &[0x5c, 1]), (40, &[4, 0])]),
                Some(Kind::MaybeAnalyze),
            ),
            (
                with(&[(0, &[0, 0, 1, 0x5c]), (40, &[0, 3])]),
                Some(Kind::MaybeAnalyze),
            ),
            (with(&[(0, &[0x5c, 1]), (40, &[0, 3])]), None),
            (
                with(&[(0, b"\x1f\x8b\x08")]),
                Some(Kind::Packed(Encoding::Gzip)),
            ),
            (with(&[(0, b"BZh9")]), Some(Kind::Packed(Encoding::Bzip2))),
            (text("NRRD0005\n"), Some(Kind::Nrrd)),
            (text("ObjectType = Image\n"), Some(Kind::MetaImage)),
            (text("NDims=3\r\nDimSize = 1 2 3"), Some(Kind::MetaImage)),
            (text("ObjectFileName: a.raw\n"), Some(Kind::Dat)),
            (text("\nResolution:\t1 2 3\n"), Some(Kind::Dat)),
            (with(&[(128, b"DICM")]), Some(Kind::Dicom)),
            (
                with(&[(0, b"\x08\0\x05\0CS\x0a\0")]),
                Some(Kind::MaybeDicom),
            ),
            (
                with(&[(0, b"\x08\0\x05\0\x0a\0\0\0")]),
                Some(Kind::MaybeDicom),
            ),
            // The preamble of DICOM may hold anything; samples may hold DICM.
            (
                with(&[(0, b"\x93NUMPY\x01"), (128, b"DICM")]),
                Some(Kind::Npy),
            ),
            (with(&[(0, b"II*\0"), (128, b"DICM")]), Some(Kind::Tiff)),
            (
                with(&[(0, b"II*\0"), (128, b"DICM\x02\0\0\0UL\x04\0")]),
                Some(Kind::Dicom),
            ),
            (with(&[(0, b"hello"), (128, b"DICM")]), Some(Kind::Dicom)),
            (with(&[(0, b"II*\0")]), Some(Kind::Tiff)),
            (with(&[(0, b"MM\0+")]), Some(Kind::Tiff)),
            (with(&[(0, b"\x89PNG\r\n\x1a\n")]), Some(Kind::Png)),
            (with(&[(0, b"\x93NUMPY\x01")]), Some(Kind::Npy)),
            (text("PVM3\n1 2 3"), Some(Kind::Pvm)),
            (text("DDS v3e\n"), Some(Kind::Pvm)),
            (with(&[]), None),
            (vec![], None),
            (text("key = value\n"), None),
            (text("hello"), None),
            (text("\u{feff}ObjectType = Image\n"), Some(Kind::MetaImage)),
            (text("\u{feff}NRRD0004\n"), Some(Kind::Nrrd)),
            (text("\u{feff}hello"), None),
        ];
        for (head, kind) in cases {
            assert_eq!(kind_of(&head), kind, "{}", head.escape_ascii());
        }
    }
}
