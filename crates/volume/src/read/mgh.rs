//! FreeSurfer volumes: `.mgh`, and `.mgz`, which is the same packed with gzip. All numbers are big endian.
//!
//! | offset | type    | what                                                                     |
//! |--------|---------|--------------------------------------------------------------------------|
//! | 0      | i32     | version, 1                                                               |
//! | 4      | i32 × 3 | voxels along x, y, z                                                     |
//! | 16     | i32     | number of frames                                                         |
//! | 20     | i32     | type: 0 u8, 1 i32, 3 f32, 4 i16, 10 u16                                  |
//! | 24     | i32     | degrees of freedom                                                       |
//! | 28     | i16     | whether the place that follows is known                                  |
//! | 30     | f32 × 3 | distances of voxels in mm                                                |
//! | 42     | f32 × 9 | directions of the grid's axes x, y, z in RAS                             |
//! | 78     | f32 × 3 | RAS of the voxel at half of the lengths                                  |
//! | 284    | …       | samples, x fastest, frame after frame; what follows them is left alone   |
//!
//! Where the place is not known, voxels are 1 mm apart and the volume is coronal about the origin, as in FreeSurfer.

use super::block::{Block, Endian};
use super::{Input, LoadedVolume, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Rescale, SampleType, Volume};
use glam::{DAffine3, DMat3, DVec3};

const HEADER_BYTES: u64 = 284;

/// Whether a file begins like this format: it has no magic but a version, so its numbers have to make sense.
pub(crate) fn begins_like_mgh(head: &[u8]) -> bool {
    let number = |at: usize| {
        let bytes = head.get(at..).and_then(|bytes| bytes.first_chunk());
        bytes.map(|bytes| i32::from_be_bytes(*bytes))
    };
    let is_length = |at: usize| number(at).is_some_and(|n| (1..=1 << 20).contains(&n));
    number(0) == Some(1)
        && (4..20).step_by(4).all(is_length)
        && number(20).is_some_and(|kind| sample_type(kind).is_some())
        && matches!(head.get(28..30), Some([0, 0 | 1]))
}

fn sample_type(kind: i32) -> Option<SampleType> {
    Some(match kind {
        0 => SampleType::U8,
        1 => SampleType::I32,
        3 => SampleType::F32,
        4 => SampleType::I16,
        10 => SampleType::U16,
        _ => return None,
    })
}

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let mut head = [0; 90];
    if input.bytes.len() < HEADER_BYTES {
        return Err(ErrorKind::Truncated {
            what: "the header".into(),
            expected: HEADER_BYTES,
            found: input.bytes.len(),
        }
        .into());
    }
    input.bytes.read_at(0, &mut head)?;
    let integer =
        |at: usize| i32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let real = |at: usize| f64::from(f32::from_bits(integer(at) as u32));
    let vector = |at: usize| DVec3::new(real(at), real(at + 4), real(at + 8));
    let length = |at: usize, name: &str| {
        let found = integer(at);
        let length = usize::try_from(found).ok().filter(|n| *n > 0);
        length.ok_or_else(|| Error::field(name, found, "1 or more"))
    };
    let dims = [
        length(4, "width")?,
        length(8, "height")?,
        length(12, "depth")?,
    ];
    let time_points = length(16, "nframes")?;
    let kind = integer(20);
    let sample_type = sample_type(kind).ok_or_else(|| {
        Error::field(
            "type",
            kind,
            "0 (u8), 1 (i32), 3 (f32), 4 (i16) or 10 (u16)",
        )
    })?;
    let mut notes = Vec::new();
    let is_placed = head[29] != 0;
    let (spacing, directions, middle) = match is_placed {
        true => (
            vector(30),
            DMat3::from_cols(vector(42), vector(54), vector(66)),
            vector(78),
        ),
        false => {
            notes.push(
                "the file has no position; it is read as coronal with voxels of 1 mm, as in FreeSurfer"
                    .into(),
            );
            (
                DVec3::ONE,
                DMat3::from_cols(-DVec3::X, -DVec3::Z, DVec3::Y),
                DVec3::ZERO,
            )
        }
    };
    let matrix = directions * DMat3::from_diagonal(spacing);
    let half = DVec3::from(dims.map(|n| n as f64)) / 2.0;
    let grid = Grid::new(
        dims,
        DAffine3::from_mat3_translation(matrix, middle - matrix * half),
    )?;
    if options.time_index >= time_points {
        return Err(Error::field(
            "time point",
            options.time_index,
            match time_points {
                1 => "0: the file holds a single volume".to_owned(),
                n => format!("0 to {}", n - 1),
            },
        ));
    }
    let count = grid.voxel_count();
    let skipped = (count as u64)
        .checked_mul(sample_type.size() as u64)
        .and_then(|bytes| bytes.checked_mul(options.time_index as u64))
        .and_then(|bytes| bytes.checked_add(HEADER_BYTES))
        .ok_or_else(|| Error::field("nframes", time_points, "fewer frames"))?;
    let block = Block {
        endian: Endian::Big,
        ..Block::raw(input.bytes, skipped)
    };
    let volume = Volume::new(
        grid,
        block.read(sample_type, count)?,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "FreeSurfer MGH".into(),
            has_length_unit: is_placed,
            time_points,
            time_index: options.time_index,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}
