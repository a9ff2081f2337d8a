//! Functions and closures over lanes must be compiled for the instruction set of their caller.
//!
//! One that the compiler does not happen to inline has none of the wide instructions: each operation becomes a call, and
//! pictures that need it take up to seven times as long, with the same bytes, so that no test notices.

use super::finding::Finding;
use super::tree::Tree;

/// Where such functions are.
const FOLDER: &str = "crates/cpu/src/";

/// Types of a packet of rays.
const LANES: [&str; 5] = ["F32s<", "I32s<", "F64s<", "Mask<", "Vec3s<"];

/// What the body begins with of a function that is compiled for the set on its own.
const COMPILED_APART: &str = "vectorized::<S, _>(";

/// Checks every function with lanes in its signature, every closure with lanes among its parameters.
pub fn check(tree: &Tree) -> Vec<Finding> {
    tree.texts()
        .filter(|(path, _)| path.starts_with(FOLDER) && path.ends_with(".rs"))
        .flat_map(|(path, text)| check_file(path, text))
        .collect()
}

fn check_file(path: &str, text: &str) -> Vec<Finding> {
    let lines: Vec<&str> = text.lines().collect();
    let tests = lines.iter().position(|line| *line == "#[cfg(test)]");
    let lines = &lines[..tests.unwrap_or(lines.len())];
    let mut findings = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        if is_closure_over_lanes(line) && !says_how(&lines[..number]) {
            findings.push(Finding::new(
                path,
                number + 1,
                "a closure has lanes and does not say how it is inlined".to_owned(),
                "Write it as `inlined(#[inline(always)] |…| …)`, the attribute in a line of its own"
                    .to_owned(),
            ));
        }
        let Some(name) = function_name(line) else {
            continue;
        };
        let last = lines[number..]
            .iter()
            .position(|line| line.ends_with('{') || line.ends_with(';'));
        let Some(last) = last.map(|last| number + last) else {
            continue;
        };
        let signature = lines[number..=last].concat();
        let has_lanes = LANES.iter().any(|lanes| signature.contains(lanes));
        let is_declared_only = signature.ends_with(';');
        let is_apart = lines
            .get(last + 1)
            .is_some_and(|line| line.trim() == COMPILED_APART);
        if !has_lanes || is_declared_only || is_apart || says_how(&lines[..number]) {
            continue;
        }
        findings.push(Finding::new(
            path,
            number + 1,
            format!("the function {name} has lanes and does not say how it is inlined"),
            format!("Write #[inline(always)] before it, or let its body be `{COMPILED_APART}…)`"),
        ));
    }
    findings
}

/// Whether a closure begins in a line and has lanes among its parameters.
fn is_closure_over_lanes(line: &str) -> bool {
    let parameters = line.split('|').nth(1).unwrap_or_default();
    LANES
        .iter()
        .any(|lanes| parameters.contains(&format!(": {lanes}")))
}

/// The name in a line that begins a function.
fn function_name(line: &str) -> Option<&str> {
    let mut words = line.trim_start().split_inclusive(' ');
    let mut word = words.next()?;
    while word.starts_with("pub") || word == "unsafe " || word == "const " {
        word = words.next()?;
    }
    if word != "fn " {
        return None;
    }
    let name = words.next()?;
    name.split(['(', '<']).next()
}

/// Whether the attributes above a function, the last of `lines`, have one about inlining.
fn says_how(lines: &[&str]) -> bool {
    lines
        .iter()
        .rev()
        .map(|line| line.trim())
        .take_while(|line| line.starts_with(['#', '/']))
        .any(|line| line.starts_with("#[inline"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_over_lanes_say_how_they_are_inlined() {
        let text = "\
fn number<S: Level>(a: F32s<S>) -> F32s<S> {
    a
}

/// Documented.
#[inline(always)]
#[must_use]
pub(super) fn always<S: Level>(a: F32s<S>) -> F32s<S> {
    a
}

fn of_arrays(a: [f32; 8]) {
    a;
}

trait Values {
    fn at(&self, position: Vec3s<S>) -> F32s<S>;
}

impl Values for X {
    fn at(
        &self,
        position: Vec3s<S>,
    ) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || 1,
        )
    }
}

pub unsafe fn words(
    at: I32s<S>,
) {
    let anywhere = |at: I32s<S>| at;
    let here = inlined(
        #[inline(always)]
        |at: I32s<S>, more: u32| anywhere(at),
    );
}

#[cfg(test)]
mod tests {
    fn shade(a: F32s<S>) {
    }
}
";
        let places: Vec<usize> = check_file("a.rs", text).iter().map(|f| f.line).collect();
        assert_eq!(places, [1, 32, 35]);
    }
}
