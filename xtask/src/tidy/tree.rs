//! The tracked files of the checkout, text only.

use crate::command::output;
use anyhow::Result;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Path from the root → text; `None` for what is not UTF-8.
#[derive(Default)]
pub struct Tree(BTreeMap<String, Option<String>>);

impl Tree {
    /// Files that git tracks, and new ones that it does not ignore.
    pub fn of(root: &Path) -> Result<Tree> {
        let list = output(Command::new("git").current_dir(root).args([
            "ls-files",
            "-z",
            "--cached",
            "--others",
            "--exclude-standard",
        ]))?;
        let mut files = BTreeMap::new();
        for path in list.split('\0').filter(|path| !path.is_empty()) {
            // A file that was just deleted is still listed.
            if let Ok(bytes) = std::fs::read(root.join(path)) {
                files.insert(path.to_string(), String::from_utf8(bytes).ok());
            }
        }
        Ok(Tree(files))
    }

    /// A tree of these texts.
    #[cfg(test)]
    pub fn from_texts<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Tree {
        Tree(
            files
                .into_iter()
                .map(|(path, text)| (path.to_string(), Some(text.to_string())))
                .collect(),
        )
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the file or folder is there.
    pub fn has(&self, path: &str) -> bool {
        let path = path.trim_end_matches('/');
        self.0.contains_key(path) || {
            let folder = format!("{path}/");
            self.0
                .range(folder.clone()..)
                .next()
                .is_some_and(|(name, _)| name.starts_with(&folder))
        }
    }

    /// The text of a file.
    pub fn text(&self, path: &str) -> Option<&str> {
        self.0.get(path)?.as_deref()
    }

    /// Every path, sorted.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Every text file: path, text.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0
            .iter()
            .filter_map(|(path, text)| Some((path.as_str(), text.as_deref()?)))
    }
}
