//! docs/glossary.md: one table, `| term | meaning | unit or space |`, sorted, no term twice.

use super::finding::Finding;
use super::tree::Tree;

const PATH: &str = "docs/glossary.md";

/// Checks that the glossary is there, sorted and complete.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let Some(text) = tree.text(PATH) else {
        return vec![Finding::new(
            PATH,
            1,
            "the glossary is missing",
            "Write it: one term per idea, with unit and space",
        )];
    };
    let mut findings = Vec::new();
    let mut previous = String::new();
    let rows = text
        .lines()
        .enumerate()
        .filter(|(_, line)| line.starts_with('|'))
        // The heading and the rule below it.
        .skip(2);
    for (number, line) in rows {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if cells.len() != 3 || cells.iter().any(|cell| cell.is_empty()) {
            findings.push(Finding::new(
                PATH,
                number + 1,
                "a row without its three cells",
                "Write | term | meaning | unit or space |, with – where there is none",
            ));
            continue;
        }
        let term = sort_key(cells[0]);
        if term == previous {
            findings.push(Finding::new(
                PATH,
                number + 1,
                format!("the term {} stands twice", cells[0]),
                "Keep one row per term",
            ));
        } else if term < previous {
            findings.push(Finding::new(
                PATH,
                number + 1,
                format!("the term {} stands after {previous}", cells[0]),
                "Sort the rows by term, ignoring case and markup",
            ));
        }
        previous = term;
    }
    if previous.is_empty() {
        findings.push(Finding::new(
            PATH,
            1,
            "the glossary has no row",
            "Write | term | meaning | unit or space |",
        ));
    }
    findings
}

fn sort_key(term: &str) -> String {
    term.replace(['`', '*'], "").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(rows: &str) -> Vec<String> {
        let text = format!("# Glossary\n\n| term | meaning | unit |\n|---|---|---|\n{rows}");
        check(&Tree::from_texts([(PATH, text.as_str())]))
            .into_iter()
            .map(|finding| finding.problem)
            .collect()
    }

    #[test]
    fn accepts_sorted_rows() {
        assert_eq!(
            problems("| Grid | a | – |\n| `plan` | b | – |\n| Step | c | mm |\n"),
            [""; 0]
        );
    }

    #[test]
    fn finds_disorder_doubles_and_gaps() {
        assert_eq!(
            problems("| step | c | mm |\n| grid | a | – |\n| Grid | a | – |\n| ray | | mm |\n"),
            [
                "the term grid stands after step",
                "the term Grid stands twice",
                "a row without its three cells",
            ]
        );
    }
}
