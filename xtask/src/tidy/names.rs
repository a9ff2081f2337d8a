//! Names that say nothing, and names of places that exist on one machine only.

use super::finding::Finding;
use super::tree::Tree;

/// Drawers that collect what has no home. A homeless function goes to the lowest crate whose words
/// it speaks.
const DRAWERS: &[&str] = &[
    "common", "util", "utils", "misc", "helper", "helpers", "shared",
];

/// Beginnings of paths that exist on one machine only. Written in two parts, so that this file
/// passes its own rule.
const MACHINE_PATHS: &[&str] = &[
    concat!("/wor", "k/"),
    concat!("/roo", "t/"),
    concat!("/hom", "e/"),
    concat!("/User", "s/"),
    concat!("C:\\User", "s\\"),
];

/// Hosts of package registries: which one is used is the business of the machine.
const HOSTS: &[&str] = &[
    concat!("static.crat", "es.io"),
    concat!("index.crat", "es.io"),
    concat!("pypi.", "org"),
    concat!("pythonhos", "ted.org"),
    concat!("deb.deb", "ian.org"),
    concat!("registry.npm", "js.org"),
    concat!("proxy.gol", "ang.org"),
];

/// Checks names of files, names of modules, and paths and hosts inside the files.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for path in tree.paths() {
        let drawer = path
            .split('/')
            .map(|part| part.split('.').next().unwrap_or_default())
            .find(|stem| DRAWERS.contains(&stem.to_ascii_lowercase().as_str()));
        if let Some(drawer) = drawer {
            findings.push(Finding::new(
                path,
                1,
                format!("a file or folder called {drawer}"),
                "Name it after what it holds, or move the content to where its words belong",
            ));
        }
    }
    for (path, text) in tree.texts() {
        if path == "Cargo.lock" {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            if path.ends_with(".rs")
                && let Some(drawer) = module_name(line).filter(|name| DRAWERS.contains(name))
            {
                findings.push(Finding::new(
                    path,
                    number + 1,
                    format!("a module called {drawer}"),
                    "Name it after what it holds, or move the content to where its words belong",
                ));
            }
            for machine in MACHINE_PATHS {
                if starts_somewhere(line, machine) {
                    findings.push(Finding::new(
                        path,
                        number + 1,
                        format!("the path {machine}… exists on one machine only"),
                        "Write it relative to the checkout",
                    ));
                }
            }
            for host in HOSTS {
                if line.contains(host) {
                    findings.push(Finding::new(
                        path,
                        number + 1,
                        format!("the host {host} is named"),
                        "Name the package; where it comes from is the business of the machine",
                    ));
                }
            }
        }
    }
    findings
}

/// The name in a line that declares a module.
fn module_name(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace().peekable();
    if words.peek().is_some_and(|word| word.starts_with("pub")) {
        words.next();
    }
    if words.next() != Some("mod") {
        return None;
    }
    words.next().map(|name| name.trim_end_matches([';', '{']))
}

/// Whether `path` occurs as the beginning of a path, not as the middle of a longer one.
fn starts_somewhere(line: &str, path: &str) -> bool {
    line.match_indices(path).any(|(at, _)| {
        !line[..at].ends_with(|before: char| before.is_alphanumeric() || "._-}>)…".contains(before))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(files: &[(&str, &str)]) -> Vec<(String, usize)> {
        check(&Tree::from_texts(files.iter().copied()))
            .into_iter()
            .map(|finding| (finding.path, finding.line))
            .collect()
    }

    #[test]
    fn finds_drawers() {
        assert_eq!(
            places(&[
                ("crates/a/src/util.rs", ""),
                ("crates/common/src/lib.rs", ""),
                ("crates/a/src/lib.rs", "//! text\npub(crate) mod misc;\n"),
            ]),
            [
                ("crates/a/src/util.rs".to_string(), 1),
                ("crates/common/src/lib.rs".to_string(), 1),
                ("crates/a/src/lib.rs".to_string(), 2),
            ]
        );
    }

    #[test]
    fn finds_paths_of_one_machine_and_hosts() {
        let path = format!("read {}x/scan.nii", MACHINE_PATHS[0]);
        let host = format!("from {}", HOSTS[2]);
        assert_eq!(places(&[("a.md", &path)]), [("a.md".to_string(), 1)]);
        assert_eq!(places(&[("b.md", &host)]), [("b.md".to_string(), 1)]);
    }

    #[test]
    fn lets_ordinary_names_pass() {
        let inside = format!("see docs{}x and framework", MACHINE_PATHS[0]);
        assert_eq!(
            places(&[
                ("crates/a/src/grid.rs", "mod commonwealth;\nfn util() {}"),
                ("docs/a.md", &inside),
            ]),
            []
        );
    }
}
