//! The standard graph of a scene with segments: the loop of `segments.wgsl` as nodes, and each technique as a
//! group that adds a sample to the run which it draws.

use super::{Builder, carried, pattern};
use crate::model::{Constant, Graph, GroupInput, Input, Kind, Loop, Node, Reference};

/// The segment of no run. Its float is exact.
const NO_SEGMENT: f64 = u32::MAX as f64;

/// What the group of a technique is given.
const INPUTS: [&str; 5] = ["state", "value", "lattice_point", "position", "to_eye"];

fn whole(number: f64) -> Input {
    Input::Constant(Constant::Numbers(vec![number]))
}

/// The name of the group of a technique.
fn group_name(technique: usize) -> String {
    format!("technique_{technique}")
}

impl Builder<'_> {
    /// One object in segments, each with a technique; samples of one segment in a row are a run.
    pub(super) fn segments(&mut self) {
        self.ray();
        self.put(pattern("start", "composite_start"));
        self.put(pattern("nothing", "no_runs"));
        let carry = vec![
            carried("k", "f32", 0.0.into(), "advance"),
            carried("segment", "u32", whole(NO_SEGMENT), "here.segment"),
            carried("technique", "u32", whole(0.0), "ended.technique"),
            carried("state", "CompositeState", "start".into(), "drawn.state"),
            carried("by_place", "f32", 0.0.into(), "drawn.by_place"),
            carried("runs", "Runs", "nothing".into(), "ended.runs"),
        ];
        self.put(Node::new(
            "samples",
            Kind::Loop(Loop {
                carry,
                while_: Some(Reference::new("is_before_end")),
                until: Some(Reference::new("is_covered")),
            }),
        ));
        self.place_in_segment();
        self.new_run();
        self.value();
        self.draw_sample();
        self.end_run();
        self.runs_to_pixel();
    }

    /// Where the sample lies, and in which segment.
    fn place_in_segment(&mut self) {
        self.put(
            pattern("is_before_end", "before_end")
                .input("k", "samples.k")
                .input("count", "lattice.count"),
        );
        self.put(
            pattern("point", "lattice_point")
                .input("k", "samples.k")
                .input("jitter_of_ray", "after_jitter"),
        );
        self.put(
            pattern("place", "position_on_ray")
                .input("entry", "lattice.entry")
                .input("step", "lattice.step")
                .input("lattice_point", "point"),
        );
        self.put(pattern("advance", "advance").input("k", "samples.k"));
        self.put(pattern("here", "enter_segment").input("position", "place"));
        self.anchor("position", "here.position");
    }

    /// `run`: the technique of the sample, the state and the runs before it. Where the segment is another than
    /// that of the last sample, a run ends and one begins.
    fn new_run(&mut self) {
        self.put(
            pattern("is_new", "differs")
                .input("a", "here.segment")
                .input("b", "samples.segment"),
        );
        self.put(
            pattern("closed", "with_closed_run")
                .input("runs", "samples.runs")
                .input("state", "samples.state")
                .input("by_place", "samples.by_place")
                .input("segment", "samples.segment")
                .input("technique", "samples.technique"),
        );
        self.put(
            pattern("entered", "entered")
                .input("runs", "closed")
                .input("segment", "here.segment"),
        );
        self.put(
            pattern("technique_of_new", "technique_of_new_run")
                .input("segment", "here.segment")
                .input("runs", "entered"),
        );
        self.put(
            Node::new("run", Kind::If)
                .input("if", "is_new")
                .input("then.technique", "technique_of_new")
                .input("else.technique", "samples.technique")
                .input("then.state", "start")
                .input("else.state", "samples.state")
                .input("then.by_place", 0.0)
                .input("else.by_place", "samples.by_place")
                .input("then.runs", "entered")
                .input("else.runs", "samples.runs"),
        );
        self.put(
            pattern("is_drawn", "differs")
                .input("a", "run.technique")
                .input("b", whole(0.0)),
        );
    }

    /// `drawn`: the state with the sample, by its technique, and whether the run needs no more.
    fn draw_sample(&mut self) {
        let mut state = "run.state".to_owned();
        for technique in 0..self.plan.techniques.len() {
            let name = group_name(technique);
            let mut group = Node::new(&name, Kind::Group(Box::new(self.technique(technique))))
                .input("state", "run.state")
                .input("value", "after_sample")
                .input("lattice_point", "point")
                .input("position", "position")
                .input("to_eye", "ray.to_eye");
            group.technique = technique;
            self.put(group);
            let number = whole(technique as f64);
            self.put(
                pattern(&format!("is_{name}"), "is_technique")
                    .input("technique", "run.technique")
                    .input("number", number),
            );
            let by = format!("by_{name}");
            self.put(
                Node::new(&by, Kind::If)
                    .input("if", format!("is_{name}").as_str())
                    .input("then.state", format!("{name}.state").as_str())
                    .input("else.state", state.as_str()),
            );
            state = format!("{by}.state");
        }
        self.put(
            pattern("is_done", "is_run_done")
                .input("state", state.as_str())
                .input("technique", "run.technique"),
        );
        self.put(
            pattern("place_counts", "with_place")
                .input("by_place", "run.by_place")
                .input("position", "position"),
        );
        let (mut done, mut by_place) = ("is_done".to_owned(), "place_counts".to_owned());
        for (level, condition) in [
            ("found", "is_value"),
            ("kept", "is_kept"),
            ("drawn", "is_drawn"),
        ] {
            self.put(
                Node::new(level, Kind::If)
                    .input("if", condition)
                    .input("then.state", state.as_str())
                    .input("else.state", "run.state")
                    .input("then.by_place", by_place.as_str())
                    .input("else.by_place", "run.by_place")
                    .input("then.done", done.as_str())
                    .input("else.done", false),
            );
            (state, done) = (format!("{level}.state"), format!("{level}.done"));
            by_place = format!("{level}.by_place");
        }
    }

    /// The nodes of a technique: a sample, added to its run.
    fn technique(&self, number: usize) -> Graph {
        let mut group = Builder {
            plan: self.plan,
            within: Some(number),
            graph: Graph::default(),
        };
        group.graph.inputs = INPUTS
            .map(|name| GroupInput {
                name: name.to_owned(),
                default: None,
            })
            .to_vec();
        let technique = &self.plan.techniques[number];
        let adds_looks = technique.composite.function().adds_looks;
        let way = if adds_looks {
            "run_of_look"
        } else {
            "run_of_sample"
        };
        let mut composite = pattern("composite", way);
        for input in INPUTS {
            composite = composite.input(input, format!("inputs.{input}").as_str());
        }
        if adds_looks {
            group.visible_look("inputs.value", "inputs.position", false);
            composite = composite
                .input("color", "before_composite_color")
                .input("opacity", "before_composite_opacity");
        }
        group.put(composite);
        group.root("state", "composite");
        group.graph
    }

    /// `ended`: a run that needs no more samples ends at once.
    fn end_run(&mut self) {
        self.put(
            pattern("ended_run", "with_closed_run")
                .input("runs", "run.runs")
                .input("state", "drawn.state")
                .input("by_place", "drawn.by_place")
                .input("segment", "here.segment")
                .input("technique", "run.technique"),
        );
        self.put(
            Node::new("ended", Kind::If)
                .input("if", "drawn.done")
                .input("then.runs", "ended_run")
                .input("else.runs", "run.runs")
                .input("then.technique", whole(0.0))
                .input("else.technique", "run.technique"),
        );
        self.put(pattern("is_covered", "is_covered").input("runs", "ended.runs"));
    }

    fn runs_to_pixel(&mut self) {
        self.put(
            pattern("all_runs", "with_closed_run")
                .input("runs", "samples.last.runs")
                .input("state", "samples.last.state")
                .input("by_place", "samples.last.by_place")
                .input("segment", "samples.last.segment")
                .input("technique", "samples.last.technique"),
        );
        self.put(pattern("finished", "pixel_of_runs").input("runs", "all_runs"));
        self.anchor("after_composite_color", "finished.rgb");
        self.anchor("after_composite_opacity", "finished.a");
        self.put(
            pattern("pixel", "pixel")
                .input("color", "after_composite_color")
                .input("opacity", "after_composite_opacity"),
        );
        self.root("color", "pixel");
    }
}
