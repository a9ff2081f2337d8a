//! What can be wrong with a graph: all of it at once.

use std::fmt;

/// One thing that is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The path of the key in the text, such as `nodes.tone.inputs.color`.
    pub place: String,
    /// What is wrong, and what would be right.
    pub why: String,
}

impl Problem {
    /// A problem at `place`.
    pub fn new(place: impl Into<String>, why: impl Into<String>) -> Problem {
        Problem {
            place: place.into(),
            why: why.into(),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.why)
    }
}

/// An error of this crate.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not JSON, or not that of a graph.
    #[error("{file}:{line}:{column}: {why}")]
    Syntax {
        /// The text's name.
        file: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What the parser met.
        why: String,
    },
    /// A newer Strahl has written it.
    #[error(
        "{file}: strahl_graph is {found}; this version of Strahl reads up to {known}: use a newer one"
    )]
    Version {
        /// The text's name.
        file: String,
        /// The version found.
        found: i64,
        /// The newest version known.
        known: i64,
    },
    /// What is wrong with the graph.
    #[error("{file}: {}", list(.problems))]
    Graph {
        /// The text's name.
        file: String,
        /// Never empty.
        problems: Vec<Problem>,
    },
    /// A rule of sampling that only the CPU's own ray loop has.
    #[error(
        "a graph takes one sample at every lattice point, and sampling.rule is {rule:?}; draw without a graph and by the CPU's own loop, or with rule \"regular\""
    )]
    Sampling {
        /// The rule.
        rule: &'static str,
    },
    /// The linker refuses.
    #[error(transparent)]
    Link(#[from] strahl_shader::Error),
}

fn list(problems: &[Problem]) -> String {
    let lines: Vec<_> = problems.iter().map(Problem::to_string).collect();
    lines.join("\n  ")
}
