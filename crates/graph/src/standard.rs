//! The standard graph: what the settings of a scene mean, as nodes.
//!
//! Every stage stands between two anchors, `before_STAGE` and `after_STAGE`, which are there whatever the
//! settings are: clip_ray, jitter, sample, clip_sample, classify, shade, composite. Edits hold on to them. Of
//! several objects, the second and all further ones have nodes of their own, with `_1` and so on behind their
//! names. Of segments, each technique is a group.

mod segments;

use crate::error::{Error, Problem};
use crate::model::{CarriedVariable, Constant, Graph, Input, Kind, Loop, Node, Reference};
use strahl_scene::plan::{Composite, Illustrate, Plan, Sampling, Shade, Technique};
use strahl_shader::registry::mixing_rules;

/// The graph that draws `plan`, with its slots as the settings fill them.
///
/// # Errors
/// Debug views have no graph.
pub fn standard(plan: &Plan) -> Result<Graph, Error> {
    let refused_at = |place: &str, why: &str| Error::Graph {
        file: "the standard graph".to_owned(),
        problems: vec![Problem::new(place, why)],
    };
    let refused = |why: &str| refused_at("composite", why);
    if plan.sampling != Sampling::Regular {
        let rule = plan.sampling.name();
        return Err(Error::Sampling { rule });
    }
    let is_debug = |technique: &Technique| matches!(technique.composite, Composite::Debug(_));
    if plan.drawn_techniques().any(is_debug) {
        return Err(refused_at(
            "debug",
            "a graph cannot draw a debug view, which `debug` or quality \"null\" asks for; remove that key, or draw without a graph",
        ));
    }
    if plan.layers.len() > 1 && !plan.technique().composite.mixes_layers() {
        return Err(refused(&format!(
            "several objects are mixed along the ray by {} only",
            mixing_rules()
        )));
    }
    let is_covered_by_ray = |technique: &Technique| {
        matches!(
            technique.composite,
            Composite::ContextPreserving { covered_by: 1, .. }
        )
    };
    if plan.labeled().is_some() && plan.drawn_techniques().any(is_covered_by_ray) {
        return Err(refused(
            "a graph of segments draws `context-preserving` with `covered_by` 0 only",
        ));
    }
    let mut graph = Builder {
        plan,
        within: None,
        graph: Graph {
            name: "standard".to_owned(),
            ..Graph::default()
        },
    };
    if plan.labeled().is_some() {
        graph.segments();
        return Ok(graph.graph);
    }
    if plan.layers.len() > 1 {
        graph.several(plan.technique().composite == Composite::BackToFront);
        return Ok(graph.graph);
    }
    graph.ray();
    match plan.technique().composite {
        Composite::EmissionAbsorption { .. } => graph.emission_absorption(false),
        Composite::BackToFront => graph.emission_absorption(true),
        Composite::Mida { blend, .. } if blend <= 0.0 => graph.mida(),
        Composite::Mip => graph.extreme("larger"),
        Composite::Minip => graph.extreme("smaller"),
        Composite::Average => graph.average(),
        Composite::Gmip { white_per_mm } => graph.steepest(white_per_mm),
        Composite::FirstHit { threshold } => graph.first_hit(f64::from(threshold)),
        other => graph.rule(other.function().adds_looks),
    }
    Ok(graph.graph)
}

struct Builder<'p> {
    plan: &'p Plan,
    /// The number of the technique whose group is built.
    within: Option<usize>,
    graph: Graph,
}

fn pattern(name: &str, pattern: &str) -> Node {
    Node::new(name, Kind::Pattern(pattern.to_owned()))
}

fn slot(name: &str, slot: &str) -> Node {
    Node::new(name, Kind::Slot(slot.to_owned()))
}

fn numbers(numbers: &[f64]) -> Input {
    Input::Constant(Constant::Numbers(numbers.to_vec()))
}

fn carried(name: &str, ty: &str, start: Input, next: &str) -> CarriedVariable {
    CarriedVariable {
        name: name.to_owned(),
        ty: Some(ty.to_owned()),
        start: Some(start),
        next: Some(next.into()),
    }
}

fn one(v: f32) -> Vec<f64> {
    vec![f64::from(v)]
}

/// The name of a node of one of several objects.
fn of_object(name: &str, object: usize) -> String {
    match object {
        0 => name.to_owned(),
        _ => format!("{name}_{object}"),
    }
}

impl Builder<'_> {
    fn put(&mut self, node: Node) {
        self.graph.nodes.push(node);
    }

    fn put_of(&mut self, object: usize, mut node: Node) {
        node.object = object;
        self.put(node);
    }

    fn anchor(&mut self, name: &str, from: &str) {
        self.put(Node::new(name, Kind::Anchor).input("in", from));
    }

    fn root(&mut self, name: &str, from: &str) {
        self.graph
            .roots
            .push((name.to_owned(), Reference::new(from)));
    }

    /// What is found once per ray.
    fn ray(&mut self) {
        self.put(pattern("ray", "ray"));
        self.put(
            pattern("extent", "extent")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction"),
        );
        self.anchor("before_clip_ray", "extent");
        self.put(
            pattern("clip_ray", "clip_ray")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction")
                .input("interval_mm", "before_clip_ray"),
        );
        self.anchor("after_clip_ray", "clip_ray");
        self.anchor("before_jitter", "ray.pixel");
        self.put(
            slot("jitter", "jitter")
                .input("pixel", "before_jitter")
                .input("frame", "ray.frame"),
        );
        self.anchor("after_jitter", "jitter");
        self.put(pattern("entry_at", "interval_start").input("interval_mm", "after_clip_ray"));
        self.put(
            pattern("lattice", "lattice")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction")
                .input("interval_mm", "after_clip_ray")
                .input("entry_at_mm", "entry_at")
                .input("jitter", "after_jitter"),
        );
    }

    /// From the number of a sample to its value, as long as it counts.
    fn sample(&mut self, backwards: bool) {
        self.put(
            pattern("is_before_end", "before_end")
                .input("k", "samples.k")
                .input("count", "lattice.count"),
        );
        let mut point = if backwards {
            pattern("point", "lattice_point_from_end").input("count", "lattice.count")
        } else {
            pattern("point", "lattice_point")
        };
        point = point
            .input("k", "samples.k")
            .input("jitter_of_ray", "after_jitter");
        self.put(point);
        self.put(
            pattern("position", "position_on_ray")
                .input("entry", "lattice.entry")
                .input("step", "lattice.step")
                .input("lattice_point", "point"),
        );
        let step = if backwards {
            self.put(pattern("step_back", "backwards").input("step", "lattice.step"));
            "step_back"
        } else {
            "lattice.step"
        };
        self.put(
            pattern("empty", "empty_points")
                .input("position", "position")
                .input("step", step),
        );
        self.put(pattern("is_seen", "is_seen").input("empty", "empty"));
        self.put(
            pattern("advance", "advance")
                .input("k", "samples.k")
                .input("empty", "empty"),
        );
        self.value();
    }

    /// The value at `position`, and whether it counts.
    fn value(&mut self) {
        self.anchor("before_clip_sample", "position");
        self.put(pattern("place_mm", "world_from_voxel").input("position", "before_clip_sample"));
        self.put(slot("clip_sample", "clip_sample").input("place_mm", "place_mm"));
        self.anchor("after_clip_sample", "clip_sample");
        self.put(pattern("is_kept", "not").input("a", "after_clip_sample"));
        self.anchor("before_sample", "position");
        self.put(slot("sample", "reconstruct").input("position", "before_sample"));
        self.anchor("after_sample", "sample");
        self.put(pattern("is_value", "is_value").input("value", "after_sample"));
    }

    /// How `object` is drawn, or what the group draws.
    fn drawing(&self, object: usize) -> &Technique {
        match self.within {
            Some(technique) => &self.plan.techniques[technique],
            None => self.plan.technique_of(object),
        }
    }

    fn to_eye(&self) -> &'static str {
        match self.within {
            Some(_) => "inputs.to_eye",
            None => "ray.to_eye",
        }
    }

    /// From `value` at `position` to color and opacity of the reference length: `after_shade_color`,
    /// `after_shade_opacity`. Shading is looked at only where something can be seen.
    fn look(&mut self, value: &str, position: &str, last_normal: Option<&str>) {
        self.look_of(0, value, position, last_normal);
    }

    fn look_of(&mut self, object: usize, value: &str, position: &str, last_normal: Option<&str>) {
        let own = |name: &str| of_object(name, object);
        self.anchor(&own("before_classify"), value);
        let classify = slot(&own("classify"), "classify")
            .input("value", own("before_classify").as_str())
            .input("position", position);
        self.put_of(object, classify);
        self.anchor(&own("after_classify"), &own("classify"));
        self.anchor(&own("before_shade"), &own("after_classify"));
        let (mut color, mut opacity) = (
            own("before_shade") + ".color",
            own("before_shade") + ".opacity",
        );
        let gradient = slot(&own("gradient"), "gradient").input("position", position);
        match self.drawing(object).shade {
            Shade::Unlit => {}
            // The memory of the last normal is one for all techniques that ask for it.
            Shade::Lit {
                keep_last_normal: true,
                ..
            } if self.within.is_some() => {
                let shaded = slot(&own("shaded"), "shade")
                    .input("surface", own("before_shade").as_str())
                    .input("position", position)
                    .input("to_eye", self.to_eye());
                self.put_of(object, shaded);
                (color, opacity) = (own("shaded") + ".color", own("shaded") + ".opacity");
            }
            Shade::Lit {
                ambient,
                keep_last_normal,
                ..
            } => {
                self.put_of(object, gradient);
                let normal = match (keep_last_normal, last_normal) {
                    (true, Some(last)) => {
                        let normals = pattern(&own("normals"), "last_normal")
                            .input("gradient_here", own("gradient").as_str())
                            .input("last", last)
                            .input("to_eye", self.to_eye());
                        self.put_of(object, normals);
                        own("normals") + ".facing"
                    }
                    _ => {
                        let normal = pattern(&own("normal"), "normal_of_gradient")
                            .input("gradient_here", own("gradient").as_str())
                            .input("to_eye", self.to_eye());
                        self.put_of(object, normal);
                        own("normal")
                    }
                };
                let lit = pattern(&own("lit"), "lit")
                    .input("color", color.as_str())
                    .input("normal", normal.as_str())
                    .input("position", position)
                    .input("to_eye", self.to_eye())
                    .param("ambient", one(ambient));
                self.put_of(object, lit);
                color = own("lit");
            }
            Shade::GradientOpacity { full_per_mm } => {
                self.put_of(object, gradient);
                let steep = pattern(&own("steep_opacity"), "gradient_opacity")
                    .input("opacity", opacity.as_str())
                    .input("gradient_here", own("gradient").as_str())
                    .param("full_per_mm", one(full_per_mm));
                self.put_of(object, steep);
                opacity = own("steep_opacity");
            }
        }
        if self.drawing(object).illustrate != Illustrate::Plain {
            let illustrated = slot(&own("illustrated"), "illustrate")
                .input("color", color.as_str())
                .input("position", position)
                .input("to_eye", self.to_eye());
            self.put_of(object, illustrated);
            color = own("illustrated");
        }
        self.anchor(&own("after_shade_color"), &color);
        self.anchor(&own("after_shade_opacity"), &opacity);
    }

    fn is_last_normal_kept(&self, object: usize) -> bool {
        matches!(
            self.plan.technique_of(object).shade,
            Shade::Lit {
                keep_last_normal: true,
                ..
            }
        )
    }

    /// `visible`: what the pixel becomes if the sample can be seen; `found`, if it is a value; `kept`, if it is
    /// not clipped; `seen`, if its brick is not empty. Each only computes what it needs.
    fn nested(&mut self, unseen: &str, unseen_opacity: &str, stop: Option<&str>) {
        self.anchor("before_composite_color", "after_shade_color");
        self.put(pattern("step_opacity", "step_opacity").input("opacity", "after_shade_opacity"));
        self.anchor("before_composite_opacity", "step_opacity");
        self.put(pattern("is_visible", "above").input("a", "after_classify.opacity"));
        let mut condition = "is_visible";
        let (mut color, mut opacity) = (
            "after_composite_color".to_owned(),
            "after_composite_opacity".to_owned(),
        );
        let mut normal = self
            .is_last_normal_kept(0)
            .then(|| "normals.kept".to_owned());
        let mut done = stop.map(str::to_owned);
        for (level, next) in [
            ("visible", "is_value"),
            ("found", "is_kept"),
            ("kept", "is_seen"),
            ("seen", ""),
        ] {
            let is_first = level == "visible";
            let mut node = Node::new(level, Kind::If)
                .input("if", condition)
                .input("then.color", color.as_str())
                .input(
                    "else.color",
                    if is_first { unseen } else { "samples.color" },
                )
                .input("then.opacity", opacity.as_str())
                .input(
                    "else.opacity",
                    if is_first {
                        unseen_opacity
                    } else {
                        "samples.opacity"
                    },
                );
            if let Some(normal) = &normal {
                node = node
                    .input("then.normal", normal.as_str())
                    .input("else.normal", "samples.normal");
            }
            if let Some(stop) = &done {
                // Fading without a sample that shows something can end a ray, too.
                let otherwise: Input = if is_first && unseen != "samples.color" {
                    "is_faded_out".into()
                } else {
                    false.into()
                };
                node = node
                    .input("then.done", stop.as_str())
                    .input("else.done", otherwise);
            }
            self.put(node);
            color = format!("{level}.color");
            opacity = format!("{level}.opacity");
            normal = normal.map(|_| format!("{level}.normal"));
            done = done.map(|_| format!("{level}.done"));
            condition = next;
        }
    }

    fn emission_absorption(&mut self, backwards: bool) {
        let stop = match self.plan.technique().composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => Some(stop_at_transmittance),
            _ => None,
        };
        let mut carry = vec![
            carried("k", "f32", 0.0.into(), "advance"),
            carried("color", "vec3f", numbers(&[0.0]), "seen.color"),
            carried("opacity", "f32", 0.0.into(), "seen.opacity"),
        ];
        if self.is_last_normal_kept(0) {
            carry.push(carried("normal", "vec3f", numbers(&[0.0]), "seen.normal"));
        }
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: stop.map(|_| Reference::new("seen.done")),
            }),
        ));
        self.sample(backwards);
        self.look("after_sample", "position", Some("samples.normal"));
        let rule = if backwards { "under" } else { "over" };
        self.put(
            pattern("composite", rule)
                .input("color", "before_composite_color")
                .input("opacity", "before_composite_opacity")
                .input("sum_color", "samples.color")
                .input("sum_opacity", "samples.opacity"),
        );
        self.anchor("after_composite_color", "composite.color");
        self.anchor("after_composite_opacity", "composite.opacity");
        if let Some(stop) = stop {
            self.put(
                pattern("is_opaque", "is_opaque")
                    .input("opacity", "after_composite_opacity")
                    .param("stop_at_transmittance", one(stop)),
            );
        }
        self.nested(
            "samples.color",
            "samples.opacity",
            stop.map(|_| "is_opaque"),
        );
        self.pixel();
    }

    /// Any other composite of the library: what it remembers is carried as it is, and its own functions are called.
    fn rule(&mut self, adds_looks: bool) {
        let mut carry = vec![
            carried("k", "f32", 0.0.into(), "advance"),
            carried("state", "CompositeState", "start".into(), "seen.state"),
        ];
        let keeps_normal = adds_looks && self.is_last_normal_kept(0);
        if keeps_normal {
            carry.push(carried("normal", "vec3f", numbers(&[0.0]), "seen.normal"));
        }
        self.put(pattern("start", "composite_start"));
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: Some(Reference::new("seen.done")),
            }),
        ));
        self.sample(false);
        let way = if adds_looks {
            "composite_of_look"
        } else {
            "composite_of_sample"
        };
        let mut composite = pattern("composite", way)
            .input("state", "samples.state")
            .input("value", "after_sample")
            .input("lattice_point", "point")
            .input("position", "position")
            .input("to_eye", "ray.to_eye");
        if adds_looks {
            self.visible_look("after_sample", "position", keeps_normal);
            composite = composite
                .input("color", "before_composite_color")
                .input("opacity", "before_composite_opacity");
        }
        self.put(composite);
        self.put(pattern("is_done", "composite_done").input("state", "composite"));
        let mut from = ["composite", "is_done", "visible.normal"].map(str::to_owned);
        for (level, condition) in [
            ("found", "is_value"),
            ("kept", "is_kept"),
            ("seen", "is_seen"),
        ] {
            let mut node = Node::new(level, Kind::If)
                .input("if", condition)
                .input("then.state", from[0].as_str())
                .input("else.state", "samples.state")
                .input("then.done", from[1].as_str())
                .input("else.done", false);
            if keeps_normal {
                node = node
                    .input("then.normal", from[2].as_str())
                    .input("else.normal", "samples.normal");
            }
            self.put(node);
            from = ["state", "done", "normal"].map(|output| format!("{level}.{output}"));
        }
        self.put(pattern("finished", "composite_finish").input("state", "samples.last.state"));
        self.anchor("after_composite_color", "finished.rgb");
        self.anchor("after_composite_opacity", "finished.a");
        self.put(
            pattern("pixel", "pixel")
                .input("color", "after_composite_color")
                .input("opacity", "after_composite_opacity"),
        );
        self.root("color", "pixel");
    }

    /// The look of a sample as `look` of shader functions gives it: nothing where nothing is visible.
    fn visible_look(&mut self, value: &str, position: &str, keeps_normal: bool) {
        self.look(value, position, Some("samples.normal"));
        self.put(pattern("step_opacity", "step_opacity").input("opacity", "after_shade_opacity"));
        self.put(pattern("is_visible", "above").input("a", "after_classify.opacity"));
        let mut visible = Node::new("visible", Kind::If)
            .input("if", "is_visible")
            .input("then.color", "after_shade_color")
            .input("else.color", numbers(&[0.0, 0.0, 0.0]))
            .input("then.opacity", "step_opacity")
            .input("else.opacity", 0.0);
        if keeps_normal {
            visible = visible
                .input("then.normal", "normals.kept")
                .input("else.normal", "samples.normal");
        }
        self.put(visible);
        self.anchor("before_composite_color", "visible.color");
        self.anchor("before_composite_opacity", "visible.opacity");
    }

    /// Several objects on one lattice, which begins where the ray meets the first of them: at every point all
    /// that are there are mixed, none before another.
    fn several(&mut self, backwards: bool) {
        let objects = self.plan.layers.len();
        let own = of_object;
        self.put(pattern("ray", "ray"));
        let mut whole = String::new();
        for i in 0..objects {
            let extent = pattern(&own("extent", i), "extent")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction");
            self.put_of(i, extent);
            self.anchor(&own("before_clip_ray", i), &own("extent", i));
            let clip = pattern(&own("clip_ray", i), "clip_ray")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction")
                .input("interval_mm", own("before_clip_ray", i).as_str());
            self.put_of(i, clip);
            self.anchor(&own("after_clip_ray", i), &own("clip_ray", i));
            let mut both = pattern(&own("whole", i), "interval_union")
                .input("interval_mm", own("after_clip_ray", i).as_str());
            if i > 0 {
                both = both.input("others_mm", whole.as_str());
            }
            self.put(both);
            whole = own("whole", i);
        }
        self.anchor("before_jitter", "ray.pixel");
        self.put(
            slot("jitter", "jitter")
                .input("pixel", "before_jitter")
                .input("frame", "ray.frame"),
        );
        self.anchor("after_jitter", "jitter");
        self.put(pattern("entry_at", "interval_start").input("interval_mm", whole.as_str()));
        for i in 0..objects {
            let lattice = pattern(&own("lattice", i), "lattice")
                .input("origin_mm", "ray.origin_mm")
                .input("direction", "ray.direction")
                .input("interval_mm", whole.as_str())
                .input("entry_at_mm", "entry_at")
                .input("jitter", "after_jitter");
            self.put_of(i, lattice);
            self.put(
                pattern(&own("interval", i), "interval_in_lattice")
                    .input("interval_mm", own("after_clip_ray", i).as_str())
                    .input("entry_at_mm", "entry_at"),
            );
        }
        let stop = match self.plan.technique().composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => Some(stop_at_transmittance),
            _ => None,
        };
        let keeps_normal = (0..objects).any(|i| self.is_last_normal_kept(i));
        let mut carry = vec![
            carried("k", "f32", 0.0.into(), "advance"),
            carried("color", "vec3f", numbers(&[0.0]), "seen.color"),
            carried("opacity", "f32", 0.0.into(), "seen.opacity"),
        ];
        if keeps_normal {
            carry.push(carried("normal", "vec3f", numbers(&[0.0]), "seen.normal"));
        }
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: stop.map(|_| Reference::new("seen.done")),
            }),
        ));
        self.put(
            pattern("is_before_end", "before_end")
                .input("k", "samples.k")
                .input("count", "lattice.count"),
        );
        let mut point = if backwards {
            pattern("point", "lattice_point_from_end").input("count", "lattice.count")
        } else {
            pattern("point", "lattice_point")
        };
        point = point
            .input("k", "samples.k")
            .input("jitter_of_ray", "after_jitter");
        self.put(point);
        let mut fewest: Input = 1e9.into();
        for i in 0..objects {
            self.is_there(i, backwards);
            self.put(
                pattern(&own("fewest", i), "least")
                    .input("a", fewest)
                    .input("b", (own("here", i) + ".points").as_str()),
            );
            fewest = own("fewest", i).as_str().into();
        }
        self.put(pattern("is_seen", "is_seen").input("empty", fewest.clone()));
        self.put(
            pattern("advance", "advance")
                .input("k", "samples.k")
                .input("empty", fewest),
        );
        let mut last_normal = "samples.normal".to_owned();
        for i in 0..objects {
            let keeps_it = self.is_last_normal_kept(i);
            self.part(i, keeps_it.then_some(last_normal.as_str()));
            if keeps_it {
                last_normal = own("part", i) + ".normal";
            }
        }
        self.anchor(
            "before_composite_color",
            &(own("mix", objects - 1) + ".mean"),
        );
        self.put(
            pattern("mixed_opacity", "rest_of")
                .input("a", (own("mix", objects - 1) + ".passing").as_str()),
        );
        self.anchor("before_composite_opacity", "mixed_opacity");
        let rule = if backwards { "under" } else { "over" };
        self.put(
            pattern("composite", rule)
                .input("color", "before_composite_color")
                .input("opacity", "before_composite_opacity")
                .input("sum_color", "samples.color")
                .input("sum_opacity", "samples.opacity"),
        );
        self.anchor("after_composite_color", "composite.color");
        self.anchor("after_composite_opacity", "composite.opacity");
        if let Some(stop) = stop {
            self.put(
                pattern("is_opaque", "is_opaque")
                    .input("opacity", "after_composite_opacity")
                    .param("stop_at_transmittance", one(stop)),
            );
        }
        self.put(
            pattern("is_visible", "above").input("a", (own("mix", objects - 1) + ".sum").as_str()),
        );
        let (mut color, mut opacity) = (
            "after_composite_color".to_owned(),
            "after_composite_opacity".to_owned(),
        );
        let mut done = stop.map(|_| "is_opaque".to_owned());
        for (level, condition) in [("visible", "is_visible"), ("seen", "is_seen")] {
            let mut node = Node::new(level, Kind::If)
                .input("if", condition)
                .input("then.color", color.as_str())
                .input("else.color", "samples.color")
                .input("then.opacity", opacity.as_str())
                .input("else.opacity", "samples.opacity");
            if let Some(stop) = &done {
                node = node
                    .input("then.done", stop.as_str())
                    .input("else.done", false);
            }
            // What was found on the way stays found, whether it is visible or not.
            if keeps_normal && level == "seen" {
                node = node
                    .input("then.normal", last_normal.as_str())
                    .input("else.normal", "samples.normal");
            }
            self.put(node);
            color = format!("{level}.color");
            opacity = format!("{level}.opacity");
            done = done.map(|_| format!("{level}.done"));
        }
        self.pixel();
    }

    /// `here`: whether an object may be seen at this point, and at how many points from it on nothing of it is.
    fn is_there(&mut self, i: usize, backwards: bool) {
        let own = |name: &str| of_object(name, i);
        self.put(
            pattern(&own("position"), "position_on_ray")
                .input("entry", (own("lattice") + ".entry").as_str())
                .input("step", (own("lattice") + ".step").as_str())
                .input("lattice_point", "point"),
        );
        let mut step = own("lattice") + ".step";
        if backwards {
            self.put(pattern(&own("step_back"), "backwards").input("step", step.as_str()));
            step = own("step_back");
        }
        self.put(
            pattern(&own("is_inside"), "in_interval")
                .input("lattice_point", "point")
                .input("interval", own("interval").as_str()),
        );
        let empty = pattern(&own("empty"), "empty_points")
            .input("position", own("position").as_str())
            .input("step", step.as_str());
        self.put_of(i, empty);
        self.put(pattern(&own("is_full"), "is_seen").input("empty", own("empty").as_str()));
        self.put(
            pattern(&own("way"), "points_to")
                .input("lattice_point", "point")
                .input("interval", own("interval").as_str())
                .input("backwards", backwards),
        );
        self.put(
            Node::new(own("here"), Kind::If)
                .input("if", own("is_inside").as_str())
                .input("then.points", own("empty").as_str())
                .input("else.points", own("way").as_str())
                .input("then.seen", own("is_full").as_str())
                .input("else.seen", false),
        );
    }

    /// `mix`: what all objects up to this one give at this point.
    fn part(&mut self, i: usize, last_normal: Option<&str>) {
        let own = |name: &str| of_object(name, i);
        self.anchor(&own("before_clip_sample"), &own("position"));
        let place = pattern(&own("place_mm"), "world_from_voxel")
            .input("position", own("before_clip_sample").as_str());
        self.put_of(i, place);
        let clip =
            slot(&own("clip_sample"), "clip_sample").input("place_mm", own("place_mm").as_str());
        self.put_of(i, clip);
        self.anchor(&own("after_clip_sample"), &own("clip_sample"));
        self.put(pattern(&own("is_kept"), "not").input("a", own("after_clip_sample").as_str()));
        self.anchor(&own("before_sample"), &own("position"));
        let sample =
            slot(&own("sample"), "reconstruct").input("position", own("before_sample").as_str());
        self.put_of(i, sample);
        self.anchor(&own("after_sample"), &own("sample"));
        self.put(
            pattern(&own("is_value"), "is_value").input("value", own("after_sample").as_str()),
        );
        self.look_of(i, &own("after_sample"), &own("position"), last_normal);
        let step_opacity = pattern(&own("step_opacity"), "step_opacity")
            .input("opacity", own("after_shade_opacity").as_str());
        self.put_of(i, step_opacity);
        self.put(
            pattern(&own("is_shown"), "above")
                .input("a", (own("after_classify") + ".opacity").as_str()),
        );
        let mut from = [
            own("after_shade_color"),
            own("step_opacity"),
            own("normals") + ".kept",
        ];
        for (level, condition) in [
            ("shown", own("is_shown")),
            ("valid", own("is_value")),
            ("kept", own("is_kept")),
            ("part", own("here") + ".seen"),
        ] {
            let mut node = Node::new(own(level), Kind::If)
                .input("if", condition.as_str())
                .input("then.color", from[0].as_str())
                .input("else.color", numbers(&[0.0, 0.0, 0.0]))
                .input("then.opacity", from[1].as_str())
                .input("else.opacity", 0.0);
            if let Some(last) = last_normal {
                node = node
                    .input("then.normal", from[2].as_str())
                    .input("else.normal", last);
            }
            self.put(node);
            from = ["color", "opacity", "normal"].map(|output| format!("{}.{output}", own(level)));
        }
        let mut mix = pattern(&own("mix"), "mixed")
            .input("color", from[0].as_str())
            .input("opacity", from[1].as_str());
        if i > 0 {
            let before = of_object("mix", i - 1);
            for member in ["light", "sum", "passing"] {
                mix = mix.input(
                    format!("{member}_before"),
                    format!("{before}.{member}").as_str(),
                );
            }
        }
        self.put(mix);
    }

    fn pixel(&mut self) {
        self.put(
            pattern("pixel", "pixel")
                .input("color", "samples.last.color")
                .input("opacity", "samples.last.opacity"),
        );
        self.root("color", "pixel");
    }

    fn mida(&mut self) {
        let Composite::Mida {
            low,
            high,
            blend,
            stop_at_transmittance,
        } = self.plan.technique().composite
        else {
            return;
        };
        let mut carry = vec![
            carried("k", "f32", 0.0.into(), "advance"),
            carried("color", "vec3f", numbers(&[0.0]), "seen.color"),
            carried("opacity", "f32", 0.0.into(), "seen.opacity"),
            carried("largest", "f32", 0.0.into(), "risen.largest"),
        ];
        if self.is_last_normal_kept(0) {
            carry.push(carried("normal", "vec3f", numbers(&[0.0]), "seen.normal"));
        }
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: Some(Reference::new("seen.done")),
            }),
        ));
        self.sample(false);
        self.put(
            pattern("fade", "fade")
                .input("value", "after_sample")
                .input("sum_color", "samples.color")
                .input("sum_opacity", "samples.opacity")
                .input("largest", "samples.largest")
                .param("low", one(low))
                .param("high", one(high))
                .param("blend", one(blend)),
        );
        self.look("after_sample", "position", Some("samples.normal"));
        self.put(
            pattern("composite", "over")
                .input("color", "before_composite_color")
                .input("opacity", "before_composite_opacity")
                .input("sum_color", "fade.color")
                .input("sum_opacity", "fade.opacity"),
        );
        self.anchor("after_composite_color", "composite.color");
        self.anchor("after_composite_opacity", "composite.opacity");
        for (name, opacity) in [
            ("is_opaque", "after_composite_opacity"),
            ("is_faded_out", "fade.opacity"),
        ] {
            self.put(
                pattern(name, "is_opaque_to_larger")
                    .input("opacity", opacity)
                    .input("largest", "fade.largest")
                    .param("stop_at_transmittance", one(stop_at_transmittance))
                    .param("blend", one(blend)),
            );
        }
        self.nested("fade.color", "fade.opacity", Some("is_opaque"));
        // The largest value so far grows by every sample that is one.
        let mut largest = "fade.largest".to_owned();
        for (name, condition) in [
            ("rises", "is_value"),
            ("rises_if_kept", "is_kept"),
            ("risen", "is_seen"),
        ] {
            self.put(
                Node::new(name, Kind::If)
                    .input("if", condition)
                    .input("then.largest", largest.as_str())
                    .input("else.largest", "samples.largest"),
            );
            largest = format!("{name}.largest");
        }
        self.pixel();
    }

    /// Walks a ray whose carried variables `names` (and type) become outputs of `rule` where a sample counts.
    fn walk(&mut self, rule: Node, names: &[(&str, &str, Input)], done: Option<&str>) {
        let mut carry = vec![carried("k", "f32", 0.0.into(), "advance")];
        for (name, ty, start) in names {
            carry.push(carried(name, ty, start.clone(), &format!("seen.{name}")));
        }
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: done.map(|_| Reference::new("seen.done")),
            }),
        ));
        self.sample(false);
        let rule_name = rule.name.clone();
        self.put(rule);
        let mut before = rule_name;
        for (level, condition) in [
            ("found_one", "is_value"),
            ("kept", "is_kept"),
            ("seen", "is_seen"),
        ] {
            let mut node = Node::new(level, Kind::If).input("if", condition);
            for (name, ..) in names {
                node = node
                    .input(format!("then.{name}"), format!("{before}.{name}").as_str())
                    .input(format!("else.{name}"), format!("samples.{name}").as_str());
            }
            if let Some(done) = done {
                let from = if level == "found_one" {
                    done.to_owned()
                } else {
                    format!("{before}.done")
                };
                node = node
                    .input("then.done", from.as_str())
                    .input("else.done", false);
            }
            self.put(node);
            before = level.to_owned();
        }
    }

    /// One value of the ray, classified and shaded once.
    fn show(&mut self, value: &str, point: &str, found: &str, is_opaque: bool) {
        self.put(
            pattern("position_seen", "position_on_ray")
                .input("entry", "lattice.entry")
                .input("step", "lattice.step")
                .input("lattice_point", point),
        );
        let value = match value {
            "" => {
                self.put(slot("value_seen", "reconstruct").input("position", "position_seen"));
                "value_seen"
            }
            value => value,
        };
        self.look(value, "position_seen", None);
        self.anchor("before_composite_color", "after_shade_color");
        self.anchor("before_composite_opacity", "after_shade_opacity");
        self.anchor("after_composite_color", "before_composite_color");
        let opacity: Input = if is_opaque {
            1.0.into()
        } else {
            "before_composite_opacity".into()
        };
        self.put(Node::new("after_composite_opacity", Kind::Anchor).input("in", opacity));
        self.put(
            pattern("pixel", "shown")
                .input("color", "after_composite_color")
                .input("opacity", "after_composite_opacity"),
        );
        self.put(
            Node::new("shown", Kind::If)
                .input("if", found)
                .input("then.pixel", "pixel")
                .input("else.pixel", numbers(&[0.0, 0.0, 0.0, 0.0])),
        );
        self.root("color", "shown.pixel");
    }

    fn extreme(&mut self, rule: &str) {
        let node = pattern("composite", rule)
            .input("value", "after_sample")
            .input("lattice_point", "point")
            .input("best", "samples.value")
            .input("best_point", "samples.lattice_point")
            .input("found", "samples.found");
        self.walk(
            node,
            &[
                ("value", "f32", 0.0.into()),
                ("lattice_point", "f32", 0.0.into()),
                ("found", "bool", false.into()),
            ],
            None,
        );
        self.show(
            "samples.last.value",
            "samples.last.lattice_point",
            "samples.last.found",
            false,
        );
    }

    fn average(&mut self) {
        let node = pattern("composite", "sum_of_values")
            .input("value", "after_sample")
            .input("lattice_point", "point")
            .input("sum", "samples.sum")
            .input("number", "samples.number");
        self.walk(
            node,
            &[
                ("sum", "f32", 0.0.into()),
                ("number", "f32", 0.0.into()),
                ("lattice_point", "f32", 0.0.into()),
            ],
            None,
        );
        self.put(
            pattern("mean", "mean")
                .input("sum", "samples.last.sum")
                .input("number", "samples.last.number"),
        );
        self.put(pattern("found", "above").input("a", "samples.last.number"));
        self.show("mean", "samples.last.lattice_point", "found", false);
    }

    fn steepest(&mut self, white_per_mm: f32) {
        self.put(slot("gradient", "gradient").input("position", "position"));
        self.put(pattern("steepness", "gradient_length").input("gradient_here", "gradient"));
        let node = pattern("composite", "larger")
            .input("value", "steepness")
            .input("lattice_point", "point")
            .input("best", "samples.value")
            .input("best_point", "samples.lattice_point")
            .input("found", "samples.found");
        self.walk(
            node,
            &[
                ("value", "f32", 0.0.into()),
                ("lattice_point", "f32", 0.0.into()),
                ("found", "bool", false.into()),
            ],
            None,
        );
        self.put(
            pattern("grey", "grey")
                .input("number", "samples.last.value")
                .input(
                    "white",
                    Input::Constant(Constant::Numbers(one(white_per_mm))),
                ),
        );
        self.anchor("before_composite_color", "grey");
        self.anchor("after_composite_color", "before_composite_color");
        self.put(
            pattern("pixel", "shown")
                .input("color", "after_composite_color")
                .input("opacity", 1.0),
        );
        self.put(
            Node::new("shown", Kind::If)
                .input("if", "samples.last.found")
                .input("then.pixel", "pixel")
                .input("else.pixel", numbers(&[0.0, 0.0, 0.0, 0.0])),
        );
        self.root("color", "shown.pixel");
    }

    fn first_hit(&mut self, threshold: f64) {
        let rule = pattern("composite", "hit_here")
            .input("value", "after_sample")
            .input("lattice_point", "point")
            .param("threshold", vec![threshold]);
        let names = [
            ("lattice_point", "f32", Input::from(0.0)),
            ("hit", "bool", false.into()),
        ];
        self.walk(rule, &names, Some("composite.hit"));
        self.put(
            pattern("surface_point", "refine_hit")
                .input("lattice_point", "samples.last.lattice_point")
                .param("threshold", vec![threshold]),
        );
        self.show("", "surface_point", "samples.last.hit", true);
        if self.plan.with_depth {
            self.put(pattern("depth_of_hit", "distance").input("lattice_point", "surface_point"));
            self.put(
                Node::new("depth", Kind::If)
                    .input("if", "samples.last.hit")
                    .input("then.mm", "depth_of_hit")
                    .input("else.mm", 3.0e38),
            );
            self.root("depth_mm", "depth.mm");
        }
    }
}
