//! `cargo xtask bench-…`: tables and plots of docs/performance.md, one command each.
//!
//! What is timed lies in examples and scripts that print lines of JSON; here they are built, run in turns and
//! compared.

mod cases;
pub mod curves;
pub mod peers;
mod pictures;
mod plot;
pub mod scenes;
pub mod threads;

use crate::command::output;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// The lines of JSON that a program prints.
pub fn lines(command: &mut Command) -> Result<Vec<Value>> {
    let text = output(command)?;
    let lines = text.lines().map(|line| {
        serde_json::from_str(line).with_context(|| format!("this is no line of JSON: {line}"))
    });
    lines.collect()
}

/// The only line of JSON that a program prints.
fn only_line(command: &mut Command) -> Result<Value> {
    let mut lines = lines(command)?;
    ensure!(
        lines.len() == 1,
        "{:?} printed {} lines instead of one",
        command.get_program(),
        lines.len()
    );
    Ok(lines.remove(0))
}

/// The numbers of the list called `key`.
fn numbers(line: &Value, key: &str) -> Result<Vec<f64>> {
    let list = line[key].as_array();
    let numbers = list.and_then(|list| list.iter().map(Value::as_f64).collect());
    numbers.with_context(|| format!("{key} is not a list of numbers in {line}"))
}

/// The number called `key`.
fn number(line: &Value, key: &str) -> Result<f64> {
    let number = line[key].as_f64();
    number.with_context(|| format!("{key} is not a number in {line}"))
}

/// The middle one of `values`, or the mean of the two in the middle; NaN of none.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => (sorted[n / 2 - 1] + sorted[n / 2]) / 2.0,
    }
}

/// A table as Markdown.
struct Table {
    text: String,
}

impl Table {
    fn new(heads: &[&str]) -> Table {
        let mut table = Table {
            text: String::new(),
        };
        table.row(heads);
        table.text += "|";
        table.text += &"---|".repeat(heads.len());
        table.text += "\n";
        table
    }

    fn row<S: AsRef<str>>(&mut self, cells: &[S]) {
        self.text += "|";
        for cell in cells {
            let _ = write!(self.text, " {} |", cell.as_ref());
        }
        self.text += "\n";
    }
}

/// Milliseconds, as tables state them.
fn milliseconds(seconds: f64) -> String {
    let digits = if seconds < 0.0995 { 1 } else { 0 };
    format!("{:.digits$} ms", 1e3 * seconds)
}

/// With `write` keeps figures as the page docs/performance/`name`.md.
fn publish(root: &Path, name: &str, title: &str, body: &str, write: bool) -> Result<()> {
    if write {
        let page = format!("# {title}\n\n{}\n\n{body}", machine());
        let folder = root.join("docs/performance");
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(format!("{name}.md")), page)?;
    }
    Ok(())
}

/// The day and the machine, in a sentence.
fn machine() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = cpu.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let model = field("model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    let family = match (field("cpu family"), field("model\t")) {
        (Some(family), Some(number)) => format!(", family {family}, model {number}"),
        _ => String::new(),
    };
    let flags = field("flags").unwrap_or_default();
    let set = match flags.split(' ').find(|flag| *flag == "avx512f") {
        Some(_) => ", with AVX-512",
        None if flags.contains("avx2") => ", with AVX2",
        None => "",
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let memory = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let kib = memory.lines().find_map(|line| {
        let number = line.strip_prefix("MemTotal:")?.trim().strip_suffix(" kB")?;
        number.parse::<f64>().ok()
    });
    let memory = kib.map_or(String::new(), |kib| {
        format!(", {:.0} GiB of memory", kib / f64::from(1 << 20))
    });
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = now.map_or(0, |since| since.as_secs() / 86_400);
    format!(
        "Measured on {} on {cores} CPU cores ({model}{family}{set}){memory}.",
        date(days)
    )
}

/// The day that lies `days` after 1970-01-01.
fn date(mut days: u64) -> String {
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    format!("{year}-{month:02}-{:02}", days + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_dates() {
        let dates = [
            (0, "1970-01-01"),
            (59, "1970-03-01"),
            (11_016, "2000-02-29"),
            (19_722, "2023-12-31"),
            (19_723, "2024-01-01"),
            (20_785, "2026-11-28"),
        ];
        for (days, expected) in dates {
            assert_eq!(date(days), expected);
        }
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
    }
}
