//! What the loop of its own needs of segments whose samples and runs all add up by emission and absorption.

use crate::lanes::{F32s, I32s, LANES, Mask, Vec3s, each, lanes, words_inside};
use crate::levels::Level;
use crate::library::classify::Tables;
use crate::segment_numbers::SegmentNumbers;
use strahl_scene::plan::{
    Classify, Composite, GlobalRule, GradientInput, Illustrate, Plan, Shade, Technique,
};

/// A technique that has no more to add to the run of a segment.
pub const FINISHED: f32 = 65535.0;

/// A ray that passes less than this may end inside a run: what lies behind is at most one step of a picture of 8 bits.
const NEGLIGIBLE: f32 = 1.0 / 256.0;

/// The looks of all segments, by their numbers counted from 1; number 0 is that of no segment.
pub struct SegmentLooks {
    pub tables: Tables,
    /// Techniques counted from 1; 0 hides. Three bytes more, so that a word can be read anywhere.
    techniques: Vec<u8>,
    /// The same where all fit a packet.
    few: Option<[f32; LANES]>,
    factors: Vec<[f32; 4]>,
    /// The technique of all segments, if there is only one.
    pub only: Option<f32>,
    /// Whether no segment has a tint.
    pub are_untinted: bool,
    /// Whether runs make no difference, up to what a ray leaves out when it ends early: the samples of all segments add up
    /// as those of one do.
    pub are_flat: bool,
    /// Whether one technique can light the samples of all.
    pub are_lit_alike: bool,
    /// The share of light at which a run, and a ray, ends.
    pub stop_at_transmittance: [f32; 2],
}

impl SegmentLooks {
    /// Those of the `segments` of `plan`; `None` if only the general loop can draw them.
    pub fn new(plan: &Plan, segments: &SegmentNumbers) -> Option<SegmentLooks> {
        let GlobalRule::EmissionAbsorption {
            stop_at_transmittance: of_ray,
        } = segments.rule
        else {
            return None;
        };
        let first = plan.drawn_techniques().next()?;
        let Composite::EmissionAbsorption {
            stop_at_transmittance: of_run,
        } = first.composite
        else {
            return None;
        };
        let fits = |technique: &Technique| {
            technique.composite == first.composite
                && technique.table.reference_mm() == first.table.reference_mm()
                && technique.classify == Classify::Table
                && is_of_single_samples(technique.shade)
        };
        let is_clipped = !plan.sample_clips.is_empty();
        if is_clipped || !segments.groups.is_empty() || !plan.drawn_techniques().all(fits) {
            return None;
        }
        let tables: Vec<_> = plan.drawn_techniques().map(|t| &t.table).collect();
        let tables = Tables::new(&tables)?;
        let looks = segments.looks();
        let mut techniques: Vec<u8> = vec![0];
        techniques.extend(looks.techniques.iter().map(|&technique| technique as u8));
        let few = (techniques.len() <= LANES).then(|| {
            let technique = |segment| techniques.get(segment).map_or(0.0, |t| f32::from(*t));
            lanes(technique)
        });
        techniques.extend([0; 3]);
        let mut factors = vec![[0.0; 4]];
        factors.extend(&looks.factors);
        let drawn = segments.drawn();
        let mut shown = drawn.clone();
        let are_opaque = shown.all(|(technique, factors)| *technique == 0 || factors[3] == 1.0);
        let technique = looks.techniques[0];
        let is_only = technique > 0 && drawn.clone().all(|(&other, _)| other == technique);
        let are_flat = are_opaque && of_run == of_ray && of_ray <= NEGLIGIBLE;
        Some(SegmentLooks {
            tables,
            techniques,
            few,
            only: (is_only && are_flat).then_some(technique as f32),
            are_untinted: drawn.clone().all(|(_, factors)| *factors == [1.0; 4]),
            factors,
            are_flat,
            are_lit_alike: plan
                .drawn_techniques()
                .all(|other| are_lit_alike(first, other)),
            stop_at_transmittance: [of_run, of_ray],
        })
    }

    /// The techniques of segments.
    #[inline(always)]
    pub fn techniques<S: Level>(&self, segment: F32s<S>) -> F32s<S> {
        let segment: I32s<S> = segment.to_i32s();
        match &self.few {
            Some(techniques) => F32s::picked(techniques, segment),
            None => words_inside(&self.techniques, segment).and(0xFF).to_f32s(),
        }
    }

    /// What the colors of segments are multiplied by, opacity included.
    #[inline(always)]
    pub fn tints<S: Level>(&self, segment: F32s<S>) -> Vec3s<S> {
        each!([0, 1, 2], |channel| self.factor(segment, channel))
    }

    /// What the opacities of the runs of segments are multiplied by.
    #[inline(always)]
    pub fn opacities<S: Level>(&self, segment: F32s<S>) -> F32s<S> {
        self.factor(segment, 3)
    }

    #[inline(always)]
    fn factor<S: Level>(&self, segment: F32s<S>, channel: i32) -> F32s<S> {
        let bytes: &[u8] = bytemuck::cast_slice(&self.factors);
        let number: I32s<S> = segment.to_i32s();
        words_inside(bytes, number.shifted_up(4) + I32s::splat(4 * channel)).as_bits()
    }

    /// Rays that have passed so much that nothing behind can be seen.
    #[inline(always)]
    pub fn are_complete<S: Level>(&self, alpha: F32s<S>) -> Mask<S> {
        let passing = F32s::splat(1.0) - alpha;
        passing.lt(F32s::splat(self.stop_at_transmittance[1])) | passing.le(F32s::zero())
    }
}

/// Whether the shading of a sample asks for nothing of earlier ones, and leaves its opacity as it is.
fn is_of_single_samples(model: Shade) -> bool {
    match model {
        Shade::Unlit => true,
        Shade::Lit {
            keep_last_normal, ..
        } => !keep_last_normal,
        _ => false,
    }
}

/// Whether samples of one color look alike by both.
fn are_lit_alike(a: &Technique, b: &Technique) -> bool {
    let have_one_normal =
        a.gradient_input != GradientInput::Opacity && a.gradient_input == b.gradient_input;
    let is_flat = a.shade == Shade::Unlit && a.illustrate == Illustrate::Plain;
    a.shade == b.shade && a.illustrate == b.illustrate && (is_flat || have_one_normal)
}
