//! How the samples of a ray become a pixel: from what a scene says to the Plan's [`Composite`].

use crate::camera::SettledCamera;
use crate::importance::BY_VOLUME;
use crate::plan::{Composite, Projection};
use crate::problem::{Checker, Within};
use crate::transfer_function::SettledWindow;
use crate::window::{automatic_threshold, round_to_width, steep_per_mm, value_range};
use crate::{DebugView, ImportanceSource, Method, Scene};
use strahl_volume::{Grid, VolumeHeader};

/// A method or debug view, with a number for everything, also for what it does not ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledComposite {
    pub method: Method,
    /// Draws a debug view instead of the data.
    pub debug: Option<DebugView>,
    /// The value of the surface of `first-hit`.
    pub threshold: f64,
    /// Of `mida`.
    pub blend: f64,
    /// Black and white where a number is shown as gray.
    pub grey_range: [f64; 2],
    /// The share of light at which a ray ends.
    pub early_termination: f64,
    /// What full importance by place is worth, if there is such a volume.
    pub importance_gain: Option<f64>,
}

impl SettledComposite {
    /// What `scene` says, then what its quality and its preset do, then the defaults.
    pub fn new(
        scene: &Scene,
        [quality, preset]: [&Scene; 2],
        method: Method,
        header: &VolumeHeader,
        steep_per_mm: f64,
        view: &DepthView,
        checker: &mut Checker,
    ) -> SettledComposite {
        if scene.blend.is_some() && !method.has("blend") {
            checker.add(
                "blend",
                format!("given for method {:?}", method.name()),
                "nothing: it belongs to mida",
            );
        }
        let debug = scene.debug.or(quality.debug);
        SettledComposite {
            method,
            debug,
            threshold: scene
                .threshold
                .or(preset.threshold)
                .unwrap_or_else(|| automatic_threshold(header)),
            blend: match method.has("blend") {
                true => scene.blend.unwrap_or(0.0),
                false => 0.0,
            },
            grey_range: scene
                .grey_range
                .unwrap_or_else(|| automatic_grey_range(debug, steep_per_mm, view)),
            early_termination: scene.early_termination.unwrap_or(1.0 / 256.0),
            importance_gain: scene.importance.as_ref().map(ImportanceSource::gain),
        }
    }

    /// Puts the numbers that the method and the view ask for into a scene that does not say them.
    pub fn fill(&self, scene: &mut Scene) {
        let method = self.method;
        scene.method = Some(method);
        scene.debug = self.debug;
        if method.has("threshold") {
            scene.threshold.get_or_insert(self.threshold);
        }
        if method.has("blend") {
            scene.blend.get_or_insert(self.blend);
        }
        let shows_grey = match self.debug {
            Some(view) => matches!(
                view,
                DebugView::GradientMagnitude | DebugView::SampleCount | DebugView::Depth
            ),
            None => method.has("white_per_mm"),
        };
        if shows_grey {
            scene.grey_range.get_or_insert(self.grey_range);
        }
        if method.has("stop_at_transmittance") {
            scene
                .early_termination
                .get_or_insert(self.early_termination);
        }
    }

    /// `window` is that of the transfer function, if it has one.
    pub fn plan(
        &self,
        window: Option<SettledWindow>,
        header: &VolumeHeader,
        checker: &mut Checker,
    ) -> Composite {
        self.check(checker);
        let [black, white] = self.grey_range;
        // Where only white is said, black is 0.
        let span = (white - black).abs().max(1e-30) as f32;
        // What counts as 0 and as 1 when maxima are looked for: the window, or all values.
        let [low, high] = match window {
            Some(window) if window.width > 0.0 => window.ends(),
            _ => value_range(header).map(f64::from),
        };
        let function = match self.debug {
            Some(view) => view.function(),
            None => self.method.function(),
        };
        // Keys of the scene, by the names of the parameters that they are.
        let value = |parameter: &str| match parameter {
            "stop_at_transmittance" => self.early_termination,
            "measure" if self.importance_gain.is_some() => f64::from(BY_VOLUME),
            "gain" if let Some(gain) = self.importance_gain => gain,
            "threshold" => self.threshold,
            "blend" => self.blend,
            "low" => low,
            "high" => high,
            "white" | "white_per_mm" => f64::from(span),
            "full_per_mm" => (0.5 * steep_per_mm(header, None)).max(1e-30),
            "near_mm" => black,
            "far_mm" => white,
            other => function.map_or(0.0, |function| function.default_of(other)),
        };
        match self.debug {
            Some(view) => Composite::Debug(view.plan(value)),
            None => self.method.plan(value),
        }
    }

    fn check(&self, checker: &mut Checker) {
        let large = Within::Closed(-1e30, 1e30);
        checker.number("threshold", self.threshold, large);
        checker.number("blend", self.blend, Within::Closed(-1.0, 1.0));
        let [black, white] = self.grey_range;
        checker.number("grey_range[0]", black, large);
        checker.number("grey_range[1]", white, large);
        if black as f32 == white as f32 {
            checker.add(
                "grey_range",
                format!("{:?}", [black, white]),
                "two different numbers",
            );
        }
        checker.number(
            "early_termination",
            self.early_termination,
            Within::Closed(0.0, 1.0),
        );
    }
}

/// What is black and what is white where a number is shown as gray.
fn automatic_grey_range(debug: Option<DebugView>, steep_per_mm: f64, view: &DepthView) -> [f64; 2] {
    match debug {
        Some(DebugView::SampleCount) => [0.0, 1000.0],
        Some(DebugView::Depth) => view.depths_mm(),
        _ => [0.0, steep_per_mm],
    }
}

/// What depths depend on.
pub(crate) struct DepthView<'v> {
    pub camera: &'v SettledCamera,
    pub framed: &'v Grid,
    pub size: [u32; 2],
}

impl DepthView<'_> {
    /// From the near to the far side of everything, along the rays.
    fn depths_mm(&self) -> [f64; 2] {
        let (lo, hi) = self.framed.bounds_mm();
        // What is wrong with the camera is said elsewhere.
        let plan = (self.camera).plan(self.framed, self.size, &mut Checker::default());
        let Some(camera) = plan else {
            return [0.0, 4.0 * lo.distance(hi)];
        };
        let corners = self.framed.corners_mm();
        let (near, far) = match camera.projection {
            Projection::Perspective { .. } => {
                let nearest = camera.eye_mm.clamp(lo, hi);
                let far = corners.map(|corner| corner.distance(camera.eye_mm));
                (nearest.distance(camera.eye_mm), far)
            }
            Projection::Orthographic { .. } => {
                let depths = corners.map(|corner| (corner - camera.eye_mm).dot(camera.forward));
                let near = depths.into_iter().fold(f64::INFINITY, f64::min);
                (near.max(0.0), depths)
            }
        };
        let far = far.into_iter().fold(near, f64::max);
        if far > near {
            // Three digits are enough for a gray, and can be read.
            let tidy = |mm: f64| round_to_width(mm, far - near);
            [tidy(near), tidy(far)]
        } else {
            [near, near + 1.0]
        }
    }
}
