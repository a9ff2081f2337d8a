//! Numbers, truths and vectors of them that are known when a graph is compiled.

use crate::model::Constant;
use crate::types::{Scalar, Type};
use std::fmt;

/// A number or truth. Floats are kept as bits, so that they can be compared and looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Number {
    /// The bits of a float.
    F32(u32),
    /// Signed.
    I32(i32),
    /// Unsigned.
    U32(u32),
    /// Truth.
    Bool(bool),
}

/// A value: one number, or 2 to 4 of the same type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Literal(pub Vec<Number>);

impl Number {
    /// A float, if every processor computes with it in the same way: finite, and not so small that some take
    /// it for 0.
    pub fn float(number: f32) -> Option<Number> {
        (number == 0.0 || number.is_normal()).then(|| Number::F32(number.to_bits()))
    }

    /// The type.
    pub fn scalar(self) -> Scalar {
        match self {
            Number::F32(_) => Scalar::F32,
            Number::I32(_) => Scalar::I32,
            Number::U32(_) => Scalar::U32,
            Number::Bool(_) => Scalar::Bool,
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Number::F32(bits) => write!(f, "{:?}", f32::from_bits(*bits)),
            Number::I32(number) => write!(f, "i32({number})"),
            Number::U32(number) => write!(f, "{number}u"),
            Number::Bool(truth) => write!(f, "{truth}"),
        }
    }
}

/// As WGSL writes it.
impl fmt::Display for Literal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, others @ ..] = &self.0[..] else {
            return Ok(());
        };
        if others.is_empty() {
            return first.fmt(f);
        }
        write!(f, "{}({first}", self.ty())?;
        if others.iter().any(|other| other != first) {
            for other in others {
                write!(f, ", {other}")?;
            }
        }
        f.write_str(")")
    }
}

impl Literal {
    /// A truth.
    pub fn truth(truth: bool) -> Literal {
        Literal(vec![Number::Bool(truth)])
    }

    /// The truth that it is, if it is one.
    pub fn as_truth(&self) -> Option<bool> {
        match self.0[..] {
            [Number::Bool(truth)] => Some(truth),
            _ => None,
        }
    }

    /// The only float that it is, if it is one.
    pub fn as_float(&self) -> Option<f32> {
        match self.0[..] {
            [Number::F32(bits)] => Some(f32::from_bits(bits)),
            _ => None,
        }
    }

    /// The type.
    pub fn ty(&self) -> Type {
        let scalar = self.0.first().map_or(Scalar::F32, |n| n.scalar());
        Type::Vector(scalar, self.0.len())
    }

    /// Components of a vector, such as `xy`, which its type has.
    pub fn components(&self, member: &str) -> Literal {
        let place = |c| "xyzw".find(c).or_else(|| "rgba".find(c)).unwrap_or(0);
        let numbers = member.chars().filter_map(|c| self.0.get(place(c)).copied());
        Literal(numbers.collect())
    }

    /// `constant` as a value of this type.
    pub fn of(constant: &Constant, ty: &Type) -> Result<Literal, String> {
        let wrong = || format!("{constant} is no {ty}");
        match (constant, ty) {
            (Constant::Bool(truth), Type::Vector(Scalar::Bool, 1)) => Ok(Literal::truth(*truth)),
            (Constant::Numbers(numbers), Type::Vector(scalar, n)) if *scalar != Scalar::Bool => {
                if numbers.len() != *n && numbers.len() != 1 {
                    return Err(wrong());
                }
                let mut parts = Vec::new();
                for number in numbers {
                    let is_whole = |low: f64, high: f64| {
                        number.fract() == 0.0 && (low..=high).contains(number)
                    };
                    parts.push(match scalar {
                        Scalar::F32 => {
                            let single = *number as f32;
                            if !single.is_finite() {
                                return Err(format!("{number} is no number that an f32 can hold"));
                            }
                            Number::F32(single.to_bits())
                        }
                        Scalar::I32 if is_whole(f64::from(i32::MIN), f64::from(i32::MAX)) => {
                            Number::I32(*number as i32)
                        }
                        Scalar::U32 if is_whole(0.0, f64::from(u32::MAX)) => {
                            Number::U32(*number as u32)
                        }
                        _ => return Err(wrong()),
                    });
                }
                if let [one] = parts[..] {
                    parts = vec![one; *n];
                }
                Ok(Literal(parts))
            }
            _ => Err(wrong()),
        }
    }
}
