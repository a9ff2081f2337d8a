//! What a Spec may say: every field by itself, and beside the others.

use super::*;

impl Spec {
    /// Whether the parts of the Spec fit each other; what depends on the volume is checked when a frame is prepared.
    ///
    /// # Errors
    /// The first field that does not fit, with its value and the bound.
    pub fn check(&self) -> Result<(), Error> {
        self.check_widths()?;
        self.check_queue()?;
        self.check_memory()?;
        self.check_look()?;
        self.check_extensions()?;
        let positive = |field, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(Error::field(field, value, "it must be greater than 0")),
        };
        positive("clock_mhz", self.clock_mhz)?;
        positive("view.step", self.view.step)?;
        positive("view.pixel", self.view.pixel)?;
        positive("host.bus_mb_per_s", self.host.bus_mb_per_s)?;
        if !(1..=1000).contains(&self.host.single_clocks) {
            let field = "host.single_clocks";
            let value = self.host.single_clocks;
            return Err(Error::field(field, value, "they must lie in 1 to 1000"));
        }
        for (field, value) in [
            ("view.rotate_z_deg", self.view.rotate_z_deg),
            ("view.rotate_x_deg", self.view.rotate_x_deg),
        ] {
            if !(-360.0..=360.0).contains(&value) {
                return Err(Error::field(field, value, "it must lie in -360 to 360"));
            }
        }
        if let Projection::Perspective { angle_deg } = self.view.projection
            && !(1.0..=120.0).contains(&angle_deg)
        {
            let field = "view.projection.perspective.angle_deg";
            return Err(Error::field(field, angle_deg, "it must lie in 1 to 120"));
        }
        let threshold = self.optimisation.termination_threshold;
        if !(0.0..1.0).contains(&threshold) {
            let field = "optimisation.termination_threshold";
            return Err(Error::field(
                field,
                threshold,
                "it must lie in 0 to below 1",
            ));
        }
        if !matches!(self.optimisation.distance_block, 1 | 2) {
            let field = "optimisation.distance_block";
            let value = self.optimisation.distance_block;
            return Err(Error::field(field, value, "it must be 1 or 2"));
        }
        if let Some(engine) = self.optimisation.distance_engine {
            for (field, value, low, high) in [
                (
                    "optimisation.distance_engine.columns",
                    engine.columns,
                    5,
                    1024,
                ),
                ("optimisation.distance_engine.rows", engine.rows, 3, 1024),
                ("optimisation.distance_engine.margin", engine.margin, 1, 254),
            ] {
                if !(low..=high).contains(&value) {
                    let problem = format!("it must lie in {low} to {high}");
                    return Err(Error::field(field, value, problem));
                }
            }
            if engine.load_ms > 60_000 {
                let field = "optimisation.distance_engine.load_ms";
                let problem = "it must lie in 0 to 60000";
                return Err(Error::field(field, engine.load_ms, problem));
            }
            if 2 * engine.margin >= engine.columns.min(engine.rows) {
                let field = "optimisation.distance_engine.margin";
                let problem = format!(
                    "nothing is left of a plane of {} × {}: at most {}",
                    engine.columns,
                    engine.rows,
                    (engine.columns.min(engine.rows) - 1) / 2
                );
                return Err(Error::field(field, engine.margin, problem));
            }
        }
        if self.optimisation.adaptive_error > 0 && self.optimisation.leaping == Leaping::Document {
            let field = "optimisation.adaptive_error";
            let value = self.optimisation.adaptive_error;
            let problem = "adaptive sampling needs optimisation.leaping safe or off";
            return Err(Error::field(field, value, problem));
        }
        Ok(())
    }

    fn check_widths(&self) -> Result<(), Error> {
        let w = &self.widths;
        let ranges = [
            ("widths.position_integer", w.position_integer, 1, 14),
            ("widths.position_fraction", w.position_fraction, 1, 24),
            ("widths.step_integer", w.step_integer, 1, 6),
            ("widths.step_fraction", w.step_fraction, 1, 24),
            ("widths.length", w.length, 1, 16),
            ("widths.key", w.key, 1, 16),
            ("widths.fraction", w.fraction, 1, 16),
            ("widths.data", w.data, 2, 12),
            ("widths.lerp_guard", w.lerp_guard, 0, 12),
            ("widths.norm", w.norm, 2, 14),
            ("widths.reflectance_index", w.reflectance_index, 1, 8),
            ("widths.intensity", w.intensity, 2, 16),
            ("widths.transmittance", w.transmittance, 4, 24),
            ("widths.accumulator_fraction", w.accumulator_fraction, 0, 16),
            ("widths.distance", w.distance, 1, 8),
            ("widths.shadow", w.shadow, 1, 16),
        ];
        for (field, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                let problem = format!("it must lie in {low} to {high}");
                return Err(Error::field(field, value, problem));
            }
        }
        let contradiction =
            |field, value: u32, problem: String| Err(Error::field(field, value, problem));
        if w.position_integer + w.position_fraction > 30 {
            let problem = format!(
                "with {} integer bits a position has more than 31 bits; at most {}",
                w.position_integer,
                30 - w.position_integer
            );
            return contradiction("widths.position_fraction", w.position_fraction, problem);
        }
        if w.step_fraction > w.position_fraction {
            let problem = format!(
                "a step finer than a position (widths.position_fraction {}) would be lost on adding",
                w.position_fraction
            );
            return contradiction("widths.step_fraction", w.step_fraction, problem);
        }
        if w.fraction > w.position_fraction {
            let problem = format!(
                "the interpolator gets bits of a position: at most widths.position_fraction {}",
                w.position_fraction
            );
            return contradiction("widths.fraction", w.fraction, problem);
        }
        if w.data + w.lerp_guard + w.fraction > 29 {
            let problem = format!(
                "with widths.data {} and widths.fraction {} a product has more than 30 bits; at most {}",
                w.data,
                w.fraction,
                29u32.saturating_sub(w.data + w.fraction)
            );
            return contradiction("widths.lerp_guard", w.lerp_guard, problem);
        }
        if w.reflectance_index > w.norm {
            let problem = format!("it must be at most widths.norm {}", w.norm);
            return contradiction("widths.reflectance_index", w.reflectance_index, problem);
        }
        if w.accumulator_fraction > w.transmittance {
            let problem = format!(
                "it must be at most widths.transmittance {}",
                w.transmittance
            );
            return contradiction(
                "widths.accumulator_fraction",
                w.accumulator_fraction,
                problem,
            );
        }
        Ok(())
    }

    fn check_queue(&self) -> Result<(), Error> {
        let [x, y] = self.queue.bundle;
        let text = format!("[{x}, {y}]");
        if x == 0 || y == 0 {
            let problem = "a processor without rays draws nothing; each side must be 1 to 64";
            return Err(Error::field("queue.bundle", text, problem));
        }
        if x > 64 || y > 64 {
            return Err(Error::field(
                "queue.bundle",
                text,
                "each side must be 1 to 64",
            ));
        }
        if let Scheduling::ReadyRowFirst { window: 0 } = self.queue.scheduling {
            let field = "queue.scheduling.ready-row-first.window";
            return Err(Error::field(field, 0, "it must be at least 1"));
        }
        if !(1..=64).contains(&self.queue.pipelines) {
            let value = self.queue.pipelines;
            return Err(Error::field(
                "queue.pipelines",
                value,
                "it must lie in 1 to 64",
            ));
        }
        let l = &self.latency;
        let all = [
            ("latency.parameter", l.parameter, 0),
            ("latency.memory", l.memory, 1),
            ("latency.multiply", l.multiply, 0),
            ("latency.add", l.add, 1),
            ("latency.sort", l.sort, 0),
            ("latency.lerp", l.lerp, 1),
            ("latency.classify", l.classify, 1),
            ("latency.absorb", l.absorb, 1),
            ("latency.terminate", l.terminate, 0),
            ("latency.shade", l.shade, 1),
            ("latency.composite", l.composite, 1),
        ];
        for (field, value, low) in all {
            if !(low..=256).contains(&value) {
                let problem = format!("it must lie in {low} to 256");
                return Err(Error::field(field, value, problem));
            }
        }
        Ok(())
    }

    fn check_memory(&self) -> Result<(), Error> {
        let m = &self.memory;
        for (field, value, low, high) in [
            ("memory.chips", m.chips, 1, 64),
            ("memory.ports", m.ports, 1, 64),
            ("memory.banks", m.banks, 1, 64),
            ("memory.rows", m.rows, 1, 1 << 20),
            ("memory.columns", m.columns, 1, 1 << 14),
            ("memory.timing.burst", m.timing.burst, 1, m.columns),
            (
                "memory.timing.bank_groups",
                m.timing.bank_groups,
                1,
                m.banks,
            ),
            ("memory.timing.precharge", m.timing.precharge, 1, 1000),
            ("memory.timing.activate", m.timing.activate, 1, 1000),
            ("memory.timing.read", m.timing.read, 1, 1000),
        ] {
            if !(low..=high).contains(&value) {
                let problem = format!("it must lie in {low} to {high}");
                return Err(Error::field(field, value, problem));
            }
        }
        for (field, value) in [
            ("memory.chips", m.chips),
            ("memory.banks", m.banks),
            ("memory.columns", m.columns),
            ("memory.timing.burst", m.timing.burst),
            ("memory.timing.bank_groups", m.timing.bank_groups),
        ] {
            if !value.is_power_of_two() {
                return Err(Error::field(field, value, "it must be a power of two"));
            }
        }
        let t = &m.timing;
        if t.refresh_interval > 0 && t.refresh_interval <= t.refresh + t.precharge + t.activate {
            let problem = format!(
                "the memory would do nothing but refresh; more than {}, or 0 for none",
                t.refresh + t.precharge + t.activate
            );
            let field = "memory.timing.refresh_interval";
            return Err(Error::field(field, t.refresh_interval, problem));
        }
        if let Some(cache) = m.cache {
            for (field, value) in [
                ("memory.cache.sets", cache.sets),
                ("memory.cache.line", cache.line),
            ] {
                if !value.is_power_of_two() || value > 1 << 16 {
                    let problem = "it must be a power of two, at most 65536";
                    return Err(Error::field(field, value, problem));
                }
            }
            if !(1..=64).contains(&cache.ways) {
                let value = cache.ways;
                return Err(Error::field(
                    "memory.cache.ways",
                    value,
                    "it must lie in 1 to 64",
                ));
            }
            if cache.line < t.burst || cache.line > m.columns {
                let problem = format!(
                    "it must lie between memory.timing.burst {} and memory.columns {}",
                    t.burst, m.columns
                );
                return Err(Error::field("memory.cache.line", cache.line, problem));
            }
        }
        Ok(())
    }

    fn check_look(&self) -> Result<(), Error> {
        let look = &self.look;
        check_curve("look.opacity", &look.opacity)?;
        for light in &look.lights {
            let squared: f64 = light.direction.iter().map(|c| c * c).sum();
            if !(squared.is_finite() && squared > 0.0) {
                let text = format!("{:?}", light.direction);
                let problem = "it must be finite and not 0";
                return Err(Error::field("look.lights.direction", text, problem));
            }
            if !(light.intensity.is_finite() && light.intensity >= 0.0) {
                let value = light.intensity;
                return Err(Error::field(
                    "look.lights.intensity",
                    value,
                    "it must be at least 0",
                ));
            }
        }
        if !look.phong.iter().all(|k| k.is_finite() && *k >= 0.0) {
            let text = format!("{:?}", look.phong);
            return Err(Error::field(
                "look.phong",
                text,
                "each share must be at least 0",
            ));
        }
        if !(look.shininess.is_finite() && look.shininess > 0.0) {
            return Err(Error::field(
                "look.shininess",
                look.shininess,
                "it must be greater than 0",
            ));
        }
        if !look.gradient_gain.is_power_of_two() || look.gradient_gain > 256 {
            let problem = "it must be a power of two, at most 256";
            return Err(Error::field(
                "look.gradient_gain",
                look.gradient_gain,
                problem,
            ));
        }
        if !(0.0..=1.0).contains(&look.background) {
            return Err(Error::field(
                "look.background",
                look.background,
                "it must lie in 0 to 1",
            ));
        }
        for (i, m) in look.materials.iter().enumerate() {
            let shares = [
                m.color[0], m.color[1], m.color[2], m.ambient, m.diffuse, m.specular,
            ];
            if !m.value.is_finite() || shares.iter().any(|share| !(0.0..=1.0).contains(share)) {
                let problem = "the value must be finite, colors and shares lie in 0 to 1";
                return Err(Error::field("look.materials", format!("{m:?}"), problem));
            }
            if i > 0 && look.materials[i - 1].value > m.value {
                return Err(Error::field(
                    "look.materials",
                    m.value,
                    "values must ascend",
                ));
            }
        }
        if !look.materials.is_empty() && look.classification != Classification::Post {
            let problem = "their table is behind interpolation: set look.classification to post";
            return Err(Error::field(
                "look.materials",
                format!("{} materials", look.materials.len()),
                problem,
            ));
        }
        if look.classification == Classification::PreIntegrated
            && self.optimisation.leaping != Leaping::Off
        {
            let problem = "a table over both ends of a step needs every step: set optimisation.leaping to off";
            return Err(Error::field(
                "look.classification",
                "pre-integrated",
                problem,
            ));
        }
        Ok(())
    }
}

/// Whether points (value, opacity) make a curve.
pub(super) fn check_curve(field: &'static str, points: &[[f64; 2]]) -> Result<(), Error> {
    for (i, &[value, opacity]) in points.iter().enumerate() {
        let text = format!("[{value}, {opacity}]");
        if !value.is_finite() || !(0.0..=1.0).contains(&opacity) {
            let problem = "values must be finite, opacities lie in 0 to 1";
            return Err(Error::field(field, text, problem));
        }
        if i > 0 && points[i - 1][0] > value {
            return Err(Error::field(field, text, "values must ascend"));
        }
    }
    Ok(())
}
