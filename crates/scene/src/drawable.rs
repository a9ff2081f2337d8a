//! What every renderer may rely on in a Plan, also in one that was changed by hand.

use crate::plan::{
    Classify, Composite, Field, GradientInput, Illustrate, Labeled, MOST_EDGE_PIXELS, MOST_FRAMES,
    MOST_GROUPS, MOST_LAYERS, Plan, PlanImportance, Sampling, Segments, Technique,
};

/// That groups of segments are there, and have numbers.
fn check_groups(labeled: &Labeled) -> Result<(), String> {
    let number = labeled.groups.len();
    if number > MOST_GROUPS {
        return Err(format!(
            "there are {number} groups of segments; at most {MOST_GROUPS}"
        ));
    }
    for group in &labeled.groups {
        let numbers = [group.opacity, group.importance];
        if !numbers.iter().all(|n| n.is_finite() && *n >= 0.0) {
            return Err(format!(
                "a group of segments is {group:?}: its numbers have to be finite and not negative"
            ));
        }
    }
    let mut looks = labeled.looks.values().chain([&labeled.others]);
    match looks.find_map(|look| look.group.filter(|group| *group >= number)) {
        Some(group) => Err(format!(
            "a segment is in group {group}, of which there are {number}"
        )),
        None => Ok(()),
    }
}

/// The most places along a halo, as its function allows.
const MOST_HALO_STEPS: u32 = 64;

/// That a number lies in 1 to `most`.
fn within(what: &str, number: u64, most: u64) -> Result<(), String> {
    match (1..=most).contains(&number) {
        true => Ok(()),
        false => Err(format!("{what} is {number}; it has to be 1 to {most}")),
    }
}

/// That the parts of a technique go together, and that its table fits.
fn check_technique(technique: &Technique) -> Result<(), String> {
    let composite = technique.composite.function();
    if technique.illustrate != Illustrate::Plain && !composite.has_place {
        return Err(format!(
            "a technique has the composite {} and is illustrated; its numbers belong to no place, so `illustrate` has to be Plain",
            composite.word
        ));
    }
    if let Illustrate::Halo { steps, .. } = technique.illustrate {
        within("steps of a halo", steps.into(), MOST_HALO_STEPS.into())?;
    }
    let reads_gradient = matches!(
        technique.classify,
        Classify::GradientTable { .. } | Classify::ValueGradient { .. }
    );
    if reads_gradient && technique.gradient_input == GradientInput::Segment {
        return Err(
            "a technique classifies by the gradient of the value and has the gradient input Segment; it has to be Value"
                .to_owned(),
        );
    }
    if let Classify::ValueGradient { columns, rows, .. } = technique.classify {
        let (of_table, entries) = (
            technique.table.rows().len(),
            technique.table.entries().len(),
        );
        let fits = columns as usize == entries && of_table == rows as usize * entries;
        if rows > 0 && !(fits && rows > 1) {
            return Err(format!(
                "a technique classifies by {rows} rows of {columns}; its table has {of_table} entries in rows of {entries}"
            ));
        }
    }
    Ok(())
}

impl Plan {
    /// What is wrong with this Plan whatever its data is: numbers out of their range, places that are not there, parts that do
    /// not go together. [`resolve`](crate::resolve()) makes no such Plan.
    ///
    /// # Errors
    /// The first thing that is wrong, and what would be right.
    pub(crate) fn check_itself(&self) -> Result<(), String> {
        let most_pixels = u64::from(MOST_EDGE_PIXELS);
        within("width", self.width.into(), most_pixels)?;
        within("height", self.height.into(), most_pixels)?;
        let frames = u64::from(self.lattice.frames);
        within("lattice.frames", frames, MOST_FRAMES.into())?;
        within(
            "the number of layers",
            self.layers.len() as u64,
            MOST_LAYERS as u64,
        )?;
        let step_mm = self.lattice.step_mm;
        if !(step_mm > 0.0 && step_mm.is_finite()) {
            return Err(format!(
                "lattice.step_mm is {step_mm}; it has to be above 0 and finite"
            ));
        }
        self.check_layers()?;
        self.techniques.iter().try_for_each(check_technique)?;
        if let Some(PlanImportance {
            low,
            high,
            gain_of_runs,
            ..
        }) = self.importance
        {
            let is_good = low.is_finite() && high.is_finite() && low != high && gain_of_runs >= 0.0;
            if !is_good || !gain_of_runs.is_finite() {
                return Err(format!(
                    "importance is {:?}: its range has to be two different numbers, its gain 0 or more",
                    self.importance
                ));
            }
        }
        self.check_sampling()
    }

    /// That fields and techniques are there, and which of them go together.
    fn check_layers(&self) -> Result<(), String> {
        let (fields, techniques) = (self.fields.len(), self.techniques.len());
        let technique = |number: usize| match number < techniques {
            true => Ok(()),
            false => Err(format!(
                "a layer asks for technique {number}, of which there are {techniques}"
            )),
        };
        for layer in &self.layers {
            if layer.field >= fields {
                let field = layer.field;
                return Err(format!(
                    "a layer asks for field {field}, of which there are {fields}"
                ));
            }
            match &layer.segments {
                Segments::Whole { technique: number } => technique(*number)?,
                Segments::Labeled(labeled) => {
                    for look in labeled.looks.values().chain([&labeled.others]) {
                        look.technique.map_or(Ok(()), technique)?;
                        let numbers = look.tint.into_iter().chain([look.opacity, look.importance]);
                        if !numbers.fold(true, |all, n| all && n.is_finite() && n >= 0.0) {
                            return Err(format!(
                                "a segment is drawn as {look:?}: its numbers have to be finite and not negative"
                            ));
                        }
                    }
                    technique(0)?;
                    check_groups(labeled)?;
                    self.check_segments()?;
                }
            }
        }
        let first = &self.fields[self.layers[0].field];
        let ways = |field: &Field| (field.fetch, field.reconstruct, field.gradient);
        let mut fields = self.layers.iter().map(|layer| &self.fields[layer.field]);
        if let Some(other) = fields.find(|field| ways(field) != ways(first)) {
            return Err(format!(
                "layers read {:?} and {:?} (fetch, reconstruct, gradient), which have to be the same",
                ways(first),
                ways(other)
            ));
        }
        let mixes = |layer: usize| self.technique_of(layer).composite.mixes_layers();
        match self.layers.len() == 1 || (0..self.layers.len()).all(mixes) {
            true => Ok(()),
            false => Err(
                "a composite that works on the values of one volume stands beside other layers"
                    .to_owned(),
            ),
        }
    }

    /// What segments of a label volume do not go together with.
    fn check_segments(&self) -> Result<(), String> {
        if self.layers.len() > 1 {
            return Err("segments of a label volume are drawn beside other layers".to_owned());
        }
        if self.sampling != Sampling::Regular {
            let rule = self.sampling.name();
            return Err(format!(
                "segments of a label volume are sampled by the rule {rule:?}; they are by \"regular\" only"
            ));
        }
        let local = |composite: Composite| composite.is_local();
        match self.techniques.iter().all(|t| local(t.composite)) {
            true => Ok(()),
            false => Err(
                "the technique of a segment has the composite BackToFront or a debug view, which make no sample of a run"
                    .to_owned(),
            ),
        }
    }

    /// Which rules of sampling there are for which composites.
    fn check_sampling(&self) -> Result<(), String> {
        if self.sampling == Sampling::Regular {
            return Ok(());
        }
        let composite = self.technique().composite;
        let fits = match composite {
            Composite::EmissionAbsorption { .. } => true,
            Composite::Mip | Composite::Minip => matches!(self.sampling, Sampling::Refine { .. }),
            _ => false,
        };
        match fits && self.layers.len() == 1 {
            true => Ok(()),
            false => Err(format!(
                "the rule of sampling {:?} is for one layer by emission and absorption (\"refine\" for MIP and MinIP, too)",
                self.sampling.name()
            )),
        }
    }
}
