//! Formats that are known and not read: what they are called, and which program converts them.

/// A format that is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Foreign {
    /// What it is.
    pub(crate) what: &'static str,
    /// What to do.
    pub(crate) instead: &'static str,
}

const BIO_FORMATS: &str =
    "convert it with Bio-Formats, for example `bfconvert IN OUT.ome.tif`, or in Fiji";
const AFNI: Foreign = Foreign {
    what: "an AFNI volume (.HEAD and .BRIK)",
    instead: "convert it with AFNI's `3dAFNItoNIFTI NAME+orig`",
};
const PAR_REC: Foreign = Foreign {
    what: "a Philips PAR/REC volume",
    instead: "convert it with `dcm2niix FILE.PAR` or nibabel's `parrec2nii FILE.PAR`",
};

/// By the first bytes of a file.
const BY_BYTES: &[(usize, &[u8], Foreign)] = &[
    (
        0,
        b"\x28\xb5\x2f\xfd",
        of("a file packed with zstd", "unpack it first"),
    ),
    (
        0,
        b"\xfd7zXZ\0",
        of("a file packed with xz", "unpack it first"),
    ),
    (
        0,
        b"\x89HDF\r\n\x1a\n",
        of(
            "an HDF5 file (MINC-2, NetCDF-4, Imaris, …)",
            "convert MINC with `mnc2nii IN OUT.nii`, others with h5py or Fiji to NIfTI, NRRD or TIFF",
        ),
    ),
    (0, b"CDF\x01", MINC_1),
    (0, b"CDF\x02", MINC_1),
    (
        0,
        b"mrtrix image",
        of(
            "an MRtrix image (.mif)",
            "convert it with `mrconvert IN.mif OUT.nii.gz`",
        ),
    ),
    (
        0,
        b"mrtrix tracks",
        of("MRtrix tracks", "lines are no volume"),
    ),
    (0, b"ZISRAWFILE", of("a Zeiss CZI file", BIO_FORMATS)),
    (0, b"\xda\xce\xbe\x0a", of("a Nikon ND2 file", BIO_FORMATS)),
    (0, b"\xff\x0a", JPEG_XL),
    (0, b"\0\0\0\x0cJXL \r\n\x87\n", JPEG_XL),
    (0, b"\0\0\0\x0cjP  \r\n\x87\n", JPEG_2000),
    (0, b"\xff\x4f\xff\x51", JPEG_2000),
    (
        0,
        b"MATRIX7",
        of(
            "an ECAT 7 volume",
            "convert it with `dcm2niix FILE` or nibabel",
        ),
    ),
    (0, b"!INTERFILE", INTERFILE),
    (0, b"# === DATA DESCRIPTION FILE", PAR_REC),
    (0, b"GIF8", of("a GIF picture", "convert it to PNG slices")),
];

const fn of(what: &'static str, instead: &'static str) -> Foreign {
    Foreign { what, instead }
}

const MINC_1: Foreign = of(
    "a MINC-1 volume (NetCDF)",
    "convert it with `mnc2nii IN.mnc OUT.nii`, or nibabel",
);
const JPEG_XL: Foreign = of("a JPEG XL picture", "convert it with `djxl IN.jxl OUT.png`");
const JPEG_2000: Foreign = of(
    "a JPEG 2000 picture",
    "convert it with `opj_decompress -i IN -o OUT.tif`",
);
const INTERFILE: Foreign = of(
    "an Interfile volume",
    "convert it with (X)MedCon, for example `medcon -f IN.hv -c nifti`",
);

/// By the first bytes of a file.
pub(crate) fn of_bytes(head: &[u8]) -> Option<Foreign> {
    let at = |offset: usize, magic: &[u8]| head.get(offset..).is_some_and(|h| h.starts_with(magic));
    // Leica: a block of XML of two bytes a letter.
    if at(0, b"\x70\0\0\0") && at(8, b"\x2a") {
        return Some(of("a Leica LIF file", BIO_FORMATS));
    }
    let text = head.trim_ascii_start();
    if text.starts_with(b"type") && head.windows(10).any(|word| word == b"-attribute") {
        return Some(AFNI);
    }
    BY_BYTES
        .iter()
        .find(|(offset, magic, _)| at(*offset, magic))
        .map(|(_, _, foreign)| *foreign)
}

/// By the ending of a name, for files whose bytes say nothing.
pub(crate) fn of_name(name: &str) -> Option<Foreign> {
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let ends = |ending: &str| name.ends_with(ending);
    Some(match name {
        _ if ends(".brik") || ends(".head") => AFNI,
        _ if ends(".rec") || ends(".par") => PAR_REC,
        _ if ends(".mif") || ends(".mih") => of(
            "an MRtrix image (.mif)",
            "convert it with `mrconvert IN.mif OUT.nii.gz`",
        ),
        _ if ends(".hv") || ends(".hs") => INTERFILE,
        _ if ends("2dseq") => of(
            "a Bruker ParaVision volume",
            "convert it with `brkraw tonii FOLDER`, or export DICOM",
        ),
        _ if ends(".lsm") || ends(".oib") || ends(".oif") || ends(".ims") || ends(".lif") => {
            of("a microscope's own format", BIO_FORMATS)
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_named_with_what_converts_them() {
        for (head, what, tool) in [
            (&b"CDF\x01\0\0"[..], "MINC-1", "mnc2nii"),
            (b"mrtrix image\ndim: 1,2,3", "MRtrix", "mrconvert"),
            (b"ZISRAWFILE\0\0", "CZI", "bfconvert"),
            (b"\xda\xce\xbe\x0a", "ND2", "bfconvert"),
            (b"\x70\0\0\0\x10\0\0\0\x2a", "LIF", "bfconvert"),
            (b"\xff\x0a", "JPEG XL", "djxl"),
            (
                b"\ntype  = string-attribute\nname  = TYPESTRING",
                "AFNI",
                "3dAFNItoNIFTI",
            ),
            (b"# === DATA DESCRIPTION FILE ======", "PAR/REC", "dcm2niix"),
        ] {
            let found = of_bytes(head).unwrap();
            assert!(
                found.what.contains(what) && found.instead.contains(tool),
                "{found:?}"
            );
        }
        assert_eq!(of_bytes(b"hello"), None);
        assert_eq!(of_name("v+orig.BRIK.gz"), Some(AFNI));
        assert_eq!(of_name("v.rec"), Some(PAR_REC));
        assert_eq!(of_name("v.raw"), None);
    }
}
