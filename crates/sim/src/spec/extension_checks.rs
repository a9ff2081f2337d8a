//! What a Spec may say about the [extensions](super::extensions).

use super::checks::check_curve;
use super::{
    Bend, Classification, Handover, Leaping, MemoryModel, Projection, Shadow, Shape, Spec,
};
use crate::Error;

impl Spec {
    /// Whether nothing of the document's chapter 8 is asked for.
    pub(crate) fn extensions_are_off(&self) -> bool {
        !self.merge.is_on()
            && self.view.slabs == 1
            && self.polygons.shape == Shape::None
            && self.bend == Bend::None
            && self.shadow == Shadow::None
            && self.look.materials.is_empty()
    }

    pub(super) fn check_extensions(&self) -> Result<(), Error> {
        self.check_merge()?;
        self.check_polygons()?;
        self.check_shadow()?;
        let slabs = self.view.slabs;
        if !(1..=64).contains(&slabs) {
            return Err(Error::field(
                "view.slabs",
                slabs,
                "they must lie in 1 to 64",
            ));
        }
        if slabs > 1 && self.view.projection == Projection::Parallel {
            let problem =
                "parallel rays do not spread: set view.projection to perspective, or slabs to 1";
            return Err(Error::field("view.slabs", slabs, problem));
        }
        if slabs > 1 && self.merge.is_on() {
            let problem = "several volumes or boards are drawn in one slab: set it to 1";
            return Err(Error::field("view.slabs", slabs, problem));
        }
        match self.bend {
            Bend::None => return Ok(()),
            Bend::Twist { deg_per_plane } => {
                if !(-90.0..=90.0).contains(&deg_per_plane) {
                    let field = "bend.twist.deg_per_plane";
                    return Err(Error::field(
                        field,
                        deg_per_plane,
                        "it must lie in -90 to 90",
                    ));
                }
            }
            Bend::Lens { strength, radius } => {
                if !(0.0..1.0).contains(&strength) {
                    let field = "bend.lens.strength";
                    return Err(Error::field(field, strength, "it must lie in 0 to below 1"));
                }
                if !(radius > 0.0 && radius <= 16384.0) {
                    let field = "bend.lens.radius";
                    return Err(Error::field(
                        field,
                        radius,
                        "it must lie above 0, up to 16384",
                    ));
                }
            }
        }
        if self.optimisation.leaping != Leaping::Off {
            let problem = "distances do not apply to bent rays: set it to off";
            let value = format!("{:?}", self.optimisation.leaping).to_lowercase();
            return Err(Error::field("optimisation.leaping", value, problem));
        }
        if self.optimisation.adaptive_error > 0 {
            let problem = "its radius does not apply to bent rays: set it to 0";
            let value = self.optimisation.adaptive_error;
            return Err(Error::field("optimisation.adaptive_error", value, problem));
        }
        if self.merge.is_on() {
            let problem = "bent rays leave their board or volume: set merge.boards to 1 and merge.volumes to []";
            return Err(Error::field("bend", "not none", problem));
        }
        Ok(())
    }

    fn check_shadow(&self) -> Result<(), Error> {
        if self.shadow == Shadow::None {
            return Ok(());
        }
        let contradiction =
            |field, value: String, problem| Err(Error::field(field, value, problem));
        let optimisation = &self.optimisation;
        if optimisation.leaping == Leaping::Document {
            let problem = "with shadows rays leap by the safe rule only: set it to safe or off";
            return contradiction("optimisation.leaping", "document".to_owned(), problem);
        }
        if optimisation.adaptive_error > 0 {
            let problem = "light needs every sample: set it to 0";
            let value = optimisation.adaptive_error.to_string();
            return contradiction("optimisation.adaptive_error", value, problem);
        }
        if optimisation.leap_homogeneous {
            let problem = "what is leapt over casts no shadow: set it to false";
            return contradiction("optimisation.leap_homogeneous", "true".to_owned(), problem);
        }
        if self.look.classification == Classification::PreIntegrated {
            let problem = "its table is for steps along the view: set it to pre or post";
            return contradiction("look.classification", "pre-integrated".to_owned(), problem);
        }
        if self.queue.handover == Handover::Refill {
            let problem =
                "the rays of a tile need its light pass: set it to when-empty, when-done or serial";
            return contradiction("queue.handover", "refill".to_owned(), problem);
        }
        if self.queue.pipelines > 1 {
            let problem = "light goes from tile to tile: set it to 1";
            return contradiction("queue.pipelines", self.queue.pipelines.to_string(), problem);
        }
        if self.view.slabs > 1 {
            let problem = "rays that end in one slab would cast no shadow in the next: set it to 1";
            return contradiction("view.slabs", self.view.slabs.to_string(), problem);
        }
        for (field, is_on) in [
            ("merge", self.merge.is_on()),
            ("polygons.shape", self.polygons.shape != Shape::None),
            ("bend", self.bend != Bend::None),
        ] {
            if is_on {
                let problem = "light does not cross boards, volumes, polygons or bent rays: leave it at its default, or set shadow to none";
                return contradiction(field, "set".to_owned(), problem);
            }
        }
        if self.widths.shadow > self.widths.transmittance {
            let value = self.widths.shadow.to_string();
            let problem = "it must be at most widths.transmittance";
            return contradiction("widths.shadow", value, problem);
        }
        Ok(())
    }

    fn check_merge(&self) -> Result<(), Error> {
        let merge = &self.merge;
        if !(1..=64).contains(&merge.boards) {
            let problem = "they must lie in 1 to 64";
            return Err(Error::field("merge.boards", merge.boards, problem));
        }
        if !(1..=merge.boards).contains(&merge.buses) {
            let problem = format!("they must lie in 1 to merge.boards {}", merge.boards);
            return Err(Error::field("merge.buses", merge.buses, problem));
        }
        if merge.volumes.len() > 15 {
            let problem = "there may be at most 15 beside the first";
            return Err(Error::field("merge.volumes", merge.volumes.len(), problem));
        }
        for placed in &merge.volumes {
            if placed.at.iter().any(|c| c.abs() > 1 << 14) {
                let value = format!("{:?}", placed.at);
                return Err(Error::field(
                    "merge.volumes.at",
                    value,
                    "it must lie in -16384 to 16384",
                ));
            }
            check_curve("merge.volumes.opacity", &placed.opacity)?;
        }
        if !merge.volumes.is_empty() && self.memory.model == MemoryModel::M1Linear {
            let problem = "the linear layout has room for one volume: set memory.model to m8 or m1-interleaved";
            return Err(Error::field("merge.volumes", merge.volumes.len(), problem));
        }
        if !merge.volumes.is_empty() && !self.look.materials.is_empty() {
            let problem = "the materials of look.materials are those of one volume: take them out";
            return Err(Error::field("merge.volumes", merge.volumes.len(), problem));
        }
        Ok(())
    }

    fn check_polygons(&self) -> Result<(), Error> {
        let polygons = &self.polygons;
        let shares = polygons.color.iter().chain([&polygons.opacity]);
        if !shares.clone().all(|share| (0.0..=1.0).contains(share)) {
            let value = format!("{:?}, opacity {}", polygons.color, polygons.opacity);
            return Err(Error::field(
                "polygons.color",
                value,
                "color and opacity lie in 0 to 1",
            ));
        }
        let is_finite = |v: &[f64; 3]| v.iter().all(|c| c.abs() <= 1e6);
        match &polygons.shape {
            Shape::None => return Ok(()),
            Shape::Plane { point, normal } => {
                if !is_finite(point) {
                    let value = format!("{point:?}");
                    let field = "polygons.shape.plane.point";
                    return Err(Error::field(field, value, "it must lie within 1e6 voxels"));
                }
                if !is_finite(normal) || normal.iter().all(|c| c.abs() < 1e-6) {
                    let value = format!("{normal:?}");
                    let field = "polygons.shape.plane.normal";
                    return Err(Error::field(field, value, "it must be finite and not 0"));
                }
            }
            Shape::Sphere { centre, radius } => {
                if !is_finite(centre) {
                    let value = format!("{centre:?}");
                    let field = "polygons.shape.sphere.centre";
                    return Err(Error::field(field, value, "it must lie within 1e6 voxels"));
                }
                if !(*radius > 0.0 && *radius <= 1e6) {
                    let field = "polygons.shape.sphere.radius";
                    return Err(Error::field(
                        field,
                        radius,
                        "it must lie above 0, up to 1e6",
                    ));
                }
            }
            Shape::File { .. } => {}
        }
        if self.merge.is_on() {
            let problem = "every board and volume would draw them: set merge.boards to 1 and merge.volumes to []";
            return Err(Error::field("polygons.shape", "not none", problem));
        }
        Ok(())
    }
}
