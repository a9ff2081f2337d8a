//! Links between the documents of the checkout lead somewhere.

use super::finding::Finding;
use super::tree::Tree;

/// Checks every relative link and picture of every Markdown file.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts().filter(|(path, _)| path.ends_with(".md")) {
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let mut in_code = false;
        for (number, line) in text.lines().enumerate() {
            if line.trim_start().starts_with("```") {
                in_code = !in_code;
            }
            if in_code {
                continue;
            }
            for target in targets(line) {
                let file = target.split('#').next().unwrap_or_default();
                if file.is_empty() || file.contains("://") || file.starts_with("mailto:") {
                    continue;
                }
                // What lies beside the checkout is not ours to check.
                let Some(full) = resolve(folder, file) else {
                    continue;
                };
                if !tree.has(&full) {
                    findings.push(Finding::new(
                        path,
                        number + 1,
                        format!("the link to {target} leads nowhere"),
                        "Correct the path or drop the link",
                    ));
                }
            }
        }
    }
    findings
}

/// What stands in `](…)`.
fn targets(line: &str) -> impl Iterator<Item = &str> {
    line.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .map(|target| target.split_whitespace().next().unwrap_or_default())
}

/// `file` as seen from `folder`, from the root; `None` if that is outside the checkout.
fn resolve(folder: &str, file: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in file.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_links_that_lead_nowhere() {
        let tree = Tree::from_texts([
            (
                "docs/a.md",
                "[b](b.md) [root](../README.md#top) [gone](gone.md) [web](https://example.org/x)\n\
                 ```\n[code](also-gone.md)\n```\n![picture](pictures/none.png)\n",
            ),
            ("docs/b.md", ""),
            ("README.md", "[docs](docs) [beside](../shared/x)\n"),
        ]);
        let found: Vec<_> = check(&tree)
            .into_iter()
            .map(|f| (f.line, f.problem))
            .collect();
        assert_eq!(
            found,
            [
                (1, "the link to gone.md leads nowhere".to_string()),
                (5, "the link to pictures/none.png leads nowhere".to_string()),
            ]
        );
    }
}
