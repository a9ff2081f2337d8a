//! Volumes from numbered slices in TIFF, PNG, BMP or JPEG: one picture per slice, in the order of the numbers in
//! their names (`slice9` before `slice10`), whatever zeros they are padded with.
//!
//! Row 0 of a picture is its top and lies at y = 0; see [`unoriented`] for what that is in the world.

use super::sniff::{self, Kind};
use super::{Bytes, Files, Input, LoadedVolume, ReadOptions, block, bmp, png, unoriented};
use crate::cores;
use crate::error::{Error, ErrorKind};
use crate::{Components, Metadata, Rescale, Samples, Volume, memory};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// One picture that is no TIFF: a volume of one slice.
pub(crate) fn read_one(
    kind: Kind,
    input: &Input,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let mut notes = Vec::new();
    let picture = picture(kind, input.bytes, options, &mut notes)?;
    let format = match kind {
        Kind::Bmp => "BMP",
        Kind::Jpeg => "JPEG",
        _ => "PNG",
    };
    let mut loaded = volume(input.name, format, picture.into(), 1, options)?;
    loaded.notes.append(&mut notes);
    loaded.notes.push("one picture is read as one slice".into());
    Ok(loaded)
}

/// One picture that is no TIFF.
fn picture(
    kind: Kind,
    bytes: &dyn Bytes,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<png::Picture, Error> {
    match kind {
        Kind::Bmp => bmp::read(bytes, options, notes),
        #[cfg(feature = "dicom")]
        Kind::Jpeg => super::jpeg::read(bytes, options, notes),
        #[cfg(not(feature = "dicom"))]
        Kind::Jpeg => Err(Error::not_built_in("JPEG", "dicom")),
        _ => png::read(bytes, options, notes),
    }
}

/// The note that `others` beside the pictures of a folder were left out.
pub(crate) fn note_of_others(others: &[String]) -> Option<String> {
    let what = "left out what is no picture";
    (!others.is_empty()).then(|| format!("{what}: {}", examples(others)))
}

/// The volume that the pictures of a folder make.
pub(crate) fn read_pictures(
    name: &str,
    files: &dyn Files,
    names: Vec<String>,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let mut notes = Vec::new();
    let names = in_order(names, &mut notes)?;
    let decode = |name: &String| slice(name, files, options).map_err(|error| error.in_file(name));

    let mut all = decode(&names[0])?;
    let (dims, sample_type) = (all.dims, all.samples.sample_type());
    let slice_samples = all.samples.len();
    let slice_bytes = block::bytes_of(slice_samples, sample_type);
    files
        .open(&names[0])?
        .keep(slice_bytes.saturating_mul(names.len() as u64))?;
    crate::with_samples!(&mut all.samples, s => {
        memory::reserve(s, slice_samples.saturating_mul(names.len() - 1))
    })?;
    // Enough at a time to keep all cores busy, few enough to take little memory.
    for batch in names[1..].chunks(32) {
        for (name, slice) in batch
            .iter()
            .zip(cores::map(batch.len(), |i| decode(&batch[i])))
        {
            let slice = slice?;
            if (slice.dims, slice.samples.sample_type()) != (dims, sample_type) {
                let text = |[x, y]: [usize; 2], t| format!("{x} x {y} {t}");
                return Err(ErrorKind::Slices(format!(
                    "{name} is {}, {} is {}; the slices of a sequence have one size and type",
                    text(slice.dims, slice.samples.sample_type()),
                    names[0],
                    text(dims, sample_type),
                ))
                .into());
            }
            append(&mut all.samples, &slice.samples);
            notes.extend(slice.notes);
        }
    }
    notes.append(&mut all.notes);
    // What is said of every slice is said once.
    notes.sort();
    notes.dedup();
    let mut loaded = volume(name, "slices", all, names.len(), options)?;
    loaded.notes.append(&mut notes);
    Ok(loaded)
}

/// One decoded picture, and then all of them, one after the other.
struct Slice {
    dims: [usize; 2],
    samples: Samples,
    components: Components,
    /// Distance between voxel centers and whether it has a length unit, if the file says.
    spacing_mm: Option<([f64; 3], bool)>,
    notes: Vec<String>,
}

impl From<png::Picture> for Slice {
    fn from(picture: png::Picture) -> Slice {
        Slice {
            dims: picture.dims,
            samples: picture.samples,
            components: picture.components,
            spacing_mm: None,
            notes: Vec::new(),
        }
    }
}

fn slice(name: &str, files: &dyn Files, options: &ReadOptions) -> Result<Slice, Error> {
    let bytes = files.open(name)?;
    let mut notes = Vec::new();
    match sniff::kind(&*bytes)? {
        #[cfg(feature = "tiff")]
        Some(Kind::Tiff) => {
            let slice = super::tiff::read_slice(&*bytes, options, &mut notes)?;
            Ok(Slice {
                dims: slice.dims,
                samples: slice.samples,
                components: slice.components,
                spacing_mm: slice.spacing_mm,
                notes,
            })
        }
        #[cfg(not(feature = "tiff"))]
        Some(Kind::Tiff) => Err(Error::not_built_in("TIFF", "tiff")),
        kind => {
            let kind = kind.unwrap_or(Kind::Png);
            let picture = picture(kind, &*bytes, options, &mut notes)?;
            Ok(Slice {
                notes,
                ..picture.into()
            })
        }
    }
}

fn volume(
    name: &str,
    format: &str,
    all: Slice,
    slices: usize,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    if options.time_index > 0 {
        return Err(Error::field("time point", options.time_index, "0"));
    }
    let (spacing_mm, has_length_unit) = unoriented::spacing_mm(options, all.spacing_mm);
    let [width, height] = all.dims;
    let volume = Volume::new(
        unoriented::grid([width, height, slices], spacing_mm)?,
        all.samples,
        Rescale::IDENTITY,
        Metadata {
            name: name.to_owned(),
            format: format.into(),
            has_length_unit,
            time_points: 1,
            components: all.components,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes: all.notes,
    })
}

fn append(into: &mut Samples, from: &Samples) {
    macro_rules! same {
        ($($variant:ident)*) => {
            match (into, from) {
                $((Samples::$variant(into), Samples::$variant(from)) => into.extend_from_slice(from),)*
                _ => unreachable!("compared before"),
            }
        };
    }
    same!(U8 I8 U16 I16 U32 I32 F32 F64);
}

/// The names in the order of their numbers.
///
/// # Errors
/// Names that are not one sequence: with other words in them, or with two numbers that count.
fn in_order(names: Vec<String>, notes: &mut Vec<String>) -> Result<Vec<String>, Error> {
    let mut groups: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for name in names {
        groups.entry(pattern(&name)).or_default().push(name);
    }
    if groups.len() > 1 {
        let list: Vec<String> = groups
            .iter()
            .take(8)
            .map(|(pattern, names)| format!("{} of `{pattern}`", names.len()))
            .collect();
        return Err(ErrorKind::Ambiguous(format!(
            "pictures of {} kinds of names lie here: {}{}; put the slices of one volume into a folder \
             of their own, or name just those files",
            groups.len(),
            list.join(", "),
            if groups.len() > 8 { ", …" } else { "" },
        ))
        .into());
    }
    let mut names: Vec<String> = groups.into_values().flatten().collect();
    names.sort_by(|a, b| compare(numbers(a), numbers(b)).then_with(|| a.cmp(b)));
    let columns = numbers(&names[0]).len();
    let Some(column) = (0..columns).find(|&i| {
        let first = numbers(&names[0])[i];
        names.iter().any(|name| numbers(name)[i] != first)
    }) else {
        return Err(
            ErrorKind::Ambiguous(format!("{} have the same number", examples(&names))).into(),
        );
    };
    if let Some(pair) = names
        .windows(2)
        .find(|pair| numbers(&pair[0])[column] == numbers(&pair[1])[column])
    {
        return Err(ErrorKind::Ambiguous(format!(
            "{} and {} have the same first number that counts, so the names are of several volumes or \
             of one with two numbers; put the slices of one volume into a folder of their own",
            pair[0], pair[1]
        ))
        .into());
    }
    let counted: Option<Vec<u64>> = names
        .iter()
        .map(|name| numbers(name)[column].parse().ok())
        .collect();
    if let Some(counted) = counted {
        let steps: Vec<u64> = counted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = steps.iter().min().copied().unwrap_or(1);
        let gaps: Vec<String> = counted
            .windows(2)
            .filter(|pair| pair[1] - pair[0] != usual)
            .take(4)
            .map(|pair| format!("{} to {}", pair[0], pair[1]))
            .collect();
        if !gaps.is_empty() {
            notes.push(format!(
                "the numbers of the slices jump ({}), as if some were missing; all are taken as evenly spaced",
                gaps.join(", ")
            ));
        }
    }
    Ok(names)
}

/// A name with `#` for each number, in lower case.
fn pattern(name: &str) -> String {
    let mut pattern = String::new();
    for c in name.chars().flat_map(char::to_lowercase) {
        match c.is_ascii_digit() {
            false => pattern.push(c),
            true if pattern.ends_with('#') => {}
            true => pattern.push('#'),
        }
    }
    pattern
}

/// The numbers in a name without leading zeros (0 is empty).
fn numbers(name: &str) -> Vec<&str> {
    name.split(|c: char| !c.is_ascii_digit())
        .filter(|digits| !digits.is_empty())
        .map(|digits| digits.trim_start_matches('0'))
        .collect()
}

/// As numbers of any length.
fn compare(a: Vec<&str>, b: Vec<&str>) -> Ordering {
    let key = |digits: &&str| (digits.len(), digits.to_string());
    a.iter().map(key).cmp(b.iter().map(key))
}

/// The first few names.
fn examples(names: &[String]) -> String {
    let mut text = names[..names.len().min(3)].join(", ");
    if names.len() > 3 {
        text += &format!(" and {} more", names.len() - 3);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(names: &[&str]) -> Result<(Vec<String>, Vec<String>), String> {
        let mut notes = Vec::new();
        let names = names.iter().map(|name| name.to_string()).collect();
        match in_order(names, &mut notes) {
            Ok(names) => Ok((names, notes)),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn names_are_sorted_by_their_numbers() {
        let cases: [(&[&str], &[&str]); 4] = [
            (
                &["img10.png", "img2.png", "img1.png", "img3.png"],
                &["img1.png", "img2.png", "img3.png", "img10.png"],
            ),
            (
                &["a01.PNG", "A2.png", "a003.png"],
                &["a01.PNG", "A2.png", "a003.png"],
            ),
            (
                &["7-scan-9.tif", "7-scan-11.tif", "7-scan-10.tif"],
                &["7-scan-9.tif", "7-scan-10.tif", "7-scan-11.tif"],
            ),
            (
                &[
                    "99999999999999999999999.png",
                    "100000000000000000000000.png",
                ],
                &[
                    "99999999999999999999999.png",
                    "100000000000000000000000.png",
                ],
            ),
        ];
        for (names, expected) in cases {
            assert_eq!(order(names).unwrap().0, expected);
        }
    }

    #[test]
    fn missing_numbers_are_noted_and_even_steps_are_not() {
        assert_eq!(order(&["s2.png", "s4.png", "s6.png"]).unwrap().1.len(), 0);
        let notes = order(&["s1.png", "s2.png", "s5.png"]).unwrap().1;
        assert!(notes[0].contains("2 to 5"), "{notes:?}");
    }

    #[test]
    fn several_sequences_are_named() {
        let mixed = order(&["ct1.png", "ct2.png", "mr1.png"]).unwrap_err();
        for part in ["2 of `ct#.png`", "1 of `mr#.png`", "folder"] {
            assert!(mixed.contains(part), "{mixed}");
        }
        let twice = order(&["s1.png", "s01.png"]).unwrap_err();
        assert!(twice.contains("same number"), "{twice}");
        let channels = order(&["z1c1.png", "z1c2.png", "z2c1.png", "z2c2.png"]).unwrap_err();
        assert!(channels.contains("z1c1.png and z1c2.png"), "{channels}");
    }
}
