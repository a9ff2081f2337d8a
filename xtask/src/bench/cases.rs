//! The cases of `bench/cases.json` and the modes that they are drawn in.

use crate::python::shared_data;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::path::Path;

/// As `time_frames` calls them.
const MODES: [&str; 4] = ["unshaded", "shaded", "mip", "first-hit"];

/// What a benchmark is asked for.
#[derive(clap::Args)]
pub struct CaseFilter {
    /// Only this case of bench/cases.json.
    #[arg(long)]
    case: Option<String>,
    /// Only this mode.
    #[arg(long, value_parser = MODES)]
    mode: Option<String>,
}

impl CaseFilter {
    /// The names of the cases whose scans are there; says which are not.
    ///
    /// # Errors
    /// There is no such case, or the file is not as it should be.
    pub fn cases(&self, root: &Path) -> Result<Vec<String>> {
        let text = std::fs::read_to_string(root.join("bench/cases.json"))?;
        let spec: Value = serde_json::from_str(&text).context("bench/cases.json")?;
        let cases = spec["cases"]
            .as_object()
            .context("cases.json has no cases")?;
        let only = self.case.as_deref();
        if let Some(only) = only {
            let names: Vec<&str> = cases.keys().map(String::as_str).collect();
            ensure!(
                cases.contains_key(only),
                "there is no case {only:?}; there are {}",
                names.join(", ")
            );
        }
        let data = shared_data(root);
        let is_asked = |name: &str| only.is_none_or(|only| only == name);
        let mut names = Vec::new();
        for (name, case) in cases.iter().filter(|(name, _)| is_asked(name)) {
            let file = case["file"].as_str().context("a case names no file")?;
            if data.join(file).is_file() {
                names.push(name.clone());
            } else {
                println!(
                    "skipped: {name} needs {}; STRAHL_SHARED may name another folder for `shared`",
                    data.join(file).display()
                );
            }
        }
        Ok(names)
    }

    /// The modes.
    pub fn modes(&self) -> Vec<&'static str> {
        let is_asked = |mode: &&str| self.mode.as_ref().is_none_or(|only| only == *mode);
        MODES.into_iter().filter(is_asked).collect()
    }
}

/// A mode as tables call it.
pub fn title(mode: &str) -> &str {
    match mode {
        "mip" => "MIP",
        "first-hit" => "first hit",
        other => other,
    }
}
