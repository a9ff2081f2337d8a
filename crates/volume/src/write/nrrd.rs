//! NRRD: header and samples in one file; the header is described at the reader.

use super::WriteOptions;
use super::format::Format;
use super::raw::{self, Packing};
use super::voxels::Voxels;
use crate::error::Error;
use crate::{Modality, SampleType};
use std::fmt::Write as _;
use std::io::Write;

pub(crate) fn write(
    voxels: &Voxels,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<(), Error> {
    out.write_all(header(voxels, options).as_bytes())?;
    let packing = if options.compress {
        Packing::Gzip
    } else {
        Packing::None
    };
    raw::write_values(voxels, packing, out)
}

fn header(voxels: &Voxels, options: &WriteOptions) -> String {
    let volume = voxels.first;
    let sample_type = match raw::value_type_of(voxels.all) {
        SampleType::U8 => "uint8",
        SampleType::I8 => "int8",
        SampleType::U16 => "uint16",
        SampleType::I16 => "int16",
        SampleType::U32 => "uint32",
        SampleType::I32 => "int32",
        SampleType::F32 => "float",
        SampleType::F64 => "double",
    };
    let metadata = volume.metadata();
    let [nx, ny, nz] = volume.grid().dims();
    let affine = volume.grid().world_from_voxel();
    let vector = |v: glam::DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let m = affine.matrix3;

    let mut header = String::from("NRRD0004\n");
    let mut line = |text: std::fmt::Arguments| {
        // Writing to a string cannot fail.
        let _ = writeln!(header, "{text}");
    };
    line(format_args!("type: {sample_type}"));
    // The axis of the numbers of a voxel, which is the fastest, if there are several.
    let (dimension, size, direction, kind) =
        match (voxels.all.len(), Format::Nrrd.keeps_colors(voxels.all)) {
            (1, _) => (3, String::new(), "", ""),
            (3, true) => (4, "3 ".to_owned(), "none ", "RGB-color "),
            (4, true) => (4, "4 ".to_owned(), "none ", "RGBA-color "),
            (count, _) => (4, format!("{count} "), "none ", "vector "),
        };
    line(format_args!("dimension: {dimension}"));
    line(format_args!("space: right-anterior-superior"));
    line(format_args!("sizes: {size}{nx} {ny} {nz}"));
    line(format_args!(
        "space directions: {direction}{} {} {}",
        vector(m.x_axis),
        vector(m.y_axis),
        vector(m.z_axis)
    ));
    line(format_args!("kinds: {kind}domain domain domain"));
    if metadata.has_length_unit {
        line(format_args!("space units: \"mm\" \"mm\" \"mm\""));
    }
    line(format_args!("space origin: {}", vector(affine.translation)));
    line(format_args!("endian: little"));
    let encoding = if options.compress { "gzip" } else { "raw" };
    line(format_args!("encoding: {encoding}"));
    if let Some(unit) = &metadata.value_unit {
        line(format_args!(
            "sample units: \"{}\"",
            one_line(unit).replace('"', "")
        ));
    }
    let modality = metadata.modality.and_then(|modality| match modality {
        Modality::Ct => Some("CT"),
        Modality::Mr => Some("MR"),
        Modality::Nuclear => Some("PT"),
        Modality::Ultrasound => Some("US"),
        Modality::Microscopy | Modality::Simulation => None,
    });
    if let Some(code) = modality {
        line(format_args!("modality:={code}"));
    }
    for (key, value) in &metadata.entries {
        let is_own = key.eq_ignore_ascii_case("modality") || key.starts_with("Segment");
        // pynrrd takes a key that is called like a field for the field.
        let prefix = if is_field(key) { "header " } else { "" };
        // A key with a colon could be taken for a field, one with `#` for a comment.
        if !(is_own || key.is_empty() || key.contains(':') || key.starts_with('#')) {
            line(format_args!("{prefix}{}:={}", escaped(key), escaped(value)));
        }
    }
    for (n, label) in options.labels.iter().flatten().enumerate() {
        line(format_args!("Segment{n}_ID:=Segment_{}", label.id));
        line(format_args!("Segment{n}_Name:={}", escaped(&label.name)));
        line(format_args!("Segment{n}_LabelValue:={}", label.id));
        line(format_args!("Segment{n}_Layer:=0"));
        if let Some([r, g, b]) = label.color {
            line(format_args!("Segment{n}_Color:={r} {g} {b}"));
        }
    }
    header.push('\n');
    header
}

/// Whether a field of the format has this name, which is compared without case and blanks.
fn is_field(key: &str) -> bool {
    const FIELDS: [&str; 33] = [
        "type",
        "blocksize",
        "dimension",
        "space",
        "spacedimension",
        "sizes",
        "spacedirections",
        "kinds",
        "endian",
        "encoding",
        "min",
        "max",
        "oldmin",
        "oldmax",
        "content",
        "sampleunits",
        "datafile",
        "lineskip",
        "byteskip",
        "number",
        "spacings",
        "thicknesses",
        "axismins",
        "axismaxs",
        "centers",
        "centerings",
        "labels",
        "units",
        "spaceunits",
        "spaceorigin",
        "measurementframe",
        "date",
        "comment",
    ];
    let name: String = key.split([' ', '_']).collect();
    FIELDS.contains(&name.to_ascii_lowercase().as_str())
}

fn escaped(text: &str) -> String {
    one_line(&text.replace('\\', "\\\\").replace('\n', "\\n"))
}

/// Without what would end the line, and the ends of which readers would trim.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r', '\0'], " ")
}
