//! Where a volume comes from.

use crate::nearest::nearest;
use crate::{Problem, Problems};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::read::{RawLayout, ReadOptions};
use strahl_volume::{Phantom, SampleType};

/// Where the volume comes from: a `path`, or the name of a `phantom`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct VolumeSource {
    /// File or folder, relative to the folder of the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Name of a built-in phantom, such as `anatomy`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phantom: Option<String>,
    /// Number of voxels along x, y, z: of a phantom, or of a headerless file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dims: Option<[usize; 3]>,
    /// Level of detail: 0 is full resolution, 1 is half as many voxels along each axis;
    /// fractions are allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Time point of a 4-D file, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<usize>,
    /// Component of a voxel with several numbers, counted from 0. By default, colors become
    /// luminance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component: Option<usize>,
    /// DICOM series of a folder: its number in the list (from 1), its series number, or its
    /// UID.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<String>,
    /// Resamples a series with missing or uneven slices instead of refusing it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allow_gaps: Option<bool>,
    /// Sample type of a headerless file: `u8` … `f64`.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub sample_type: Option<String>,
    /// Distance between voxel centers along x, y, z, for files that do not contain it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing_mm: Option<[f64; 3]>,
    /// Byte order of a headerless file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub endian: Option<Endian>,
    /// Number of bytes before the first sample of a headerless file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header_bytes: Option<u64>,
}

impl VolumeSource {
    /// What the readers need to know.
    ///
    /// # Errors
    /// Neither or both of `path` and `phantom`; a phantom that is not known; a type or spacing that is not one.
    pub fn read_options(&self) -> Result<ReadOptions, Problems> {
        let mut problems = Vec::new();
        self.check(&mut problems);
        let sample_type = self.sample_type.as_deref().and_then(SampleType::from_name);
        Problems::none_of(problems)?;
        Ok(ReadOptions {
            time_index: self.time.unwrap_or(0),
            component: self.component,
            series: self.series.clone(),
            allow_gaps: self.allow_gaps.unwrap_or(false),
            raw: RawLayout {
                dims: self.dims,
                sample_type,
                big_endian: self.endian == Some(Endian::Big),
                header_bytes: self.header_bytes.unwrap_or(0),
            },
            spacing_mm: self.spacing_mm,
            ..ReadOptions::default()
        })
    }

    pub(crate) fn check(&self, problems: &mut Vec<Problem>) {
        if let Some(level) = self.level
            && !(0.0..=16.0).contains(&level)
        {
            problems.push(Problem::new("volume.level", level, "0 to 16"));
        }
        match (&self.path, &self.phantom) {
            (Some(path), Some(phantom)) => problems.push(Problem::new(
                "volume",
                format!("path {path:?} and phantom {phantom:?}"),
                "one of the two",
            )),
            (None, None) => problems.push(Problem::new(
                "volume",
                "without path and phantom",
                "a \"path\" to a file or folder, or the name of a \"phantom\"",
            )),
            (None, Some(name)) => {
                if Phantom::from_name(name).is_none() {
                    let known = Phantom::NAMES.join(", ");
                    let allowed = match nearest(name, Phantom::NAMES.into_iter()) {
                        Some(near) => format!("{known}; did you mean {near:?}?"),
                        None => known,
                    };
                    problems.push(Problem::new("volume.phantom", format!("{name:?}"), allowed));
                }
                let given = [
                    (self.time.is_some(), "time"),
                    (self.component.is_some(), "component"),
                    (self.series.is_some(), "series"),
                    (self.allow_gaps.is_some(), "allow_gaps"),
                    (self.sample_type.is_some(), "type"),
                    (self.spacing_mm.is_some(), "spacing_mm"),
                    (self.endian.is_some(), "endian"),
                    (self.header_bytes.is_some(), "header_bytes"),
                ];
                for (_, key) in given.into_iter().filter(|(given, _)| *given) {
                    problems.push(Problem::new(
                        format!("volume.{key}"),
                        "given for a phantom",
                        "\"dims\" only; the other keys describe files",
                    ));
                }
            }
            (Some(_), None) => {}
        }
        if let Some(name) = &self.sample_type
            && SampleType::from_name(name).is_none()
        {
            problems.push(Problem::new(
                "volume.type",
                format!("{name:?}"),
                "u8, i8, u16, i16, u32, i32, f32 or f64",
            ));
        }
        if let Some(spacing) = self.spacing_mm
            && !spacing.iter().all(|s| s.is_finite() && *s > 0.0)
        {
            problems.push(Problem::new(
                "volume.spacing_mm",
                format!("{spacing:?}"),
                "three numbers above 0",
            ));
        }
        if let Some(dims) = self.dims
            && dims.contains(&0)
        {
            problems.push(Problem::new(
                "volume.dims",
                format!("{dims:?}"),
                "three whole numbers above 0",
            ));
        }
    }
}

/// Byte order of numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}
