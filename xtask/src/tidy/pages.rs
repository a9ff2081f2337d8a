//! Pages that must be there: the documents, the scene schema, and a runnable example on the first
//! page of every library.

use super::finding::Finding;
use super::tree::Tree;

const REQUIRED: &[(&str, &str)] = &[
    (
        "README.md",
        "Write it: the picture first, then the commands",
    ),
    (
        "ARCHITECTURE.md",
        "Write the map of the crates and the invariants",
    ),
    (
        "DESIGN.md",
        "Write why things are as they are, as questions with answers",
    ),
    (
        "CONTRIBUTING.md",
        "Write how to test and how to add a reader",
    ),
    ("CHANGELOG.md", "Write what changed, in the user's words"),
    ("LICENSE-MIT", "Restore it"),
    ("LICENSE-APACHE", "Restore it"),
    ("docs/plan.md", "Write what a Plan may contain"),
    (
        "docs/scene.schema.json",
        "Run `cargo run -- scene schema > docs/scene.schema.json`",
    ),
];

/// Checks that every page is there.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings: Vec<Finding> = REQUIRED
        .iter()
        .filter(|(path, _)| !tree.has(path))
        .map(|(path, remedy)| Finding::new(*path, 1, "the file is missing", *remedy))
        .collect();
    for (path, text) in tree.texts() {
        let library = path.ends_with("/src/lib.rs") && !path.starts_with("fuzz/");
        if library && !has_runnable_example(text) {
            findings.push(Finding::new(
                path,
                1,
                "the first page of the library has no runnable example",
                "Open lib.rs with //! purpose, words, and a ``` block that cargo test runs",
            ));
        }
    }
    findings
}

/// Whether the `//!` lines hold a code block that the documentation tests run.
fn has_runnable_example(text: &str) -> bool {
    let mut in_code = false;
    text.lines()
        .filter_map(|line| line.trim_start().strip_prefix("//!"))
        .filter_map(|line| line.trim().strip_prefix("```"))
        .any(|language| {
            in_code = !in_code;
            in_code
                && language
                    .split(',')
                    .all(|word| matches!(word.trim(), "" | "rust"))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_examples_that_run_from_those_that_do_not() {
        assert!(has_runnable_example(
            "//! Text\n//!\n//! ```\n//! f();\n//! ```\n"
        ));
        assert!(has_runnable_example(
            "//! ```text\n//! a\n//! ```\n//! ```rust\n//! f();\n//! ```\n"
        ));
        assert!(!has_runnable_example("//! ```text\n//! a\n//! ```\n"));
        assert!(!has_runnable_example("//! ```no_run\n//! f();\n//! ```\n"));
        assert!(!has_runnable_example("//! Text\n/// ```\nfn f() {}\n"));
    }

    #[test]
    fn names_the_missing_page() {
        let found = check(&Tree::from_texts([("README.md", "")]));
        assert!(found.iter().all(|finding| finding.path != "README.md"));
        assert!(
            found
                .iter()
                .any(|finding| finding.path == "docs/scene.schema.json")
        );
    }
}
