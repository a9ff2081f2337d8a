//! Programs in which the technique of a sample chooses functions: how a technique is stored, and what the
//! linker writes to read it.
//!
//! A technique is a row of numbers in the texture of the transfer tables. Which techniques there are is data
//! then: a program depends on the functions among which they choose, and on nothing else.

use crate::error::Error;
use crate::module::Module;
use crate::parameter::Scalar;
use crate::slot::{Signature, Slot};
use std::fmt::Write;

/// The slots of which a technique chooses the function.
pub const TECHNIQUE_SLOTS: [&str; 6] = [
    "classify",
    "gradient_input",
    "illuminate",
    "shade",
    "composite",
    "illustrate",
];

/// Texels of a technique in the texture of the transfer tables, which they begin at its start:
///
/// | texel | numbers |
/// |---|---|
/// | 0 | the entry at which its table begins, the number of entries, the table's domain |
/// | 1, 2 | the exponent of the opacity correction, then which function of each of the [`TECHNIQUE_SLOTS`] |
/// | 4 + 2·n, 5 + 2·n | the parameters of its function of the slot n, in their order |
pub const TECHNIQUE_TEXELS: u32 = 16;

/// Numbers that the parameters of a function may be together.
const MOST_NUMBERS: usize = 8;

/// The texel and the component in which the function of `slot` is named, and the texel of its parameters.
pub(crate) struct Place {
    texel: usize,
    component: char,
}

const COMPONENTS: [char; 4] = ['x', 'y', 'z', 'w'];

fn number(slot: &Slot) -> usize {
    TECHNIQUE_SLOTS
        .iter()
        .position(|name| *name == slot.name)
        .unwrap_or(0)
}

/// Where the function of `slot` is named.
pub(crate) fn place(slot: &Slot) -> Place {
    let number = 1 + number(slot);
    Place {
        texel: 1 + number / 4,
        component: COMPONENTS[number % 4],
    }
}

/// The numbers of a technique as texels.
#[derive(Clone, Debug, PartialEq)]
pub struct TechniqueTexels([[f32; 4]; TECHNIQUE_TEXELS as usize]);

impl TechniqueTexels {
    /// One whose table has `entries` entries from `first` on over `domain`.
    pub fn new(first: u32, entries: u32, domain: [f32; 2], steps_per_reference: f32) -> Self {
        let mut texels = [[0.0; 4]; TECHNIQUE_TEXELS as usize];
        texels[0] = [first as f32, entries as f32, domain[0], domain[1]];
        texels[1][0] = steps_per_reference;
        TechniqueTexels(texels)
    }

    /// Chooses function number `function` of `slot`, with these numbers as its parameters.
    pub fn choose(&mut self, slot: &Slot, function: usize, parameters: &[f64]) {
        let at = number(slot);
        self.0[1 + (1 + at) / 4][(1 + at) % 4] = function as f32;
        for (i, &parameter) in parameters.iter().take(MOST_NUMBERS).enumerate() {
            self.0[4 + 2 * at + i / 4][i % 4] = parameter as f32;
        }
    }

    /// The texels.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.0
    }
}

/// The function that calls the one of `labels` that the technique names; none of them is the null function.
pub(crate) fn one_of(
    function: &Signature,
    null: Option<&str>,
    labels: &[String],
    place: Place,
) -> String {
    let arguments: Vec<_> = function.arguments.iter().map(|(name, _)| *name).collect();
    let arguments = arguments.join(", ");
    let call = |label: &String| format!("return {label}({arguments});");
    let mut bodies: Vec<_> = labels.iter().map(call).collect();
    bodies.extend(null.map(str::to_owned));
    format!("{function} {{\n{}}}\n", switched(&bodies, &place))
}

/// The four functions of a composite rule over those of `labels`, whose `states` lie side by side.
pub(crate) fn rule_of(
    functions: &[Signature],
    labels: &[String],
    states: &[String],
    place: Place,
) -> String {
    let mut text = "struct State {\n".to_owned();
    for (label, state) in labels.iter().zip(states) {
        let _ = writeln!(text, "    {label}: {state},");
    }
    // Graphs carry it along their rays under this name.
    text.push_str("}\n\nalias CompositeState = State;\n\n");
    for function in functions {
        let called = |label: &String| format!("{label}_{}", function.name);
        let bodies: Vec<_> = match function.arguments {
            [] => {
                let starts: Vec<_> = labels.iter().map(|l| called(l) + "()").collect();
                let starts = starts.join(", ");
                let _ = writeln!(text, "{function} {{\n    return State({starts});\n}}\n");
                continue;
            }
            [_] => labels
                .iter()
                .map(|l| format!("return {}(state.{l});", called(l)))
                .collect(),
            _ => labels
                .iter()
                .map(|l| {
                    format!(
                        "var next = state; next.{l} = {}(state.{l}, sample); return next;",
                        called(l)
                    )
                })
                .collect(),
        };
        let _ = writeln!(text, "{function} {{\n{}}}\n", switched(&bodies, &place));
    }
    text
}

/// The body that the technique names; the last one where it names none.
fn switched(bodies: &[String], place: &Place) -> String {
    let Place { texel, component } = place;
    let mut text = format!("    switch u32(technique_numbers({texel}u).{component}) {{\n");
    for (i, body) in bodies.iter().enumerate() {
        let case = match i + 1 == bodies.len() {
            true => "default".to_owned(),
            false => format!("case {i}u"),
        };
        let _ = writeln!(text, "        {case}: {{ {body} }}");
    }
    text.push_str("    }\n");
    text
}

/// The function `load` that reads the parameters of `module`, of the type `of_type`, from the technique.
///
/// # Errors
/// There are too many.
pub(crate) fn parameters(module: &Module, load: &str, of_type: &str) -> Result<String, Error> {
    let count: usize = module.parameters().iter().map(|p| p.components).sum();
    if count > MOST_NUMBERS {
        return Err(Error::Parameters {
            module: module.name().to_owned(),
            count,
            most: MOST_NUMBERS,
        });
    }
    let first = 4 + 2 * number(module.slot());
    let mut next = 0;
    let mut component = || {
        let at = next;
        next += 1;
        let name = if at < 4 { "a" } else { "b" };
        format!("{name}.{}", COMPONENTS[at % 4])
    };
    let values: Vec<_> = module
        .parameters()
        .iter()
        .map(|parameter| {
            let numbers: Vec<_> = (0..parameter.components).map(|_| component()).collect();
            match (parameter.components, parameter.scalar) {
                (1, Scalar::F32) => numbers[0].clone(),
                (n, scalar) => {
                    let whole = format!("vec{n}f({})", numbers.join(", "));
                    let whole = if n == 1 { numbers[0].clone() } else { whole };
                    match scalar {
                        Scalar::F32 => whole,
                        _ => format!("{}({whole})", parameter.type_name()),
                    }
                }
            }
        })
        .collect();
    let mut text = format!("fn {load}() -> {of_type} {{\n");
    let _ = writeln!(text, "    let a = technique_numbers({first}u);");
    if count > 4 {
        let _ = writeln!(text, "    let b = technique_numbers({}u);", first + 1);
    }
    let _ = writeln!(text, "    return {of_type}({});\n}}\n", values.join(", "));
    Ok(text)
}
