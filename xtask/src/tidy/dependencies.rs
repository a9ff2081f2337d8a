//! Which crate may know which: the arrows of ARCHITECTURE.md, over `cargo metadata`.

use super::finding::Finding;
use super::tree::Tree;
use crate::command::{cargo, output};
use anyhow::{Context, Result};
use std::path::Path;

/// Each crate of ours and those of ours that it may name, in tests too. What is not listed must be
/// added here, which is the moment to think about it.
const MAY_KNOW: &[(&str, &[&str])] = &[
    ("strahl-volume", &[]),
    ("strahl-shader", &[]),
    ("strahl-scene", &["strahl-volume", "strahl-shader"]),
    (
        "strahl-cpu",
        &["strahl-volume", "strahl-shader", "strahl-scene"],
    ),
    (
        "strahl-program",
        &["strahl-volume", "strahl-shader", "strahl-scene"],
    ),
    (
        "strahl-evaluate",
        &[
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-program",
        ],
    ),
    (
        "strahl-graph",
        &[
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-program",
            // For tests only: they evaluate what is compiled.
            "strahl-evaluate",
        ],
    ),
    (
        "strahl-gpu",
        &[
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-program",
        ],
    ),
    ("strahl-sim", &["strahl-volume"]),
    (
        "strahl",
        &[
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-cpu",
            "strahl-gpu",
            "strahl-program",
            "strahl-evaluate",
            "strahl-graph",
            "strahl-sim",
        ],
    ),
    ("strahl-cli", &["strahl"]),
    (
        "strahl-viewer",
        &[
            "strahl",
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-cpu",
            "strahl-gpu",
        ],
    ),
    (
        "strahl-conformance",
        &[
            "strahl",
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-cpu",
            "strahl-gpu",
            "strahl-program",
            "strahl-evaluate",
            "strahl-graph",
            "strahl-sim",
        ],
    ),
    (
        "strahl-bench",
        &[
            "strahl",
            "strahl-volume",
            "strahl-shader",
            "strahl-scene",
            "strahl-cpu",
            "strahl-gpu",
            "strahl-program",
            "strahl-evaluate",
            "strahl-graph",
            "strahl-sim",
        ],
    ),
    ("xtask", &[]),
];

/// Foreign crates that only some of ours may name: beginning of the name, who may, why.
const ONLY_IN: &[(&str, &[&str], &str)] = &[
    (
        "wgpu",
        &["strahl-gpu", "strahl-viewer"],
        "GPU calls stay in one crate, so that a new major version is one edit",
    ),
    (
        "egui",
        &["strahl-viewer"],
        "the window toolkit stays out of what tests build",
    ),
    (
        "eframe",
        &["strahl-viewer"],
        "the window toolkit stays out of what tests build",
    ),
    (
        "winit",
        &["strahl-viewer"],
        "the window toolkit stays out of what tests build",
    ),
    (
        "anyhow",
        &["strahl-cli", "strahl-viewer", "strahl-bench", "xtask"],
        "a library has its own error type; anyhow is for programs",
    ),
];

/// A member of the workspace.
#[derive(Debug)]
pub struct Package {
    /// Its name in the manifest.
    pub name: String,
    /// Path of the manifest from the root of the checkout.
    pub manifest: String,
    /// Names of all dependencies, those for tests and build scripts included.
    pub dependencies: Vec<String>,
}

/// The members of the workspace.
pub fn packages(root: &Path) -> Result<Vec<Package>> {
    let text = output(cargo(root).args(["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: serde_json::Value =
        serde_json::from_str(&text).context("cargo metadata is not JSON")?;
    let root = root.canonicalize()?;
    let string = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_string();
    let list = |value: &serde_json::Value| value.as_array().cloned().unwrap_or_default();
    Ok(list(&metadata["packages"])
        .iter()
        .map(|package| {
            let manifest = string(&package["manifest_path"]);
            let manifest = Path::new(&manifest)
                .strip_prefix(&root)
                .map(|path| path.to_string_lossy().replace('\\', "/"))
                .unwrap_or(manifest);
            Package {
                name: string(&package["name"]),
                manifest,
                dependencies: list(&package["dependencies"])
                    .iter()
                    .map(|dependency| string(&dependency["name"]))
                    .collect(),
            }
        })
        .collect())
}

/// Every arrow that must not be.
pub fn check(packages: &[Package], tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    let ours = |name: &str| {
        MAY_KNOW.iter().any(|(ours, _)| *ours == name)
            || packages.iter().any(|package| package.name == name)
    };
    for package in packages {
        let Some((_, allowed)) = MAY_KNOW.iter().find(|(name, _)| *name == package.name) else {
            findings.push(Finding::new(
                &package.manifest,
                1,
                format!("the crate {} has no place in the order of crates", package.name),
                "Add it to MAY_KNOW in xtask/src/tidy/dependencies.rs and to the map in ARCHITECTURE.md",
            ));
            continue;
        };
        for dependency in &package.dependencies {
            let line = line_of(tree, &package.manifest, dependency);
            // Itself it names to turn features on for its tests.
            let is_itself = *dependency == package.name;
            if ours(dependency) && !is_itself && !allowed.contains(&dependency.as_str()) {
                findings.push(Finding::new(
                    &package.manifest,
                    line,
                    format!("{} must not know {dependency}", package.name),
                    format!(
                        "It may know: {}. Move what you need into the lowest crate whose words it \
                         speaks, or pass it in from above",
                        if allowed.is_empty() {
                            "no crate of ours".to_string()
                        } else {
                            allowed.join(", ")
                        }
                    ),
                ));
            }
            for (beginning, who, why) in ONLY_IN {
                let named = dependency == beginning
                    || dependency.starts_with(&format!("{beginning}-"))
                    || dependency.starts_with(&format!("{beginning}_"))
                    || dependency.ends_with(&format!("-{beginning}"));
                if named && !who.contains(&package.name.as_str()) {
                    findings.push(Finding::new(
                        &package.manifest,
                        line,
                        format!("{} must not name {dependency}", package.name),
                        format!("Only {} may: {why}", who.join(", ")),
                    ));
                }
            }
        }
    }
    findings
}

/// The line of the manifest that names the dependency.
fn line_of(tree: &Tree, manifest: &str, dependency: &str) -> usize {
    tree.text(manifest)
        .and_then(|text| {
            text.lines().position(|line| {
                line.strip_prefix(dependency)
                    .is_some_and(|rest| rest.starts_with(['.', ' ', '=']))
            })
        })
        .map_or(1, |index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, dependencies: &[&str]) -> Package {
        Package {
            name: name.to_string(),
            manifest: format!("crates/{name}/Cargo.toml"),
            dependencies: dependencies.iter().map(|d| d.to_string()).collect(),
        }
    }

    fn problems(packages: &[Package], tree: &Tree) -> Vec<String> {
        check(packages, tree)
            .into_iter()
            .map(|finding| finding.problem)
            .collect()
    }

    #[test]
    fn allows_the_arrows_of_the_design() {
        let packages = [
            package("strahl-volume", &["glam", "flate2"]),
            package("strahl-scene", &["strahl-volume", "serde"]),
            package("strahl-cpu", &["strahl-scene", "strahl-volume", "rayon"]),
            package("strahl", &["strahl-cpu"]),
            package("strahl-cli", &["strahl", "anyhow"]),
            package("xtask", &["anyhow", "clap"]),
        ];
        assert_eq!(problems(&packages, &Tree::default()), [""; 0]);
    }

    #[test]
    fn refuses_every_other_arrow() {
        let tree = Tree::from_texts([(
            "crates/strahl-cpu/Cargo.toml",
            "[dependencies]\nstrahl-gpu.workspace = true\n",
        )]);
        let packages = [
            package("strahl-volume", &["strahl-scene"]),
            package("strahl-cpu", &["strahl-gpu"]),
            package("strahl-scene", &["wgpu"]),
            package("strahl", &["anyhow"]),
            package("strahl-gpu", &["egui-wgpu"]),
            package("strahl-extra", &[]),
        ];
        assert_eq!(
            problems(&packages, &tree),
            [
                "strahl-volume must not know strahl-scene",
                "strahl-cpu must not know strahl-gpu",
                "strahl-scene must not name wgpu",
                "strahl must not name anyhow",
                "strahl-gpu must not name egui-wgpu",
                "the crate strahl-extra has no place in the order of crates",
            ]
        );
        assert_eq!(check(&packages, &tree)[1].line, 2);
    }
}
