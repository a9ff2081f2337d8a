//! Circles of files: files of one crate that need one another can only be read, changed and moved together.
//!
//! A file needs another if it names something that is defined there, in a `use` or in a path, outside of tests.
//! To declare a module is no need. A name that a file passes on (`pub use`) is needed from where it is defined, and
//! needed by the file that passes it on only if that uses it otherwise.

use super::finding::Finding;
use super::tree::Tree;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

/// How many names may stand for one another before the search gives up.
const MOST_ALIASES: usize = 16;

/// Checks the files under each `src` that begin at a `lib.rs` or `main.rs`.
pub fn check(tree: &Tree) -> Vec<Finding> {
    let is_root = |path: &&str| path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs");
    let roots = tree.paths().filter(is_root);
    let mut findings = Vec::new();
    for root in roots {
        match Sources::read(tree, root) {
            Ok(sources) => findings.extend(sources.circles()),
            Err(finding) => findings.push(finding),
        }
    }
    findings
}

/// The names in a path, from the first.
type Names = Vec<String>;

/// A path in a file: to something of this crate, if its names lead there.
struct Mention {
    module: Names,
    path: Names,
    line: usize,
    /// Whether it only passes a name on, as far as its own line says.
    is_passed_on: bool,
}

#[derive(Default)]
struct Source {
    path: String,
    mentions: Vec<Mention>,
    /// Names outside of `use`.
    words: HashSet<String>,
}

/// The files of one crate.
#[derive(Default)]
struct Sources {
    files: Vec<Source>,
    /// Module → its file.
    modules: HashMap<Names, usize>,
    /// Module → name → the path that it stands for there.
    aliases: HashMap<Names, HashMap<String, Names>>,
}

impl Sources {
    fn read(tree: &Tree, root: &str) -> Result<Sources, Finding> {
        let mut sources = Sources::default();
        let mut waiting = VecDeque::from([(root.to_owned(), Names::new())]);
        while let Some((path, module)) = waiting.pop_front() {
            let text = tree.text(&path).unwrap_or_default();
            let tokens: TokenStream = text.parse().map_err(|error| {
                let remedy = "Let rustc say what is wrong with it";
                Finding::new(&path, 1, format!("not Rust: {error}"), remedy)
            })?;
            let file = sources.files.len();
            sources.files.push(Source {
                path: path.clone(),
                ..Source::default()
            });
            let mut declared = Vec::new();
            sources.scan(tokens, &module, file, &mut declared);
            for child in declared {
                waiting.extend(file_of(tree, &path, &child[module.len()..]).map(|p| (p, child)));
            }
        }
        Ok(sources)
    }

    /// Notes what the tokens of a module say; `declared` gets the modules with files of their own.
    fn scan(
        &mut self,
        tokens: TokenStream,
        module: &Names,
        file: usize,
        declared: &mut Vec<Names>,
    ) {
        self.modules.entry(module.clone()).or_insert(file);
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            at = match &tokens[at] {
                TokenTree::Punct(punct) if punct.as_char() == '#' => after_attribute(&tokens, at),
                TokenTree::Group(group) => {
                    self.scan(group.stream(), module, file, declared);
                    at + 1
                }
                TokenTree::Ident(word) if *word == "use" => {
                    self.scan_use(&tokens, at, module, file)
                }
                TokenTree::Ident(word) if *word == "mod" => {
                    let name = tokens.get(at + 1).map(TokenTree::to_string);
                    let mut inner = module.clone();
                    inner.extend(name);
                    match tokens.get(at + 2) {
                        Some(TokenTree::Group(body)) => {
                            self.scan(body.stream(), &inner, file, declared);
                        }
                        _ => declared.push(inner),
                    }
                    at + 3
                }
                TokenTree::Ident(_) => self.scan_path(&tokens, at, module, file),
                _ => at + 1,
            };
        }
    }

    /// Notes a path in an expression or type; where it ends.
    fn scan_path(&mut self, tokens: &[TokenTree], at: usize, module: &Names, file: usize) -> usize {
        let (path, end) = path_from(tokens, at);
        let goes_on = at > 0
            && matches!(&tokens[at - 1], TokenTree::Punct(p) if matches!(p.as_char(), ':' | '.' | '\''))
            && !is_single_colon(tokens, at - 1);
        if !goes_on {
            self.files[file].words.insert(path[0].clone());
            if path.len() > 1 {
                self.files[file].mentions.push(Mention {
                    module: module.clone(),
                    path,
                    line: tokens[at].span().start().line,
                    is_passed_on: false,
                });
            }
        }
        end
    }

    /// Notes what a `use` brings in; where it ends.
    fn scan_use(&mut self, tokens: &[TokenTree], at: usize, module: &Names, file: usize) -> usize {
        let end = (at..tokens.len())
            .find(|i| is_punct(&tokens[*i], ';'))
            .unwrap_or(tokens.len());
        let before = |back: usize| at.checked_sub(back).map(|i| tokens[i].to_string());
        let is_passed_on =
            before(1).as_deref() == Some("pub") || before(2).as_deref() == Some("pub");
        let mut found = Vec::new();
        brought_in(&tokens[at + 1..end], &Names::new(), &mut found);
        for (name, path) in found {
            self.files[file].mentions.push(Mention {
                module: module.clone(),
                path: path.clone(),
                line: tokens[at].span().start().line,
                is_passed_on,
            });
            self.aliases
                .entry(module.clone())
                .or_default()
                .insert(name, path);
        }
        end + 1
    }

    /// The module in which the thing is defined that a path names; none for things of other crates.
    fn landing(&self, module: &Names, path: &[String], aliases: usize) -> Option<Names> {
        if aliases > MOST_ALIASES {
            return None;
        }
        let (mut at, mut rest) = (module.clone(), path);
        let mut is_start = true;
        while let Some((name, others)) = rest.split_first() {
            match name.as_str() {
                "crate" if is_start => at.clear(),
                "self" => {}
                "super" => {
                    at.pop()?;
                }
                _ => {
                    let inner = [at.as_slice(), std::slice::from_ref(name)].concat();
                    if self.modules.contains_key(&inner) {
                        at = inner;
                    } else if let Some(alias) = self.aliases.get(&at).and_then(|all| all.get(name))
                    {
                        let whole = [alias.as_slice(), others].concat();
                        return self.landing(&at, &whole, aliases + 1);
                    } else {
                        return (!is_start).then_some(at);
                    }
                }
            }
            (rest, is_start) = (others, false);
        }
        Some(at)
    }

    /// For each file those that it needs, with a name and a line for each.
    fn needs(&self) -> Vec<BTreeMap<usize, (String, usize)>> {
        let of = |(number, file): (usize, &Source)| {
            let mut needs = BTreeMap::new();
            for mention in &file.mentions {
                let name = mention.path.last().cloned().unwrap_or_default();
                if mention.is_passed_on && !file.words.contains(&name) {
                    continue;
                }
                let landing = self.landing(&mention.module, &mention.path, 0);
                let needed = landing.and_then(|module| self.modules.get(&module));
                if let Some(needed) = needed.filter(|needed| **needed != number) {
                    needs.entry(*needed).or_insert((name, mention.line));
                }
            }
            needs
        };
        self.files.iter().enumerate().map(of).collect()
    }

    /// A finding for each set of files in a circle: the shortest way around from the first of them.
    fn circles(&self) -> Vec<Finding> {
        let needs = self.needs();
        let mut findings = Vec::new();
        let mut told = HashSet::new();
        for start in 0..self.files.len() {
            let Some(circle) = shortest_circle(&needs, start) else {
                continue;
            };
            if circle.iter().any(|file| told.contains(file)) {
                continue;
            }
            let path = |file: &usize| &self.files[*file].path;
            let steps = circle.iter().zip(circle.iter().cycle().skip(1));
            let ways: Vec<String> = steps
                .map(|(from, to)| {
                    let name = &needs[*from][to].0;
                    format!("{} needs {name} of {}", path(from), path(to))
                })
                .collect();
            let second = circle.get(1).unwrap_or(&start);
            findings.push(Finding::new(
                &self.files[start].path,
                needs[start][second].1,
                format!("files in a circle: {}", ways.join(", ")),
                "Move what both need into a file of its own, or hand it in from above",
            ));
            told.extend(circle);
        }
        findings
    }
}

/// The files of the shortest circle through `start`, from there on.
fn shortest_circle(needs: &[BTreeMap<usize, (String, usize)>], start: usize) -> Option<Vec<usize>> {
    let mut from: HashMap<usize, usize> = HashMap::new();
    let mut waiting = VecDeque::from([start]);
    while let Some(file) = waiting.pop_front() {
        for &next in needs[file].keys() {
            if next == start {
                let mut circle = vec![file];
                while circle[circle.len() - 1] != start {
                    circle.push(from[&circle[circle.len() - 1]]);
                }
                circle.reverse();
                return Some(circle);
            }
            from.entry(next).or_insert_with(|| {
                waiting.push_back(next);
                file
            });
        }
    }
    None
}

/// The file of a module that the file at `path` declares, by its names from there.
fn file_of(tree: &Tree, path: &str, names: &[String]) -> Option<String> {
    let (folder, file) = path.rsplit_once('/')?;
    let folder = match file {
        "lib.rs" | "main.rs" | "mod.rs" => folder,
        _ => path.trim_end_matches(".rs"),
    };
    let module = format!("{folder}/{}", names.join("/"));
    [format!("{module}.rs"), format!("{module}/mod.rs")]
        .into_iter()
        .find(|path| tree.text(path).is_some())
}

fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == wanted)
}

/// Whether the token at `at` is a colon that is not half of `::`.
fn is_single_colon(tokens: &[TokenTree], at: usize) -> bool {
    is_punct(&tokens[at], ':') && (at == 0 || !is_punct(&tokens[at - 1], ':'))
}

/// The names from `at` on that `::` joins, and where they end.
fn path_from(tokens: &[TokenTree], at: usize) -> (Names, usize) {
    let mut path = vec![tokens[at].to_string()];
    let mut end = at + 1;
    while let [first, second, TokenTree::Ident(name), ..] = &tokens[end..]
        && is_punct(first, ':')
        && is_punct(second, ':')
    {
        path.push(name.to_string());
        end += 3;
    }
    (path, end)
}

/// What follows an attribute; after one that says `test`, what follows the item below it.
fn after_attribute(tokens: &[TokenTree], at: usize) -> usize {
    let is_inner = tokens.get(at + 1).is_some_and(|token| is_punct(token, '!'));
    let group = at + 1 + usize::from(is_inner);
    let Some(TokenTree::Group(attribute)) = tokens.get(group) else {
        return at + 1;
    };
    if is_inner || !is_for_tests(attribute) {
        return group + 1;
    }
    let is_end = |token: &TokenTree| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        _ => is_punct(token, ';'),
    };
    let item = &tokens[group + 1..];
    group + 2 + item.iter().position(is_end).unwrap_or(item.len())
}

/// Whether an attribute is `cfg(test)` or `cfg(all(test, …))`.
fn is_for_tests(attribute: &Group) -> bool {
    let text: String = attribute.stream().to_string().split_whitespace().collect();
    text.starts_with("cfg(test") || text.starts_with("cfg(all(test")
}

/// The names that a `use` brings in, and the path of each.
fn brought_in(tokens: &[TokenTree], before: &Names, found: &mut Vec<(String, Names)>) {
    for tree in tokens.split(|token| is_punct(token, ',')) {
        let mut path = before.clone();
        let mut name = None;
        let mut is_renamed = false;
        for token in tree {
            match token {
                TokenTree::Group(group) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    brought_in(&inner, &path, found);
                    name = None;
                    path.clear();
                }
                TokenTree::Ident(word) if *word == "as" => is_renamed = true,
                TokenTree::Ident(word) if is_renamed => name = Some(word.to_string()),
                TokenTree::Ident(word) if *word == "self" && !path.is_empty() => {
                    name = path.last().cloned();
                }
                TokenTree::Ident(word) => {
                    path.push(word.to_string());
                    name = Some(word.to_string());
                }
                token if is_punct(token, '*') => name = Some("*".to_owned()),
                _ => {}
            }
        }
        found.extend(name.map(|name| (name, path)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(files: &[(&str, &str)]) -> Vec<String> {
        let tree = Tree::from_texts(files.iter().copied());
        check(&tree)
            .into_iter()
            .map(|f| format!("{}:{}: {}", f.path, f.line, f.problem))
            .collect()
    }

    #[test]
    fn files_that_need_one_another_are_found() {
        let found = problems(&[
            (
                "a/src/lib.rs",
                "mod one;\nmod two;\nmod three;\npub use one::One;\n",
            ),
            (
                "a/src/one.rs",
                "use crate::{\n    two::{Two, self as pair},\n};\npub struct One(Two);\n",
            ),
            (
                "a/src/two.rs",
                "pub struct Two;\nfn f() -> u32 { super::three::number(\"crate::one\") }\n",
            ),
            (
                "a/src/three.rs",
                "// crate::two\npub fn number(one: super::One) {}\n",
            ),
        ]);
        assert_eq!(
            found,
            [
                "a/src/one.rs:1: files in a circle: a/src/one.rs needs Two of a/src/two.rs, \
                 a/src/two.rs needs number of a/src/three.rs, a/src/three.rs needs One of a/src/one.rs"
            ]
        );
    }

    #[test]
    fn parents_that_use_a_child_that_uses_them_are_found() {
        let child = "use super::Parent;\npub fn make() -> Parent { Parent }\n";
        let parent =
            "mod child;\npub struct Parent;\npub fn make() -> Parent {\n    child::make()\n}\n";
        let found = problems(&[("a/src/main.rs", parent), ("a/src/child.rs", child)]);
        assert_eq!(found.len(), 1, "{found:?}");
        // To declare it, and to pass on what it has, is no need.
        let parent = "mod child;\npub use child::make;\npub struct Parent;\n";
        assert_eq!(
            problems(&[("a/src/main.rs", parent), ("a/src/child.rs", child)]),
            [""; 0]
        );
    }

    #[test]
    fn tests_and_names_of_others_need_nothing() {
        let found = problems(&[
            (
                "a/src/lib.rs",
                "mod one;\nmod two;\nuse other::two::make;\n",
            ),
            ("a/src/one.rs", "use crate::two::Two;\npub struct One;\n"),
            (
                "a/src/two.rs",
                "pub struct Two;\nuse other::one::One;\nfn f(t: T) { t.one::<u8>(); Two::new(); }\n\
                 #[cfg(test)]\nuse crate::one::One;\n#[cfg(test)]\nmod tests {\n    use crate::one::One;\n}\n",
            ),
        ]);
        assert_eq!(found, [""; 0]);
    }
}
