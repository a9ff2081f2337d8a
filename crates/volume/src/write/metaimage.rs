//! MetaImage, in one file or two; the header is described at the reader.

use super::WriteOptions;
use super::raw::{self, Packing};
use super::voxels::Voxels;
use crate::error::Error;
use crate::{Modality, SampleType};
use std::fmt::Write as _;
use std::io::Write;

/// Header and samples in one file.
pub(crate) fn write(
    voxels: &Voxels,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<(), Error> {
    if !options.compress {
        out.write_all(header(voxels, options, "LOCAL", None).as_bytes())?;
        return write_samples(voxels, options, out);
    }
    // ITK finds packed samples behind their header only if it says how many bytes they take.
    let mut packed = Vec::new();
    write_samples(voxels, options, &mut packed)?;
    out.write_all(header(voxels, options, "LOCAL", Some(packed.len())).as_bytes())?;
    Ok(out.write_all(&packed)?)
}

/// The header, up to the line break after the name of the file that holds the samples, which are
/// packed into `packed_bytes` if known.
pub(crate) fn header(
    voxels: &Voxels,
    options: &WriteOptions,
    data_file: &str,
    packed_bytes: Option<usize>,
) -> String {
    let volume = voxels.first;
    let element_type = match raw::value_type_of(voxels.all) {
        SampleType::U8 => "MET_UCHAR",
        SampleType::I8 => "MET_CHAR",
        SampleType::U16 => "MET_USHORT",
        SampleType::I16 => "MET_SHORT",
        SampleType::U32 => "MET_UINT",
        SampleType::I32 => "MET_INT",
        SampleType::F32 => "MET_FLOAT",
        SampleType::F64 => "MET_DOUBLE",
    };
    let [nx, ny, nz] = volume.grid().dims();
    let affine = volume.grid().world_from_voxel();
    let spacing = volume.grid().spacing_mm();
    let m = affine.matrix3;
    // MetaImage is in LPS; −0 would be written as such.
    let flip = |v: glam::DVec3| glam::DVec3::new(0.0 - v.x, 0.0 - v.y, v.z);
    let numbers = |v: glam::DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let direction = |axis: glam::DVec3, length: f64| numbers(flip(axis) / length);
    let modality = match volume.metadata().modality {
        Some(Modality::Ct) => "MET_MOD_CT",
        Some(Modality::Mr) => "MET_MOD_MR",
        Some(Modality::Nuclear) => "MET_MOD_NM",
        Some(Modality::Ultrasound) => "MET_MOD_US",
        _ => "MET_MOD_UNKNOWN",
    };
    let is_packed = if options.compress { "True" } else { "False" };

    let mut header = String::new();
    let mut line = |key: &str, value: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(header, "{key} = {value}");
    };
    line("ObjectType", "Image");
    line("NDims", "3");
    line("BinaryData", "True");
    line("BinaryDataByteOrderMSB", "False");
    line("CompressedData", is_packed);
    if let Some(bytes) = packed_bytes {
        line("CompressedDataSize", &bytes.to_string());
    }
    line(
        "TransformMatrix",
        &format!(
            "{} {} {}",
            direction(m.x_axis, spacing.x),
            direction(m.y_axis, spacing.y),
            direction(m.z_axis, spacing.z)
        ),
    );
    line("Offset", &numbers(flip(affine.translation)));
    line("CenterOfRotation", "0 0 0");
    line("ElementSpacing", &numbers(spacing));
    line("DimSize", &format!("{nx} {ny} {nz}"));
    line("Modality", modality);
    if voxels.all.len() > 1 {
        line("ElementNumberOfChannels", &voxels.all.len().to_string());
    }
    line("ElementType", element_type);
    line("ElementDataFile", data_file);
    header
}

pub(crate) fn write_samples(
    voxels: &Voxels,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<(), Error> {
    let packing = if options.compress {
        Packing::Zlib
    } else {
        Packing::None
    };
    raw::write_values(voxels, packing, out)
}
