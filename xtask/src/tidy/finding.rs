//! What is wrong at one place.

/// One broken rule at one place.
#[derive(Debug, PartialEq)]
pub struct Finding {
    /// Path from the root of the checkout.
    pub path: String,
    /// From 1.
    pub line: usize,
    /// What is wrong, in one sentence without a full stop.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl Finding {
    pub fn new(
        path: impl Into<String>,
        line: usize,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Finding {
        Finding {
            path: path.into(),
            line,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Finding {
            path,
            line,
            problem,
            remedy,
        } = self;
        write!(f, "{path}:{line}: {problem}. {remedy}")
    }
}
