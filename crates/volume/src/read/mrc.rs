//! MRC and CCP4 maps (MRC2014): electron microscopy and crystallography.
//!
//! | offset | type    | what                                                                          |
//! |--------|---------|-------------------------------------------------------------------------------|
//! | 0      | i32 × 3 | columns, rows, sections                                                       |
//! | 12     | i32     | type: 0 i8, 1 i16, 2 f32, 6 u16, 12 half float; complex and 4 bits are refused |
//! | 16     | i32 × 3 | where the first column, row and section lie, in steps of the cell             |
//! | 28     | i32 × 3 | steps along the cell's axes x, y, z                                           |
//! | 40     | f32 × 3 | lengths of the cell in Ångström                                               |
//! | 52     | f32 × 3 | its angles in degrees                                                         |
//! | 64     | i32 × 3 | which axis columns, rows and sections follow: 1 x, 2 y, 3 z                   |
//! | 88     | i32     | space group; 0 for a stack of pictures, from 401 on for a stack of volumes    |
//! | 92     | i32     | bytes of an extended header behind these 1024                                 |
//! | 152    | i32 × 2 | `IMOD` and its flags: without bit 0, type 0 is unsigned                       |
//! | 196    | f32 × 3 | place of the origin in Ångström, instead of the steps at 16                   |
//! | 208    | text    | `MAP `                                                                        |
//! | 212    | u8 × 2  | byte order: 44 little, 11 big endian                                          |
//!
//! Axes x, y, z are taken as left, back, up (LPS), as for other files that do not say where a patient is.

use super::block::{Block, Endian};
use super::stored::Stored;
use super::{Input, LoadedVolume, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Modality, Rescale, SampleType, Volume};
use glam::{DAffine3, DMat3, DVec3};

const HEADER_BYTES: usize = 1024;
const MM_PER_ANGSTROM: f64 = 1e-7;

struct Header {
    bytes: Vec<u8>,
    endian: Endian,
}

impl Header {
    fn integer(&self, at: usize) -> i32 {
        let bytes = [0, 1, 2, 3].map(|i| self.bytes[at + i]);
        match self.endian {
            Endian::Little => i32::from_le_bytes(bytes),
            Endian::Big => i32::from_be_bytes(bytes),
        }
    }

    fn integers(&self, at: usize) -> [i32; 3] {
        [0, 4, 8].map(|i| self.integer(at + i))
    }

    fn reals(&self, at: usize) -> [f64; 3] {
        self.integers(at)
            .map(|bits| f64::from(f32::from_bits(bits as u32)))
    }

    fn stored(&self) -> Result<Stored, Error> {
        let is_unsigned = &self.bytes[152..156] == b"IMOD" && self.integer(156) & 1 == 0
            || &self.bytes[152..156] == b"DOMI" && self.integer(156) & 1 == 0;
        Ok(match self.integer(12) {
            0 if is_unsigned => Stored::Kept(SampleType::U8),
            0 => Stored::Kept(SampleType::I8),
            1 => Stored::Kept(SampleType::I16),
            2 => Stored::Kept(SampleType::F32),
            6 => Stored::Kept(SampleType::U16),
            12 => Stored::F16,
            mode => {
                return Err(Error::field(
                    "MODE",
                    mode,
                    "0 (i8), 1 (i16), 2 (f32), 6 (u16) or 12 (half float); complex maps and 4 bits are not read",
                ));
            }
        })
    }

    /// Which of x, y, z columns, rows and sections follow.
    fn axes(&self, notes: &mut Vec<String>) -> [usize; 3] {
        let said = self.integers(64);
        let mut sorted = said;
        sorted.sort_unstable();
        if sorted == [1, 2, 3] {
            return said.map(|axis| axis as usize - 1);
        }
        notes.push(format!(
            "MAPC, MAPR and MAPS are {said:?}; x, y, z are taken"
        ));
        [0, 1, 2]
    }

    /// Voxels in LPS Ångström, from the indices of columns, rows and sections.
    fn place(&self, notes: &mut Vec<String>) -> (DMat3, DVec3) {
        let axes = self.axes(notes);
        let (steps, lengths, angles) = (self.integers(28), self.reals(40), self.reals(52));
        let mut edge = [1.0; 3];
        for axis in 0..3 {
            let step = lengths[axis] / f64::from(steps[axis]);
            if steps[axis] > 0 && step > 0.0 && step.is_finite() {
                edge[axis] = step;
            } else {
                notes.push(format!(
                    "the cell has no voxel distance along {}; 1 Å is used",
                    ["x", "y", "z"][axis]
                ));
            }
        }
        let is_angle = |angle: &f64| *angle > 0.0 && *angle < 180.0;
        let [alpha, beta, gamma] = match angles.iter().all(is_angle) {
            true => angles.map(|angle| {
                if angle == 90.0 {
                    0.0
                } else {
                    angle.to_radians().cos()
                }
            }),
            false => [0.0; 3],
        };
        // The cell's axes: a along x, b in the plane of x and y.
        let sine = (1.0 - gamma * gamma).sqrt();
        let y = (alpha - beta * gamma) / sine;
        let cell = [
            DVec3::X * edge[0],
            DVec3::new(gamma, sine, 0.0) * edge[1],
            DVec3::new(beta, y, (1.0 - beta * beta - y * y).max(0.0).sqrt()) * edge[2],
        ];
        let matrix = DMat3::from_cols(cell[axes[0]], cell[axes[1]], cell[axes[2]]);
        let origin = DVec3::from(self.reals(196));
        let start = DVec3::from(self.integers(16).map(f64::from));
        let origin = match origin != DVec3::ZERO && origin.is_finite() {
            true => origin,
            false => matrix * start,
        };
        (matrix, origin)
    }
}

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let mut bytes = vec![0; HEADER_BYTES];
    if input.bytes.len() < HEADER_BYTES as u64 {
        return Err(ErrorKind::Truncated {
            what: "the header".into(),
            expected: HEADER_BYTES as u64,
            found: input.bytes.len(),
        }
        .into());
    }
    input.bytes.read_at(0, &mut bytes)?;
    let mut notes = Vec::new();
    let mut header = Header {
        endian: match bytes[212] {
            0x11 => Endian::Big,
            _ => Endian::Little,
        },
        bytes,
    };
    // Some writers leave the byte order out; the type tells.
    if header.bytes[212] == 0 && !(0..256).contains(&header.integer(12)) {
        header.endian = Endian::Big;
    }
    let stored = header.stored()?;
    let [columns, rows, sections] = header.integers(0);
    let length = |name: &str, n: i32| {
        let length = usize::try_from(n).ok().filter(|n| *n > 0);
        length.ok_or_else(|| Error::field(name, n, "1 or more"))
    };
    let mut dims = [
        length("NX", columns)?,
        length("NY", rows)?,
        length("NZ", sections)?,
    ];
    let mut time_points = 1;
    let volumes = header.integer(36).max(0) as usize;
    match header.integer(88) {
        401.. if volumes > 0 && dims[2].is_multiple_of(volumes) => {
            (time_points, dims[2]) = (dims[2] / volumes, volumes);
        }
        0 if dims[2] > 1 && volumes == 1 => {
            notes.push("the file is marked as a stack of pictures; they are read as slices".into());
        }
        _ => {}
    }
    let (mut matrix, mut origin) = header.place(&mut notes);
    matrix *= MM_PER_ANGSTROM;
    origin *= MM_PER_ANGSTROM;
    if let Some(spacing) = options.spacing_mm {
        let unit = |column: DVec3| column.normalize_or_zero();
        matrix = DMat3::from_cols(
            unit(matrix.x_axis),
            unit(matrix.y_axis),
            unit(matrix.z_axis),
        ) * DMat3::from_diagonal(spacing.into());
    }
    let ras_from_lps = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    let place = DAffine3::from_mat3_translation(ras_from_lps * matrix, ras_from_lps * origin);
    let grid = Grid::new(dims, place)?;
    if options.time_index >= time_points {
        return Err(Error::field(
            "time point",
            options.time_index,
            format!("0 to {}", time_points - 1),
        ));
    }
    let count = grid.voxel_count();
    let extended = header.integer(92);
    let start = u64::try_from(extended)
        .map_err(|_| Error::field("NSYMBT", extended, "0 or more"))?
        .saturating_add(HEADER_BYTES as u64);
    let block = Block {
        endian: header.endian,
        skip: (count as u64)
            .saturating_mul(stored.bits().size() as u64)
            .saturating_mul(options.time_index as u64),
        ..Block::raw(input.bytes, start)
    };
    let samples =
        stored.kept_of_bits(block.read(stored.bits(), count)?, input.bytes, &mut notes)?;
    let volume = Volume::new(
        grid,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "MRC".into(),
            modality: Some(Modality::Microscopy),
            has_length_unit: true,
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
