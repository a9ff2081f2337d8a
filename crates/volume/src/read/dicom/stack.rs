//! Frames into one even grid: sorted by place, split into moments, checked for gaps.

use super::frames::Frame;
use super::keys::{INSTANCE_NUMBER, KEYS, Key, KeyValue};
use super::ras::ras;
use crate::error::{Error, ErrorKind, Remedy};
use crate::read::ReadOptions;
use glam::{DAffine3, DMat3, DVec3};

/// Which frames make the volume, and where it lies.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// The frames from the first slice to the last.
    pub(super) slices: Vec<usize>,
    /// For slices that lie unevenly: for each slice of the grid the slice below it and how far it
    /// is on the way to the next (0 to 1). Empty if slices and grid are the same.
    pub(super) resampled: Vec<(usize, f64)>,
    /// RAS mm.
    pub(super) world_from_voxel: DAffine3,
    pub(super) time_points: usize,
    /// What the user should know.
    pub(super) notes: Vec<String>,
}

/// Distances may differ by this much: positions are decimal strings, often of two or three digits
/// behind the point, and a hundredth of a slice moves nothing that can be seen.
fn tolerance_mm(spacing_mm: f64) -> f64 {
    (0.01 * spacing_mm).max(0.01)
}

/// Puts frames of one size and orientation in order. `names` are those of their files.
///
/// # Errors
/// Slices that repeat without a reason that can be found, gaps, slices shifted sideways, a time
/// index that is not there.
pub(super) fn arrange(
    frames: &[Frame],
    names: &dyn Fn(&Frame) -> String,
    thickness_mm: Option<f64>,
    options: &ReadOptions,
) -> Result<Stack, Error> {
    let first = &frames[0];
    let normal = first.normal();
    let mut notes = Vec::new();
    let axis = Axis::of(normal);
    let along = |frame: usize| frames[frame].position.dot(normal);

    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by(|a, b| along(*a).total_cmp(&along(*b)));
    // A hundredth of a pixel is the same place; never more than the tolerance of gaps.
    let same_mm = (0.01 * first.spacing[0].min(first.spacing[1])).min(0.01);
    let places: Vec<&[usize]> = order
        .chunk_by(|a, b| along(*b) - along(*a) <= same_mm)
        .collect();
    let moments = moments(frames, &places, &axis, names, &along)?;
    let time_points = moments.columns;
    if options.time_index >= time_points {
        return Err(Error::field(
            "the time index",
            options.time_index,
            match time_points {
                1 => "0; the series holds one volume".to_owned(),
                n => format!("0 to {}", n - 1),
            },
        ));
    }
    notes.extend(
        moments
            .note
            .map(|note| format!("{note}; number {} is taken", options.time_index)),
    );
    let slices: Vec<usize> = moments
        .frames
        .iter()
        .skip(options.time_index)
        .step_by(time_points)
        .copied()
        .collect();

    let n = slices.len();
    let at: Vec<f64> = slices.iter().map(|s| along(*s)).collect();
    let start = frames[slices[0]].position;
    let end = frames[slices[n - 1]].position;
    let mut resampled = Vec::new();
    let mut grid_slices = n;
    let step = if n == 1 {
        let thickness = match (thickness_mm, options.spacing_mm) {
            (_, Some([_, _, z])) => z,
            (Some(mm), _) if mm > 0.0 => mm,
            _ => {
                notes.push("one slice without a thickness: it counts as 1 mm thick".into());
                1.0
            }
        };
        thickness * normal
    } else {
        if let Some(gaps) = gaps(&at, &axis) {
            if !options.allow_gaps {
                let message = format!(
                    "{gaps}. Look for the missing files, or allow even slices to be interpolated"
                );
                return Err(Error::from(ErrorKind::Slices(message)).with_remedy(Remedy::AllowGaps));
            }
            (grid_slices, resampled) = even_grid(&at)?;
            notes.push(format!(
                "{gaps}; {grid_slices} even slices were interpolated from {n}"
            ));
        }
        (end - start) / (grid_slices - 1) as f64
    };
    check_straight(frames, &slices, &at, &axis, names)?;
    if let Some(degrees) = tilt_degrees(step, normal) {
        notes.push(format!(
            "the slices are sheared by {degrees:.2}° (gantry tilt); the grid keeps the shear"
        ));
    }
    Ok(Stack {
        slices,
        resampled,
        world_from_voxel: DAffine3::from_mat3_translation(
            DMat3::from_cols(
                ras(first.row * first.spacing[0]),
                ras(first.column * first.spacing[1]),
                ras(step),
            ),
            ras(start),
        ),
        time_points,
        notes,
    })
}

/// How places along the normal are called in messages.
struct Axis {
    name: &'static str,
}

impl Axis {
    fn of(normal: DVec3) -> Axis {
        let axis_aligned = [(normal.x, "x"), (normal.y, "y"), (normal.z, "z")]
            .into_iter()
            .find(|(part, _)| *part > 0.9999);
        Axis {
            name: axis_aligned.map_or("the position along the normal", |(_, name)| name),
        }
    }
}

/// Rounded to what matters, without trailing zeros.
fn mm(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

struct Moments {
    /// Place by place, moments inside.
    frames: Vec<usize>,
    columns: usize,
    note: Option<String>,
}

/// Several images at one place are moments of a film, echoes, …: finds what tells them apart.
fn moments(
    frames: &[Frame],
    places: &[&[usize]],
    axis: &Axis,
    names: &dyn Fn(&Frame) -> String,
    along: &dyn Fn(usize) -> f64,
) -> Result<Moments, Error> {
    let most = places.iter().map(|place| place.len()).max().unwrap_or(1);
    if most == 1 {
        return Ok(Moments {
            frames: places.concat(),
            columns: 1,
            note: None,
        });
    }
    let describe = |place: &[usize]| {
        let files: Vec<String> = place.iter().take(3).map(|f| names(&frames[*f])).collect();
        format!(
            "{} = {} mm holds {} images ({}{})",
            axis.name,
            mm(along(place[0])),
            place.len(),
            files.join(", "),
            if place.len() > 3 { ", …" } else { "" }
        )
    };
    if let Some(odd) = places.iter().find(|place| place.len() != most) {
        let full = places.iter().filter(|place| place.len() == most).count();
        let fullest = places
            .iter()
            .find(|place| place.len() == most)
            .unwrap_or(odd);
        return Err(ErrorKind::Slices(format!(
            "places repeat unevenly: {} of {} places hold {most} images; {}; {}. Leave the repeated files out",
            full,
            places.len(),
            describe(fullest),
            describe(odd)
        ))
        .into());
    }
    if let Some(split) = tell_apart(frames, places) {
        let list: Vec<String> = split.shown.iter().take(12).cloned().collect();
        return Ok(Moments {
            frames: split.frames,
            columns: most,
            note: Some(format!(
                "the series holds {most} volumes that differ in {} ({}{})",
                split.name,
                list.join(", "),
                if most > 12 { ", …" } else { "" }
            )),
        });
    }
    let keys: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
    Err(ErrorKind::Slices(format!(
        "every place repeats {most} times, and none of {}, alone or together, tells the images apart; {}. Leave the repeated files out",
        keys.join(", "),
        describe(places[0])
    ))
    .into())
}

/// Images at the same places, told apart.
struct Split {
    /// Place by place, those of a place in the order of the keys.
    frames: Vec<usize>,
    /// What tells them apart.
    name: String,
    /// Its values at the first place.
    shown: Vec<String>,
}

/// How many attributes are tried together.
const MOST_KEYS: usize = 4;

/// Finds the attribute, else the fewest attributes together, that tell the images of every place apart.
fn tell_apart(frames: &[Frame], places: &[&[usize]]) -> Option<Split> {
    let differs = |key: &usize| {
        let first = &frames[places[0][0]].keys[*key];
        places[0].iter().any(|f| frames[*f].keys[*key] != *first)
    };
    let (last_resorts, mut usual): (Vec<usize>, Vec<usize>) = (0..KEYS.len())
        .filter(differs)
        .partition(|key| KEYS[*key].is_last_resort);
    let alone = |keys: &[usize]| {
        keys.iter()
            .find_map(|key| split_by(frames, places, &[*key]))
    };
    if let Some(split) = alone(&usual) {
        return Some(split);
    }
    // Attributes that every place shows alike come first: of the others only the order counts.
    usual.sort_by_key(|key| !KEYS[*key].is_shared);
    (2..=MOST_KEYS)
        .flat_map(|count| subsets(&usual, count))
        .find_map(|keys| split_by(frames, places, &keys))
        .or_else(|| alone(&last_resorts))
}

/// All choices of `count` of the keys, in their order.
fn subsets(keys: &[usize], count: usize) -> Vec<Vec<usize>> {
    let (Some((first, rest)), 1..) = (keys.split_first(), count) else {
        return match count {
            0 => vec![Vec::new()],
            _ => Vec::new(),
        };
    };
    let mut with = subsets(rest, count - 1);
    with.iter_mut().for_each(|keys| keys.insert(0, *first));
    with.extend(subsets(rest, count));
    with
}

/// The images of every place in the order of the keys; `None` if these do not tell them apart.
fn split_by(frames: &[Frame], places: &[&[usize]], keys: &[usize]) -> Option<Split> {
    let keys_of = |frame: &usize| -> Vec<&Option<KeyValue>> {
        keys.iter().map(|key| &frames[*frame].keys[*key]).collect()
    };
    let is_shared = |key: &usize| KEYS[*key].is_shared;
    let shared = keys.iter().filter(|key| is_shared(key)).count();
    let mut ordered = Vec::with_capacity(frames.len());
    let mut columns: Option<Vec<Vec<&Option<KeyValue>>>> = None;
    for place in places {
        let mut keyed: Vec<_> = place.iter().map(|f| (keys_of(f), *f)).collect();
        // A value of one's own for each place has to be there; others may be missing, as b = 0 has no direction.
        if keyed
            .iter()
            .any(|(values, _)| values[shared..].contains(&&None))
        {
            return None;
        }
        keyed.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(std::cmp::Ordering::Equal));
        if keyed.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        let first = columns.get_or_insert_with(|| keyed.iter().map(|(v, _)| v.clone()).collect());
        let is_alike =
            |(first, (here, _)): (&Vec<_>, &(Vec<_>, usize))| first[..shared] == here[..shared];
        if !first.iter().zip(&keyed).all(is_alike) {
            return None;
        }
        ordered.extend(keyed.iter().map(|(_, frame)| *frame));
    }
    let columns = columns?;
    let mut order: Vec<usize> = (0..columns.len()).collect();
    if keys.iter().any(|key| !KEYS[*key].is_ordered)
        && let Some(acquired) = order_of_acquisition(frames, &ordered, columns.len())
    {
        ordered = ordered
            .chunks_exact(columns.len())
            .flat_map(|place| acquired.iter().map(|column| place[*column]))
            .collect();
        order = acquired;
    }
    let name = |key: &usize| -> &str {
        let Key { name, .. } = KEYS[*key];
        name
    };
    let shown = |values: &Vec<&Option<KeyValue>>| {
        let texts: Vec<String> = values
            .iter()
            .map(|value| value.as_ref().map_or("none".into(), KeyValue::to_string))
            .collect();
        texts.join(" · ")
    };
    Some(Split {
        frames: ordered,
        name: keys.iter().map(name).collect::<Vec<_>>().join(" and "),
        shown: order
            .iter()
            .map(|column| shown(&columns[*column]))
            .collect(),
    })
}

/// The columns in the order of their instance numbers, if that is the same at all places.
fn order_of_acquisition(frames: &[Frame], ordered: &[usize], columns: usize) -> Option<Vec<usize>> {
    let mut found: Option<Vec<usize>> = None;
    for place in ordered.chunks_exact(columns) {
        let instance = |column: &usize| frames[place[*column]].keys[INSTANCE_NUMBER].as_ref();
        let mut order: Vec<usize> = (0..columns).collect();
        order.sort_by(|a, b| {
            let order = instance(a).partial_cmp(&instance(b));
            order.unwrap_or(std::cmp::Ordering::Equal)
        });
        let is_strict = order
            .windows(2)
            .all(|pair| instance(&pair[0]) < instance(&pair[1]));
        if !is_strict || found.get_or_insert_with(|| order.clone()) != &order {
            return None;
        }
    }
    found
}

/// What is uneven about rising positions, if anything: each gap with its places.
fn gaps(at: &[f64], axis: &Axis) -> Option<String> {
    let distances: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = usual_mm(&distances);
    let tolerance = tolerance_mm(usual);
    let is_uneven = |distance: f64| (distance - usual).abs() > tolerance;
    let uneven: Vec<String> = distances
        .iter()
        .enumerate()
        .filter(|(_, distance)| is_uneven(**distance))
        .map(|(i, distance)| {
            format!(
                "between {} = {} and {}: {} mm instead of {} mm",
                axis.name,
                mm(at[i]),
                mm(at[i + 1]),
                mm(*distance),
                mm(usual)
            )
        })
        .collect();
    if !uneven.is_empty() {
        let shown = uneven[..uneven.len().min(5)].join("; ");
        let more = match uneven.len() {
            n @ 6.. => format!("; and {} more", n - 5),
            _ => String::new(),
        };
        return Some(format!("the slices are uneven {shown}{more}"));
    }
    // Small differences of one sign add up.
    let step = (at[at.len() - 1] - at[0]) / distances.len() as f64;
    let (worst, off) = at
        .iter()
        .enumerate()
        .map(|(i, z)| (i, (z - at[0] - i as f64 * step).abs()))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (off > (0.1 * step).max(2.0 * tolerance)).then(|| {
        format!(
            "the slices are uneven: {} = {} is {} mm away from the even grid",
            axis.name,
            mm(at[worst]),
            mm(off)
        )
    })
}

/// The median distance.
fn usual_mm(distances: &[f64]) -> f64 {
    let mut sorted = distances.to_vec();
    sorted.sort_by(f64::total_cmp);
    // The lower one of two in the middle: of two distances the shorter is the usual one.
    sorted[(sorted.len() - 1) / 2]
}

/// An even grid over rising positions, and where each of its slices lies among them.
fn even_grid(at: &[f64]) -> Result<(usize, Vec<(usize, f64)>), Error> {
    let distances: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (first, last) = (at[0], at[at.len() - 1]);
    let steps = ((last - first) / usual_mm(&distances)).round().max(1.0);
    // More would be invention, and memory that no file backs.
    if steps > 4.0 * at.len() as f64 {
        return Err(ErrorKind::Slices(format!(
            "{} slices are there of about {}; with more than three quarters missing they are not interpolated",
            at.len(),
            steps + 1.0
        ))
        .into());
    }
    let count = steps as usize + 1;
    let step = (last - first) / steps;
    let mut below = 0;
    let places = (0..count)
        .map(|slice| {
            let z = first + slice as f64 * step;
            while below + 2 < at.len() && at[below + 1] <= z {
                below += 1;
            }
            let part = (z - at[below]) / (at[below + 1] - at[below]);
            (below, part.clamp(0.0, 1.0))
        })
        .collect();
    Ok((count, places))
}

/// Slices must lie on one line, else no affine map holds them.
fn check_straight(
    frames: &[Frame],
    slices: &[usize],
    at: &[f64],
    axis: &Axis,
    names: &dyn Fn(&Frame) -> String,
) -> Result<(), Error> {
    let n = slices.len();
    if n < 3 {
        return Ok(());
    }
    let (start, end) = (frames[slices[0]].position, frames[slices[n - 1]].position);
    // A tenth of a pixel cannot be seen, and is beyond rounding.
    let spacing = frames[slices[0]].spacing;
    let tolerance = (0.1 * spacing[0].min(spacing[1])).max(0.02);
    for (slice, z) in slices.iter().zip(at) {
        let frame = &frames[*slice];
        let expected = start.lerp(end, (z - at[0]) / (at[n - 1] - at[0]));
        let off = expected.distance(frame.position);
        if off > tolerance {
            return Err(ErrorKind::Slices(format!(
                "the slice at {} = {} ({}) is shifted sideways by {} mm from the line through the others; such a series is no single grid",
                axis.name,
                mm(*z),
                names(frame),
                mm(off)
            ))
            .into());
        }
    }
    Ok(())
}

/// The angle between slice direction and normal, if it is more than rounding.
fn tilt_degrees(step: DVec3, normal: DVec3) -> Option<f64> {
    let degrees = step
        .cross(normal)
        .length()
        .atan2(step.dot(normal))
        .to_degrees();
    (degrees > 0.05).then_some(degrees)
}
