//! Flags of the command line in messages of libraries: whoever calls them from code, a viewer or a page has none.

use super::finding::Finding;
use super::tree::Tree;

/// Crates whose business the command line is.
const PROGRAMS: &[&str] = &["crates/cli/", "xtask/"];

/// Checks the texts under each `src` of a library, without comments.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts() {
        let is_program = PROGRAMS.iter().any(|program| path.starts_with(program));
        if !path.ends_with(".rs") || !path.contains("/src/") || is_program {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            if let Some(flag) = flag(line) {
                findings.push(Finding::new(
                    path,
                    number + 1,
                    format!("a message names the flag {flag}"),
                    "Say what is wrong in an error with data; crates/cli/src/remedy.rs has the flags",
                ));
            }
        }
    }
    findings
}

/// The first flag in a line that is no comment and does not speak of another program.
fn flag(line: &str) -> Option<&str> {
    if line.trim_start().starts_with("//") || line.contains("gdcmconv") {
        return None;
    }
    let is_end = |c: char| !(c.is_ascii_lowercase() || c == '-');
    line.match_indices("--").find_map(|(at, _)| {
        let begins = line[..at].ends_with([' ', '"', '`', '(', '[']);
        let rest = &line[at + 2..];
        let name = &rest[..rest.find(is_end).unwrap_or(rest.len())];
        (begins && name.starts_with(|c: char| c.is_ascii_lowercase()))
            .then(|| &line[at..at + 2 + name.len()])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_flags_in_messages() {
        let text =
            "/// Without `--backend`.\nlet a = \"draw with --backend cpu\";\nlet b = x --1;\n";
        let files = [
            ("crates/gpu/src/error.rs", text),
            ("crates/cli/src/remedy.rs", text),
            ("crates/gpu/tests/it/main.rs", text),
        ];
        let found = check(&Tree::from_texts(files));
        assert_eq!(found.len(), 1);
        let place = (found[0].path.as_str(), found[0].line);
        assert_eq!(place, ("crates/gpu/src/error.rs", 2));
        assert!(found[0].to_string().contains("--backend"), "{}", found[0]);
    }
}
