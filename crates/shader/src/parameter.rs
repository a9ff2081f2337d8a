//! Parameters: the members of a module's struct `Params`, with what their comments say.
//!
//! ```wgsl
//! struct Params {
//!     /// Exponent of the highlight: the larger, the smaller the highlight.
//!     /// default 32, range 0.01 to 1000
//!     shininess: f32,
//!     /// Where the plane lies.
//!     /// default (0, 0, 0), unit mm
//!     origin: vec3f,
//!     /// The value that is white.
//!     /// default 1, not black
//!     white: f32,
//! }
//! ```

use std::borrow::Cow;

/// A parameter of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The member's name, also the key in a scene.
    pub name: Cow<'static, str>,
    /// The type of one component.
    pub scalar: Scalar,
    /// Components: 1 to 4.
    pub components: usize,
    /// Byte offset in the struct, as naga lays it out.
    pub offset: u32,
    /// What it means.
    pub meaning: Cow<'static, str>,
    /// The value if nothing is said; as many numbers as components.
    pub default: Cow<'static, [f64]>,
    /// The smallest and largest allowed value of each component.
    pub range: [f64; 2],
    /// The unit, if it has one.
    pub unit: Option<Cow<'static, str>>,
    /// What its value is beside that of another parameter.
    pub beside: Option<ParameterRelation>,
}

/// What the value of a parameter is beside that of another one.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterRelation {
    /// `not NAME`: another number than that of the parameter `NAME`.
    Not(Cow<'static, str>),
    /// `above NAME`: a larger number.
    Above(Cow<'static, str>),
}

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// 32-bit float.
    F32,
    /// 32-bit signed.
    I32,
    /// 32-bit unsigned.
    U32,
}

impl ParameterRelation {
    /// The name of the other parameter.
    pub fn other(&self) -> &str {
        match self {
            ParameterRelation::Not(other) | ParameterRelation::Above(other) => other,
        }
    }
}

impl Parameter {
    /// A parameter of which nothing is said yet: any number that its type has.
    pub(crate) fn new(name: String, scalar: Scalar, components: usize, offset: u32) -> Parameter {
        let range = match scalar {
            Scalar::F32 => [f64::from(f32::MIN), f64::from(f32::MAX)],
            Scalar::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
            Scalar::U32 => [0.0, f64::from(u32::MAX)],
        };
        Parameter {
            name: name.into(),
            scalar,
            components,
            offset,
            meaning: "".into(),
            default: Cow::Borrowed(&[]),
            range,
            unit: None,
            beside: None,
        }
    }

    /// The type as WGSL writes it.
    pub fn type_name(&self) -> String {
        let (long, short) = match self.scalar {
            Scalar::F32 => ("f32", "f"),
            Scalar::I32 => ("i32", "i"),
            Scalar::U32 => ("u32", "u"),
        };
        match self.components {
            1 => long.to_owned(),
            n => format!("vec{n}{short}"),
        }
    }

    /// What is wrong with `value`, if anything.
    ///
    /// # Errors
    /// A sentence that says what would be right.
    pub fn check(&self, value: &[f64]) -> Result<(), String> {
        if value.len() != self.components {
            let numbers = if self.components == 1 {
                "number"
            } else {
                "numbers"
            };
            return Err(format!(
                "has {} numbers; it takes {} {numbers} ({})",
                value.len(),
                self.components,
                self.type_name()
            ));
        }
        let [low, high] = self.range;
        for &number in value {
            if !number.is_finite() || number < low || number > high {
                return Err(format!("is {number}; it has to be {low} to {high}"));
            }
            if self.scalar != Scalar::F32 && number.fract() != 0.0 {
                return Err(format!("is {number}; it has to be a whole number"));
            }
        }
        Ok(())
    }

    /// What is wrong with `value` beside the values that `of` gives for other parameters, if anything.
    ///
    /// # Errors
    /// What would be right.
    pub fn check_beside(&self, value: f64, of: impl Fn(&str) -> f64) -> Result<(), String> {
        // As the program sees them.
        let value = value as f32;
        match &self.beside {
            Some(ParameterRelation::Not(other)) if value == of(other) as f32 => {
                Err(format!("{} other than {other}", self.name))
            }
            Some(ParameterRelation::Above(other)) if value <= of(other) as f32 => {
                Err(format!("{} above {other}", self.name))
            }
            _ => Ok(()),
        }
    }

    /// Writes a checked value to where it lies in `block`, the bytes of the struct.
    pub fn write(&self, value: &[f64], block: &mut [u8]) {
        for (i, &number) in value.iter().enumerate() {
            let bytes = match self.scalar {
                Scalar::F32 => (number as f32).to_le_bytes(),
                Scalar::I32 => (number as i32).to_le_bytes(),
                Scalar::U32 => (number as u32).to_le_bytes(),
            };
            let at = self.offset as usize + 4 * i;
            block[at..at + 4].copy_from_slice(&bytes);
        }
    }

    /// Fills meaning, default, range and unit from the lines of the member's doc comment.
    ///
    /// # Errors
    /// Which part of the comment cannot be read, and how it is written.
    pub(crate) fn describe<'l>(
        &mut self,
        lines: impl Iterator<Item = &'l str>,
    ) -> Result<(), String> {
        let mut meaning = Vec::new();
        let mut has_default = false;
        for line in lines {
            let line = line.trim_start_matches('/').trim();
            if !line.starts_with("default ") {
                meaning.push(line);
                continue;
            }
            has_default = true;
            for part in parts(line) {
                self.describe_part(part)?;
            }
        }
        self.meaning = meaning.join(" ").trim().to_owned().into();
        if !has_default {
            return Err("has no default; its comment needs a line such as `default 0.5, range 0 to 1, unit mm`".into());
        }
        self.check(&self.default)
            .map_err(|why| format!("has a default that {why}"))
    }

    fn describe_part(&mut self, part: &str) -> Result<(), String> {
        let unreadable = || {
            format!(
                "has `{part}` in its comment; it has to be like `default 0.5, range 0 to 1, unit mm`{}",
                if self.components > 1 {
                    ", several numbers in brackets"
                } else {
                    ""
                }
            )
        };
        let (word, rest) = part.split_once(' ').ok_or_else(unreadable)?;
        match word {
            "default" => {
                let list = rest.trim_start_matches('(').trim_end_matches(')');
                self.default = list
                    .split(',')
                    .map(|number| number.trim().parse().ok())
                    .collect::<Option<Vec<_>>>()
                    .ok_or_else(unreadable)?
                    .into();
            }
            "range" => {
                let (low, high) = rest.split_once(" to ").ok_or_else(unreadable)?;
                let low = low.trim().parse().map_err(|_| unreadable())?;
                let high = high.trim().parse().map_err(|_| unreadable())?;
                self.range = [low, high];
            }
            "unit" => self.unit = Some(rest.to_owned().into()),
            "not" => self.beside = Some(ParameterRelation::Not(rest.to_owned().into())),
            "above" => self.beside = Some(ParameterRelation::Above(rest.to_owned().into())),
            _ => return Err(unreadable()),
        }
        Ok(())
    }
}

/// Splits at commas outside brackets.
fn parts(line: &str) -> Vec<&str> {
    let (mut found, mut depth, mut start) = (Vec::new(), 0, 0);
    for (i, c) in line.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                found.push(line[start..i].trim());
                start = i + 1;
            }
            _ => {}
        }
    }
    found.push(line[start..].trim());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(components: usize) -> Parameter {
        Parameter::new("p".into(), Scalar::F32, components, 4)
    }

    #[test]
    fn comments_say_default_range_and_unit() {
        let mut p = parameter(1);
        p.describe(
            [
                "/// Distance",
                "/// of the plane.",
                "/// default -2.5, range -10 to 1e3, unit mm",
            ]
            .into_iter(),
        )
        .unwrap();
        assert_eq!(p.meaning, "Distance of the plane.");
        assert_eq!(*p.default, [-2.5]);
        assert_eq!(p.range, [-10.0, 1000.0]);
        assert_eq!(p.unit.as_deref(), Some("mm"));
        let mut v = parameter(3);
        v.describe(["default (0, 0, 1)"].into_iter()).unwrap();
        assert_eq!(*v.default, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn comments_that_say_too_little_are_refused() {
        let message = |line: &'static str| parameter(1).describe([line].into_iter()).unwrap_err();
        assert!(message("Only words.").contains("has no default"));
        assert!(message("default x").contains("`default x`"));
        assert!(message("default 1, range 0").contains("`range 0`"));
        assert!(message("default 2, range 0 to 1").contains("is 2"));
        assert!(message("default (1, 2)").contains("takes 1 number "));
    }

    #[test]
    fn values_are_checked_and_written_in_place() {
        let mut p = parameter(1);
        p.range = [0.0, 1.0];
        assert!(p.check(&[f64::NAN]).is_err());
        assert!(p.check(&[1.5]).unwrap_err().contains("0 to 1"));
        p.scalar = Scalar::U32;
        assert!(p.check(&[0.5]).unwrap_err().contains("whole number"));
        let mut block = [0; 8];
        p.write(&[1.0], &mut block);
        assert_eq!(block, [0, 0, 0, 0, 1, 0, 0, 0]);
    }
}
