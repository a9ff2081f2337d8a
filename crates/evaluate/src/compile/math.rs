//! WGSL's built-in functions.

use super::{Compiler, Scope};
use crate::code::{Binary, Op, Reg, Unary};
use crate::error::Error;
use crate::scalar;
use naga::{Expression, Handle, MathFunction as M, ScalarKind, TypeInner};
use std::rc::Rc;

impl<'m> Compiler<'m> {
    pub(super) fn math(
        &mut self,
        scope: &mut Scope<'m>,
        fun: M,
        arg: Handle<Expression>,
        rest: [Option<Handle<Expression>>; 3],
    ) -> Result<Rc<[Reg]>, Error> {
        let kind = self.kind_of(scope, arg)?;
        let ty = self.type_of(scope, arg);
        let a = self.scalars_of(scope, arg)?;
        let mut others: Vec<Rc<[Reg]>> = Vec::new();
        for handle in rest.into_iter().flatten() {
            others.push(self.scalars_of(scope, handle)?);
        }
        let whole = match fun {
            M::Dot => Some([self.dot(kind, &a, &others[0])].into()),
            M::Length => Some([self.length(&a)].into()),
            M::Distance => {
                let way = self.each(Binary::SubF, &a, &others[0]);
                Some([self.length(&way)].into())
            }
            M::Normalize => {
                let length = self.length(&a);
                Some(self.each(Binary::DivF, &a, &[length]))
            }
            M::Cross => Some(self.cross(&a, &others[0])),
            M::FaceForward => {
                // faceForward(e1, e2, e3): e1 if dot(e2, e3) is below 0, else −e1.
                let dot = self.dot(kind, &others[0], &others[1]);
                let zero = self.constant(0);
                let is_facing = self.binary(Binary::LtF, dot, zero);
                let turned = a.iter().map(|a| {
                    let other = self.unary(Unary::NegF, *a);
                    self.select(is_facing, *a, other)
                });
                Some(turned.collect::<Vec<_>>().into())
            }
            M::Reflect => {
                // e1 − 2·dot(e2, e1)·e2
                let dot = self.dot(kind, &others[0], &a);
                let two = self.float(2.0);
                let twice = self.binary(Binary::MulF, two, dot);
                let along = self.each(Binary::MulF, &others[0], &[twice]);
                Some(self.each(Binary::SubF, &a, &along))
            }
            M::Refract => Some(self.refract(&a, &others[0], others[1][0])),
            M::Outer => Some(
                others[0]
                    .iter()
                    .flat_map(|b| self.each(Binary::MulF, &a, &[*b]).to_vec())
                    .collect(),
            ),
            M::Transpose => {
                let rows = matrix_rows(ty);
                let transposed =
                    (0..rows).flat_map(|row| a.iter().copied().skip(row).step_by(rows));
                Some(transposed.collect())
            }
            M::Determinant => {
                let columns: Vec<&[Reg]> = a.chunks(matrix_rows(ty)).collect();
                Some([self.determinant(&columns)].into())
            }
            M::Inverse => return Err(self.missing("inverse of a matrix")),
            M::Modf => {
                let whole: Vec<_> = a.iter().map(|a| self.unary(Unary::Trunc, *a)).collect();
                let mut both = self.each(Binary::SubF, &a, &whole).to_vec();
                both.extend(whole);
                Some(both.into())
            }
            M::Frexp => {
                let parts = a.iter().map(|a| self.scalar1(scalar::frexp_fraction, *a));
                let mut both: Vec<_> = parts.collect();
                both.extend(a.iter().map(|a| self.scalar1(scalar::frexp_exponent, *a)));
                Some(both.into())
            }
            _ => self.packing(fun, &a, &others),
        };
        if let Some(whole) = whole {
            return Ok(whole);
        }
        // Component by component; a scalar goes with all of them.
        (0..a.len())
            .map(|i| {
                let at = |n: usize| others.get(n).map_or(a[i], |o| o[i.min(o.len() - 1)]);
                self.math_scalar(fun, kind, a[i], at(0), at(1), at(2))
            })
            .collect()
    }

    /// Component by component; one register on the right goes with all.
    fn each(&mut self, op: Binary, a: &[Reg], b: &[Reg]) -> Rc<[Reg]> {
        (0..a.len())
            .map(|i| self.binary(op, a[i], b[i.min(b.len() - 1)]))
            .collect()
    }

    fn length(&mut self, a: &[Reg]) -> Reg {
        if let [a] = a {
            return self.unary(Unary::AbsF, *a);
        }
        let square = self.dot(ScalarKind::Float, a, a);
        self.unary(Unary::Sqrt, square)
    }

    fn cross(&mut self, a: &[Reg], b: &[Reg]) -> Rc<[Reg]> {
        [(1, 2), (2, 0), (0, 1)]
            .map(|(i, j)| {
                let one = self.binary(Binary::MulF, a[i], b[j]);
                let other = self.binary(Binary::MulF, a[j], b[i]);
                self.binary(Binary::SubF, one, other)
            })
            .into()
    }

    fn refract(&mut self, a: &[Reg], normal: &[Reg], ratio: Reg) -> Rc<[Reg]> {
        let (zero, one) = (self.constant(0), self.float(1.0));
        let dot = self.dot(ScalarKind::Float, normal, a);
        // k = 1 − e3²·(1 − dot(e2, e1)²)
        let square = self.binary(Binary::MulF, dot, dot);
        let rest = self.binary(Binary::SubF, one, square);
        let ratio2 = self.binary(Binary::MulF, ratio, ratio);
        let scaled = self.binary(Binary::MulF, ratio2, rest);
        let k = self.binary(Binary::SubF, one, scaled);
        let is_reflected = self.binary(Binary::LtF, k, zero);
        let root = self.unary(Unary::Sqrt, k);
        let along = self.binary(Binary::MulF, ratio, dot);
        let along = self.binary(Binary::AddF, along, root);
        (0..a.len())
            .map(|i| {
                let ahead = self.binary(Binary::MulF, ratio, a[i]);
                let aside = self.binary(Binary::MulF, along, normal[i]);
                let bent = self.binary(Binary::SubF, ahead, aside);
                self.select(is_reflected, zero, bent)
            })
            .collect()
    }

    /// By the first column.
    fn determinant(&mut self, columns: &[&[Reg]]) -> Reg {
        if let [column] = columns {
            return column[0];
        }
        let mut sum = None;
        for (row, element) in columns[0].iter().enumerate() {
            let minor: Vec<Vec<Reg>> = columns[1..]
                .iter()
                .map(|column| {
                    let kept = column.iter().enumerate().filter(|(r, _)| *r != row);
                    kept.map(|(_, reg)| *reg).collect()
                })
                .collect();
            let minor: Vec<&[Reg]> = minor.iter().map(Vec::as_slice).collect();
            let minor = self.determinant(&minor);
            let product = self.binary(Binary::MulF, *element, minor);
            sum = Some(match sum {
                None => product,
                Some(sum) if row % 2 == 0 => self.binary(Binary::AddF, sum, product),
                Some(sum) => self.binary(Binary::SubF, sum, product),
            });
        }
        sum.unwrap_or(0)
    }

    /// Numbers in the bits of a word.
    fn packing(&mut self, fun: M, a: &[Reg], others: &[Rc<[Reg]>]) -> Option<Rc<[Reg]>> {
        let zero = self.constant(0);
        let at = |i: usize| a.get(i).copied().unwrap_or(zero);
        let all = [at(0), at(1), at(2), at(3)];
        let pack: fn([u32; 4]) -> u32 = match fun {
            M::Pack4x8snorm => scalar::pack4x8snorm,
            M::Pack4x8unorm => scalar::pack4x8unorm,
            M::Pack2x16snorm => scalar::pack2x16snorm,
            M::Pack2x16unorm => scalar::pack2x16unorm,
            M::Pack2x16float => scalar::pack2x16float,
            M::Pack4xI8 | M::Pack4xU8 => scalar::pack4x8,
            M::Pack4xI8Clamp => scalar::pack4xi8clamp,
            M::Pack4xU8Clamp => scalar::pack4xu8clamp,
            M::Dot4I8Packed | M::Dot4U8Packed => {
                let f = if fun == M::Dot4I8Packed {
                    scalar::dot4i8
                } else {
                    scalar::dot4u8
                };
                return Some([self.scalar2(f, a[0], others[0][0])].into());
            }
            _ => {
                let (parts, unpack): (u32, fn(u32, u32) -> u32) = match fun {
                    M::Unpack4x8snorm => (4, scalar::unpack4x8snorm),
                    M::Unpack4x8unorm => (4, scalar::unpack4x8unorm),
                    M::Unpack2x16snorm => (2, scalar::unpack2x16snorm),
                    M::Unpack2x16unorm => (2, scalar::unpack2x16unorm),
                    M::Unpack2x16float => (2, scalar::unpack2x16float),
                    M::Unpack4xI8 => (4, scalar::unpack4xi8),
                    M::Unpack4xU8 => (4, scalar::unpack4xu8),
                    _ => return None,
                };
                let unpacked = (0..parts).map(|i| {
                    let part = self.constant(i);
                    self.scalar2(unpack, a[0], part)
                });
                return Some(unpacked.collect::<Vec<_>>().into());
            }
        };
        Some([self.scalar4(pack, all)].into())
    }

    fn math_scalar(
        &mut self,
        fun: M,
        kind: ScalarKind,
        a: Reg,
        b: Reg,
        c: Reg,
        d: Reg,
    ) -> Result<Reg, Error> {
        let is_float = kind == ScalarKind::Float;
        let is_signed = kind == ScalarKind::Sint;
        let of = |float, signed, unsigned| {
            if is_float {
                float
            } else if is_signed {
                signed
            } else {
                unsigned
            }
        };
        let min = of(Binary::MinF, Binary::MinS, Binary::MinU);
        let max = of(Binary::MaxF, Binary::MaxS, Binary::MaxU);
        Ok(match fun {
            M::Abs if is_float => self.unary(Unary::AbsF, a),
            M::Abs if is_signed => self.unary(Unary::AbsI, a),
            M::Abs => a,
            M::Min => self.binary(min, a, b),
            M::Max => self.binary(max, a, b),
            M::Clamp => {
                let low = self.binary(max, a, b);
                self.binary(min, low, c)
            }
            M::Saturate => self.unary(Unary::Saturate, a),
            M::Sign if is_float => self.unary(Unary::SignF, a),
            M::Sign => self.unary(Unary::SignI, a),
            M::Ceil => self.unary(Unary::Ceil, a),
            M::Floor => self.unary(Unary::Floor, a),
            M::Round => self.unary(Unary::Round, a),
            M::Fract => self.unary(Unary::Fract, a),
            M::Trunc => self.unary(Unary::Trunc, a),
            M::Sqrt => self.unary(Unary::Sqrt, a),
            M::InverseSqrt => self.unary(Unary::InverseSqrt, a),
            M::Radians => {
                let factor = self.float(std::f32::consts::PI / 180.0);
                self.binary(Binary::MulF, a, factor)
            }
            M::Degrees => {
                let factor = self.float(180.0 / std::f32::consts::PI);
                self.binary(Binary::MulF, a, factor)
            }
            M::Fma => {
                let product = self.binary(Binary::MulF, a, b);
                self.binary(Binary::AddF, product, c)
            }
            M::Mix => self.pure(&[a, b, c], |to| Op::Mix { to, a, b, t: c }),
            M::Step => {
                // step(edge, x)
                let (zero, one) = (self.constant(0), self.float(1.0));
                let is_over = self.binary(Binary::LeF, a, b);
                self.select(is_over, one, zero)
            }
            M::SmoothStep => {
                // smoothstep(low, high, x)
                let above = self.binary(Binary::SubF, c, a);
                let range = self.binary(Binary::SubF, b, a);
                let t = self.binary(Binary::DivF, above, range);
                let t = self.unary(Unary::Saturate, t);
                let (two, three) = (self.float(2.0), self.float(3.0));
                let twice = self.binary(Binary::MulF, two, t);
                let factor = self.binary(Binary::SubF, three, twice);
                let square = self.binary(Binary::MulF, t, t);
                self.binary(Binary::MulF, square, factor)
            }
            M::Atan2 => self.scalar2(scalar::atan2, a, b),
            M::Pow => self.scalar2(scalar::pow, a, b),
            M::Ldexp => self.scalar2(scalar::ldexp, a, b),
            M::ExtractBits if is_signed => self.scalar4(scalar::extract_signed, [a, b, c, c]),
            M::ExtractBits => self.scalar4(scalar::extract_unsigned, [a, b, c, c]),
            M::InsertBits => self.scalar4(scalar::insert_bits, [a, b, c, d]),
            _ => {
                let f: fn(u32) -> u32 = match fun {
                    M::Cos => scalar::cos,
                    M::Cosh => scalar::cosh,
                    M::Sin => scalar::sin,
                    M::Sinh => scalar::sinh,
                    M::Tan => scalar::tan,
                    M::Tanh => scalar::tanh,
                    M::Acos => scalar::acos,
                    M::Asin => scalar::asin,
                    M::Atan => scalar::atan,
                    M::Asinh => scalar::asinh,
                    M::Acosh => scalar::acosh,
                    M::Atanh => scalar::atanh,
                    M::Exp => scalar::exp,
                    M::Exp2 => scalar::exp2,
                    M::Log => scalar::log,
                    M::Log2 => scalar::log2,
                    M::QuantizeToF16 => scalar::quantize_to_f16,
                    M::CountTrailingZeros => scalar::trailing_zeros,
                    M::CountLeadingZeros => scalar::leading_zeros,
                    M::CountOneBits => scalar::ones,
                    M::ReverseBits => scalar::reversed,
                    M::FirstTrailingBit => scalar::first_trailing,
                    M::FirstLeadingBit if is_signed => scalar::first_leading_signed,
                    M::FirstLeadingBit => scalar::first_leading,
                    other => return Err(self.missing(format!("function {other:?}"))),
                };
                self.scalar1(f, a)
            }
        })
    }
}

/// Rows of a matrix type.
fn matrix_rows(ty: &TypeInner) -> usize {
    match ty {
        TypeInner::Matrix { rows, .. } => *rows as usize,
        _ => 1,
    }
}
