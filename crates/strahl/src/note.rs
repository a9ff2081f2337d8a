//! What a user should know about a picture.

use std::fmt;
use strahl_scene::WithoutEffect;

/// Something worth knowing about a picture that is not an error.
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
    /// A software renderer has drawn, although the GPU was asked for.
    SoftwareAdapter {
        /// The adapter, with its driver.
        adapter: String,
    },
    /// A key of the scene that changes nothing of the picture.
    WithoutEffect(WithoutEffect),
    /// The scene chooses segments, and there are no labels: the volume is drawn as a whole.
    NoLabels,
    /// The clips leave nothing of a volume.
    ClippedAway {
        /// Which one, such as `the object "liver"`.
        object: String,
    },
    /// The picture file tells only the names of some files of its scene, not where they lie.
    UntoldPlaces {
        /// The names.
        files: Vec<String>,
    },
    /// The picture shows nothing but its background.
    Empty {
        /// Possible reasons; empty if none is known.
        why: Vec<String>,
    },
    /// Colors that are no light: not numbers, as after a loop of a graph that was stopped, infinite, or below zero.
    NoLight {
        /// The number of pixels.
        pixels: usize,
    },
    /// The program of a graph was evaluated on the CPU.
    GraphEvaluated,
    /// The program of a function that has no implementation for the CPU was evaluated there.
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
            Note::SoftwareAdapter { adapter } => {
                write!(f, "{adapter} is a software renderer: it draws on the CPU")
            }
            Note::WithoutEffect(key) => key.fmt(f),
            Note::NoLabels => f.write_str("segments has no effect without labels (key `labels`)"),
            Note::ClippedAway { object } => {
                write!(
                    f,
                    "the clips leave nothing of {object}; check the places, `keep` and `objects` of `clips`"
                )
            }
            Note::UntoldPlaces { files } => {
                let (name, them) = match files.len() {
                    1 => ("name", "it"),
                    _ => ("names", "them"),
                };
                write!(
                    f,
                    "the picture keeps only the {name} of {}; to draw it again, put {them} beside the picture",
                    files.join(", ")
                )
            }
            Note::Empty { why } => {
                f.write_str("the picture shows nothing but its background")?;
                match why.is_empty() {
                    true => Ok(()),
                    false => write!(f, ": {}", why.join("; ")),
                }
            }
            Note::NoLight { pixels } => write!(
                f,
                "{pixels} pixels are no light: a function of the scene gives NaN, infinite or negative colors, or a loop of a graph was stopped before its end"
            ),
            Note::GraphEvaluated => {
                f.write_str("the graph was evaluated on the CPU, which is exact but slow")
            }
            Note::FunctionEvaluated { function } => write!(
                f,
                "the function {function} has no CPU implementation: its program was evaluated on the CPU, which is exact but slow"
            ),
        }
    }
}
