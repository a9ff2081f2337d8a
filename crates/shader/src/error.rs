//! What can be wrong with a module or with a choice of modules.

#[cfg(feature = "link")]
use crate::report::Report;

/// An error of this crate.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Something is wrong with the text of a module; displayed with the place marked.
    #[cfg(feature = "link")]
    #[error("{0}")]
    Text(Box<Report>),
    /// A function is needed, and its slot is empty.
    #[error(
        "{needed_by} needs a function in the slot {slot}, and there is none; choose one of: {known}"
    )]
    Empty {
        /// The empty slot.
        slot: &'static str,
        /// Who calls it.
        needed_by: String,
        /// The functions of the library for this slot.
        known: String,
    },
    /// Functions call one another in a circle, which no GPU can run.
    #[error("the functions call one another in a circle: {}; choose another function for one of them", .path.join(" → "))]
    Circle {
        /// The functions, the first one again at the end.
        path: Vec<String>,
    },
    /// The linked text is no valid program. Its parts are checked, so this is a mistake of Strahl's
    /// (or of a skeleton), worth a report.
    #[error(
        "the program linked for {skeleton} is not valid, which is a mistake of Strahl's: {message}"
    )]
    Program {
        /// The skeleton.
        skeleton: String,
        /// What naga says.
        message: String,
    },
    /// A composite that works on the values of one volume, and several objects.
    #[error(
        "the composite {composite} works on the values of one volume, and {objects} objects are drawn; for several objects it has to add up the results of `look`, as emission_absorption and back_to_front do"
    )]
    OneObject {
        /// The composite.
        composite: String,
        /// Objects of the ray loop.
        objects: usize,
    },
    /// No ray loop has such a number of objects or volumes.
    #[error("a ray loop over {number} {what} cannot be made; it has 1 to {most}")]
    Objects {
        /// Objects or volumes.
        what: &'static str,
        /// How many were asked for.
        number: usize,
        /// How many there may be.
        most: usize,
    },
    /// A function with more parameters than a technique holds.
    #[error(
        "{module} takes {count} numbers as parameters; where techniques choose it, it may take {most}"
    )]
    Parameters {
        /// The function.
        module: String,
        /// How many numbers it takes.
        count: usize,
        /// How many a technique holds.
        most: usize,
    },
    /// More masks than a program has textures for.
    #[error(
        "the GPU and graphs can use {most} masks, and the scene has {number}; draw on the CPU without a graph, or combine masks (one mask can have several labels)"
    )]
    Masks {
        /// How many are asked for.
        number: usize,
        /// How many there can be.
        most: usize,
    },
    /// A rule of sampling that only the CPU's own ray loop has.
    #[error(
        "the ray loop of shader programs takes one sample at every lattice point, and sampling.rule is {rule:?}; draw without a graph and by the CPU's own loop, or with rule \"regular\""
    )]
    Sampling {
        /// The rule.
        rule: &'static str,
    },
    /// More functions than a slot can hold.
    #[error("the slot {slot} holds one function, not {}: {}", .modules.len(), .modules.join(", "))]
    Crowded {
        /// The slot.
        slot: &'static str,
        /// The functions chosen for it.
        modules: Vec<String>,
    },
    /// No function of this name is in the library.
    #[error("there is no function {slot}/{name} in the library; {known}")]
    Unknown {
        /// The slot.
        slot: String,
        /// The name asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A value for a parameter that does not exist or cannot be what it is.
    #[error("{module}: parameter {parameter} {problem}")]
    Parameter {
        /// The module.
        module: String,
        /// The parameter's name.
        parameter: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
}
