//! The problems of a scene, reported all at once.

use std::fmt;

/// One problem of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Where: the path of the key, such as `camera.view_angle_deg` or `clips[1].plane.normal`.
    pub path: String,
    /// The value found there.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
}

impl Problem {
    /// A problem at `path`.
    pub fn new(
        path: impl Into<String>,
        value: impl fmt::Display,
        allowed: impl Into<String>,
    ) -> Problem {
        Problem {
            path: path.into(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{} is {}; allowed: {}",
            self.path, self.value, self.allowed
        )
    }
}

/// All problems of a scene; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// `Ok` if there is no problem.
    pub(crate) fn none_of(problems: Vec<Problem>) -> Result<(), Problems> {
        if problems.is_empty() {
            Ok(())
        } else {
            Err(Problems(problems))
        }
    }

    /// A single problem.
    pub(crate) fn one(problem: Problem) -> Problems {
        Problems(vec![problem])
    }

    /// The problems, in the order of the scene's keys.
    pub fn iter(&self) -> std::slice::Iter<'_, Problem> {
        self.0.iter()
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, problem) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            problem.fmt(f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// Whoever has a thousand mistakes reads the first.
pub(crate) const MOST_PROBLEMS: usize = 1000;

/// Collects problems while numbers are checked.
#[derive(Default)]
pub(crate) struct Checker {
    pub problems: Vec<Problem>,
}

impl Checker {
    pub fn add(&mut self, path: impl Into<String>, value: impl fmt::Display, allowed: &str) {
        if self.problems.len() < MOST_PROBLEMS {
            self.problems.push(Problem::new(path, value, allowed));
        }
    }

    /// Whether `value` is `within`; a problem if not.
    pub fn number(&mut self, path: &str, value: f64, within: Within) -> bool {
        let good = value.is_finite() && within.contains(value);
        if !good {
            self.add(path, Number(value), &within.to_string());
        }
        good
    }

    /// Whether all three numbers are finite and at most a million kilometres.
    pub fn point(&mut self, path: &str, value: [f64; 3]) -> bool {
        let good = value.iter().all(|v| v.abs() <= 1e12);
        if !good {
            self.add(
                path,
                format!("{value:?}"),
                "three numbers from -1e12 to 1e12",
            );
        }
        good
    }
}

/// An interval of allowed numbers.
#[derive(Clone, Copy)]
pub(crate) enum Within {
    /// Both ends allowed.
    Closed(f64, f64),
    /// The lower end not allowed.
    Above(f64, f64),
}

impl Within {
    fn contains(self, value: f64) -> bool {
        match self {
            Within::Closed(lo, hi) => lo <= value && value <= hi,
            Within::Above(lo, hi) => lo < value && value <= hi,
        }
    }
}

impl fmt::Display for Within {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Within::Closed(lo, hi) => write!(f, "{} to {}", Number(*lo), Number(*hi)),
            Within::Above(lo, hi) => write!(f, "above {} to {}", Number(*lo), Number(*hi)),
        }
    }
}

/// A number as people write it: with an exponent where there would be many zeros.
pub(crate) struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || !size.is_finite() || (1e-4..1e9).contains(&size) {
            self.0.fmt(f)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}
