//! Graphs that are drawn by slices instead of along rays: how that is written, and what such a graph cannot do.

use crate::error::Problem;
use crate::model::{Graph, Kind, Node, Stage};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use strahl_program::{Blend, BlendPart, Factor, Operation, Order, Slicing};

/// Patterns that need the lattice of a ray.
const ALONG_THE_RAY: [&str; 2] = ["lattice", "distance"];

/// Patterns that need a slice.
const OF_A_SLICE: [&str; 2] = ["slice", "slice_mm"];

/// The pattern of the picture's corners.
const CORNER: &str = "corner";

/// Patterns that are computed from the pixel.
const OF_A_PIXEL: [&str; 2] = ["ray", "slice"];

/// What a graph that slices cannot do, and what only such a graph can; and nodes in a stage that does not have
/// what they need.
pub fn problems(graph: &Graph) -> Vec<Problem> {
    let mut problems = Vec::new();
    for node in &graph.nodes {
        if let Kind::Pattern(pattern) = &node.kind {
            let why = why_not(node, pattern, graph.slicing.is_some());
            let place = || format!("nodes.{}", node.name);
            problems.extend(why.map(|why| Problem::new(place(), why)));
        }
    }
    let Some(slicing) = &graph.slicing else {
        return problems;
    };
    if let Err((part, why)) = slicing.blend.check() {
        problems.push(Problem::new(format!("slicing.blend.{part}"), why));
    }
    if let Some(order) = slicing.blend.order()
        && order != slicing.order
    {
        let (written, why) = match order {
            Order::FrontToBack => (
                "front-to-back",
                "hides what comes later behind what is there",
            ),
            Order::BackToFront => ("back-to-front", "hides what is there behind what comes"),
        };
        problems.push(Problem::new(
            "slicing.order",
            format!("this blend {why}: its order is \"{written}\""),
        ));
    }
    if !slicing.start.iter().all(|number| number.is_finite()) {
        problems.push(Problem::new(
            "slicing.start",
            "it has four numbers that an f32 can hold",
        ));
    }
    if !graph.roots.iter().any(|(name, _)| name == "color") {
        problems.push(Problem::new(
            "roots",
            "a slice has the root `color` (vec4f), which is what is blended",
        ));
    }
    if graph.roots.iter().any(|(name, _)| name == "depth_mm") {
        problems.push(Problem::new(
            "roots.depth_mm",
            "slices have no depth: none knows whether it is the first that is seen",
        ));
    }
    problems
}

fn why_not(node: &Node, pattern: &str, is_slicing: bool) -> Option<String> {
    let is_vertex = node.stage != Stage::Pixel;
    if is_slicing && ALONG_THE_RAY.contains(&pattern) {
        return Some(format!(
            "a graph with `slicing` has no loop along the ray, and no `{pattern}`: the pattern `slice` gives the point of the slice, its distance, and the way to the next one"
        ));
    }
    if !is_slicing && OF_A_SLICE.contains(&pattern) {
        return Some(format!(
            "only a graph with `slicing` has slices; set how they are blended, such as \"slicing\": {{ \"blend\": \"front-to-back\" }}, or take the point from the lattice of a ray instead of `{pattern}`"
        ));
    }
    if pattern == CORNER && !is_vertex {
        return Some(
            "the corners of the picture are there in the vertex stage only; set \"stage\": \"vertex\""
                .to_owned(),
        );
    }
    if OF_A_PIXEL.contains(&pattern) && is_vertex {
        return Some(format!(
            "`{pattern}` is that of a pixel, and vertices have none; the pattern `{CORNER}` gives where a corner of the picture lies"
        ));
    }
    None
}

/// The graph is drawn by slices across the view, nearest or farthest first, instead of along rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Slicing")]
pub struct SlicingText {
    /// Which slice comes first; that of the blend if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    order: Option<OrderText>,
    /// How a slice joins those before it.
    blend: BlendText,
    /// What is there before the first slice: premultiplied color, opacity; 0 if not said, and 1 for the blend
    /// `smaller`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<[f32; 4]>,
}

/// One that has a name, or a state of its own.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Blend")]
enum BlendText {
    /// By its name.
    Named(NamedBlend),
    /// Factors and operations.
    State(BlendStateText),
}

impl<'de> Deserialize<'de> for BlendText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<BlendText, D::Error> {
        struct Any;
        impl<'de> serde::de::Visitor<'de> for Any {
            type Value = BlendText;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("the name of a blend, or an object with `color` and `opacity`")
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<BlendText, E> {
                let name = serde::de::value::StrDeserializer::<E>::new(text);
                NamedBlend::deserialize(name).map(BlendText::Named)
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(
                self,
                map: A,
            ) -> Result<BlendText, A::Error> {
                let of = serde::de::value::MapAccessDeserializer::new(map);
                BlendStateText::deserialize(of).map(BlendText::State)
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// Blends that have a name. Colors are premultiplied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum NamedBlend {
    /// A slice behind those before it.
    FrontToBack,
    /// A slice in front of those before it.
    BackToFront,
    /// The larger of each channel.
    Larger,
    /// The smaller of each channel.
    Smaller,
    /// The sum.
    Add,
}

const NAMED: [(NamedBlend, Blend); 5] = [
    (NamedBlend::FrontToBack, Blend::FRONT_TO_BACK),
    (NamedBlend::BackToFront, Blend::BACK_TO_FRONT),
    (NamedBlend::Larger, Blend::LARGER),
    (NamedBlend::Smaller, Blend::SMALLER),
    (NamedBlend::Add, Blend::ADD),
];

/// The blend state of the graphics interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BlendState")]
struct BlendStateText {
    /// Of red, green and blue.
    color: BlendPartText,
    /// Of the opacity; as of the color if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    opacity: Option<BlendPartText>,
}

/// operation(source · factor, destination · factor): the source is the slice, the destination what is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BlendPart")]
struct BlendPartText {
    /// What the slice is multiplied by; default `one`.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    source: FactorText,
    /// What is there is multiplied by this; default `one`.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    destination: FactorText,
    /// What is done with both; default `add`.
    #[serde(default = "add", skip_serializing_if = "is_add")]
    operation: OperationText,
}

fn one() -> FactorText {
    FactorText::One
}

fn is_one(factor: &FactorText) -> bool {
    *factor == FactorText::One
}

fn add() -> OperationText {
    OperationText::Add
}

fn is_add(operation: &OperationText) -> bool {
    *operation == OperationText::Add
}

/// An enum of words for one of the program's.
macro_rules! words {
    ($(#[$of_enum:meta])* $text:ident ($name:literal) = $of:ident { $($(#[$of_word:meta])* $word:ident),+ $(,)? }) => {
        $(#[$of_enum])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        #[schemars(rename = $name)]
        enum $text {
            $($(#[$of_word])* $word),+
        }

        impl From<$text> for $of {
            fn from(text: $text) -> $of {
                match text {
                    $($text::$word => $of::$word),+
                }
            }
        }

        impl From<$of> for $text {
            fn from(of: $of) -> $text {
                match of {
                    $($of::$word => $text::$word),+
                }
            }
        }
    };
}

words! {
    /// Which slice comes first.
    OrderText("SliceOrder") = Order {
        /// The nearest.
        FrontToBack,
        /// The farthest.
        BackToFront,
    }
}

words! {
    /// What one side of a blend is multiplied by.
    FactorText("BlendFactor") = Factor {
        /// 0.
        Zero,
        /// 1.
        One,
        /// The source, channel by channel.
        Source,
        /// 1 − the source.
        OneMinusSource,
        /// The source's opacity.
        SourceOpacity,
        /// 1 − the source's opacity.
        OneMinusSourceOpacity,
        /// The destination, channel by channel.
        Destination,
        /// 1 − the destination.
        OneMinusDestination,
        /// The destination's opacity.
        DestinationOpacity,
        /// 1 − the destination's opacity.
        OneMinusDestinationOpacity,
    }
}

words! {
    /// What is done with source and destination after their factors.
    OperationText("BlendOperation") = Operation {
        /// Source + destination.
        Add,
        /// Source − destination.
        Subtract,
        /// Destination − source.
        ReverseSubtract,
        /// The smaller; without factors.
        Smaller,
        /// The larger; without factors.
        Larger,
    }
}

impl BlendPartText {
    fn part(self) -> BlendPart {
        BlendPart {
            source: self.source.into(),
            destination: self.destination.into(),
            operation: self.operation.into(),
        }
    }

    fn of(part: BlendPart) -> BlendPartText {
        BlendPartText {
            source: part.source.into(),
            destination: part.destination.into(),
            operation: part.operation.into(),
        }
    }
}

/// What is there before the first slice, if nothing is said.
fn start_of(blend: &Blend) -> [f32; 4] {
    match blend.color.operation {
        Operation::Smaller => [1.0; 4],
        _ => [0.0; 4],
    }
}

impl SlicingText {
    /// What it means.
    pub fn slicing(&self) -> Slicing {
        let blend = match &self.blend {
            BlendText::Named(name) => {
                let found = NAMED.iter().find(|(known, _)| known == name);
                found.map_or(Blend::FRONT_TO_BACK, |(_, blend)| *blend)
            }
            BlendText::State(state) => Blend {
                color: state.color.part(),
                opacity: state.opacity.unwrap_or(state.color).part(),
            },
        };
        Slicing {
            order: match self.order {
                Some(order) => order.into(),
                None => blend.order().unwrap_or_default(),
            },
            blend,
            start: self.start.unwrap_or_else(|| start_of(&blend)),
        }
    }

    /// How `slicing` is written.
    pub fn of(slicing: &Slicing) -> SlicingText {
        let blend = slicing.blend;
        let named = NAMED.iter().find(|(_, known)| *known == blend);
        SlicingText {
            order: Some(slicing.order.into()),
            blend: match named {
                Some((name, _)) => BlendText::Named(*name),
                None => BlendText::State(BlendStateText {
                    color: BlendPartText::of(blend.color),
                    opacity: (blend.opacity != blend.color)
                        .then(|| BlendPartText::of(blend.opacity)),
                }),
            },
            start: (slicing.start != start_of(&blend)).then_some(slicing.start),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Compiler, Graph, GraphUse};
    use strahl_program::{Blend, Factor, Functions, Order, loop_of};
    use strahl_scene::{Scene, resolve};
    use strahl_shader::Texels;
    use strahl_volume::Phantom;

    fn graph(slicing: &str, rest: &str) -> Graph {
        let text = format!(
            r#"{{ "strahl_graph": 1, "slicing": {slicing}, "nodes": {{
                "slice": {{ "pattern": "slice" }},
                "value": {{ "slot": "reconstruct", "inputs": {{ "position": "slice.position" }} }},
                "look": {{ "slot": "classify", "inputs": {{ "value": "value", "position": "slice.position" }} }},
                "opacity": {{ "pattern": "step_opacity", "inputs": {{ "opacity": "look.opacity" }} }},
                "color": {{ "pattern": "premultiply", "inputs": {{ "color": "look.color", "opacity": "opacity" }} }},
                "pixel": {{ "pattern": "pixel", "inputs": {{ "color": "color", "opacity": "opacity" }} }} {rest}
            }}, "roots": {{ "color": "pixel" }} }}"#
        );
        let read = GraphUse::read("test", &text, &mut |_| Err("none".to_owned()));
        read.unwrap_or_else(|error| panic!("{error}"))
            .graph
            .unwrap()
    }

    fn compiled(graph: &Graph) -> Result<String, String> {
        let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
        let plan = resolve(&Scene::default(), &volume.header(), None).unwrap();
        let functions = Functions::of(&plan, true, |_, threshold| f64::from(threshold)).unwrap();
        let what = loop_of(&plan, Texels::Float);
        let compiled = Compiler::default().compile("test", graph, &what, &functions);
        let compiled = compiled.map_err(|error| error.to_string())?;
        assert_eq!(compiled.slicing, graph.slicing);
        Ok(compiled.program.wgsl().to_owned())
    }

    #[test]
    fn a_slice_is_a_program() {
        let program = compiled(&graph(r#"{ "blend": "front-to-back" }"#, "")).unwrap();
        assert!(
            program.contains("frame.first_slice + i32(instance)"),
            "{program}"
        );
        assert!(program.contains("discard"), "{program}");
        let program = compiled(&graph(r#"{ "blend": "back-to-front" }"#, "")).unwrap();
        assert!(
            program.contains("frame.first_slice - i32(instance)"),
            "{program}"
        );
    }

    #[test]
    fn slicing_is_written_as_it_is_read() {
        for text in [
            r#"{ "blend": "larger" }"#,
            r#"{ "blend": "smaller", "start": [2, 2, 2, 0] }"#,
            r#"{ "order": "back-to-front", "blend": { "color": { "source": "source-opacity", "destination": "one-minus-source-opacity" },
                 "opacity": { "destination": "one-minus-source-opacity" } } }"#,
        ] {
            let graph = graph(text, "");
            let printed = graph.to_text();
            let again = GraphUse::read("again", &printed, &mut |_| Err("none".to_owned())).unwrap();
            assert_eq!(again.graph.as_ref(), Some(&graph), "{printed}");
            assert!(compiled(&graph).is_ok());
        }
        let own = graph(
            r#"{ "blend": { "color": { "source": "source-opacity", "destination": "one-minus-source-opacity" } } }"#,
            "",
        );
        let slicing = own.slicing.unwrap();
        assert_eq!(slicing.order, Order::BackToFront);
        assert_eq!(slicing.blend.opacity.source, Factor::SourceOpacity);
        assert_ne!(slicing.blend, Blend::BACK_TO_FRONT);
    }

    #[test]
    fn what_slices_cannot_do_is_refused() {
        let refused = |slicing: &str, rest: &str, place: &str, why: &str| {
            let said = compiled(&graph(slicing, rest)).unwrap_err();
            assert!(said.contains(place) && said.contains(why), "{said}");
        };
        refused(
            r#"{ "order": "back-to-front", "blend": "front-to-back" }"#,
            "",
            "slicing.order: ",
            "its order is \"front-to-back\"",
        );
        refused(
            r#"{ "blend": { "color": { "source": "source-opacity", "operation": "larger" } } }"#,
            "",
            "slicing.blend.color: ",
            "take no factors",
        );
        refused(
            r#"{ "blend": { "color": { "source": "zero" } } }"#,
            "",
            "slicing.blend.color: ",
            "no slice would be seen",
        );
        let ours = r#"{ "blend": "add" }"#;
        refused(
            ours,
            r#", "walk": { "pattern": "lattice" }"#,
            "nodes.walk: ",
            "no loop along the ray",
        );
        refused(
            ours,
            r#", "edge": { "pattern": "corner" }"#,
            "nodes.edge: ",
            r#"set "stage": "vertex""#,
        );
        refused(
            ours,
            r#", "ray": { "pattern": "ray", "stage": "vertex" }"#,
            "nodes.ray: ",
            "vertices have none",
        );
        let mut rays = graph(ours, "");
        rays.slicing = None;
        let said = compiled(&rays).unwrap_err();
        assert!(
            said.contains("nodes.slice: ") && said.contains("only a graph with `slicing`"),
            "{said}"
        );
        let mut rootless = graph(ours, "");
        rootless.roots[0].0 = "depth_mm".to_owned();
        let said = compiled(&rootless).unwrap_err();
        assert!(
            said.contains("roots: a slice has the root `color`"),
            "{said}"
        );
        assert!(
            said.contains("roots.depth_mm: slices have no depth"),
            "{said}"
        );
    }

    #[test]
    fn unknown_words_are_refused_with_their_place() {
        let text = "{ \"strahl_graph\": 1,\n \"slicing\": { \"blend\": \"front\" } }";
        let error = GraphUse::read("test", text, &mut |_| Err("none".to_owned())).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains("test:2:")
                && said.contains("slicing.blend")
                && said.contains("back-to-front"),
            "{said}"
        );
        let text = r#"{ "strahl_graph": 1, "nodes": { "a": { "graph": { "slicing": { "blend": "add" } } } } }"#;
        let error = GraphUse::read("test", text, &mut |_| Err("none".to_owned())).unwrap_err();
        assert!(
            error.to_string().contains("nodes.a.graph.slicing"),
            "{error}"
        );
    }
}
