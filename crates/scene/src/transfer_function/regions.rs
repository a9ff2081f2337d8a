//! Two-dimensional transfer functions: areas of value and gradient magnitude → a table of rows.

use crate::Color;
use crate::light::check_color;
use crate::plan::{Classify, Compositing};
use crate::problem::{Checker, Within};
use crate::transfer::TransferTable;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Values beyond are no help to anybody, and their differences would overflow f32.
pub(super) const LARGEST_VALUE: f64 = 1e30;

/// Entries of a row: a byte of values, twice.
const COLUMNS: usize = 512;
/// Transparent entries at either end of a row: skipping looks at neighbors of the entries around a value.
const BEYOND: usize = 4;
/// Rows from no gradient to beyond the steepest corner.
const ROWS: usize = 128;
const MOST_CORNERS: usize = 256;
const MOST_REGIONS: usize = 256;
/// Places along each axis at which an entry looks whether it lies in a region.
const PLACES: usize = 4;

/// An area of value and gradient magnitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TransferRegion {
    /// The corners of a polygon, 3 to 256, each a value and a gradient magnitude per mm.
    pub corners: Vec<[f64; 2]>,
    /// Opacity of one reference length, 0 to 1; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f64>,
    /// Color; default white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
}

pub(super) fn check(regions: &[TransferRegion], checker: &mut Checker) {
    let path = "transfer_function.regions";
    if regions.len() > MOST_REGIONS {
        let allowed = format!("up to {MOST_REGIONS}");
        checker.add(path, format!("{} regions", regions.len()), &allowed);
        return;
    }
    for (i, region) in regions.iter().enumerate() {
        let path = format!("{path}[{i}]");
        let number = region.corners.len();
        if !(3..=MOST_CORNERS).contains(&number) {
            let allowed = format!("3 to {MOST_CORNERS}");
            checker.add(
                format!("{path}.corners"),
                format!("{number} corners"),
                &allowed,
            );
        }
        for (j, [value, steepness]) in region.corners.iter().enumerate() {
            let path = format!("{path}.corners[{j}]");
            let large = Within::Closed(-LARGEST_VALUE, LARGEST_VALUE);
            checker.number(&format!("{path}[0]"), *value, large);
            let steep = Within::Closed(0.0, LARGEST_VALUE);
            checker.number(&format!("{path}[1]"), *steepness, steep);
        }
        if let Some(opacity) = region.opacity {
            checker.number(
                &format!("{path}.opacity"),
                opacity,
                Within::Closed(0.0, 1.0),
            );
        }
        if let Some(color) = region.color {
            check_color(&format!("{path}.color"), color, checker);
        }
        if (3..=MOST_CORNERS).contains(&number) && is_line(&region.corners) {
            let allowed = "a polygon with an area";
            checker.add(format!("{path}.corners"), "on one line", allowed);
        }
    }
}

/// Whether all corners lie on one line.
fn is_line(corners: &[[f64; 2]]) -> bool {
    let [x, y] = corners[0];
    let ways = || corners.iter().map(|corner| [corner[0] - x, corner[1] - y]);
    ways().all(|a| ways().all(|b| a[0] * b[1] == a[1] * b[0]))
}

/// From the least to the largest value, and gradient magnitude.
fn bounds(regions: &[TransferRegion]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let all = regions.iter().flat_map(|region| &region.corners);
        let all = all.map(|corner| corner[axis]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    })
}

/// The gradient magnitude of the last row.
fn full_per_mm(regions: &[TransferRegion]) -> f64 {
    let [_, [_, top]] = bounds(regions);
    // The last row is beyond all.
    top * (ROWS - 1) as f64 / (ROWS - 2) as f64
}

/// How a volume is classified whose table these regions made; `None` without regions.
pub(crate) fn classify_of(regions: &[TransferRegion]) -> Option<Classify> {
    (!regions.is_empty()).then(|| Classify::ValueGradient {
        full_per_mm: full_per_mm(regions) as f32,
        columns: COLUMNS as u32,
        rows: ROWS as u32,
    })
}

/// The table of regions that were checked. An entry has what the share of it that lies in a region says.
pub(super) fn table(
    regions: &[TransferRegion],
    reference_mm: f32,
    compositing: Compositing,
) -> TransferTable {
    let [[left, right], _] = bounds(regions);
    let width = (right - left) / (COLUMNS - 2 * BEYOND - 1) as f64;
    let height = full_per_mm(regions) / (ROWS - 1) as f64;
    let low = left - BEYOND as f64 * width;
    let mut rows = vec![[0.0f32; 4]; COLUMNS * ROWS];
    for region in regions {
        let color = region.color.unwrap_or(Color::WHITE).in_space(compositing);
        let opacity = region.opacity.unwrap_or(1.0);
        for (i, entry) in rows.iter_mut().enumerate() {
            let at = [(i % COLUMNS) as f64, (i / COLUMNS) as f64];
            let share = share_inside(region, [low, 0.0], at, [width, height]);
            lay_over(entry, color, (opacity * share) as f32);
        }
    }
    let high = low + width * (COLUMNS - 1) as f64;
    let (low, mut high) = (low as f32, high as f32);
    if high <= low {
        high = low.next_up();
    }
    TransferTable::of_rows([low, high], reference_mm, COLUMNS, rows)
}

/// The share of the entry in column and row `at` that lies in a region.
fn share_inside(region: &TransferRegion, first: [f64; 2], at: [f64; 2], size: [f64; 2]) -> f64 {
    let mut inside = 0;
    for i in 0..PLACES * PLACES {
        let offset = [i % PLACES, i / PLACES].map(|n| (n as f64 + 0.5) / PLACES as f64 - 0.5);
        // The first row stands for no gradient alone: nothing lies below it.
        let place = [0, 1].map(|axis| {
            let place = first[axis] + size[axis] * (at[axis] + offset[axis]);
            if axis == 1 {
                place.max(1e-6 * size[1])
            } else {
                place
            }
        });
        inside += usize::from(is_inside(&region.corners, place));
    }
    inside as f64 / (PLACES * PLACES) as f64
}

/// Whether a polygon is around a place: the edges to its right are odd in number.
fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut is_inside = false;
    for (i, to) in corners.iter().enumerate() {
        let from = corners[(i + corners.len() - 1) % corners.len()];
        if (from[1] > y) != (to[1] > y) {
            let crossing = from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
            is_inside ^= x < crossing;
        }
    }
    is_inside
}

/// Lays a color over an entry that is not premultiplied.
fn lay_over(entry: &mut [f32; 4], color: [f32; 3], opacity: f32) {
    let behind = entry[3] * (1.0 - opacity);
    let alpha = opacity + behind;
    if opacity <= 0.0 {
        return;
    }
    for (channel, own) in entry.iter_mut().zip(color) {
        *channel = (opacity * own + behind * *channel) / alpha;
    }
    entry[3] = alpha;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(corners: &[[f64; 2]], opacity: f64, color: [f64; 3]) -> TransferRegion {
        TransferRegion {
            corners: corners.to_vec(),
            opacity: Some(opacity),
            color: Some(Color(color)),
        }
    }

    #[test]
    fn entries_are_those_of_the_regions_around_them() {
        let square = [[10.0, 0.0], [50.0, 0.0], [50.0, 8.0], [10.0, 8.0]];
        let triangle = [[30.0, 0.0], [50.0, 8.0], [30.0, 8.0]];
        let regions = [
            region(&square, 0.5, [1.0, 0.0, 0.0]),
            region(&triangle, 1.0, [0.0, 0.0, 1.0]),
        ];
        let table = table(&regions, 2.0, Compositing::Linear);
        let [low, high] = table.domain().map(f64::from);
        let at = |value: f64, per_mm: f64| {
            let column = ((value - low) / (high - low)).min(1.0) * (COLUMNS - 1) as f64;
            let row = (per_mm / full_per_mm(&regions)).min(1.0) * (ROWS - 1) as f64;
            table.rows()[row.round() as usize * COLUMNS + column.round() as usize]
        };
        assert_eq!(at(20.0, 4.0), [1.0, 0.0, 0.0, 0.5]);
        assert_eq!(at(20.0, 0.0), [1.0, 0.0, 0.0, 0.5]);
        assert_eq!(at(45.0, 1.0), [1.0, 0.0, 0.0, 0.5]);
        assert_eq!(at(33.0, 7.0), [0.0, 0.0, 1.0, 1.0]);
        for [value, per_mm] in [[9.5, 4.0], [50.5, 4.0], [20.0, 8.1]] {
            assert_eq!(at(value, per_mm)[3], 0.0, "{value} {per_mm}");
        }
        assert_eq!(
            (table.entries().len(), table.max_opacity(12.0, 25.0)),
            (COLUMNS, 0.5)
        );
        assert_eq!(table.max_opacity(35.0, 36.0), 1.0);
    }
}
