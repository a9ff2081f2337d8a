//! `cargo xtask tidy`: the rules of the house that no compiler checks.
//!
//! Every rule is a function from the tracked files (or cargo's metadata) to [`Finding`]s; each
//! finding names the place, what is wrong, and the remedy.

mod coverage;
mod dependencies;
mod glossary;
mod lanes;
mod links;
mod names;
mod pages;
mod tree;

use anyhow::Result;
use std::path::Path;
use tree::Tree;

/// One broken rule at one place.
#[derive(Debug, PartialEq)]
pub struct Finding {
    /// Path from the root of the checkout.
    pub path: String,
    /// From 1.
    pub line: usize,
    /// What is wrong, in one sentence without a full stop.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl Finding {
    fn new(
        path: impl Into<String>,
        line: usize,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Finding {
        Finding {
            path: path.into(),
            line,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Finding {
            path,
            line,
            problem,
            remedy,
        } = self;
        write!(f, "{path}:{line}: {problem}. {remedy}")
    }
}

/// Checks every rule and prints what is broken; whether nothing is.
pub fn run(root: &Path) -> Result<bool> {
    let tree = Tree::of(root)?;
    let mut findings = dependencies::check(&dependencies::packages(root)?, &tree);
    findings.extend(names::check(&tree));
    findings.extend(coverage::check(&tree));
    findings.extend(glossary::check(&tree));
    findings.extend(lanes::check(&tree));
    findings.extend(pages::check(&tree));
    findings.extend(links::check(&tree));
    for finding in &findings {
        println!("{finding}");
    }
    if findings.is_empty() {
        println!("tidy: {} files, nothing to say", tree.len());
    } else {
        println!("tidy: {} broken rules", findings.len());
    }
    Ok(findings.is_empty())
}
