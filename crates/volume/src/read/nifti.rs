//! NIfTI-1, NIfTI-2 and the Analyze 7.5 they grew from: `.nii`, `.nii.gz`, and `.hdr` with `.img`.
//!
//! Numbers are in the byte order that makes the header size right. Offsets in bytes:
//!
//! | field               | NIfTI-1       | NIfTI-2       | taken as                                       |
//! |---------------------|---------------|---------------|------------------------------------------------|
//! | `sizeof_hdr`        | 0 i32 = 348   | 0 i32 = 540   | version and byte order                         |
//! | `magic`             | 344 [4]       | 4 [8]         | `n+1`, `n+2`: one file; `ni1`, `ni2`: a pair   |
//! | `dim[8]`            | 40 i16        | 16 i64        | number of dimensions, then their lengths       |
//! | `intent_code`       | 68 i16        | 504 i32       | 1002: label ids                                |
//! | `datatype`          | 70 i16        | 12 i16        | sample type                                    |
//! | `pixdim[8]`         | 76 f32        | 104 f64       | qfac, then spacings                            |
//! | `vox_offset`        | 108 f32       | 168 i64       | position of the first sample                   |
//! | `scl_slope`, `_inter` | 112 f32     | 176 f64       | value = slope · stored + inter                 |
//! | `xyzt_units`        | 123 u8        | 500 i32       | bits 0–2: 1 m, 2 mm, 3 µm                      |
//! | `descrip`           | 148 [80]      | 240 [80]      | free text                                      |
//! | `qform_code`, `sform_code` | 252 i16 | 344 i32      | what the affines mean; 0: not set              |
//! | `quatern_b`, `c`, `d` | 256 f32     | 352 f64       | rotation                                       |
//! | `qoffset_x`, `y`, `z` | 268 f32     | 376 f64       | translation                                    |
//! | `srow_x[4]`, `y`, `z` | 280 f32     | 400 f64       | first three rows of the affine                 |
//! | `intent_name`       | 328 [16]      | 508 [16]      | free text                                      |
//!
//! Analyze 7.5 is NIfTI-1 without magic, with `originator` (253, 3 × i16, voxel of the origin
//! counted from 1, as SPM writes it) in place of the affines.
//!
//! Tables of labels stand in extensions behind the header.
//!
//! Which affine counts: the sform if `sform_code` is not 0, else the qform if `qform_code` is not 0,
//! else the spacings about the center of the grid with x to the left, which is what nibabel does.

mod extensions;

use super::block::{self, Block, Encoding, Endian, Trailing};
use super::components::{self, Choice, Meaning};
use super::stored::Stored;
use super::{Bytes, Input, LoadedVolume, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Rescale, SampleType, Volume, voxel_count};
use glam::{DAffine3, DMat3, DVec3};

/// The magic that says that the numbers are ids of objects.
const INTENT_LABEL: i64 = 1002;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let (head_encoding, head) = header_bytes(input.bytes)?;
    let mut header = Header::parse(&head)?;
    let lower = input.name.to_ascii_lowercase();
    if header.version == Version::Analyze && (lower.ends_with(".nii") || lower.ends_with(".nii.gz"))
    {
        // Analyze has no single files, so the magic of NIfTI is damaged.
        return Err(Error::field(
            "magic",
            format!("`{}`", head[344..348].escape_ascii()),
            "`n+1\\0` or `ni1\\0`",
        ));
    }
    let mut notes = std::mem::take(&mut header.notes);

    let [nx, ny, nz, time_points] = header.lengths()?;
    let stored = header.sample_type()?;
    let grid = Grid::new([nx, ny, nz], header.world_from_voxel(&mut notes)?)?;
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
    // Colors lie side by side, vectors one volume behind the other.
    let (side_by_side, behind) = (header.colors(), header.vector_length()?);
    let (numbers, meaning) = match side_by_side {
        1 => (behind, Meaning::Vector),
        n => (n * behind, Meaning::Color),
    };
    if side_by_side > 1 && behind > 1 {
        return Err(Error::field("dim[5]", behind, "1 for colors"));
    }
    let choice = components::choice(numbers, meaning, options, &mut notes)?;
    let count = components::total(grid.voxel_count(), side_by_side)?;
    let earlier = match choice {
        Choice::One(component) if behind > 1 => component as u64 * time_points as u64,
        _ => 0,
    };
    let too_large = || Error::field("dim", format!("{:?}", header.dim), "fewer samples");
    let frame_bytes = (count as u64)
        .checked_mul(stored.bits().size() as u64)
        .ok_or_else(too_large)?;
    let skip = frame_bytes
        .checked_mul(options.time_index as u64 + earlier)
        .and_then(|skip| skip.checked_add(header.vox_offset))
        .ok_or_else(too_large)?;

    let samples_in = |bytes, encoding| {
        let (offset, skip) = match encoding {
            Encoding::Raw => (skip, 0),
            _ => (0, skip),
        };
        Block {
            bytes,
            offset,
            encoding,
            skip,
            endian: header.endian,
            // The standard does not forbid it and tools pad.
            trailing: Trailing::Ignored,
        }
        .read(stored.bits(), count)
    };
    let samples = if header.single_file {
        samples_in(input.bytes, head_encoding)?
    } else {
        let name = image_of_header(input)?;
        let in_file = |error: Error| error.in_file(&name);
        let bytes = input.files.open(&name).map_err(|e| in_file(e.into()))?;
        let mut magic = [0; 2];
        let is_gzip = bytes.len() >= 2 && {
            bytes
                .read_at(0, &mut magic)
                .map_err(|e| in_file(e.into()))?;
            magic == [0x1f, 0x8b] && name.to_ascii_lowercase().ends_with(".gz")
        };
        let encoding = if is_gzip {
            Encoding::Gzip
        } else {
            Encoding::Raw
        };
        samples_in(&*bytes, encoding).map_err(in_file)?
    };

    let samples = stored.kept_of_bits(samples, input.bytes, &mut notes)?;
    let samples = components::reduced(samples, side_by_side, choice);

    if header.intercept_is_broken() {
        notes.push(format!(
            "scl_inter is {}, which is not a number to add; 0 is taken",
            header.scl_inter
        ));
    }
    let labels = extensions::labels(
        header.extensions().as_ref(),
        header.intent_code == INTENT_LABEL,
        input.bytes,
        head_encoding,
        options.time_index,
        &mut notes,
    )?;
    let metadata = Metadata {
        components: meaning.of(numbers),
        ..header.metadata(input.name, time_points, options.time_index)
    };
    if header.scl_slope.is_infinite() {
        notes.push(format!(
            "scl_slope is {}; values are the stored numbers",
            header.scl_slope
        ));
    }
    let rescale = Rescale::new(header.scl_slope, header.scl_inter);
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, rescale, metadata)?,
        labels,
        notes,
    })
}

/// The name of a file beside the input: `stem` with `suffix`, in lower or upper case.
pub(crate) fn sibling(input: &Input, stem: &str, suffix: &str) -> Option<String> {
    let names = input.files.names();
    [suffix.to_owned(), suffix.to_ascii_uppercase()]
        .iter()
        .map(|suffix| format!("{stem}{suffix}"))
        .find(|name| names.contains(name))
}

fn image_of_header(input: &Input) -> Result<String, Error> {
    let lower = input.name.to_ascii_lowercase();
    let stem = [".hdr.gz", ".hdr", ".nii.gz", ".nii"]
        .iter()
        .find(|suffix| lower.ends_with(*suffix))
        .map_or(input.name, |suffix| {
            &input.name[..input.name.len() - suffix.len()]
        });
    sibling(input, stem, ".img")
        .or_else(|| sibling(input, stem, ".img.gz"))
        .ok_or_else(|| {
            ErrorKind::Missing {
                field: format!("the data file {stem}.img"),
                allowed: "the header refers to a file of that name beside it for the samples"
                    .into(),
            }
            .into()
        })
}

/// The first bytes, unpacked if need be.
fn header_bytes(bytes: &dyn Bytes) -> Result<(Encoding, Vec<u8>), Error> {
    let raw = block::head(bytes, 0, Encoding::Raw, Header::LONGEST)?;
    if raw.starts_with(&[0x1f, 0x8b]) {
        Ok((
            Encoding::Gzip,
            block::head(bytes, 0, Encoding::Gzip, Header::LONGEST)?,
        ))
    } else {
        Ok((Encoding::Raw, raw))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Analyze,
    Nifti1,
    Nifti2,
}

/// The header with the numbers of all versions as the widest type.
struct Header {
    version: Version,
    endian: Endian,
    single_file: bool,
    dim: [i64; 8],
    intent_code: i64,
    datatype: i64,
    pixdim: [f64; 8],
    vox_offset: u64,
    scl_slope: f64,
    scl_inter: f64,
    xyzt_units: i64,
    descrip: String,
    qform_code: i64,
    sform_code: i64,
    quatern: [f64; 3],
    qoffset: [f64; 3],
    srow: [[f64; 4]; 3],
    intent_name: String,
    /// Analyze: the voxel of the origin, from 1.
    originator: [f64; 3],
    notes: Vec<String>,
}

/// Numbers at positions in the header's byte order. The header is long enough for all of them.
struct Fields<'a> {
    head: &'a [u8],
    endian: Endian,
}

impl Fields<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut bytes: [u8; N] = self.head[at..at + N]
            .try_into()
            .expect("a slice of N bytes");
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    }

    fn i16(&self, at: usize) -> i64 {
        i16::from_le_bytes(self.bytes(at)).into()
    }

    fn i32(&self, at: usize) -> i64 {
        i32::from_le_bytes(self.bytes(at)).into()
    }

    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.bytes(at))
    }

    fn f32(&self, at: usize) -> f64 {
        f32::from_le_bytes(self.bytes(at)).into()
    }

    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.bytes(at))
    }

    fn text(&self, at: usize, length: usize) -> String {
        let bytes = &self.head[at..at + length];
        let end = bytes.iter().position(|&c| c == 0).unwrap_or(length);
        String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
    }
}

impl Header {
    const LONGEST: usize = 540;

    fn extensions(&self) -> Option<extensions::Place> {
        let start = match self.version {
            Version::Analyze => return None,
            Version::Nifti1 => 348,
            Version::Nifti2 => 540,
        };
        let end = match self.single_file {
            true => self.vox_offset,
            false => u64::MAX,
        };
        let endian = self.endian;
        Some(extensions::Place { start, end, endian })
    }

    fn parse(head: &[u8]) -> Result<Header, Error> {
        let cut_off = |expected: u64| ErrorKind::Truncated {
            what: "the header".into(),
            expected,
            found: head.len() as u64,
        };
        let &first = head.first_chunk::<4>().ok_or_else(|| cut_off(348))?;
        let (size, endian) = match (i32::from_le_bytes(first), i32::from_be_bytes(first)) {
            (size @ (348 | 540), _) => (size, Endian::Little),
            (_, size @ (348 | 540)) => (size, Endian::Big),
            (size, _) => {
                return Err(Error::field(
                    "sizeof_hdr",
                    size,
                    "348 (NIfTI-1) or 540 (NIfTI-2)",
                ));
            }
        };
        if head.len() < size as usize {
            return Err(cut_off(size as u64).into());
        }
        let fields = Fields { head, endian };
        let mut header = if size == 540 {
            Header::nifti2(&fields)?
        } else {
            Header::nifti1(&fields)?
        };
        header.put_right();
        Ok(header)
    }

    fn nifti1(f: &Fields) -> Result<Header, Error> {
        let (version, single_file) = match &f.head[344..348] {
            b"n+1\0" => (Version::Nifti1, true),
            b"ni1\0" => (Version::Nifti1, false),
            _ => (Version::Analyze, false),
        };
        let offset = f.f32(108);
        if !(offset.is_finite() && offset >= 0.0) {
            return Err(Error::field(
                "vox_offset",
                offset,
                "the position of the first sample, 0 or more",
            ));
        }
        Ok(Header {
            version,
            endian: f.endian,
            single_file,
            dim: std::array::from_fn(|i| f.i16(40 + 2 * i)),
            intent_code: f.i16(68),
            datatype: f.i16(70),
            pixdim: std::array::from_fn(|i| f.f32(76 + 4 * i)),
            vox_offset: offset as u64,
            scl_slope: f.f32(112),
            scl_inter: f.f32(116),
            xyzt_units: f.head[123].into(),
            descrip: f.text(148, 80),
            qform_code: f.i16(252),
            sform_code: f.i16(254),
            quatern: std::array::from_fn(|i| f.f32(256 + 4 * i)),
            qoffset: std::array::from_fn(|i| f.f32(268 + 4 * i)),
            srow: std::array::from_fn(|row| {
                std::array::from_fn(|column| f.f32(280 + 16 * row + 4 * column))
            }),
            intent_name: f.text(328, 16),
            originator: std::array::from_fn(|i| f.i16(253 + 2 * i) as f64),
            notes: Vec::new(),
        })
    }

    fn nifti2(f: &Fields) -> Result<Header, Error> {
        let single_file = match &f.head[4..8] {
            b"n+2\0" => true,
            b"ni2\0" => false,
            magic => {
                return Err(Error::field(
                    "magic",
                    format!("`{}`", magic.escape_ascii()),
                    "`n+2\\0` or `ni2\\0`",
                ));
            }
        };
        let vox_offset = u64::try_from(f.i64(168)).map_err(|_| {
            Error::field(
                "vox_offset",
                f.i64(168),
                "the position of the first sample, 0 or more",
            )
        })?;
        Ok(Header {
            version: Version::Nifti2,
            endian: f.endian,
            single_file,
            dim: std::array::from_fn(|i| f.i64(16 + 8 * i)),
            intent_code: f.i32(504),
            datatype: f.i16(12),
            pixdim: std::array::from_fn(|i| f.f64(104 + 8 * i)),
            vox_offset,
            scl_slope: f.f64(176),
            scl_inter: f.f64(184),
            xyzt_units: f.i32(500),
            descrip: f.text(240, 80),
            qform_code: f.i32(344),
            sform_code: f.i32(348),
            quatern: std::array::from_fn(|i| f.f64(352 + 8 * i)),
            qoffset: std::array::from_fn(|i| f.f64(376 + 8 * i)),
            srow: std::array::from_fn(|row| {
                std::array::from_fn(|column| f.f64(400 + 32 * row + 8 * column))
            }),
            intent_name: f.text(508, 16),
            originator: [0.0; 3],
            notes: Vec::new(),
        })
    }

    /// Mends what files in the wild have wrong and everybody mends the same way.
    fn put_right(&mut self) {
        let shortest = match self.version {
            Version::Analyze => 0,
            Version::Nifti1 => 352,
            Version::Nifti2 => 544,
        };
        if self.single_file && self.vox_offset < shortest {
            self.notes.push(format!(
                "vox_offset is {}, inside the header; {shortest} is taken",
                self.vox_offset
            ));
            self.vox_offset = shortest;
        }
        for axis in 3..=7 {
            if self.dim[axis] == 0 && axis as i64 <= self.dim[0] {
                self.notes.push(format!("dim[{axis}] is 0; 1 is taken"));
                self.dim[axis] = 1;
            }
        }
        if self.version == Version::Analyze {
            (self.qform_code, self.sform_code, self.intent_code) = (0, 0, 0);
            (self.xyzt_units, self.intent_name) = (0, String::new());
        }
        self.drop_useless_sform();
        // The spacings count only where there is no sform.
        if self.sform_code != 0 {
            return;
        }
        for axis in 1..4 {
            let spacing = &mut self.pixdim[axis];
            let right = if *spacing == 0.0 || self.dim[0] < axis as i64 {
                1.0
            } else {
                spacing.abs()
            };
            if self.dim[0] >= axis as i64 && right != *spacing && !spacing.is_nan() {
                self.notes
                    .push(format!("pixdim[{axis}] is {spacing}; {right} is taken"));
            }
            *spacing = right;
        }
        if self.pixdim[0] != -1.0 {
            self.pixdim[0] = 1.0;
        }
    }

    /// An sform that places nothing gives way to a qform, as in ITK.
    fn drop_useless_sform(&mut self) {
        let [x, y, z] = self.srow;
        let [a, b, c] = [0, 1, 2].map(|i| DVec3::new(x[i], y[i], z[i]));
        let determinant = a.cross(b).dot(c);
        let is_useless = determinant == 0.0 || !determinant.is_finite();
        if self.sform_code != 0 && self.qform_code != 0 && is_useless {
            self.notes.push(format!(
                "sform_code is {}, but the matrix places nothing; the qform is taken",
                self.sform_code
            ));
            self.sform_code = 0;
        }
    }

    /// Lengths along x, y, z and time.
    fn lengths(&self) -> Result<[usize; 4], Error> {
        if !(1..=7).contains(&self.dim[0]) {
            return Err(Error::field(
                "dim[0] (the number of dimensions)",
                self.dim[0],
                "1 to 7",
            ));
        }
        let rank = self.dim[0] as usize;
        for axis in 1..=rank {
            let length = self.dim[axis];
            if length < 1 {
                return Err(Error::field(format!("dim[{axis}]"), length, "1 or more"));
            }
            if axis > 5 && length > 1 {
                return Err(ErrorKind::Unsupported {
                    feature: format!(
                        "dim[{axis}] = {length} (several numbers per voxel and time point)"
                    ),
                    instead: "write each component as a volume of its own".into(),
                }
                .into());
            }
        }
        let mut lengths = [1; 4];
        for (axis, length) in lengths.iter_mut().enumerate().take(rank.min(4)) {
            let stored = self.dim[axis + 1];
            *length = usize::try_from(stored).map_err(|_| {
                Error::field(format!("dim[{}]", axis + 1), stored, "a smaller length")
            })?;
        }
        // Before anything is computed from the product.
        voxel_count([lengths[0], lengths[1], lengths[2]])
            .and_then(|n| n.checked_mul(lengths[3]))
            .ok_or_else(|| {
                Error::field(
                    "dim",
                    format!("{:?}", &self.dim[..=rank]),
                    "fewer samples than this machine can address",
                )
            })?;
        Ok(lengths)
    }

    /// Numbers of a voxel that lie side by side.
    fn colors(&self) -> usize {
        match self.datatype {
            128 => 3,
            2304 => 4,
            _ => 1,
        }
    }

    /// Numbers of a voxel that lie one volume behind the other.
    fn vector_length(&self) -> Result<usize, Error> {
        match self.dim[5] {
            length if self.dim[0] >= 5 => {
                usize::try_from(length).map_err(|_| Error::field("dim[5]", length, "1 or more"))
            }
            _ => Ok(1),
        }
    }

    fn sample_type(&self) -> Result<Stored, Error> {
        let (name, instead) = match self.datatype {
            2 | 128 | 2304 => return Ok(Stored::Kept(SampleType::U8)),
            4 => return Ok(Stored::Kept(SampleType::I16)),
            8 => return Ok(Stored::Kept(SampleType::I32)),
            16 => return Ok(Stored::Kept(SampleType::F32)),
            64 => return Ok(Stored::Kept(SampleType::F64)),
            256 => return Ok(Stored::Kept(SampleType::I8)),
            512 => return Ok(Stored::Kept(SampleType::U16)),
            768 => return Ok(Stored::Kept(SampleType::U32)),
            1024 => return Ok(Stored::I64),
            1280 => return Ok(Stored::U64),
            1 => ("binary", "write it as uint8"),
            32 => ("complex64", "write magnitude or phase as float32"),
            1536 => ("float128", "write it as float64"),
            1792 | 2048 => ("complex", "write magnitude or phase as float64"),
            other => {
                return Err(Error::field(
                    "datatype",
                    other,
                    "2 (uint8), 4 (int16), 8 (int32), 16 (float32), 64 (float64), 256 (int8), 512 (uint16), 768 (uint32), 1024 (int64) or 1280 (uint64)",
                ));
            }
        };
        Err(ErrorKind::Unsupported {
            feature: format!("datatype {} ({name})", self.datatype),
            instead: instead.into(),
        }
        .into())
    }

    /// Length of one unit in mm, if the file says.
    fn unit_mm(&self) -> Option<f64> {
        match self.xyzt_units & 7 {
            1 => Some(1000.0),
            2 => Some(1.0),
            3 => Some(0.001),
            _ => None,
        }
    }

    fn world_from_voxel(&self, notes: &mut Vec<String>) -> Result<DAffine3, Error> {
        let affine = if self.sform_code != 0 {
            let [x, y, z] = self.srow;
            DAffine3::from_cols(
                DVec3::new(x[0], y[0], z[0]),
                DVec3::new(x[1], y[1], z[1]),
                DVec3::new(x[2], y[2], z[2]),
                DVec3::new(x[3], y[3], z[3]),
            )
        } else if self.qform_code != 0 {
            let [qfac, dx, dy, dz] = [0, 1, 2, 3].map(|i| self.pixdim[i]);
            let scale = DMat3::from_diagonal(DVec3::new(dx, dy, dz * qfac));
            DAffine3::from_mat3_translation(self.rotation() * scale, self.qoffset.into())
        } else {
            notes.push(match self.version {
                Version::Analyze => "Analyze 7.5 does not state which side is left; x is assumed to run to the left, as in nibabel and SPM".into(),
                _ => "sform_code and qform_code are 0: the file has no position; x is assumed to run to the left, as in nibabel".into(),
            });
            let spacing = DVec3::new(-self.pixdim[1], self.pixdim[2], self.pixdim[3]);
            DAffine3::from_mat3_translation(
                DMat3::from_diagonal(spacing),
                -self.origin_voxel() * spacing,
            )
        };
        let unit = self.unit_mm().unwrap_or(1.0);
        Ok(DAffine3::from_mat3_translation(
            affine.matrix3 * unit,
            affine.translation * unit,
        ))
    }

    /// The rotation of the unit quaternion whose last three numbers are stored. Numbers that are too
    /// long for one (rounding makes them so) are taken as a half turn about their direction.
    fn rotation(&self) -> DMat3 {
        let [b, c, d] = self.quatern;
        let rest = 1.0 - (b * b + c * c + d * d);
        // Below the precision of what is stored a difference means nothing (as in nibabel).
        let threshold = match self.version {
            Version::Nifti2 => 3.0 * f64::EPSILON,
            _ => 3.0 * f64::from(f32::EPSILON),
        };
        let a = if rest < threshold { 0.0 } else { rest.sqrt() };
        let norm = a * a + b * b + c * c + d * d;
        let s = 2.0 / norm;
        DMat3::from_cols(
            DVec3::new(
                1.0 - s * (c * c + d * d),
                s * (b * c + a * d),
                s * (b * d - a * c),
            ),
            DVec3::new(
                s * (b * c - a * d),
                1.0 - s * (b * b + d * d),
                s * (c * d + a * b),
            ),
            DVec3::new(
                s * (b * d + a * c),
                s * (c * d - a * b),
                1.0 - s * (b * b + c * c),
            ),
        )
    }

    /// The voxel (from 0) that lies at the origin where neither sform nor qform is set.
    fn origin_voxel(&self) -> DVec3 {
        let length = |axis: i64| {
            if axis <= self.dim[0] {
                self.dim[axis as usize] as f64
            } else {
                1.0
            }
        };
        let lengths = DVec3::new(length(1), length(2), length(3));
        let origin = DVec3::from(self.originator);
        let stored = self.version == Version::Analyze
            && origin != DVec3::ZERO
            && origin.cmpgt(-lengths).all()
            && origin.cmplt(2.0 * lengths).all();
        if stored {
            origin - 1.0
        } else {
            (lengths - 1.0) / 2.0
        }
    }

    fn intercept_is_broken(&self) -> bool {
        self.scl_slope.is_finite() && self.scl_slope != 0.0 && !self.scl_inter.is_finite()
    }

    fn metadata(&self, name: &str, time_points: usize, time_index: usize) -> Metadata {
        let mut entries = Vec::new();
        let mut entry = |key: &str, value: String| {
            if !value.is_empty() {
                entries.push((key.to_owned(), value));
            }
        };
        entry("description", self.descrip.clone());
        entry("intent", self.intent_name.clone());
        let code = if self.sform_code != 0 {
            self.sform_code
        } else {
            self.qform_code
        };
        let space = match code {
            1 => "scanner",
            2 => "aligned to another scan",
            3 => "Talairach",
            4 => "MNI 152",
            5 => "template",
            _ => "",
        };
        entry("space", space.into());
        if time_points > 1 {
            let unit = match self.xyzt_units & 0x38 {
                8 => " s",
                16 => " ms",
                24 => " µs",
                32 => " Hz",
                40 => " ppm",
                48 => " rad/s",
                _ => "",
            };
            entry("time step", format!("{}{unit}", self.pixdim[4]));
        }
        Metadata {
            name: name.to_owned(),
            format: match self.version {
                Version::Analyze => "Analyze 7.5",
                Version::Nifti1 => "NIfTI-1",
                Version::Nifti2 => "NIfTI-2",
            }
            .into(),
            has_length_unit: self.unit_mm().is_some(),
            time_points,
            time_index,
            entries,
            ..Metadata::default()
        }
    }
}
