//! `cargo xtask tidy`: the rules of the house that no compiler checks.
//!
//! Every rule is a function from the tracked files (or cargo's metadata) to [`Finding`](finding::Finding)s; each
//! finding names the place, what is wrong, and the remedy.

mod circles;
mod coverage;
mod dependencies;
mod finding;
mod flags;
mod glossary;
mod lanes;
mod links;
mod names;
mod pages;
mod tree;

use anyhow::Result;
use std::path::Path;
use tree::Tree;

/// Checks every rule and prints what is broken; whether nothing is.
pub fn run(root: &Path) -> Result<bool> {
    let tree = Tree::of(root)?;
    let mut findings = dependencies::check(&dependencies::packages(root)?, &tree);
    findings.extend(circles::check(&tree));
    findings.extend(names::check(&tree));
    findings.extend(flags::check(&tree));
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
