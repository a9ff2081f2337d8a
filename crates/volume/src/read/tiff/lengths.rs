//! Units of length as programs of microscopes spell them.

/// Millimeters in a unit of length, in the spellings of ImageJ, OME and MetaMorph.
pub(super) fn mm_per(unit: &str) -> Option<f64> {
    Some(match unit {
        "m" | "meter" | "metre" => 1e3,
        "cm" => 10.0,
        "mm" => 1.0,
        "micron" | "microns" | "micrometer" | "um" | "\u{b5}m" | "\u{3bc}m" | "\\u00B5m"
        | "\\u00b5m" | "&#181;m" | "&#xB5;m" | "&#xb5;m" => 1e-3,
        "nm" | "nanometer" => 1e-6,
        "pm" => 1e-9,
        "\u{c5}" | "\u{212b}" | "angstrom" => 1e-7,
        "inch" | "in" => 25.4,
        _ => return None,
    })
}
