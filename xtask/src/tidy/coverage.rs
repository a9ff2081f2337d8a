//! docs/coverage.md: every row of the source documents, its state, and what shows it.
//!
//! A row is `| S0-1 | title | state | shown by | note |`. "Shown by" is a list, separated by
//! commas, of
//!
//! - `test:PATH::NAME`: the function NAME, marked `#[test]`, in the file PATH;
//! - `doc:PATH`: the documentation test on the first page of PATH;
//! - `file:PATH`: a scene, picture or page.

use super::finding::Finding;
use super::tree::Tree;

const PATH: &str = "docs/coverage.md";

/// The source documents and how many rows each has.
const DOCUMENTS: [(&str, usize); 5] = [("S0", 108), ("S1", 68), ("S2", 57), ("S3", 98), ("S4", 61)];

/// Checks that every row is there once and in order, and that what it names exists.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let Some(text) = tree.text(PATH) else {
        return vec![Finding::new(
            PATH,
            1,
            "the coverage table is missing",
            "Restore it: one line for every row of the source documents",
        )];
    };
    let mut findings = Vec::new();
    let mut expected = DOCUMENTS
        .iter()
        .flat_map(|(document, rows)| (1..=*rows).map(move |row| format!("{document}-{row}")))
        .peekable();
    let mut last_line = 0;
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        last_line = number;
        if !is_row(line) {
            continue;
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let id = cells[0];
        match expected.peek() {
            Some(next) if next == id => {
                expected.next();
            }
            _ => {
                let next = expected.peek().map_or("the end", String::as_str);
                findings.push(Finding::new(
                    PATH,
                    number,
                    format!("the row {id} stands where {next} is due"),
                    "Keep every row once, in the order of the source documents",
                ));
                // Go on behind the row that stands here, so that one slip is told once.
                if expected.clone().any(|row| row == id) {
                    while expected.next().is_some_and(|row| row != id) {}
                }
            }
        }
        findings.extend(check_row(tree, number, id, &cells));
    }
    let missing: Vec<String> = expected.collect();
    if let Some(first) = missing.first() {
        findings.push(Finding::new(
            PATH,
            last_line,
            format!("{} rows are missing, from {first} on", missing.len()),
            "Add a line for each, with its state",
        ));
    }
    findings
}

fn is_row(line: &str) -> bool {
    DOCUMENTS
        .iter()
        .any(|(document, _)| line.starts_with(&format!("| {document}-")))
}

fn check_row(tree: &Tree, number: usize, id: &str, cells: &[&str]) -> Vec<Finding> {
    let finding = |problem: String, remedy: &str| Finding::new(PATH, number, problem, remedy);
    let [_, title, state, shown_by, note] = cells else {
        return vec![finding(
            format!("{id} has {} cells", cells.len()),
            "Write | id | title | state | shown by | note |",
        )];
    };
    let mut findings = Vec::new();
    if title.is_empty() {
        findings.push(finding(format!("{id} has no title"), "Write a short one"));
    }
    let shown: Vec<&str> = shown_by
        .split(',')
        .map(|reference| reference.trim().trim_matches('`'))
        .filter(|reference| !reference.is_empty() && *reference != "–")
        .collect();
    let note_missing = note.is_empty() || *note == "–";
    match *state {
        "works" | "partly" if shown.is_empty() => findings.push(finding(
            format!("{id} is said to be there, but nothing shows it"),
            "Name a test, or write `not yet`",
        )),
        "works" => {}
        "partly" | "not yet" | "left out" if note_missing => findings.push(finding(
            format!("{id} is `{state}` without a note"),
            "Write what is missing, when it comes, or why it is left out",
        )),
        "partly" | "not yet" | "left out" => {}
        _ => findings.push(finding(
            format!("{id} has the state `{state}`"),
            "Use works, partly, not yet or left out",
        )),
    }
    for reference in shown {
        if let Err(problem) = resolve(tree, reference) {
            findings.push(finding(
                format!("{id} names {reference}, {problem}"),
                "Use test:PATH::NAME, doc:PATH or file:PATH of what exists",
            ));
        }
    }
    findings
}

/// What is wrong with a reference, if anything is.
fn resolve(tree: &Tree, reference: &str) -> Result<(), &'static str> {
    if let Some(test) = reference.strip_prefix("test:") {
        let (path, name) = test.split_once("::").ok_or("which names no function")?;
        let text = tree.text(path).ok_or("a file that does not exist")?;
        return match is_test(text, name) {
            true => Ok(()),
            false => Err("a test that does not exist"),
        };
    }
    if let Some(path) = reference.strip_prefix("doc:") {
        let text = tree.text(path).ok_or("a file that does not exist")?;
        return match text.contains("/// ```") || text.contains("//! ```") {
            true => Ok(()),
            false => Err("a file without an example"),
        };
    }
    match reference.strip_prefix("file:") {
        Some(path) if tree.has(path) => Ok(()),
        Some(_) => Err("a file that does not exist"),
        None => Err("which is none of the three kinds"),
    }
}

/// Whether `text` has a function `name` with `#[test]` among the attributes above it.
fn is_test(text: &str, name: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let head = format!("fn {name}(");
    lines.iter().enumerate().any(|(index, line)| {
        line.starts_with(&head)
            && lines[..index]
                .iter()
                .rev()
                .take_while(|above| above.starts_with('#') || above.starts_with("//"))
                .any(|above| *above == "#[test]")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TESTS: &str = "#[test]\n/// Why.\nfn shown() {}\n\nfn helper() {}\n";

    fn table(change: impl Fn(&str) -> Option<String>) -> String {
        DOCUMENTS
            .iter()
            .flat_map(|(document, rows)| (1..=*rows).map(move |row| format!("{document}-{row}")))
            .filter_map(|id| change(&id))
            .map(|row| row + "\n")
            .collect()
    }

    fn row(id: &str) -> String {
        format!("| {id} | title | not yet | – | later |")
    }

    fn problems(text: &str) -> Vec<String> {
        let tree = Tree::from_texts([(PATH, text), ("a/tests/it.rs", TESTS)]);
        check(&tree).into_iter().map(|f| f.problem).collect()
    }

    #[test]
    fn accepts_a_complete_table() {
        let text = table(|id| {
            Some(match id {
                "S0-1" => "| S0-1 | t | works | `test:a/tests/it.rs::shown` | – |".to_string(),
                "S4-61" => "| S4-61 | t | left out | – | because |".to_string(),
                _ => row(id),
            })
        });
        assert_eq!(problems(&text), [""; 0]);
    }

    #[test]
    fn tells_a_missing_row_once() {
        let text = table(|id| (id != "S1-5").then(|| row(id)));
        assert_eq!(problems(&text), ["the row S1-6 stands where S1-5 is due"]);
        let text = table(|id| (id != "S4-61").then(|| row(id)));
        assert_eq!(problems(&text), ["1 rows are missing, from S4-61 on"]);
    }

    #[test]
    fn wants_proof_that_exists() {
        let with = |state: &str, shown: &str| {
            problems(&table(|id| {
                Some(match id {
                    "S2-7" => format!("| S2-7 | t | {state} | {shown} | note |"),
                    _ => row(id),
                })
            }))
        };
        assert_eq!(
            with("works", "–"),
            ["S2-7 is said to be there, but nothing shows it"]
        );
        assert_eq!(
            with("works", "`test:a/tests/it.rs::helper`"),
            ["S2-7 names test:a/tests/it.rs::helper, a test that does not exist"]
        );
        assert_eq!(
            with("partly", "`file:gone.png`"),
            ["S2-7 names file:gone.png, a file that does not exist"]
        );
        assert_eq!(with("done", "–"), ["S2-7 has the state `done`"]);
        assert_eq!(with("partly", "`test:a/tests/it.rs::shown`"), [""; 0]);
    }
}
