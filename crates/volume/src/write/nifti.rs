//! NIfTI in one file, little endian; the header is described at the reader.
//!
//! The affine goes into the sform, which holds any; into the qform too if it is a rotation with
//! spacings, for programs that look there first. NIfTI-1 has f32 for both and for the rescale, so
//! about seven digits are kept. NIfTI-2 (f64) is written only where NIfTI-1 has no room, because
//! fewer programs read it.

use super::WriteOptions;
use super::format::Format;
use super::raw::{self, Packing};
use super::voxels::Voxels;
use crate::error::Error;
use crate::{SampleType, Volume};
use glam::{DMat3, DQuat};
use std::io::Write;

pub(crate) fn write(
    voxels: &Voxels,
    options: &WriteOptions,
    compress: bool,
    out: &mut dyn Write,
) -> Result<(), Error> {
    let numbers = Numbers::of(voxels);
    let header = header(voxels.first, options, numbers);
    let packing = if compress {
        Packing::Gzip
    } else {
        Packing::None
    };
    raw::packed(packing, out, &mut |out| {
        out.write_all(&header)?;
        match numbers {
            Numbers::Colors(_) => raw::side_by_side(voxels, out),
            Numbers::Vector(_) => voxels.all.iter().try_for_each(|one| raw::stored(one, out)),
        }
    })
}

/// How many numbers a voxel has, and how they lie.
#[derive(Clone, Copy)]
enum Numbers {
    /// Red, green, blue and perhaps opacity, side by side in 8 bits each.
    Colors(usize),
    /// One volume behind the other.
    Vector(usize),
}

impl Numbers {
    fn of(voxels: &Voxels) -> Numbers {
        let count = voxels.all.len();
        match Format::Nifti.keeps_colors(voxels.all) {
            true => Numbers::Colors(count),
            false => Numbers::Vector(count),
        }
    }
}

const INTENT_LABEL: i16 = 1002;
const INTENT_VECTOR: i16 = 1007;

/// The header with the four bytes after it that say that there is no extension.
fn header(volume: &Volume, options: &WriteOptions, numbers: Numbers) -> Vec<u8> {
    let grid = volume.grid();
    let dims = grid.dims();
    let rescale = volume.rescale();
    let affine = grid.world_from_voxel();
    let fits = |v: f64| (v as f32).is_finite() && (v == 0.0 || v as f32 != 0.0);
    let vector_length = match numbers {
        Numbers::Vector(length) => length,
        Numbers::Colors(_) => 1,
    };
    let fits_i16 = |n: &usize| *n <= i16::MAX as usize;
    let is_small = dims.iter().chain([&vector_length]).all(fits_i16)
        && fits(rescale.slope)
        && (rescale.intercept as f32).is_finite()
        && affine
            .to_cols_array()
            .iter()
            .all(|&v| (v as f32).is_finite())
        && grid.spacing_mm().to_array().iter().all(|&v| fits(v));

    let (qform, qfac) = quaternion(affine.matrix3);
    let metadata = volume.metadata();
    let entry = |key: &str| {
        let found = metadata.entries.iter().find(|(k, _)| k == key);
        found.map_or("", |(_, value)| value.as_str())
    };
    let code: i16 = match entry("space") {
        "scanner" => 1,
        "Talairach" => 3,
        "MNI 152" => 4,
        "template" => 5,
        _ => 2,
    };
    let (datatype, bits): (i16, i16) = match volume.sample_type() {
        SampleType::U8 => match numbers {
            Numbers::Colors(3) => (128, 24),
            Numbers::Colors(_) => (2304, 32),
            Numbers::Vector(_) => (2, 8),
        },
        SampleType::I8 => (256, 8),
        SampleType::U16 => (512, 16),
        SampleType::I16 => (4, 16),
        SampleType::U32 => (768, 32),
        SampleType::I32 => (8, 32),
        SampleType::F32 => (16, 32),
        SampleType::F64 => (64, 64),
    };
    let fields = Fields {
        dim: [
            if vector_length > 1 { 5 } else { 3 },
            dims[0] as i64,
            dims[1] as i64,
            dims[2] as i64,
            1,
            vector_length as i64,
            1,
            1,
        ],
        intent_code: match vector_length {
            1 if options.labels.is_some() => INTENT_LABEL,
            1 => 0,
            _ => INTENT_VECTOR,
        },
        datatype,
        bits,
        pixdim: {
            let s = grid.spacing_mm();
            [qfac, s.x, s.y, s.z, 1.0, 1.0, 1.0, 1.0]
        },
        rescale: [rescale.slope, rescale.intercept],
        units: if metadata.has_length_unit { 2 } else { 0 },
        descrip: entry("description"),
        qform_code: if qform.is_some() { code } else { 0 },
        sform_code: code,
        quatern: qform.map_or([0.0; 3], |q| [q.x, q.y, q.z]),
        qoffset: affine.translation.to_array(),
        srow: {
            let (m, t) = (affine.matrix3.transpose(), affine.translation);
            [(m.x_axis, t.x), (m.y_axis, t.y), (m.z_axis, t.z)]
                .map(|(row, t)| [row.x, row.y, row.z, t])
        },
    };
    if is_small {
        fields.nifti1()
    } else {
        fields.nifti2()
    }
}

/// The rotation in an affine, if it is nothing but that, spacings and a mirrored last axis (−1).
fn quaternion(matrix: DMat3) -> (Option<DQuat>, f64) {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.normalize());
    let qfac = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
    let skew = x.dot(y).abs().max(x.dot(z).abs()).max(y.dot(z).abs());
    if skew > 1e-6 {
        return (None, qfac);
    }
    let q = DQuat::from_mat3(&DMat3::from_cols(x, y, z * qfac)).normalize();
    // Only the vector part is stored, so the scalar part must not be negative.
    (Some(if q.w < 0.0 { -q } else { q }), qfac)
}

/// What both versions store.
struct Fields<'a> {
    dim: [i64; 8],
    intent_code: i16,
    datatype: i16,
    bits: i16,
    pixdim: [f64; 8],
    rescale: [f64; 2],
    units: u8,
    descrip: &'a str,
    qform_code: i16,
    sform_code: i16,
    quatern: [f64; 3],
    qoffset: [f64; 3],
    srow: [[f64; 4]; 3],
}

/// A header under construction.
struct Head(Vec<u8>);

impl Head {
    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn f32s(&mut self, at: usize, values: &[f64]) {
        for (i, &value) in values.iter().enumerate() {
            self.put(at + 4 * i, &(value as f32).to_le_bytes());
        }
    }

    fn f64s(&mut self, at: usize, values: &[f64]) {
        for (i, &value) in values.iter().enumerate() {
            self.put(at + 8 * i, &value.to_le_bytes());
        }
    }

    /// At most `length` − 1 bytes of text, cut between characters.
    fn text(&mut self, at: usize, length: usize, text: &str) {
        let end = (0..length.min(text.len() + 1))
            .rev()
            .find(|&end| text.is_char_boundary(end))
            .unwrap_or(0);
        self.put(at, &text.as_bytes()[..end]);
    }
}

impl Fields<'_> {
    fn nifti1(&self) -> Vec<u8> {
        let mut head = Head(vec![0; 352]);
        head.put(0, &348i32.to_le_bytes());
        head.put(38, b"r");
        for (i, &length) in self.dim.iter().enumerate() {
            head.put(40 + 2 * i, &(length as i16).to_le_bytes());
        }
        head.put(68, &self.intent_code.to_le_bytes());
        head.put(70, &self.datatype.to_le_bytes());
        head.put(72, &self.bits.to_le_bytes());
        head.f32s(76, &self.pixdim);
        head.f32s(108, &[352.0]);
        head.f32s(112, &self.rescale);
        head.put(123, &[self.units]);
        head.text(148, 80, self.descrip);
        head.put(252, &self.qform_code.to_le_bytes());
        head.put(254, &self.sform_code.to_le_bytes());
        head.f32s(256, &self.quatern);
        head.f32s(268, &self.qoffset);
        head.f32s(280, self.srow.as_flattened());
        head.put(344, b"n+1\0");
        head.0
    }

    fn nifti2(&self) -> Vec<u8> {
        let mut head = Head(vec![0; 544]);
        head.put(0, &540i32.to_le_bytes());
        head.put(4, b"n+2\0\r\n\x1a\n");
        head.put(12, &self.datatype.to_le_bytes());
        head.put(14, &self.bits.to_le_bytes());
        for (i, &length) in self.dim.iter().enumerate() {
            head.put(16 + 8 * i, &length.to_le_bytes());
        }
        head.f64s(104, &self.pixdim);
        head.put(168, &544i64.to_le_bytes());
        head.f64s(176, &self.rescale);
        head.text(240, 80, self.descrip);
        head.put(344, &i32::from(self.qform_code).to_le_bytes());
        head.put(348, &i32::from(self.sform_code).to_le_bytes());
        head.f64s(352, &self.quatern);
        head.f64s(376, &self.qoffset);
        head.f64s(400, self.srow.as_flattened());
        head.put(500, &i32::from(self.units).to_le_bytes());
        head.put(504, &i32::from(self.intent_code).to_le_bytes());
        head.0
    }
}
