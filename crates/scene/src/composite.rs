//! How the samples of a ray become a pixel: from what a scene says to the Plan's [`Composite`].

use crate::plan::{Composite, DebugView as PlanDebugView};
use crate::problem::{Checker, Within};
use crate::transfer_function::SettledWindow;
use crate::window::{automatic_threshold, steep_per_mm, value_range};
use crate::{DebugView, Method, Scene};
use strahl_volume::VolumeHeader;

/// A method or debug view, with a number for everything, also for what it does not ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledComposite {
    pub method: Method,
    /// Instead of the data, how the picture is made.
    pub debug: Option<DebugView>,
    /// The value of the surface of `first-hit`.
    pub threshold: f64,
    /// Of `mida`.
    pub blend: f64,
    /// Black and white where a number is shown as grey.
    pub grey_range: [f64; 2],
    /// The share of light at which a ray ends.
    pub early_termination: f64,
}

impl SettledComposite {
    /// What `scene` says, then what its quality and its preset do, then the defaults. `framed` is around everything.
    pub fn new(
        scene: &Scene,
        [quality, preset]: [&Scene; 2],
        method: Method,
        [header, framed]: [&VolumeHeader; 2],
        checker: &mut Checker,
    ) -> SettledComposite {
        if scene.blend.is_some() && method != Method::Mida {
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
            blend: match method {
                Method::Mida => scene.blend.unwrap_or(0.0),
                _ => 0.0,
            },
            grey_range: scene
                .grey_range
                .unwrap_or_else(|| automatic_grey_range(debug, header, framed)),
            early_termination: scene.early_termination.unwrap_or(1.0 / 256.0),
        }
    }

    /// Puts the numbers that the method and the view ask for into a scene that does not say them.
    pub fn fill(&self, scene: &mut Scene) {
        let method = self.method;
        scene.method = Some(method);
        scene.debug = self.debug;
        if method == Method::FirstHit {
            scene.threshold.get_or_insert(self.threshold);
        }
        if method == Method::Mida {
            scene.blend.get_or_insert(self.blend);
        }
        let shows_grey = match self.debug {
            Some(view) => matches!(
                view,
                DebugView::GradientMagnitude | DebugView::SampleCount | DebugView::Depth
            ),
            None => method == Method::Gmip,
        };
        if shows_grey {
            scene.grey_range.get_or_insert(self.grey_range);
        }
        if matches!(method, Method::EmissionAbsorption | Method::Mida) {
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
        if let Some(view) = self.debug {
            return Composite::Debug(match view {
                DebugView::Entry => PlanDebugView::Entry,
                DebugView::Exit => PlanDebugView::Exit,
                DebugView::Normal => PlanDebugView::Normal,
                DebugView::GradientRaw => PlanDebugView::GradientRaw,
                DebugView::GradientMagnitude => {
                    PlanDebugView::GradientMagnitude { white_per_mm: span }
                }
                DebugView::SampleCount => PlanDebugView::SampleCount { white: span },
                DebugView::Depth => PlanDebugView::Depth {
                    near_mm: black as f32,
                    far_mm: white as f32,
                },
            });
        }
        let stop_at_transmittance = self.early_termination as f32;
        match self.method {
            Method::EmissionAbsorption => Composite::EmissionAbsorption {
                stop_at_transmittance,
            },
            Method::Mip => Composite::Mip,
            Method::Minip => Composite::MinIp,
            Method::Average => Composite::Average,
            Method::Gmip => Composite::Gmip { white_per_mm: span },
            Method::Mida => {
                // What counts as 0 and as 1 when maxima are looked for: the window, or all values.
                let [low, high] = match window {
                    Some(window) if window.width > 0.0 => window.ends().map(|end| end as f32),
                    _ => value_range(header),
                };
                Composite::Mida {
                    low,
                    high,
                    blend: self.blend as f32,
                    stop_at_transmittance,
                }
            }
            Method::FirstHit => Composite::FirstHit {
                threshold: self.threshold,
            },
        }
    }

    fn check(&self, checker: &mut Checker) {
        let large = Within::Closed(-1e30, 1e30);
        checker.number("threshold", self.threshold, large);
        checker.number("blend", self.blend, Within::Closed(-1.0, 0.0));
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

/// What is black and what is white where a number is shown as grey.
fn automatic_grey_range(
    debug: Option<DebugView>,
    header: &VolumeHeader,
    framed: &VolumeHeader,
) -> [f64; 2] {
    match debug {
        Some(DebugView::SampleCount) => [0.0, 1000.0],
        // From the near to the far side of what the camera frames, about its usual distance.
        Some(DebugView::Depth) => {
            let (lo, hi) = framed.grid.bounds_mm();
            [0.0, 4.0 * lo.distance(hi)]
        }
        _ => [0.0, steep_per_mm(header)],
    }
}
