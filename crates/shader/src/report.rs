//! What is wrong with a text, and where.

use codespan_reporting::diagnostic::{Diagnostic, Label as Marked};
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

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
