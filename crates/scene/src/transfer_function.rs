//! The transfer function, as people write it, and its way to a [`TransferTable`].

mod regions;

use regions::LARGEST_VALUE;
pub use regions::TransferRegion;
pub(crate) use regions::classify_of;

use crate::light::check_color;
use crate::plan::Compositing;
use crate::problem::{Checker, Within};
use crate::transfer::TransferTable;
use crate::window::{Window, round_to_width};
use crate::{Color, ColorMap, Method};
#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
#[cfg(feature = "schema")]
use std::borrow::Cow;
use std::fmt;
use strahl_volume::VolumeHeader;

/// Maps values to color and opacity: points, a color map over a window, or a combination.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct TransferFunction {
    /// Points in ascending order of value. Color and opacity are each linear between the points
    /// that have them (color in sRGB). Two points with the same value make a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<TransferPoint>>,
    /// What the values of points count in; default `values`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points_in: Option<PointsIn>,
    /// Width of the window in values; default chosen from the histogram.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<f64>,
    /// Center of the window in values; default chosen from the histogram.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Colors over the window, for points without a color; default `grey`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_map: Option<ColorMap>,
    /// Opacity at the low and the high end of the window, for points without opacity; default 0
    /// and 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<[f64; 2]>,
    /// Areas of value and gradient magnitude, in place of points: a two-dimensional transfer function. Later ones lie over
    /// earlier ones; elsewhere everything is transparent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regions: Option<Vec<TransferRegion>>,
    /// The length of material in mm that an opacity refers to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_mm: Option<f64>,
    /// The same in units of the mean voxel spacing; default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_voxels: Option<f64>,
}

/// What regions do not go together with.
fn check_beside_regions(function: &TransferFunction, path: &str, checker: &mut Checker) {
    for (is_set, key) in [
        (function.points.is_some(), "points"),
        (function.window.is_some(), "window"),
        (function.level.is_some(), "level"),
        (function.color_map.is_some(), "color_map"),
        (function.opacity.is_some(), "opacity"),
    ] {
        if is_set {
            let path = format!("{path}transfer_function.{key}");
            checker.add(
                path,
                "set together with regions",
                "either regions, or points, window, level, color_map and opacity",
            );
        }
    }
}

/// What the values of transfer function points count in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PointsIn {
    /// Values of the volume (HU for CT).
    Values,
    /// Fractions of the window: 0 is its low end, 1 its high end.
    Window,
}

/// A point of a transfer function: `{"value": 300, "opacity": 0.4, "color": "#eee"}`, or shorter
/// `[300, 0.4, "#eee"]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferPoint {
    /// The value.
    pub value: f64,
    /// Opacity of one reference length of this value, 0 to 1.
    pub opacity: Option<f64>,
    /// Color.
    pub color: Option<Color>,
}

impl TransferPoint {
    /// A point with all it can have.
    pub const fn new(value: f64, opacity: f64, color: Color) -> TransferPoint {
        TransferPoint {
            value,
            opacity: Some(opacity),
            color: Some(color),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
struct PointKeys {
    value: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    opacity: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    color: Option<Color>,
}

impl Serialize for TransferPoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PointKeys {
            value: self.value,
            opacity: self.opacity,
            color: self.color,
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TransferPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<TransferPoint, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = TransferPoint;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str(
                    "a point: {\"value\": …, \"opacity\": …, \"color\": …} or [value, opacity, color]",
                )
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<TransferPoint, A::Error> {
                let keys = PointKeys::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(TransferPoint {
                    value: keys.value,
                    opacity: keys.opacity,
                    color: keys.color,
                })
            }

            fn visit_seq<A: de::SeqAccess<'de>>(
                self,
                mut seq: A,
            ) -> Result<TransferPoint, A::Error> {
                let value = seq
                    .next_element()?
                    .ok_or_else(|| de::Error::invalid_length(0, &self))?;
                let point = TransferPoint {
                    value,
                    opacity: seq.next_element()?.flatten(),
                    color: seq.next_element()?.flatten(),
                };
                if seq.next_element::<de::IgnoredAny>()?.is_some() {
                    return Err(de::Error::invalid_length(4, &self));
                }
                Ok(point)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for TransferPoint {
    fn schema_name() -> Cow<'static, str> {
        "TransferPoint".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let keys = generator.subschema_for::<PointKeys>();
        let color = generator.subschema_for::<Color>();
        json_schema!({
            "description": "A point, with keys or as [value, opacity, color]",
            "anyOf": [
                keys,
                {
                    "type": "array", "minItems": 1, "maxItems": 3,
                    "prefixItems": [
                        { "type": "number" },
                        { "type": ["number", "null"], "minimum": 0, "maximum": 1 },
                        { "anyOf": [color, { "type": "null" }] }
                    ]
                }
            ]
        })
    }
}

/// A table of 65,536 entries takes 1 MiB; more would be slower to look up than to compute.
const MOST_ENTRIES: usize = 1 << 16;
/// With fewer entries than this (64 KiB, at home in a CPU's second cache) nothing is saved.
const FEWEST_ENTRIES: usize = 1 << 12;

/// [`TransferFunction`] with everything said that it stands on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SettledFunction {
    /// In values.
    pub points: Vec<TransferPoint>,
    /// `None`: colors are the points'.
    pub color_map: Option<ColorMap>,
    /// At the ends of the window; `None`: opacities are the points'.
    pub opacity: Option<[f64; 2]>,
    /// `None` if nothing counts in it.
    pub window: Option<SettledWindow>,
    /// In place of all that, if there are some.
    pub regions: Vec<TransferRegion>,
    pub reference: Reference,
}

/// A window of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledWindow {
    pub level: f64,
    pub width: f64,
}

/// The length of material that an opacity belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reference {
    Mm(f64),
    /// Mean voxel spacings.
    Voxels(f64),
}

impl Reference {
    /// `reference_mm` or `reference_voxels`.
    fn scene(self) -> (Option<f64>, Option<f64>) {
        match self {
            Reference::Mm(mm) => (Some(mm), None),
            Reference::Voxels(voxels) => (None, Some(voxels)),
        }
    }
}

impl SettledWindow {
    pub fn ends(self) -> [f64; 2] {
        let half = 0.5 * self.width;
        [self.level - half, self.level + half]
    }
}

impl TransferFunction {
    /// `path` is that of the object it belongs to, with a dot; empty for the scene's own volume.
    pub(crate) fn settled(
        &self,
        method: Method,
        header: &VolumeHeader,
        path: &str,
        checker: &mut Checker,
    ) -> SettledFunction {
        if self.points.as_ref().is_some_and(Vec::is_empty) {
            let path = format!("{path}transfer_function.points");
            checker.add(path, "empty", "one point or more");
        }
        if let Some(regions) = &self.regions {
            check_beside_regions(self, path, checker);
            if regions.is_empty() {
                let path = format!("{path}transfer_function.regions");
                checker.add(path, "empty", "one region or more");
            }
        }
        let mut points = self.points.clone().unwrap_or_default();
        let colors = points.iter().any(|point| point.color.is_some());
        let opacities = points.iter().any(|point| point.opacity.is_some());
        let relative = self.points_in == Some(PointsIn::Window) && !points.is_empty();
        let says_window = self.window.is_some() || self.level.is_some();
        let window = (!colors || !opacities || relative || says_window).then(|| {
            let automatic = Window::automatic(method, header);
            SettledWindow {
                level: self.level.unwrap_or(automatic.middle()),
                width: self.window.unwrap_or(automatic.width()),
            }
        });
        // In a wrong window the points would be wrong as well: only the window is reported.
        if let (true, Some(SettledWindow { level, width })) = (relative, window)
            && width > 0.0
            && width.is_finite()
            && level.is_finite()
        {
            for point in &mut points {
                point.value = round_to_width(level + (point.value - 0.5) * width, width);
            }
        }
        // The window has done its work unless a color map or a ramp stands on it.
        let stands_on_window = !colors || !opacities || says_window;
        SettledFunction {
            points,
            color_map: self.color_map.or((!colors).then_some(ColorMap::Grey)),
            opacity: self.opacity.or((!opacities).then_some([0.0, 1.0])),
            window: window.filter(|_| stands_on_window),
            regions: self.regions.clone().unwrap_or_default(),
            reference: match (self.reference_mm, self.reference_voxels) {
                (Some(mm), voxels) => {
                    if let Some(voxels) = voxels {
                        checker.add(
                            format!("{path}transfer_function.reference_voxels"),
                            voxels,
                            "either reference_mm or reference_voxels",
                        );
                    }
                    Reference::Mm(mm)
                }
                (None, voxels) => Reference::Voxels(voxels.unwrap_or(1.0)),
            },
        }
    }

    /// This transfer function with what it does not say taken from a preset's. Points replace the
    /// preset's altogether; a color map replaces its colors, the two opacities its opacities; a
    /// window moves points that count in it and replaces those that count in values.
    pub(crate) fn over(&self, preset: &TransferFunction) -> TransferFunction {
        if self.points.is_some() || self.regions.is_some() {
            return self.clone();
        }
        let mut merged = preset.clone();
        let windowed = self.window.is_some() || self.level.is_some();
        if windowed && preset.points_in != Some(PointsIn::Window) {
            merged.points = None;
            merged.points_in = None;
        }
        if let Some(points) = &mut merged.points {
            if self.color_map.is_some() {
                // The map runs over the preset's points, not over a window it knows nothing of.
                if let (Some(first), Some(last), false, None | Some(PointsIn::Values)) =
                    (points.first(), points.last(), windowed, preset.points_in)
                {
                    merged.window = Some(last.value - first.value);
                    merged.level = Some(0.5 * (last.value + first.value));
                }
                points.iter_mut().for_each(|point| point.color = None);
            }
            if self.opacity.is_some() {
                points.iter_mut().for_each(|point| point.opacity = None);
            }
            if self.color_map.is_some() && self.opacity.is_some() {
                merged.points = None;
                merged.points_in = None;
            }
        }
        let own_reference = self.reference_mm.is_some() || self.reference_voxels.is_some();
        TransferFunction {
            regions: None,
            points: merged.points,
            points_in: self.points_in.or(merged.points_in),
            window: self.window.or(merged.window),
            level: self.level.or(merged.level),
            color_map: self.color_map.or(merged.color_map),
            opacity: self.opacity.or(merged.opacity),
            reference_mm: if own_reference {
                self.reference_mm
            } else {
                merged.reference_mm
            },
            reference_voxels: if own_reference {
                self.reference_voxels
            } else {
                merged.reference_voxels
            },
        }
    }
}

impl SettledFunction {
    /// The largest opacity, from 0 to 1.
    pub fn most_opaque(&self) -> f64 {
        if !self.regions.is_empty() {
            let of_regions = self.regions.iter().map(|r| r.opacity.unwrap_or(1.0));
            return of_regions.fold(0.0, f64::max).clamp(0.0, 1.0);
        }
        let of_points = self.points.iter().filter_map(|point| point.opacity);
        let opacities = of_points.chain(self.opacity.into_iter().flatten());
        opacities.fold(0.0, f64::max).clamp(0.0, 1.0)
    }

    /// As a scene says it.
    pub fn scene(&self) -> TransferFunction {
        if !self.regions.is_empty() {
            let (reference_mm, reference_voxels) = self.reference.scene();
            return TransferFunction {
                regions: Some(self.regions.clone()),
                reference_mm,
                reference_voxels,
                ..TransferFunction::default()
            };
        }
        let has_points = !self.points.is_empty();
        let (reference_mm, reference_voxels) = self.reference.scene();
        TransferFunction {
            regions: None,
            points: has_points.then(|| self.points.clone()),
            points_in: has_points.then_some(PointsIn::Values),
            window: self.window.map(|window| window.width),
            level: self.window.map(|window| window.level),
            color_map: self.color_map,
            opacity: self.opacity,
            reference_mm,
            reference_voxels,
        }
    }

    /// The table of a plan.
    pub fn plan(
        &self,
        header: &VolumeHeader,
        compositing: Compositing,
        checker: &mut Checker,
    ) -> Option<TransferTable> {
        let before = checker.problems.len();
        self.check(header, checker);
        if checker.problems.len() > before {
            return None;
        }
        let reference_mm = match self.reference {
            Reference::Mm(mm) => mm,
            Reference::Voxels(voxels) => voxels * header.grid.mean_spacing_mm(),
        } as f32;
        if !(reference_mm > 0.0 && reference_mm.is_finite()) {
            checker.add(
                "transfer_function.reference_mm",
                reference_mm,
                "a length that a 32-bit number can hold",
            );
            return None;
        }
        if !self.regions.is_empty() {
            return Some(regions::table(&self.regions, reference_mm, compositing));
        }
        Some(self.curves().table(header, reference_mm, compositing))
    }

    fn check(&self, header: &VolumeHeader, checker: &mut Checker) {
        regions::check(&self.regions, checker);
        let points = &self.points;
        if points.len() > MOST_ENTRIES {
            checker.add(
                "transfer_function.points",
                format!("{} points", points.len()),
                &format!("up to {MOST_ENTRIES}"),
            );
            return;
        }
        let mut last = f64::NEG_INFINITY;
        for (i, point) in points.iter().enumerate() {
            let path = format!("transfer_function.points[{i}]");
            if checker.number(
                &format!("{path}.value"),
                point.value,
                Within::Closed(-LARGEST_VALUE, LARGEST_VALUE),
            ) {
                if point.value < last {
                    checker.add(
                        format!("{path}.value"),
                        point.value,
                        &format!("{last} or more: points ascend"),
                    );
                }
                last = point.value;
            }
            if let Some(opacity) = point.opacity {
                checker.number(
                    &format!("{path}.opacity"),
                    opacity,
                    Within::Closed(0.0, 1.0),
                );
            }
            if let Some(color) = point.color {
                check_color(&format!("{path}.color"), color, checker);
            }
        }
        let colors = points.iter().any(|point| point.color.is_some());
        let opacities = points.iter().any(|point| point.opacity.is_some());
        if let (true, Some(map)) = (colors, self.color_map) {
            checker.add(
                "transfer_function.color_map",
                format!("{:?} beside points with colors", map.name()),
                "colors either from the points or from a map",
            );
        }
        if let Some(ends) = self.opacity {
            if opacities {
                checker.add(
                    "transfer_function.opacity",
                    format!("{ends:?} beside points with opacities"),
                    "opacities either from the points or from the ends of the window",
                );
            }
            for (i, end) in ends.into_iter().enumerate() {
                checker.number(
                    &format!("transfer_function.opacity[{i}]"),
                    end,
                    Within::Closed(0.0, 1.0),
                );
            }
        }
        if let Some(SettledWindow { level, width }) = self.window {
            checker.number(
                "transfer_function.window",
                width,
                // As wide as the widest volume.
                Within::Above(0.0, 2.0 * LARGEST_VALUE),
            );
            checker.number(
                "transfer_function.level",
                level,
                Within::Closed(-LARGEST_VALUE, LARGEST_VALUE),
            );
        }
        match self.reference {
            Reference::Mm(mm) => checker.number(
                "transfer_function.reference_mm",
                mm,
                Within::Closed(1e-9, 1e9),
            ),
            Reference::Voxels(voxels) => checker.number(
                "transfer_function.reference_voxels",
                voxels,
                Within::Closed(1e-6, 1e6),
            ),
        };
        // What cannot be said of a scene alone: the values of the file itself.
        let [lo, hi] = header.statistics.range;
        if !(lo.abs() <= LARGEST_VALUE && hi.abs() <= LARGEST_VALUE) {
            checker.add(
                "volume",
                format!("a volume with values from {lo} to {hi}"),
                &format!("values from -{LARGEST_VALUE} to {LARGEST_VALUE}"),
            );
        }
    }

    fn curves(&self) -> Curves {
        // Without a window nothing below counts in it.
        let window = self.window.map_or([0.0, 1.0], SettledWindow::ends);
        let points = &self.points;
        Curves {
            color: match self.color_map {
                Some(map) => ColorCurve::Map(map, window),
                None => ColorCurve::Points(
                    points
                        .iter()
                        .filter_map(|point| Some((point.value, point.color?.0)))
                        .collect(),
                ),
            },
            opacity: match self.opacity {
                Some([lo, hi]) => vec![(window[0], [lo]), (window[1], [hi])],
                None => points
                    .iter()
                    .filter_map(|point| Some((point.value, [point.opacity?])))
                    .collect(),
            },
        }
    }
}

/// The exact transfer function: continuous pieces in sRGB.
struct Curves {
    color: ColorCurve,
    opacity: Vec<(f64, [f64; 1])>,
}

enum ColorCurve {
    Points(Vec<(f64, [f64; 3])>),
    Map(ColorMap, [f64; 2]),
}

impl Curves {
    /// sRGB and opacity at a value; at a step its upper side.
    fn at(&self, value: f64, tolerance: f64) -> ([f64; 3], f64) {
        let color = match &self.color {
            ColorCurve::Points(points) => piecewise(points, value, tolerance),
            ColorCurve::Map(map, [lo, hi]) if lo < hi => map.at((value - lo) / (hi - lo)).0,
            // Narrower than the numbers at its level can tell apart: a step.
            ColorCurve::Map(map, [lo, _]) => map.at(f64::from(value + tolerance >= *lo)).0,
        };
        (color, piecewise(&self.opacity, value, tolerance)[0])
    }

    /// Every value at which a piece ends, ascending.
    fn knots(&self) -> Vec<f64> {
        let mut knots: Vec<f64> = self.opacity.iter().map(|point| point.0).collect();
        match &self.color {
            ColorCurve::Points(points) => knots.extend(points.iter().map(|point| point.0)),
            ColorCurve::Map(_, window) => knots.extend(window),
        }
        knots.sort_by(f64::total_cmp);
        knots
    }

    /// The table. Its entries cover the pieces of the function and one more spacing on each side, so
    /// that a step at an end stays a step, but no more than the values of the volume.
    ///
    /// Integer volumes: entries lie at the stored values and evenly between them, so a peak one
    /// stored value wide survives and is exact at voxels; up to 65,536 stored values. Other volumes:
    /// at least 4096 entries, and four to the narrowest piece up to 65,536 entries.
    fn table(
        &self,
        header: &VolumeHeader,
        reference_mm: f32,
        compositing: Compositing,
    ) -> TransferTable {
        let [range_lo, range_hi] = header.statistics.range;
        let knots = self.knots();
        let (mut lo, mut hi) = (knots[0], knots[knots.len() - 1]);
        if lo < range_hi && hi > range_lo {
            (lo, hi) = (lo.max(range_lo), hi.min(range_hi));
        }
        let stored_step = header.rescale.slope.abs();
        // From one stored value below the first piece to one above the last. (Far away from the volume
        // numbers are too coarse to be told apart from their neighbors.)
        let below = ((lo - range_lo) / stored_step).floor() - 1.0;
        let above = ((hi - range_lo) / stored_step).ceil() + 1.0;
        let stored_steps = above - below;
        let (first, spacing, steps) = if header.sample_type.is_integer()
            && (1.0..MOST_ENTRIES as f64).contains(&stored_steps)
        {
            let per_value = (FEWEST_ENTRIES as f64 / stored_steps).floor().max(1.0);
            (
                range_lo + below * stored_step,
                stored_step / per_value,
                stored_steps * per_value,
            )
        } else {
            let narrowest = knots
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .filter(|gap| *gap > 0.0)
                .fold(hi - lo, f64::min);
            let wanted = (4.0 * (hi - lo) / narrowest).ceil();
            let steps = if wanted.is_finite() { wanted } else { 0.0 }
                .clamp(FEWEST_ENTRIES as f64, (MOST_ENTRIES - 3) as f64);
            // A function of one step only has no width of its own.
            let spacing = ((hi - lo) / steps).max(1e-6 * hi.abs().max(lo.abs()).max(1e-20));
            (lo - spacing, spacing, steps + 2.0)
        };
        let last = first + steps * spacing;
        let (domain_lo, mut domain_hi) = (first as f32, last as f32);
        if domain_hi <= domain_lo {
            // The window is narrower than f32 can tell apart at this value.
            domain_hi = domain_lo.next_up();
        }
        let tolerance = 1e-6 * spacing;
        let entries = (0..=steps as usize)
            .map(|i| {
                let (color, opacity) = self.at(first + i as f64 * spacing, tolerance);
                let [r, g, b] = Color(color).in_space(compositing);
                [r, g, b, opacity as f32]
            })
            .collect();
        TransferTable::new([domain_lo, domain_hi], reference_mm, entries)
    }
}

/// Linear between points in ascending order, constant beyond; at equal values the last point counts.
/// Values up to `tolerance` below a point count as its own, because entries of a table are computed.
fn piecewise<const N: usize>(points: &[(f64, [f64; N])], value: f64, tolerance: f64) -> [f64; N] {
    let next = points.partition_point(|point| point.0 <= value + tolerance);
    if next == 0 {
        return points[0].1;
    }
    let below = points[next - 1];
    let Some(above) = points.get(next) else {
        return below.1;
    };
    let part = ((value - below.0) / (above.0 - below.0)).clamp(0.0, 1.0);
    std::array::from_fn(|i| below.1[i] + (above.1[i] - below.1[i]) * part)
}
