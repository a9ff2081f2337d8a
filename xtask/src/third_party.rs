//! `cargo xtask third-party`: the licenses of the crates that the programs contain.

use crate::command::{cargo, output};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use spdx::{Expression, LicenseReq, ParseMode};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Licenses whose terms are met by publishing their texts, which `--texts` collects.
const ALLOWED: [&str; 11] = [
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "bzip2-1.0.6",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

const PAGE: &str = "docs/third-party.md";

#[derive(Default, clap::Args)]
pub struct Arguments {
    /// Writes docs/third-party.md instead of checking it.
    #[arg(long)]
    write: bool,
    /// Writes the texts of all licenses to this file, which is to accompany a published program.
    #[arg(long, value_name = "FILE")]
    texts: Option<PathBuf>,
}

/// A crate that somebody else publishes.
struct Crate {
    name: String,
    version: String,
    license: String,
    repository: String,
    folder: PathBuf,
}

/// Checks licenses and the page, or writes it; whether all is well.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let crates = crates(root)?;
    let refused: Vec<&Crate> = crates.iter().filter(|c| !is_allowed(&c.license)).collect();
    for of in &refused {
        println!(
            "{} {} has the license {:?}, which is not among those of xtask/src/third_party.rs: \
             replace the crate, or add the license if publishing its text meets its terms",
            of.name, of.version, of.license
        );
    }
    if let Some(file) = &arguments.texts {
        fs::write(file, texts(&crates)?).with_context(|| file.display().to_string())?;
    }
    let page = page(&crates);
    let path = root.join(PAGE);
    if arguments.write {
        fs::write(&path, page)?;
        return Ok(refused.is_empty());
    }
    let is_current = fs::read_to_string(&path).is_ok_and(|now| now == page);
    if !is_current {
        println!("{PAGE} is not what Cargo.lock says: run `cargo xtask third-party --write`");
    }
    Ok(refused.is_empty() && is_current)
}

/// Whether some of the licenses offered are allowed.
fn is_allowed(license: &str) -> bool {
    let is_in_list = |asked: &LicenseReq| {
        let name = asked.license.id().map(|id| id.name);
        name.is_some_and(|name| ALLOWED.contains(&name))
    };
    // Older crates write `/` for `OR`.
    Expression::parse_mode(license, ParseMode::LAX)
        .is_ok_and(|expression| expression.evaluate(is_in_list))
}

/// All that the command line contains on any platform; what only tests, benchmarks or build scripts need is not among it.
fn crates(root: &Path) -> Result<Vec<Crate>> {
    let arguments = ["metadata", "--format-version=1", "--locked"];
    let metadata: Value = serde_json::from_str(&output(cargo(root).args(arguments))?)?;
    let of = |key: &str, id: &str| -> Result<&Value> {
        let list = if key == "packages" {
            &metadata["packages"]
        } else {
            &metadata["resolve"]["nodes"]
        };
        let mut all = list.as_array().into_iter().flatten();
        let found = all.find(|one| one["id"] == id);
        found.with_context(|| format!("cargo metadata has no {id} in {key}"))
    };
    let packages = metadata["packages"].as_array();
    let program = packages
        .into_iter()
        .flatten()
        .find(|one| one["name"] == "strahl-cli");
    let program = program.and_then(|one| one["id"].as_str());
    let mut open = vec![program.context("there is no crate strahl-cli")?.to_owned()];
    let mut seen = BTreeSet::new();
    let mut crates = BTreeMap::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id.clone()) {
            continue;
        }
        for dependency in of("nodes", &id)?["deps"].as_array().into_iter().flatten() {
            let mut kinds = dependency["dep_kinds"].as_array().into_iter().flatten();
            if kinds.any(|kind| kind["kind"].is_null()) {
                open.push(dependency["pkg"].as_str().context("no pkg")?.to_owned());
            }
        }
        let package = of("packages", &id)?;
        if !package["source"].is_null() {
            let found = found(package)?;
            crates.insert((found.name.clone(), found.version.clone()), found);
        }
    }
    ensure!(!crates.is_empty(), "cargo metadata names no dependencies");
    Ok(crates.into_values().collect())
}

fn found(package: &Value) -> Result<Crate> {
    let text = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
    let manifest = PathBuf::from(text("manifest_path"));
    Ok(Crate {
        name: text("name"),
        version: text("version"),
        license: text("license"),
        repository: text("repository"),
        folder: manifest.parent().context("no folder")?.to_owned(),
    })
}

fn page(crates: &[Crate]) -> String {
    let mut page = format!(
        "# Third-party crates\n\nThe command line contains {} crates of others, counted over all \
         platforms and configurations. `cargo xtask third-party --write` makes this page from \
         `Cargo.lock`. `cargo xtask ci` fails if it is out of date, or if a crate offers no license \
         whose terms are met by publishing its text.\n\nIf you publish a program that contains \
         Strahl, add the texts of these licenses: `cargo xtask third-party --texts FILE` collects \
         them.\n\n| crate | version | license |\n|---|---|---|\n",
        crates.len()
    );
    for of in crates {
        let name = match of.repository.as_str() {
            "" => of.name.clone(),
            repository => format!("[{}]({repository})", of.name),
        };
        page += &format!("| {name} | {} | {} |\n", of.version, of.license);
    }
    page
}

/// Every text once, with the crates that it belongs to.
fn texts(crates: &[Crate]) -> Result<String> {
    let mut by_text: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for of in crates {
        let title = format!("{} {} ({})", of.name, of.version, of.license);
        let files = license_files(&of.folder)?;
        if files.is_empty() {
            println!("{title} comes without the text of its license: add it to what you publish");
        }
        for file in files {
            let bytes = fs::read(&file).with_context(|| file.display().to_string())?;
            let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n");
            let titles = by_text.entry(text.trim().to_owned()).or_default();
            if !titles.contains(&title) {
                titles.push(title.clone());
            }
        }
    }
    let mut all = String::new();
    for (text, titles) in by_text {
        all += &format!("{}\n{}\n\n{text}\n\n", "=".repeat(78), titles.join("\n"));
    }
    Ok(all)
}

/// Files of licenses, copyright and notices in a crate's own folder.
fn license_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_uppercase();
        let begins = [
            "LICENSE",
            "LICENCE",
            "COPYING",
            "COPYRIGHT",
            "NOTICE",
            "UNLICENSE",
        ];
        if path.is_file() && begins.iter().any(|word| name.starts_with(word)) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::is_allowed;

    #[test]
    fn one_of_the_licenses_offered_has_to_be_allowed() {
        for license in [
            "MIT",
            "MIT/Apache-2.0",
            "MIT OR Apache-2.0 OR LGPL-2.1-or-later",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
        ] {
            assert!(is_allowed(license), "{license}");
        }
        for license in ["GPL-3.0-only", "MIT AND LGPL-2.1-or-later", "", "my own"] {
            assert!(!is_allowed(license), "{license}");
        }
    }
}
