//! What the user says about a file, and that it is something the file leaves open.

use crate::{Error, Label, SampleType};

/// What the user says about a file that the file does not say itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Which time point of a 4-D file to take, from 0.
    pub time_index: usize,
    /// Which of several numbers per voxel to take, from 0. Without, colors become luminance.
    pub component: Option<usize>,
    /// Which DICOM series to take: its number in the list from 1, its series number, or (the
    /// beginning of) its instance UID.
    pub series: Option<String>,
    /// Resamples a series with missing or uneven slices to the even grid instead of refusing it.
    pub allow_gaps: bool,
    /// Layout of headerless files; what is `None` is taken from the file's name, else asked for.
    pub raw: RawLayout,
    /// Distance between voxel centers in mm for files that do not say (raw, npy, TIFF, PNG, and
    /// `.dat` without `SliceThickness`).
    pub spacing_mm: Option<[f64; 3]>,
    /// Whether the numbers are object ids even if the file does not say so: [`LoadedVolume::labels`] is
    /// there, with the names of a table beside the file if there is one.
    ///
    /// [`LoadedVolume::labels`]: super::LoadedVolume::labels
    pub as_labels: bool,
    /// Names and colors of the object ids, in place of those in or beside the file. Implies
    /// `as_labels`.
    pub label_table: Option<Vec<Label>>,
}

/// Layout of a headerless file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawLayout {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Type of a sample.
    pub sample_type: Option<SampleType>,
    /// Byte order; little if not said.
    pub big_endian: bool,
    /// Bytes before the first sample.
    pub header_bytes: u64,
}

/// What a format may leave for the user to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Open {
    /// Which of several time points.
    Time,
    /// Which of several series.
    Series,
    /// Which of several numbers per voxel.
    Component,
    /// Dimensions, type, and where the samples begin.
    Layout,
    /// Byte order.
    Endian,
    /// Distance between voxel centers.
    Spacing,
}

impl ReadOptions {
    /// Whether the user said only what files of a format leave open. To ignore the rest would be to
    /// draw something else than what was asked for. (`allow_gaps` is no statement but a permission.)
    ///
    /// # Errors
    /// The first statement that has no effect, and what to do about it.
    pub(super) fn check(&self, format: &str, open: &[Open]) -> Result<(), Error> {
        let raw = &self.raw;
        let triple = |[x, y, z]: [String; 3]| format!("{x},{y},{z}");
        let said = [
            (
                Open::Layout,
                "dims",
                raw.dims.map(|d| triple(d.map(|n| n.to_string()))),
            ),
            (Open::Layout, "type", raw.sample_type.map(|t| t.to_string())),
            (
                Open::Layout,
                "header_bytes",
                (raw.header_bytes > 0).then(|| raw.header_bytes.to_string()),
            ),
            (Open::Endian, "endian", raw.big_endian.then(|| "big".into())),
            (
                Open::Spacing,
                "spacing_mm",
                self.spacing_mm.map(|s| triple(s.map(|mm| mm.to_string()))),
            ),
            (Open::Series, "series", self.series.clone()),
            (
                Open::Component,
                "component",
                self.component.map(|component| component.to_string()),
            ),
        ];
        for (what, name, value) in said {
            if let Some(value) = value.filter(|_| !open.contains(&what)) {
                let why = match what {
                    Open::Series => "have no series",
                    Open::Component => "are read with one number per voxel",
                    _ => "contain it",
                };
                return Err(Error::field(
                    name,
                    value,
                    format!("nothing: {format} files {why}"),
                ));
            }
        }
        if self.time_index > 0 && !open.contains(&Open::Time) {
            return Err(Error::field(
                "time point",
                self.time_index,
                format!("0: a {format} file holds a single volume"),
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says_itself_cannot_be_said() {
        let options = ReadOptions {
            raw: RawLayout {
                dims: Some([3, 4, 5]),
                ..RawLayout::default()
            },
            ..ReadOptions::default()
        };
        options.check("raw", &[Open::Layout]).unwrap();
        let message = options
            .check("NIfTI", &[Open::Time])
            .unwrap_err()
            .to_string();
        assert_eq!(
            message,
            "dims is 3,4,5; allowed: nothing: NIfTI files contain it"
        );
        let refused = |change: fn(&mut ReadOptions)| {
            let mut options = ReadOptions::default();
            options.check("PVM", &[]).unwrap();
            change(&mut options);
            options.check("PVM", &[]).unwrap_err().to_string()
        };
        for (change, expected) in [
            (
                (|o| o.series = Some("2".into())) as fn(&mut ReadOptions),
                "series is 2; allowed: nothing: PVM files have no series",
            ),
            (|o| o.time_index = 1, "time point is 1; allowed: 0"),
            (|o| o.spacing_mm = Some([1.0; 3]), "spacing_mm is 1,1,1"),
            (|o| o.raw.big_endian = true, "endian is big"),
            (|o| o.raw.header_bytes = 7, "header_bytes is 7"),
            (|o| o.raw.sample_type = Some(SampleType::U8), "type is u8"),
        ] {
            let message = refused(change);
            assert!(message.starts_with(expected), "{message}");
        }
    }
}
