//! What a function gives when some of its arguments are known: a value, or one of the arguments as it is.
//!
//! The function is read as naga understands it, and run with what is known. Only what every processor computes
//! alike to the bit is computed here (with `mix`, `dot`, `sqrt` and division, which processors may round once
//! more); anything else is not known, and stays in the program.

use crate::literal::{Literal, Number};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, LocalVariable, MathFunction, Module,
    RelationalFunction, ScalarKind, Statement, Type, TypeInner, UnaryOperator,
};
use std::collections::HashMap;

/// A function that calls no other, reads nothing but its arguments, and has no loop.
#[derive(Debug)]
pub struct PureFunction {
    module: Module,
    function: Handle<Function>,
}

/// A value as far as it is known.
#[derive(Clone, Debug, PartialEq)]
pub enum Known {
    /// Wholly.
    Value(Literal),
    /// The members of a struct.
    Members(Vec<Known>),
    /// An argument, or members of it.
    Argument(usize, Vec<String>),
    /// Not at all.
    Nothing,
}

/// Texts longer than this are not worth a second look.
const LONGEST: usize = 4096;

impl PureFunction {
    /// The function `main` of `source`, if it is of that kind. `prelude` are the types that it may use.
    pub fn of(source: &str, main: &str, prelude: &str) -> Option<PureFunction> {
        if source.len() > LONGEST || !strahl_shader::is_shallow(source) {
            return None;
        }
        let module = naga::front::wgsl::parse_str(&format!("{source}\n{prelude}")).ok()?;
        let mut functions = module.functions.iter();
        let found = functions.find(|(_, f)| f.name.as_deref() == Some(main) && is_plain(&f.body));
        let function = found.map(|(handle, _)| handle)?;
        drop(functions);
        Some(PureFunction { module, function })
    }

    /// What it gives for these arguments.
    pub fn call(&self, arguments: &[Known]) -> Known {
        let function = &self.module.functions[self.function];
        let mut run = Run {
            module: &self.module,
            function,
            arguments,
            values: HashMap::new(),
            locals: HashMap::new(),
        };
        for (handle, variable) in function.local_variables.iter() {
            let value = match variable.init {
                Some(init) => run.value(init),
                None => run.zero(variable.ty),
            };
            run.locals.insert(handle, value);
        }
        match run.block(&function.body) {
            Some(Way::Returned(value)) => value,
            _ => Known::Nothing,
        }
    }
}

/// Whether there is nothing in it but values, branches, and variables of its own.
fn is_plain(block: &Block) -> bool {
    block.iter().all(|statement| match statement {
        Statement::Emit(_) | Statement::Return { .. } | Statement::Store { .. } => true,
        Statement::Block(block) => is_plain(block),
        Statement::If { accept, reject, .. } => is_plain(accept) && is_plain(reject),
        _ => false,
    })
}

/// How a block ends.
enum Way {
    On,
    Returned(Known),
}

struct Run<'r> {
    module: &'r Module,
    function: &'r Function,
    arguments: &'r [Known],
    values: HashMap<Handle<Expression>, Known>,
    locals: HashMap<Handle<LocalVariable>, Known>,
}

impl Run<'_> {
    /// `None` where nobody knows which way it goes.
    fn block(&mut self, block: &Block) -> Option<Way> {
        for statement in block {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        let value = self.expression(handle);
                        self.values.insert(handle, value);
                    }
                }
                Statement::Block(inner) => match self.block(inner)? {
                    Way::On => {}
                    returned => return Some(returned),
                },
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    let Known::Value(literal) = self.value(*condition) else {
                        return None;
                    };
                    let taken = if literal.as_truth()? { accept } else { reject };
                    match self.block(taken)? {
                        Way::On => {}
                        returned => return Some(returned),
                    }
                }
                Statement::Store { pointer, value } => {
                    let Expression::LocalVariable(variable) = self.function.expressions[*pointer]
                    else {
                        return None;
                    };
                    let value = self.value(*value);
                    self.locals.insert(variable, value);
                }
                Statement::Return { value } => return Some(Way::Returned(self.value((*value)?))),
                _ => return None,
            }
        }
        Some(Way::On)
    }

    /// What has been computed, or needs no computation.
    fn value(&self, handle: Handle<Expression>) -> Known {
        match self.values.get(&handle) {
            Some(value) => value.clone(),
            None => self.expression(handle),
        }
    }

    fn zero(&self, ty: Handle<Type>) -> Known {
        let zero = |scalar: naga::Scalar| match scalar.kind {
            ScalarKind::Float => Some(Number::F32(0)),
            ScalarKind::Sint => Some(Number::I32(0)),
            ScalarKind::Uint => Some(Number::U32(0)),
            ScalarKind::Bool => Some(Number::Bool(false)),
            _ => None,
        };
        let found = match self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => zero(scalar).map(|n| vec![n]),
            TypeInner::Vector { size, scalar } => zero(scalar).map(|n| vec![n; size as usize]),
            _ => None,
        };
        found.map_or(Known::Nothing, |numbers| Known::Value(Literal(numbers)))
    }

    /// A value of the whole module; these are written without computation.
    fn constant(&self, handle: Handle<Expression>) -> Known {
        match &self.module.global_expressions[handle] {
            Expression::Literal(literal) => of_literal(*literal),
            Expression::ZeroValue(ty) => self.zero(*ty),
            Expression::Constant(constant) => self.constant(self.module.constants[*constant].init),
            Expression::Compose { ty, components } => {
                let parts = components.iter().map(|c| self.constant(*c)).collect();
                self.composed(*ty, parts)
            }
            Expression::Splat { size, value } => splat(self.constant(*value), *size as usize),
            _ => Known::Nothing,
        }
    }

    fn composed(&self, ty: Handle<Type>, parts: Vec<Known>) -> Known {
        match self.module.types[ty].inner {
            TypeInner::Struct { .. } => Known::Members(parts),
            TypeInner::Vector { .. } => {
                let mut numbers = Vec::new();
                for part in parts {
                    match part {
                        Known::Value(literal) => numbers.extend(literal.0),
                        _ => return Known::Nothing,
                    }
                }
                Known::Value(Literal(numbers))
            }
            _ => Known::Nothing,
        }
    }

    fn expression(&self, handle: Handle<Expression>) -> Known {
        let found = match &self.function.expressions[handle] {
            Expression::Literal(literal) => Some(of_literal(*literal)),
            Expression::Constant(constant) => {
                Some(self.constant(self.module.constants[*constant].init))
            }
            Expression::ZeroValue(ty) => Some(self.zero(*ty)),
            Expression::FunctionArgument(i) => self.arguments.get(*i as usize).cloned(),
            Expression::Load { pointer } => match self.function.expressions[*pointer] {
                Expression::LocalVariable(variable) => self.locals.get(&variable).cloned(),
                _ => None,
            },
            Expression::Compose { ty, components } => {
                let parts = components.iter().map(|c| self.value(*c)).collect();
                Some(self.composed(*ty, parts))
            }
            Expression::Splat { size, value } => Some(splat(self.value(*value), *size as usize)),
            Expression::AccessIndex { base, index } => self.member(*base, *index as usize),
            Expression::Swizzle {
                size,
                vector,
                pattern,
            } => {
                let places = pattern[..*size as usize].iter().map(|p| *p as usize);
                match self.value(*vector) {
                    Known::Value(literal) => {
                        let numbers = places.filter_map(|p| literal.0.get(p).copied());
                        Some(Known::Value(Literal(numbers.collect())))
                    }
                    Known::Argument(i, mut path) => {
                        path.push(places.map(|p| ['x', 'y', 'z', 'w'][p]).collect());
                        Some(Known::Argument(i, path))
                    }
                    _ => None,
                }
            }
            Expression::Unary { op, expr } => match self.value(*expr) {
                Known::Value(literal) => each(&[&literal], |n| unary(*op, n[0])),
                _ => None,
            },
            Expression::Binary { op, left, right } => {
                let (left, right) = (self.value(*left), self.value(*right));
                match (&left, &right) {
                    (Known::Value(a), Known::Value(b)) => {
                        each(&[a, b], |n| binary(*op, n[0], n[1]))
                    }
                    _ => identity(*op, &left, &right),
                }
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                let (accept, reject) = (self.value(*accept), self.value(*reject));
                match self.value(*condition) {
                    Known::Value(literal) if literal.0.len() == 1 => {
                        (literal.as_truth()).map(|truth| if truth { accept } else { reject })
                    }
                    Known::Value(condition) => match (&accept, &reject) {
                        (Known::Value(a), Known::Value(b)) => each(&[&condition, a, b], |n| {
                            Some(if n[0] == Number::Bool(true) {
                                n[1]
                            } else {
                                n[2]
                            })
                        }),
                        _ => None,
                    },
                    _ if accept == reject => Some(accept),
                    _ => None,
                }
            }
            Expression::Relational { fun, argument } => match (fun, self.value(*argument)) {
                (RelationalFunction::All, Known::Value(literal)) => Some(Known::Value(
                    Literal::truth(literal.0.iter().all(|n| *n == Number::Bool(true))),
                )),
                (RelationalFunction::Any, Known::Value(literal)) => Some(Known::Value(
                    Literal::truth(literal.0.contains(&Number::Bool(true))),
                )),
                _ => None,
            },
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3: None,
            } => {
                let arguments = [Some(*arg), *arg1, *arg2];
                let mut literals = Vec::new();
                for argument in arguments.into_iter().flatten() {
                    match self.value(argument) {
                        Known::Value(literal) => literals.push(literal),
                        _ => return Known::Nothing,
                    }
                }
                let literals: Vec<_> = literals.iter().collect();
                match fun {
                    MathFunction::Dot => dot(literals[0], literals[1]),
                    _ => each(&literals, |n| math(*fun, n)),
                }
            }
            Expression::As {
                expr,
                kind,
                convert: Some(4 | 1),
            } => match self.value(*expr) {
                Known::Value(literal) => each(&[&literal], |n| converted(n[0], *kind)),
                _ => None,
            },
            _ => None,
        };
        found.unwrap_or(Known::Nothing)
    }

    fn member(&self, base: Handle<Expression>, index: usize) -> Option<Known> {
        match self.value(base) {
            Known::Value(literal) => Some(Known::Value(Literal(vec![*literal.0.get(index)?]))),
            Known::Members(members) => members.get(index).cloned(),
            Known::Argument(i, mut path) => {
                // Only the outermost type is at hand: members of an argument that is a struct, components of
                // one that is a vector or a member of a struct.
                let ty = &self.module.types[self.function.arguments[i].ty].inner;
                let name = match (ty, &path[..]) {
                    (TypeInner::Struct { members, .. }, []) => members.get(index)?.name.clone()?,
                    (TypeInner::Vector { .. }, []) | (TypeInner::Struct { .. }, [_]) => {
                        ["x", "y", "z", "w"].get(index)?.to_string()
                    }
                    _ => return None,
                };
                path.push(name);
                Some(Known::Argument(i, path))
            }
            Known::Nothing => None,
        }
    }
}

fn of_literal(literal: naga::Literal) -> Known {
    let number = match literal {
        naga::Literal::F32(number) => Number::F32(number.to_bits()),
        naga::Literal::I32(number) => Number::I32(number),
        naga::Literal::U32(number) => Number::U32(number),
        naga::Literal::Bool(truth) => Number::Bool(truth),
        _ => return Known::Nothing,
    };
    Known::Value(Literal(vec![number]))
}

fn splat(value: Known, size: usize) -> Known {
    match value {
        Known::Value(literal) if literal.0.len() == 1 => {
            Known::Value(Literal(vec![literal.0[0]; size]))
        }
        _ => Known::Nothing,
    }
}

/// Component by component; a single number goes with every component of a vector.
fn each(literals: &[&Literal], f: impl Fn(&[Number]) -> Option<Number>) -> Option<Known> {
    let size = literals.iter().map(|l| l.0.len()).max()?;
    let mut numbers = Vec::with_capacity(size);
    for i in 0..size {
        let of_this: Option<Vec<_>> = (literals.iter())
            .map(|l| l.0.get(if l.0.len() == 1 { 0 } else { i }).copied())
            .collect();
        numbers.push(f(&of_this?)?);
    }
    Some(Known::Value(Literal(numbers)))
}

/// What leaves the other side as it is: times 1, divided by 1, minus 0, and true, or false.
fn identity(op: BinaryOperator, left: &Known, right: &Known) -> Option<Known> {
    let is_all = |known: &Known, wanted: &[Number]| match known {
        Known::Value(literal) => literal.0.len() == 1 && wanted.contains(&literal.0[0]),
        _ => false,
    };
    let ones = [
        Number::F32(1.0f32.to_bits()),
        Number::I32(1),
        Number::U32(1),
    ];
    let zeros = [Number::F32(0), Number::I32(0), Number::U32(0)];
    let whole = [Number::I32(0), Number::U32(0)];
    let (of_left, of_right): (&[Number], &[Number]) = match op {
        BinaryOperator::Multiply => (&ones, &ones),
        BinaryOperator::Divide => (&[], &ones),
        BinaryOperator::Subtract => (&[], &zeros),
        // -0 + 0 is 0.
        BinaryOperator::Add => (&whole, &whole),
        BinaryOperator::LogicalAnd => (&[Number::Bool(true)], &[Number::Bool(true)]),
        BinaryOperator::LogicalOr => (&[Number::Bool(false)], &[Number::Bool(false)]),
        _ => return None,
    };
    // A single number beside a vector leaves the vector; a vector beside a number makes one of it.
    let is_argument = |known: &Known| matches!(known, Known::Argument(..));
    if is_argument(right) && is_all(left, of_left) {
        return Some(right.clone());
    }
    if is_argument(left) && is_all(right, of_right) {
        return Some(left.clone());
    }
    None
}

fn unary(op: UnaryOperator, n: Number) -> Option<Number> {
    match (op, n) {
        (UnaryOperator::Negate, Number::F32(bits)) => Number::float(-f32::from_bits(bits)),
        (UnaryOperator::Negate, Number::I32(n)) => Some(Number::I32(n.wrapping_neg())),
        (UnaryOperator::LogicalNot, Number::Bool(truth)) => Some(Number::Bool(!truth)),
        (UnaryOperator::BitwiseNot, Number::I32(n)) => Some(Number::I32(!n)),
        (UnaryOperator::BitwiseNot, Number::U32(n)) => Some(Number::U32(!n)),
        _ => None,
    }
}

fn binary(op: BinaryOperator, a: Number, b: Number) -> Option<Number> {
    use BinaryOperator as Op;
    let compared = match (a, b) {
        (Number::F32(a), Number::F32(b)) => f32::from_bits(a).partial_cmp(&f32::from_bits(b)),
        (Number::I32(a), Number::I32(b)) => Some(a.cmp(&b)),
        (Number::U32(a), Number::U32(b)) => Some(a.cmp(&b)),
        _ => None,
    };
    if let Some(order) = compared {
        let truth = match op {
            Op::Equal => Some(order.is_eq()),
            Op::NotEqual => Some(order.is_ne()),
            Op::Less => Some(order.is_lt()),
            Op::LessEqual => Some(order.is_le()),
            Op::Greater => Some(order.is_gt()),
            Op::GreaterEqual => Some(order.is_ge()),
            _ => None,
        };
        if let Some(truth) = truth {
            return Some(Number::Bool(truth));
        }
    }
    match (a, b) {
        (Number::F32(a), Number::F32(b)) => {
            let (a, b) = (f32::from_bits(a), f32::from_bits(b));
            match op {
                Op::Add => Number::float(a + b),
                Op::Subtract => Number::float(a - b),
                Op::Multiply => Number::float(a * b),
                Op::Divide => Number::float(a / b),
                _ => None,
            }
        }
        (Number::I32(a), Number::I32(b)) => {
            let number = match op {
                Op::Add => a.wrapping_add(b),
                Op::Subtract => a.wrapping_sub(b),
                Op::Multiply => a.wrapping_mul(b),
                Op::Divide => a.checked_div(b)?,
                Op::Modulo => a.checked_rem(b)?,
                Op::And => a & b,
                Op::InclusiveOr => a | b,
                Op::ExclusiveOr => a ^ b,
                _ => return None,
            };
            Some(Number::I32(number))
        }
        (Number::U32(a), Number::U32(b)) => {
            let number = match op {
                Op::Add => a.wrapping_add(b),
                Op::Subtract => a.wrapping_sub(b),
                Op::Multiply => a.wrapping_mul(b),
                Op::Divide => a.checked_div(b)?,
                Op::Modulo => a.checked_rem(b)?,
                Op::And => a & b,
                Op::InclusiveOr => a | b,
                Op::ExclusiveOr => a ^ b,
                Op::ShiftLeft => a.checked_shl(b)?,
                Op::ShiftRight => a.checked_shr(b)?,
                _ => return None,
            };
            Some(Number::U32(number))
        }
        (Number::Bool(a), Number::Bool(b)) => {
            let truth = match op {
                Op::And | Op::LogicalAnd => a & b,
                Op::InclusiveOr | Op::LogicalOr => a | b,
                Op::Equal => a == b,
                Op::NotEqual | Op::ExclusiveOr => a != b,
                _ => return None,
            };
            Some(Number::Bool(truth))
        }
        _ => None,
    }
}

fn math(fun: MathFunction, n: &[Number]) -> Option<Number> {
    use MathFunction as F;
    let floats: Option<Vec<f32>> = n
        .iter()
        .map(|n| match n {
            Number::F32(bits) => Some(f32::from_bits(*bits)),
            _ => None,
        })
        .collect();
    if let Some(floats) = floats {
        let number = match (fun, &floats[..]) {
            (F::Abs, [a]) => a.abs(),
            (F::Min, [a, b]) => a.min(*b),
            (F::Max, [a, b]) => a.max(*b),
            (F::Clamp, [a, low, high]) => a.max(*low).min(*high),
            (F::Saturate, [a]) => a.clamp(0.0, 1.0),
            (F::Ceil, [a]) => a.ceil(),
            (F::Floor, [a]) => a.floor(),
            (F::Trunc, [a]) => a.trunc(),
            (F::Round, [a]) => a.round_ties_even(),
            (F::Fract, [a]) => a - a.floor(),
            (F::Sign, [a]) if *a == 0.0 => 0.0,
            (F::Sign, [a]) => a.signum(),
            (F::Sqrt, [a]) => a.sqrt(),
            (F::Mix, [a, b, share]) => a * (1.0 - share) + b * share,
            (F::Step, [edge, a]) => f32::from(edge <= a),
            _ => return None,
        };
        return Number::float(number);
    }
    match (fun, n) {
        (F::Min, [Number::I32(a), Number::I32(b)]) => Some(Number::I32(*a.min(b))),
        (F::Max, [Number::I32(a), Number::I32(b)]) => Some(Number::I32(*a.max(b))),
        (F::Min, [Number::U32(a), Number::U32(b)]) => Some(Number::U32(*a.min(b))),
        (F::Max, [Number::U32(a), Number::U32(b)]) => Some(Number::U32(*a.max(b))),
        (F::Abs, [Number::I32(a)]) => Some(Number::I32(a.wrapping_abs())),
        (F::Clamp, [Number::I32(a), Number::I32(low), Number::I32(high)]) => {
            Some(Number::I32(*a.max(low).min(high)))
        }
        (F::Clamp, [Number::U32(a), Number::U32(low), Number::U32(high)]) => {
            Some(Number::U32(*a.max(low).min(high)))
        }
        _ => None,
    }
}

fn dot(a: &Literal, b: &Literal) -> Option<Known> {
    let mut sum = 0.0f32;
    for pair in a.0.iter().zip(&b.0) {
        let (Number::F32(a), Number::F32(b)) = pair else {
            return None;
        };
        sum += f32::from_bits(*a) * f32::from_bits(*b);
    }
    Some(Known::Value(Literal(vec![Number::float(sum)?])))
}

/// Numbers that the other type does not have stay in the program.
fn converted(n: Number, kind: ScalarKind) -> Option<Number> {
    let number = match n {
        Number::F32(bits) => f64::from(f32::from_bits(bits)),
        Number::I32(number) => f64::from(number),
        Number::U32(number) => f64::from(number),
        Number::Bool(truth) => f64::from(u8::from(truth)),
    };
    match kind {
        ScalarKind::Float => Number::float(number as f32),
        ScalarKind::Sint if (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&number) => {
            Some(Number::I32(number as i32))
        }
        ScalarKind::Uint if (0.0..=f64::from(u32::MAX)).contains(&number) => {
            Some(Number::U32(number as u32))
        }
        ScalarKind::Bool => Some(Number::Bool(number != 0.0)),
        _ => None,
    }
}
