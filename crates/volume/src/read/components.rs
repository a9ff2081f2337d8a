//! Several numbers per voxel: color is turned into luminance, or one of them is taken.

use super::{LoadedComponents, LoadedVolume, ReadOptions};
use crate::Components;
use crate::error::{Error, ErrorKind, Remedy};
use crate::{Sample, Samples, with_samples};

/// What the numbers of a voxel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// Red, green and blue, perhaps with opacity; or gray with opacity.
    Color,
    /// A vector, or nobody says.
    Vector,
}

impl Meaning {
    /// `count` numbers of this meaning.
    pub(crate) fn of(self, count: usize) -> Components {
        Components {
            count,
            are_colors: count > 1 && self == Meaning::Color,
        }
    }
}

/// The numbers of a pixel whose color is one of a palette: one, if all of them are gray.
pub(crate) fn of_palette<T: PartialEq>(colors: &[[T; 3]]) -> Components {
    let are_gray = colors.iter().all(|[r, g, b]| r == g && g == b);
    Meaning::Color.of(if are_gray { 1 } else { 3 })
}

/// Which number of a voxel is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// The one at this place, from 0.
    One(usize),
    /// 0.2126 red + 0.7152 green + 0.0722 blue (ITU-R BT.709), on the numbers as they are stored.
    Luminance,
}

/// Which of `count` numbers is meant.
///
/// # Errors
/// One that is not there; vectors of which none is picked.
pub(crate) fn choice(
    count: usize,
    meaning: Meaning,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Choice, Error> {
    match (options.component, meaning) {
        (None | Some(0), _) if count == 1 => Ok(Choice::One(0)),
        (Some(component), _) if component >= count => Err(Error::field(
            "component",
            component,
            match count {
                1 => "nothing: the file has one number per voxel".to_owned(),
                n => format!("0 to {}", n - 1),
            },
        )),
        (Some(component), _) => {
            notes.push(note_of(component, count));
            Ok(Choice::One(component))
        }
        (None, Meaning::Color) if count == 2 => {
            notes.push("opacity (the second of two numbers per voxel) was left out".into());
            Ok(Choice::One(0))
        }
        (None, Meaning::Color) if matches!(count, 3 | 4) => {
            notes.push(
                "colors were turned into luminance (BT.709); single components can be picked"
                    .into(),
            );
            Ok(Choice::Luminance)
        }
        (None, _) => Err(Error::from(ErrorKind::Unsupported {
            feature: format!("a volume of {count} numbers per voxel"),
            instead: format!("pick one of its components, 0 to {}", count - 1),
        })
        .with_remedy(Remedy::Component)),
    }
}

/// The note that one component was read.
pub(crate) fn note_of(component: usize, count: usize) -> String {
    format!("component {component} of {count} is taken")
}

/// The chosen number of every voxel, of `count` that lie side by side. In place.
pub(crate) fn reduced(mut samples: Samples, count: usize, choice: Choice) -> Samples {
    with_samples!(&mut samples, s => reduce(s, count, choice));
    samples
}

fn reduce<T: Sample>(samples: &mut Vec<T>, count: usize, choice: Choice) {
    let voxels = samples.len() / count;
    if count == 1 {
        return;
    }
    for voxel in 0..voxels {
        let numbers = &samples[voxel * count..(voxel + 1) * count];
        samples[voxel] = match choice {
            Choice::One(component) => numbers[component],
            Choice::Luminance => {
                let [r, g, b] = [0, 1, 2].map(|i| numbers[i].to_f64());
                let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
                let is_whole = T::TYPE.is_integer();
                T::from_f64(if is_whole {
                    luminance.round()
                } else {
                    luminance
                })
            }
        };
    }
    samples.truncate(voxels);
    samples.shrink_to_fit();
}

/// All components of a file. `read` reads one of them: that of its argument for
/// [`ReadOptions::component`], or whatever the file gives without one. The file is read once for each component.
///
/// # Errors
/// Those of `read`, but for vectors of which no component is picked.
pub fn read_components<E>(
    read: &mut dyn FnMut(Option<usize>) -> Result<LoadedVolume, E>,
    wants_component: impl Fn(&E) -> bool,
) -> Result<LoadedComponents, E> {
    let mut first = match read(None) {
        Err(error) if wants_component(&error) => read(Some(0))?,
        Ok(scalar) if scalar.volume.metadata().components.count < 2 => {
            return Ok(LoadedComponents {
                volumes: vec![scalar.volume],
                labels: scalar.labels,
                notes: scalar.notes,
            });
        }
        Ok(_) => read(Some(0))?,
        Err(error) => return Err(error),
    };
    let count = first.volume.metadata().components.count;
    let note = note_of(0, count);
    first.notes.retain(|other| *other != note);
    let mut volumes = vec![first.volume];
    for component in 1..count {
        volumes.push(read(Some(component))?.volume);
    }
    Ok(LoadedComponents {
        volumes,
        labels: first.labels,
        notes: first.notes,
    })
}

/// Room for `count` numbers of each of `voxels`.
///
/// # Errors
/// More than this machine can address.
pub(crate) fn total(voxels: usize, count: usize) -> Result<usize, Error> {
    let total = voxels.checked_mul(count);
    total
        .filter(|n| *n <= isize::MAX as usize)
        .ok_or_else(|| Error::field("number of components", count, "fewer"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_is_that_of_bt_709() {
        let samples = Samples::U8(vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255]);
        let grey = reduced(samples.clone(), 3, Choice::Luminance);
        assert_eq!(grey, Samples::U8(vec![54, 182, 18, 255]));
        assert_eq!(
            reduced(samples, 3, Choice::One(2)),
            Samples::U8(vec![0, 0, 255, 255])
        );
        let floats = Samples::F32(vec![1.0, 0.5, 0.25, 9.0]);
        assert_eq!(
            reduced(floats, 4, Choice::Luminance),
            Samples::F32(vec![(0.2126 + 0.3576 + 0.01805) as f32])
        );
    }

    #[test]
    fn vectors_are_asked_about() {
        let pick = |count, meaning, component| {
            let options = ReadOptions {
                component,
                ..ReadOptions::default()
            };
            choice(count, meaning, &options, &mut Vec::new())
        };
        assert_eq!(pick(1, Meaning::Vector, None).unwrap(), Choice::One(0));
        assert_eq!(pick(3, Meaning::Vector, Some(2)).unwrap(), Choice::One(2));
        assert_eq!(pick(2, Meaning::Color, None).unwrap(), Choice::One(0));
        let open = pick(3, Meaning::Vector, None).unwrap_err();
        assert_eq!(open.remedy(), Some(Remedy::Component));
        assert!(open.to_string().contains("0 to 2"), "{open}");
        assert!(pick(3, Meaning::Color, Some(3)).is_err());
        assert!(pick(1, Meaning::Color, Some(0)).is_ok());
        assert!(
            pick(1, Meaning::Color, Some(1))
                .unwrap_err()
                .to_string()
                .contains("one number")
        );
    }
}
