//! `cargo xtask test`: every test of the workspace, and what was skipped.
//!
//! A test that cannot run here (the data beside the checkout is missing) prints a line that starts
//! with `skipped:` and returns. The harness hides the output of tests that pass; it is asked for,
//! searched for those lines, and dropped.

use crate::command::cargo;
use crate::driver;
use anyhow::{Context, Result};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

/// What the test programs said.
#[derive(Debug, Default, PartialEq)]
pub struct Report {
    /// Tests that passed.
    pub passed: usize,
    /// Tests that failed.
    pub failed: usize,
    /// Tests marked `#[ignore]`.
    pub ignored: usize,
    /// The reasons why tests returned early, each once.
    pub skipped: Vec<String>,
    /// How many tests returned early.
    pub skipped_count: usize,
    /// Whether cargo itself was content: everything compiled and every program ended well.
    pub completed: bool,
    hidden: bool,
}

impl Report {
    /// Takes one line of output in; whether it should be shown.
    fn line(&mut self, line: &str) -> bool {
        if let Some(reason) = line.trim_start().strip_prefix("skipped:") {
            self.skipped_count += 1;
            let reason = reason.trim().to_string();
            if !self.skipped.contains(&reason) {
                self.skipped.push(reason);
            }
        }
        if line == "successes:" {
            self.hidden = true;
        } else if line == "failures:" || line.starts_with("test result:") {
            self.hidden = false;
        }
        if let Some(counts) = line.strip_prefix("test result:") {
            for part in counts.split([';', '.']) {
                let mut words = part.split_whitespace();
                let Some(count) = words.next().and_then(|n| n.parse::<usize>().ok()) else {
                    continue;
                };
                match words.next() {
                    Some("passed") => self.passed += count,
                    Some("failed") => self.failed += count,
                    Some("ignored") => self.ignored += count,
                    _ => {}
                }
            }
        }
        !self.hidden
    }

    /// Prints the summary; whether all is well.
    pub fn print(&self) -> bool {
        println!();
        if self.skipped_count > 0 {
            println!("{} tests were skipped:", self.skipped_count);
            for reason in &self.skipped {
                println!("  {reason}");
            }
        }
        println!("{}", self.closing_line());
        self.all_well()
    }

    /// Whether everything ran and nothing failed.
    pub fn all_well(&self) -> bool {
        self.completed && self.failed == 0
    }

    /// `N passed, N failed, N skipped`; a skipped test counts as skipped, not as passed.
    pub fn closing_line(&self) -> String {
        format!(
            "{} passed, {} failed, {} skipped",
            self.passed.saturating_sub(self.skipped_count),
            self.failed,
            self.ignored + self.skipped_count
        )
    }
}

/// Runs the tests, those with `filter` in their name only if it is given.
pub fn run(root: &Path, filter: Option<&str>) -> Result<Report> {
    driver::prepare()?;
    let mut command = cargo(root);
    command.args(["test", "--workspace", "--no-fail-fast"]);
    command.args(filter);
    command.args(["--", "--show-output"]);
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start cargo")?;
    let output = child.stdout.take().context("no output of cargo test")?;
    let mut report = Report::default();
    for line in BufReader::new(output).split(b'\n') {
        let line = String::from_utf8_lossy(&line?).into_owned();
        if report.line(&line) {
            println!("{line}");
        }
    }
    report.completed = child.wait()?.success();
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_results_and_hides_the_output_of_what_passed() {
        let mut report = Report::default();
        let output = "running 3 tests\n\
            test a ... ok\n\
            test b ... FAILED\n\
            \n\
            successes:\n\
            \n\
            ---- a stdout ----\n\
            skipped: no volume data beside the checkout\n\
            noise\n\
            \n\
            failures:\n\
            \n\
            ---- b stdout ----\n\
            assertion failed\n\
            test result: FAILED. 1 passed; 1 failed; 1 ignored; 0 measured; 0 filtered out";
        let shown: Vec<&str> = output.lines().filter(|line| report.line(line)).collect();
        assert!(shown.contains(&"assertion failed"));
        assert!(!shown.contains(&"noise"));
        assert_eq!((report.passed, report.failed, report.ignored), (1, 1, 1));
        assert_eq!(report.skipped, ["no volume data beside the checkout"]);
        assert_eq!(report.closing_line(), "0 passed, 1 failed, 2 skipped");
        assert!(!report.all_well());
    }
}
