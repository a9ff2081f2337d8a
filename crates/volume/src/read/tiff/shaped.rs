//! What the Python library tifffile writes into the first page: the shape of the array and what its axes are.
//!
//! ```text
//! {"shape": [2, 3, 4, 5], "axes": "TZYX"}        shape=(2, 3, 4, 5)
//! ```
//!
//! The last two axes are the page. Without `axes`, three are slices and four are (time, z, y, x), as for npy.

use super::description::{Description, Writer};

/// Nothing if the text says no shape. `numbers` is how many a pixel has.
pub(super) fn parse(text: &str, numbers: usize) -> Option<Description> {
    let text = text.trim();
    let list = match text.strip_prefix("shape=(") {
        Some(rest) => rest,
        None if text.starts_with('{') => {
            let value = value_of(text, "shape")?;
            value.strip_prefix('[')?
        }
        None => return None,
    };
    let list = &list[..list.find([')', ']'])?];
    let shape: Vec<usize> = list
        .split(',')
        .map(str::trim)
        .filter(|number| !number.is_empty())
        .map(|number| number.parse().ok())
        .collect::<Option<_>>()?;
    let axes = match text.starts_with('{') {
        true => value_of(text, "axes").and_then(|value| {
            let value = value.strip_prefix('"')?;
            Some(&value[..value.find('"')?])
        }),
        false => None,
    };
    let axes = axes.filter(|axes| axes.is_ascii() && axes.len() == shape.len());
    // Numbers of a pixel are the last axis.
    let shape = match shape.split_last() {
        Some((last, rest)) if axes.is_none() && numbers > 1 && *last == numbers => rest,
        _ => &shape,
    };
    described(shape, axes)
}

/// What follows a key of a JSON object.
fn value_of<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let after = text.split_once(&format!("\"{key}\""))?.1;
    Some(after.trim_start().strip_prefix(':')?.trim_start())
}

fn described(shape: &[usize], axes: Option<&str>) -> Option<Description> {
    let images = |shape: &[usize]| {
        let product = shape
            .iter()
            .try_fold(1usize, |n, &size| n.checked_mul(size));
        product.filter(|n| *n > 0)
    };
    let mut found = Description::of_writer(Writer::Tifffile);
    let Some(axes) = axes else {
        let (_, before) = shape
            .split_last_chunk::<2>()
            .map(|(rest, page)| (page, rest))?;
        found.images = Some(images(before)?);
        let long: Vec<usize> = before.iter().copied().filter(|n| *n > 1).collect();
        (found.times, found.slices) = match long[..] {
            [] => (1, 1),
            [slices] => (1, slices),
            [times, slices] => (times, slices),
            _ => (1, images(before)?),
        };
        found.is_guessed = long.len() > 1;
        return Some(found);
    };
    // Samples of a pixel may lie behind the page's axes.
    let page = axes.find("YX")?;
    found.images = Some(images(&shape[..page])?);
    found.channels = images(&shape[page + 2..])?;
    let mut last = ' ';
    for (axis, &size) in axes
        .chars()
        .zip(&shape[..page])
        .filter(|(_, size)| **size > 1)
    {
        match axis {
            'T' => found.times *= size,
            'Z' => found.slices *= size,
            'C' | 'S' => found.channels *= size,
            // Some sequence: slices, or times if there are slices.
            _ if axes[..page].contains('Z') => found.times *= size,
            _ => found.slices *= size,
        }
        if matches!(axis, 'T' | 'Z') {
            found.time_is_faster = axis == 'T' && last == 'Z';
            last = axis;
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_say_what_is_slice_and_time() {
        let order = |text: &str| {
            let found = parse(text, 1)?;
            Some((
                found.slices,
                found.times,
                found.channels,
                found.time_is_faster,
            ))
        };
        for (text, expected) in [
            (
                r#"{"shape": [2, 3, 4, 5], "axes": "TZYX"}"#,
                (3, 2, 1, false),
            ),
            (
                r#"{"axes": "ZTYX", "shape": [3, 2, 4, 5]}"#,
                (3, 2, 1, true),
            ),
            (
                r#"{"shape": [2, 1, 3, 4, 5], "axes": "TCZYX"}"#,
                (3, 2, 1, false),
            ),
            (
                r#"{"shape": [2, 3, 4, 5], "axes": "CZYX"}"#,
                (3, 1, 2, false),
            ),
            (r#"{"shape": [3, 4, 5], "axes": "QYX"}"#, (3, 1, 1, false)),
            (
                r#"{"shape": [7, 3, 4, 5], "axes": "QZYX"}"#,
                (3, 7, 1, false),
            ),
            (r#"{"shape": [4, 5], "axes": "YX"}"#, (1, 1, 1, false)),
            (r#"{"shape": [2, 3, 4, 5]}"#, (3, 2, 1, false)),
            (r#"{"shape": [3, 1, 4, 5]}"#, (3, 1, 1, false)),
            ("shape=(6, 4, 5)", (6, 1, 1, false)),
        ] {
            assert_eq!(order(text), Some(expected), "{text}");
        }
        let colors = parse(r#"{"shape": [7, 4, 5, 3]}"#, 3).unwrap();
        assert_eq!(
            (colors.slices, colors.times, colors.images),
            (7, 1, Some(7))
        );
        for text in [
            "{}",
            "made by hand",
            r#"{"shape": [4.5]}"#,
            r#"{"shape": [0, 4, 5]}"#,
        ] {
            assert_eq!(order(text), None, "{text}");
        }
    }
}
