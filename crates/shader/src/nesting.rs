//! How deep a text nests, told before it is parsed. Parsers and checkers of WGSL call themselves once for everything
//! that stands in something else, so that a file of a few kilobytes would take all of their stack.

use crate::token::{Kind, Token, tokens};
use std::ops::Range;

/// Brackets in one another, with the operators that stand before them in each.
pub const DEEPEST: usize = 400;

/// What is deeper is parsed on a thread with a stack for it; what is not, on the caller's.
const SHALLOW: usize = 48;

/// Far beyond what [`DEEPEST`] takes in a build without optimization. Memory is taken as it is used.
const STACK_BYTES: usize = 256 << 20;

/// How deep `tokens` nest, and where it is deepest. Counted are open brackets, and in each of them the operators since
/// the last `,` or `;` (`a + b + c` nests to the left) and the branches of a chain of `else`.
pub fn deepest(source: &str, tokens: &[Token]) -> (usize, Range<usize>) {
    // Of each open bracket what is counted in it.
    let mut open = vec![0];
    let (mut depth, mut most, mut place) = (0, 0, 0..0);
    for (i, token) in tokens.iter().enumerate() {
        let Kind::Sign(sign) = token.kind else {
            continue;
        };
        let last = open.len() - 1;
        match sign {
            b'(' | b'[' | b'{' => {
                open.push(0);
                depth += 1;
            }
            b')' | b']' | b'}' if last > 0 => {
                depth -= 1 + open.pop().unwrap_or(0);
                let goes_on = tokens.get(i + 1).map(|next| next.text(source)) == Some("else");
                match (sign, goes_on) {
                    (b'}', true) => {
                        open[last - 1] += 1;
                        depth += 1;
                    }
                    (b'}', false) => depth -= std::mem::take(&mut open[last - 1]),
                    _ => {}
                }
            }
            b')' | b']' | b'}' => {}
            b',' | b';' => depth -= std::mem::take(&mut open[last]),
            _ => {
                open[last] += 1;
                depth += 1;
            }
        }
        if depth > most {
            (most, place) = (depth, token.span.clone());
        }
    }
    (most, place)
}

/// Whether a text of WGSL nests so little that it can be parsed on any stack.
pub fn is_shallow(source: &str) -> bool {
    deepest(source, &tokens(source)).0 <= SHALLOW
}

/// Has `work` done on a text that nests so deep.
pub fn with_stack<R: Send>(depth: usize, work: impl FnOnce() -> R + Send) -> R {
    if depth <= SHALLOW {
        return work();
    }
    // Where no thread can be started, the own stack has to do.
    let work = std::sync::Mutex::new(Some(work));
    let taken = || {
        let work = work.lock().ok().and_then(|mut work| work.take());
        work.map(|work| work())
    };
    let done = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        let thread = thread.spawn_scoped(scope, taken).ok()?;
        match thread.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    });
    match done.or_else(taken) {
        Some(done) => done,
        None => unreachable!("either thread takes the work, once"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_operators_and_chains_of_else_nest() {
        for (text, depth) in [
            ("a;", 0),
            ("f(g(x), h(y));", 2),
            ("!!!a; !b;", 3),
            ("a + b + c; d + e;", 2),
            ("(a + (b + (c)));", 5),
            ("{ a; } { b; }", 1),
            ("if a { b; } else if c { d; } else { e; } f;", 3),
            ("))((", 2),
        ] {
            assert_eq!(deepest(text, &tokens(text)).0, depth, "{text}");
        }
    }
}
