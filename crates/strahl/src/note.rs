//! What a person should know of a picture.

use std::fmt;

/// Something worth knowing of a picture that is no failure.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Note {
    /// What a reader assumed or left out, or what is odd about a graph.
    Data(String),
    /// [`Backend::Auto`](crate::Backend) has drawn on the CPU.
    NoGraphics {
        /// Why the GPU has not.
        why: String,
    },
    /// The program of a graph was evaluated on the CPU.
    GraphEvaluated,
    /// The program of a function that has no form for the CPU was evaluated there.
    FunctionEvaluated {
        /// Its name.
        function: String,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::Data(text) => f.write_str(text),
            Note::NoGraphics { why } => write!(f, "drawn on the CPU: {why}"),
            Note::GraphEvaluated => {
                f.write_str("the graph was evaluated on the CPU, which is exact but slow")
            }
            Note::FunctionEvaluated { function } => write!(
                f,
                "the function {function} has no form for the CPU: its program was evaluated there, which is exact but slow"
            ),
        }
    }
}
