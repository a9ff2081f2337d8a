//! What can be wrong with a module or with a choice of modules.

use codespan_reporting::diagnostic::{Diagnostic, Label as Marked};
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// An error of this crate.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Something is wrong with the text of a module; displayed with the place marked.
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
        "the composite {composite} works on the values of one volume, and {objects} objects are drawn; for several it has to add up what `look` says of them, as emission_absorption and back_to_front do"
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
    /// A rule of sampling that only the processor's own ray loop has.
    #[error(
        "the ray loop of shader programs takes one sample at every lattice point, and sampling.rule is {rule:?}; draw without a graph and by the processor's own loop, or with rule \"regular\""
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

/// A message about a text, with places marked in it.
#[derive(Clone, Debug)]
pub struct Report {
    /// What is wrong.
    pub message: String,
    /// The file, or the name of a built-in module.
    pub file: String,
    /// The whole text.
    pub source: Arc<str>,
    /// Byte ranges with what is to be said there; the first is the main one.
    pub labels: Vec<(Range<usize>, String)>,
    /// What would be right.
    pub notes: Vec<String>,
}

impl Report {
    /// Line and column (from 1) of the first label.
    pub fn location(&self) -> Option<(usize, usize)> {
        let (range, _) = self.labels.first()?;
        let before = self.source.get(..range.start)?;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Some((
            before.matches('\n').count() + 1,
            before[line_start..].chars().count() + 1,
        ))
    }
}

impl fmt::Display for Report {
    /// The message, the lines with carets under the places, the notes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Control characters could move the caret or speak to the terminal.
        let source: String = self
            .source
            .chars()
            .map(|c| match c {
                '\n' | '\t' => c,
                c if c.is_control() && c.is_ascii() => ' ',
                c => c,
            })
            .collect();
        let file = SimpleFile::new(&self.file, source);
        let labels = self.labels.iter().enumerate().map(|(i, (range, text))| {
            let label = if i == 0 {
                Marked::primary((), range.clone())
            } else {
                Marked::secondary((), range.clone())
            };
            label.with_message(text)
        });
        let diagnostic = Diagnostic::error()
            .with_message(&self.message)
            .with_labels(labels.collect())
            .with_notes(self.notes.clone());
        let config = term::Config {
            chars: term::Chars::ascii(),
            ..term::Config::default()
        };
        match term::emit_into_string(&config, &file, &diagnostic) {
            Ok(text) => f.write_str(text.strip_prefix("error: ").unwrap_or(&text).trim_end()),
            Err(_) => write!(f, "{}: {}", self.file, self.message),
        }
    }
}
