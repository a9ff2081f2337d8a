//! Series: which DICOM files of a folder belong together, and which of them is meant.

use super::elements::{self, Elements, plain_text};
use super::image::Image;
use super::tags;
use crate::cores;
use crate::error::{Error, ErrorKind, Remedy};
use crate::read::input::Whole;
use crate::read::{Bytes, Files, unpacked};
use std::collections::BTreeMap;
use std::fmt::Write;

/// One DICOM series of a folder, as it is listed for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesSummary {
    /// Its place in the list, from 1.
    pub number: usize,
    /// SeriesInstanceUID.
    pub uid: String,
    /// SeriesNumber, if the files say one.
    pub series_number: Option<i64>,
    /// SeriesDescription, or what else the files call it; may be empty.
    pub description: String,
    /// Modality as the standard abbreviates it, such as `CT`; may be empty.
    pub modality: String,
    /// Images in all files together.
    pub slices: usize,
    /// Samples along a row and along a column of the first image.
    pub size: [usize; 2],
    /// Number of files.
    pub files: usize,
}

/// What the files of a folder are.
#[derive(Default)]
pub(super) struct Scan {
    /// Files with pixels, by series, in the order of the list.
    pub(super) series: Vec<(SeriesSummary, Vec<Image>)>,
    /// Files that begin like DICOM and break off: name, series if it got that far, what is wrong.
    pub(super) damaged: Vec<(String, Option<String>, Error)>,
    /// What the user should know about the rest.
    pub(super) notes: Vec<String>,
}

enum Scanned {
    Foreign,
    WithoutPixels,
    Image(Image),
    Damaged(Option<String>, Error),
}

/// The image of a file whose elements were read. `None`: no pixels.
pub(super) fn image(name: &str, bytes: &dyn Bytes, elements: Elements) -> Option<Image> {
    elements.pixels.map(|pixels| Image {
        name: name.to_owned(),
        file_bytes: bytes.len(),
        elements,
        pixels,
    })
}

/// Opens a file; one that is packed as a whole is unpacked.
pub(super) fn open<'a>(files: &'a dyn Files, name: &str) -> Result<Box<dyn Bytes + 'a>, Error> {
    let bytes = files.open(name)?;
    match unpacked::whole_if(&*bytes, |head| elements::is_dicom(head))? {
        Some(whole) => Ok(Box::new(Whole {
            bytes: whole,
            file: bytes,
        })),
        None => Ok(bytes),
    }
}

fn scan_file(name: &str, files: &dyn Files) -> Result<Scanned, Error> {
    let bytes = open(files, name)?;
    if !elements::is_dicom(&*bytes) {
        return Ok(Scanned::Foreign);
    }
    let (elements, result) = elements::read(&*bytes);
    if let Err(error) = result {
        let series = elements.set.text(tags::SERIES_INSTANCE_UID);
        return Ok(Scanned::Damaged(series, error.in_file(name)));
    }
    let image = image(name, &*bytes, elements);
    Ok(image.map_or(Scanned::WithoutPixels, Scanned::Image))
}

/// Reads the elements of the files of these names.
///
/// # Errors
/// What the system says.
pub(super) fn scan(files: &dyn Files, names: Vec<String>) -> Result<Scan, Error> {
    let mut scanned: Vec<Option<Scanned>> = Vec::new();
    scanned.resize_with(names.len(), || None);
    cores::try_for_each(
        names.iter().zip(&mut scanned),
        || (),
        |(), (name, into)| {
            *into = Some(scan_file(name, files).map_err(|error| error.in_file(name))?);
            Ok::<_, Error>(())
        },
    )?;
    let mut scan = Scan::default();
    let (mut foreign, mut without) = (0, 0);
    let mut by_uid: BTreeMap<String, Vec<Image>> = BTreeMap::new();
    for (name, scanned) in names.into_iter().zip(scanned) {
        match scanned {
            None | Some(Scanned::Foreign) => foreign += 1,
            Some(Scanned::WithoutPixels) => without += 1,
            Some(Scanned::Damaged(series, error)) => scan.damaged.push((name, series, error)),
            Some(Scanned::Image(image)) => by_uid.entry(image.series()).or_default().push(image),
        }
    }
    if foreign > 0 {
        scan.notes
            .push(format!("{foreign} files that are not DICOM were left out"));
    }
    if without > 0 {
        scan.notes.push(format!(
            "{without} DICOM files without an image (directories, reports) were left out"
        ));
    }
    scan.series = by_uid
        .into_iter()
        .map(|(uid, images)| (summary(uid, &images), images))
        .collect();
    // By series number, so that the list reads like the console of the scanner.
    scan.series.sort_by(|(a, _), (b, _)| {
        (a.series_number.unwrap_or(i64::MAX), &a.uid)
            .cmp(&(b.series_number.unwrap_or(i64::MAX), &b.uid))
    });
    for (i, (summary, _)) in scan.series.iter_mut().enumerate() {
        summary.number = i + 1;
    }
    Ok(scan)
}

fn summary(uid: String, images: &[Image]) -> SeriesSummary {
    let set = images[0].set();
    let edge = |tag| set.u16(tag).map_or(0, usize::from);
    SeriesSummary {
        number: 0,
        uid,
        series_number: set
            .bytes(tags::SERIES_NUMBER)
            .and_then(|bytes| plain_text(bytes).parse().ok()),
        description: set
            .description(tags::SERIES_DESCRIPTION)
            .or_else(|| set.description(tags::PROTOCOL_NAME))
            .unwrap_or_default(),
        modality: set.description(tags::MODALITY).unwrap_or_default(),
        slices: images.iter().map(Image::slices).sum(),
        size: [edge(tags::COLUMNS), edge(tags::ROWS)],
        files: images.len(),
    }
}

impl Scan {
    /// Takes the series that is meant.
    ///
    /// # Errors
    /// No image at all; several series and none picked; a pick that fits none or several.
    pub(super) fn pick(
        mut self,
        wanted: Option<&str>,
    ) -> Result<(SeriesSummary, Vec<Image>, Scan), Error> {
        if self.series.is_empty() {
            if let Some((_, _, error)) = self.damaged.into_iter().next() {
                return Err(error);
            }
            return Err(ErrorKind::Unknown {
                why: "no file here is a DICOM image".into(),
            }
            .into());
        }
        let index = match wanted {
            None if self.series.len() == 1 => 0,
            None if let Some(only) = self.only_besides_localisers() => only,
            None => {
                let what = format!("there are {} series", self.series.len());
                return Err(self.ambiguous(&what));
            }
            Some(wanted) => self.find(wanted.trim())?,
        };
        let (summary, images) = self.series.swap_remove(index);
        Ok((summary, images, self))
    }

    /// The one series that is no localiser, if there is just one; notes that the others are left out.
    fn only_besides_localisers(&mut self) -> Option<usize> {
        let is_localiser = |images: &[Image]| {
            images.iter().all(|image| {
                let image_type = image.set().text(tags::IMAGE_TYPE).unwrap_or_default();
                image_type
                    .split('\\')
                    .any(|part| part.trim() == "LOCALIZER")
            })
        };
        let mut others = (0..self.series.len()).filter(|i| !is_localiser(&self.series[*i].1));
        let (only, None) = (others.next()?, others.next()) else {
            return None;
        };
        self.notes.push(format!(
            "{} series of localisers left out; all `series` are:\n{}",
            self.series.len() - 1,
            self.table()
        ));
        Some(only)
    }

    fn find(&self, wanted: &str) -> Result<usize, Error> {
        let all = || self.series.iter().map(|(summary, _)| summary).enumerate();
        let number = wanted.parse::<i64>().ok();
        // The place in the list comes before the series number: it is what the list shows first.
        let in_list = number
            .and_then(|n| usize::try_from(n).ok())
            .filter(|n| (1..=self.series.len()).contains(n));
        if let Some(n) = in_list {
            return Ok(n - 1);
        }
        let fitting: Vec<usize> = match number {
            Some(n) => all()
                .filter(|(_, s)| s.series_number == Some(n))
                .map(|(i, _)| i)
                .collect(),
            None => {
                let exact = all().find(|(_, s)| s.uid == wanted).map(|(i, _)| vec![i]);
                exact.unwrap_or_else(|| {
                    all()
                        .filter(|(_, s)| !wanted.is_empty() && s.uid.starts_with(wanted))
                        .map(|(i, _)| i)
                        .collect()
                })
            }
        };
        match fitting[..] {
            [one] => Ok(one),
            [] => Err(self.ambiguous(&format!("no series is {wanted:?}"))),
            _ => Err(self.ambiguous(&format!("{} series are {wanted:?}", fitting.len()))),
        }
    }

    fn ambiguous(&self, what: &str) -> Error {
        let message = format!("{what}; pick one by its number N:\n{}", self.table());
        Error::from(ErrorKind::Ambiguous(message)).with_remedy(Remedy::Series)
    }

    fn table(&self) -> String {
        let mut rows =
            vec![["N", "series", "modality", "slices", "size", "description"].map(String::from)];
        rows.extend(self.series.iter().map(|(s, _)| {
            [
                s.number.to_string(),
                s.series_number.map_or("-".into(), |n| n.to_string()),
                s.modality.clone(),
                s.slices.to_string(),
                format!("{}×{}", s.size[0], s.size[1]),
                s.description.clone(),
            ]
        }));
        let widths: [usize; 5] = std::array::from_fn(|i| {
            rows.iter()
                .map(|row| row[i].chars().count())
                .max()
                .unwrap_or(0)
        });
        let mut table = String::new();
        for row in &rows {
            let mut line = String::new();
            for (cell, width) in row.iter().zip(widths) {
                let _ = write!(line, "  {cell:<width$}");
            }
            let _ = writeln!(table, "{}", format!("{line}  {}", row[5]).trim_end());
        }
        table.trim_end().to_owned()
    }
}
