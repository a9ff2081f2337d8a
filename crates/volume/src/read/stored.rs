//! Number types that files have and volumes have not: 64-bit whole numbers and half floats. They are read as the
//! bits they are and then turned into the narrowest type that holds them.

use super::Bytes;
use crate::error::{Error, ErrorKind};
use crate::{SampleType, Samples, memory};

/// How a number is stored in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    /// As it stays in memory.
    Kept(SampleType),
    /// A signed whole number of 64 bits.
    I64,
    /// An unsigned whole number of 64 bits.
    U64,
    /// A floating-point number of 16 bits (IEEE 754 binary16).
    F16,
}

impl Stored {
    /// The type of the same size whose bits are read in its place.
    pub(crate) fn bits(self) -> SampleType {
        match self {
            Stored::Kept(sample_type) => sample_type,
            Stored::I64 | Stored::U64 => SampleType::F64,
            Stored::F16 => SampleType::U16,
        }
    }

    /// The type that numbers in text are read as.
    pub(crate) fn of_text(self) -> SampleType {
        match self {
            Stored::F16 => SampleType::F32,
            other => other.bits(),
        }
    }

    /// Whether it is a floating-point number.
    #[cfg(feature = "tiff")]
    pub(crate) fn is_float(self) -> bool {
        match self {
            Stored::Kept(sample_type) => !sample_type.is_integer(),
            Stored::I64 | Stored::U64 => false,
            Stored::F16 => true,
        }
    }

    /// The numbers whose bits were read from `bytes`. `notes` hears what they were turned into.
    ///
    /// # Errors
    /// A whole number that no type holds exactly; no memory, or more than is allowed.
    pub(crate) fn kept_of_bits(
        self,
        samples: Samples,
        bytes: &dyn Bytes,
        notes: &mut Vec<String>,
    ) -> Result<Samples, Error> {
        let count = samples.len() as u64;
        match self {
            Stored::Kept(_) => {}
            Stored::F16 => bytes.keep(count.saturating_mul(4))?,
            Stored::I64 | Stored::U64 => bytes.has_room(count.saturating_mul(8))?,
        }
        match (self, samples) {
            (Stored::F16, Samples::U16(halves)) => {
                notes.push("half floats were read as f32".into());
                Ok(Samples::F32(converted(&halves, |bits| from_half(*bits))?))
            }
            (Stored::I64, Samples::F64(bits)) => {
                narrowed(&bits, |bits| (bits.to_bits() as i64).into(), notes)
            }
            (Stored::U64, Samples::F64(bits)) => {
                narrowed(&bits, |bits| bits.to_bits().into(), notes)
            }
            (_, samples) => Ok(samples),
        }
    }

    /// The same for numbers that stood in text, and were read as [`Stored::of_text`].
    ///
    /// # Errors
    /// As [`Stored::kept_of_bits`]; a number that is not whole.
    pub(crate) fn kept_of_text(
        self,
        samples: Samples,
        notes: &mut Vec<String>,
    ) -> Result<Samples, Error> {
        match (self, samples) {
            (Stored::I64 | Stored::U64, Samples::F64(numbers)) => {
                if let Some(number) = numbers.iter().find(|n| n.fract() != 0.0) {
                    return Err(not_exact(number));
                }
                narrowed(&numbers, |number| *number as i128, notes)
            }
            (_, samples) => Ok(samples),
        }
    }
}

fn converted<T, U>(from: &[T], convert: impl Fn(&T) -> U) -> Result<Vec<U>, Error> {
    let mut into = memory::reserved(from.len())?;
    into.extend(from.iter().map(convert));
    Ok(into)
}

/// Whole numbers in the narrowest of i32, u32 and f64 that holds all of them.
fn narrowed(
    stored: &[f64],
    number: impl Fn(&f64) -> i128,
    notes: &mut Vec<String>,
) -> Result<Samples, Error> {
    const EXACT: i128 = 1 << 53;
    let least = stored.iter().map(&number).min().unwrap_or(0);
    let most = stored.iter().map(&number).max().unwrap_or(0);
    let holds = |low: i128, high: i128| low <= least && most <= high;
    let samples = if holds(i32::MIN.into(), i32::MAX.into()) {
        Samples::I32(converted(stored, |n| number(n) as i32)?)
    } else if holds(0, u32::MAX.into()) {
        Samples::U32(converted(stored, |n| number(n) as u32)?)
    } else if holds(-EXACT, EXACT) {
        Samples::F64(converted(stored, |n| number(n) as f64)?)
    } else {
        return Err(not_exact(if least < -EXACT { least } else { most }));
    };
    notes.push(format!(
        "64-bit whole numbers were read as {}, which holds all of them",
        samples.sample_type()
    ));
    Ok(samples)
}

fn not_exact(number: impl std::fmt::Display) -> Error {
    ErrorKind::Field {
        field: "a 64-bit whole number".into(),
        value: number.to_string(),
        allowed: "whole numbers from −2^53 to 2^53, which f64 holds exactly; convert the file to float64 if their last digits do not matter".into(),
    }
    .into()
}

/// The number whose bits these are: sign, 5 bits of exponent, 10 of fraction.
fn from_half(bits: u16) -> f32 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    match exponent {
        0 => sign * fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => sign * f32::INFINITY,
        31 => f32::NAN,
        _ => sign * (1024.0 + fraction) * 2f32.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_the_standard() {
        // From the tables of IEEE 754-2008 and numpy.float16.
        for (bits, number) in [
            (0x0000, 0.0),
            (0x0001, 5.960_464_5e-8),
            (0x03FF, 6.097_555e-5),
            (0x0400, 6.103_515_6e-5),
            (0x3555, 0.333_251_95),
            (0x3C00, 1.0),
            (0xC000, -2.0),
            (0x7BFF, 65504.0),
            (0x7C00, f32::INFINITY),
            (0xFC00, f32::NEG_INFINITY),
        ] {
            assert_eq!(from_half(bits), number, "{bits:04x}");
        }
        assert!(from_half(0x7E00).is_nan());
        assert!(from_half(0x8000).is_sign_negative());
    }

    #[test]
    fn whole_numbers_take_the_narrowest_type() {
        let read = |stored: Stored, numbers: &[i128]| {
            let bits = numbers.iter().map(|n| f64::from_bits(*n as u64));
            stored.kept_of_bits(
                Samples::F64(bits.collect()),
                &[0u8; 0].as_slice(),
                &mut Vec::new(),
            )
        };
        assert_eq!(
            read(Stored::I64, &[-2_147_483_648, 7]).unwrap(),
            Samples::I32(vec![-2_147_483_648, 7])
        );
        assert_eq!(
            read(Stored::I64, &[0, 4_294_967_295]).unwrap(),
            Samples::U32(vec![0, 4_294_967_295])
        );
        assert_eq!(
            read(Stored::I64, &[-1, 9_007_199_254_740_991]).unwrap(),
            Samples::F64(vec![-1.0, 9_007_199_254_740_991.0])
        );
        for (stored, numbers) in [
            (Stored::I64, [0, i128::from(i64::MIN)]),
            (Stored::U64, [0, i128::from(u64::MAX)]),
        ] {
            let error = read(stored, &numbers).unwrap_err().to_string();
            assert!(error.contains(&numbers[1].to_string()), "{error}");
        }
        let text = Samples::F64(vec![1.5]);
        assert!(Stored::I64.kept_of_text(text, &mut Vec::new()).is_err());
    }
}
