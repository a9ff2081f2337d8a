//! Transfer syntaxes: how elements and pixels are encoded.

use crate::error::{Error, ErrorKind};

/// Names of transfer syntaxes (PS3.6, annex A).
mod uids {
    pub const IMPLICIT_VR_LITTLE_ENDIAN: &str = "1.2.840.10008.1.2";
    pub const EXPLICIT_VR_LITTLE_ENDIAN: &str = "1.2.840.10008.1.2.1";
    pub const ENCAPSULATED_UNCOMPRESSED_EXPLICIT_VR_LITTLE_ENDIAN: &str = "1.2.840.10008.1.2.1.98";
    pub const DEFLATED_EXPLICIT_VR_LITTLE_ENDIAN: &str = "1.2.840.10008.1.2.1.99";
    pub const JPEG_BASELINE8_BIT: &str = "1.2.840.10008.1.2.4.50";
    pub const JPEG_EXTENDED12_BIT: &str = "1.2.840.10008.1.2.4.51";
    pub const JPEG_LOSSLESS: &str = "1.2.840.10008.1.2.4.57";
    pub const JPEG_LOSSLESS_SV1: &str = "1.2.840.10008.1.2.4.70";
    pub const JPEGLS_LOSSLESS: &str = "1.2.840.10008.1.2.4.80";
    pub const JPEGLS_NEAR_LOSSLESS: &str = "1.2.840.10008.1.2.4.81";
    pub const JPEG2000_LOSSLESS: &str = "1.2.840.10008.1.2.4.90";
    pub const JPEG2000: &str = "1.2.840.10008.1.2.4.91";
    pub const RLE_LOSSLESS: &str = "1.2.840.10008.1.2.5";
}

/// How the pixels of a frame are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    /// Not at all; in fragments or in one piece.
    Native,
    /// Run lengths of byte planes (PS3.5, annex G).
    Rle,
    /// JPEG: baseline, extended, lossless.
    Jpeg,
    /// JPEG-LS, lossless and near-lossless.
    JpegLs,
    /// JPEG 2000.
    Jpeg2000,
}

/// A transfer syntax.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Syntax {
    pub(super) is_explicit: bool,
    pub(super) is_big_endian: bool,
    /// The data set behind the meta elements is deflated as a whole.
    pub(super) is_deflated: bool,
    /// The pixels lie in fragments.
    pub(super) is_encapsulated: bool,
    pub(super) packing: Packing,
}

impl Syntax {
    pub(super) fn implicit_little_endian() -> Syntax {
        Syntax {
            is_explicit: false,
            ..Syntax::explicit_little_endian()
        }
    }

    pub(super) fn explicit_little_endian() -> Syntax {
        Syntax {
            is_explicit: true,
            is_big_endian: false,
            is_deflated: false,
            is_encapsulated: false,
            packing: Packing::Native,
        }
    }

    /// The syntax with this UID.
    ///
    /// # Errors
    /// One that is not read, with what to do instead.
    pub(super) fn of(uid: &str) -> Result<Syntax, Error> {
        let native = Syntax::explicit_little_endian();
        let packed = |packing| Syntax {
            is_encapsulated: true,
            packing,
            ..native
        };
        Ok(match uid {
            uids::IMPLICIT_VR_LITTLE_ENDIAN => Syntax::implicit_little_endian(),
            uids::EXPLICIT_VR_LITTLE_ENDIAN => native,
            EXPLICIT_VR_BIG_ENDIAN => Syntax {
                is_big_endian: true,
                ..native
            },
            uids::DEFLATED_EXPLICIT_VR_LITTLE_ENDIAN => Syntax {
                is_deflated: true,
                ..native
            },
            uids::ENCAPSULATED_UNCOMPRESSED_EXPLICIT_VR_LITTLE_ENDIAN => packed(Packing::Native),
            uids::RLE_LOSSLESS => packed(Packing::Rle),
            uids::JPEG_BASELINE8_BIT
            | uids::JPEG_EXTENDED12_BIT
            | uids::JPEG_LOSSLESS
            | uids::JPEG_LOSSLESS_SV1 => packed(Packing::Jpeg),
            uids::JPEGLS_LOSSLESS | uids::JPEGLS_NEAR_LOSSLESS => packed(Packing::JpegLs),
            uids::JPEG2000_LOSSLESS | uids::JPEG2000 => packed(Packing::Jpeg2000),
            _ => {
                let (name, instead) = unread(uid);
                return Err(ErrorKind::Unsupported {
                    feature: format!("the transfer syntax {name}{uid}"),
                    instead: instead.into(),
                }
                .into());
            }
        })
    }
}

/// Retired from the standard, but not from the archives.
const EXPLICIT_VR_BIG_ENDIAN: &str = "1.2.840.10008.1.2.2";

/// What to do with a file whose pixels are packed in a way that is not read.
pub(super) const CONVERT: &str = "convert the files to an uncompressed syntax first, for example with `gdcmconv --raw IN OUT` or `dcmdjpeg IN OUT`";

/// What a syntax is called that is not read, and which program decodes it.
fn unread(uid: &str) -> (&'static str, &'static str) {
    const PYDICOM: &str = "decode the files with pydicom and pylibjpeg-openjpeg: `ds = pydicom.dcmread(IN); ds.decompress(); ds.save_as(OUT)`";
    const VIDEO: &str = "a video is no volume; `ffmpeg` decodes it to pictures";
    match uid.strip_prefix("1.2.840.10008.1.2.4.") {
        Some("110" | "111" | "112") => ("JPEG XL ", "ask the archive for another transfer syntax"),
        Some("201" | "202" | "203") => ("High-Throughput JPEG 2000 ", PYDICOM),
        Some("92" | "93") => ("JPEG 2000 of several components ", CONVERT),
        Some(video) if video.starts_with("10") => ("video ", VIDEO),
        _ => ("", CONVERT),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn syntaxes_that_are_not_read_are_named_with_what_decodes_them() {
        for (uid, name, tool) in [
            (
                "1.2.840.10008.1.2.4.201",
                "High-Throughput JPEG 2000",
                "pylibjpeg-openjpeg",
            ),
            (
                "1.2.840.10008.1.2.4.110",
                "JPEG XL",
                "another transfer syntax",
            ),
            ("1.2.840.10008.1.2.4.102", "video", "ffmpeg"),
            (
                "1.2.840.10008.1.2.4.54",
                "1.2.840.10008.1.2.4.54",
                "gdcmconv",
            ),
        ] {
            let message = Syntax::of(uid).unwrap_err().to_string();
            assert!(
                message.contains(name) && message.contains(tool),
                "{message}"
            );
            assert!(message.contains(uid), "{message}");
        }
    }
}
