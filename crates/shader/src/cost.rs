//! What a program costs, counted in its intermediate form.
//!
//! An upper bound: of two branches the dearer one counts, and every sample counts as visible. A loop that
//! counts from a constant to a constant is multiplied by its turns; any other loop counts once, except the
//! loop over the samples, whose turn is the sample.

use naga::{BinaryOperator, Block, Expression, Function, Handle, Literal, Module, Statement};
use std::collections::HashMap;
use std::ops::{Add, Mul};

/// Work of one ray or of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Reads of textures, filtered or not.
    pub texture_reads: u64,
    /// Operations on numbers and vectors; moves, conversions of shape and reads of variables are none.
    pub instructions: u64,
}

impl Add for Work {
    type Output = Work;

    fn add(self, other: Work) -> Work {
        Work {
            texture_reads: self.texture_reads.saturating_add(other.texture_reads),
            instructions: self.instructions.saturating_add(other.instructions),
        }
    }
}

impl Mul<u64> for Work {
    type Output = Work;

    fn mul(self, times: u64) -> Work {
        Work {
            texture_reads: self.texture_reads.saturating_mul(times),
            instructions: self.instructions.saturating_mul(times),
        }
    }
}

impl Work {
    fn or(self, other: Work) -> Work {
        Work {
            texture_reads: self.texture_reads.max(other.texture_reads),
            instructions: self.instructions.max(other.instructions),
        }
    }
}

/// What a program costs at most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Once per ray: its set-up, the jitter, the end of the composite.
    pub per_ray: Work,
    /// Once per sample that is visible.
    pub per_sample: Work,
    /// Of each function with all that it calls, by its name in the program; functions without work are
    /// left out.
    pub functions: Vec<(String, Work)>,
}

impl Cost {
    /// The cost of a linked program, whose loop over the samples is the one in `march`.
    pub(crate) fn of(module: &Module) -> Cost {
        let mut counter = Counter {
            module,
            known: HashMap::new(),
        };
        let (mut per_ray, mut per_sample) = (Work::default(), Work::default());
        let mut functions = Vec::new();
        // Callees come before their callers.
        for (handle, function) in module.functions.iter() {
            let work = counter.function(function);
            let name = function.name.clone().unwrap_or_default();
            if name == "march" {
                (per_ray, per_sample) = (work.0, work.1);
            }
            let all = work.0 + work.1;
            counter.known.insert(handle, all);
            if all != Work::default() {
                functions.push((name, all));
            }
        }
        Cost {
            per_ray,
            per_sample,
            functions,
        }
    }
}

struct Counter<'m> {
    module: &'m Module,
    /// Of the functions counted so far.
    known: HashMap<Handle<Function>, Work>,
}

impl Counter<'_> {
    /// Outside loops whose turns nobody knows, and inside.
    fn function(&mut self, function: &Function) -> (Work, Work) {
        let mut starts = HashMap::new();
        for (handle, variable) in function.local_variables.iter() {
            if let Some(number) = variable.init.and_then(|e| number(self.module, function, e)) {
                starts.insert(handle, number);
            }
        }
        self.block(function, &function.body, &mut starts)
    }

    fn block(
        &self,
        function: &Function,
        block: &Block,
        starts: &mut HashMap<Handle<naga::LocalVariable>, i64>,
    ) -> (Work, Work) {
        let (mut outside, mut inside) = (Work::default(), Work::default());
        for statement in block {
            let (once, looped) = match statement {
                Statement::Emit(range) => {
                    let works = range.clone().map(|e| of_expression(function, e));
                    (works.fold(Work::default(), Add::add), Work::default())
                }
                Statement::Call {
                    function: callee, ..
                } => (
                    self.known.get(callee).copied().unwrap_or_default(),
                    Work::default(),
                ),
                Statement::Block(inner) => self.block(function, inner, starts),
                Statement::If { accept, reject, .. } => {
                    let (a, b) = (
                        self.block(function, accept, starts),
                        self.block(function, reject, starts),
                    );
                    (a.0.or(b.0), a.1.or(b.1))
                }
                Statement::Switch { cases, .. } => {
                    let mut dearest = (Work::default(), Work::default());
                    for case in cases {
                        let work = self.block(function, &case.body, starts);
                        dearest = (dearest.0.or(work.0), dearest.1.or(work.1));
                    }
                    dearest
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    let turns = self.turns(function, body, continuing, starts);
                    let first = self.block(function, body, starts);
                    let second = self.block(function, continuing, starts);
                    let turn = first.0 + second.0 + first.1 + second.1;
                    match turns {
                        Some(turns) => (turn * turns, Work::default()),
                        None => (Work::default(), turn),
                    }
                }
                Statement::Store { pointer, value } => {
                    if let Expression::LocalVariable(variable) = function.expressions[*pointer] {
                        match number(self.module, function, *value) {
                            Some(number) => starts.insert(variable, number),
                            None => starts.remove(&variable),
                        };
                    }
                    continue;
                }
                _ => continue,
            };
            outside = outside + once;
            inside = inside + looped;
        }
        (outside, inside)
    }

    /// How often a loop turns that begins with `if !(i < end) { break; }` and ends with `i += step`.
    fn turns(
        &self,
        function: &Function,
        body: &Block,
        continuing: &Block,
        starts: &HashMap<Handle<naga::LocalVariable>, i64>,
    ) -> Option<u64> {
        let breaks = |block: &Block| block.iter().any(|s| matches!(s, Statement::Break));
        let condition = body.iter().find_map(|statement| match statement {
            Statement::If {
                condition, reject, ..
            } if breaks(reject) => Some(*condition),
            _ => None,
        })?;
        let Expression::Binary { op, left, right } = function.expressions[condition] else {
            return None;
        };
        let variable = loaded(function, left)?;
        let end = number(self.module, function, right)?;
        let end = match op {
            BinaryOperator::Less => end,
            BinaryOperator::LessEqual => end + 1,
            _ => return None,
        };
        let step = continuing.iter().find_map(|statement| match statement {
            Statement::Store { pointer, value } => {
                let is_same = matches!(function.expressions[*pointer],
                    Expression::LocalVariable(stored) if stored == variable);
                let Expression::Binary {
                    op: BinaryOperator::Add,
                    left,
                    right,
                } = function.expressions[*value]
                else {
                    return None;
                };
                let step = number(self.module, function, right)?;
                (is_same && loaded(function, left) == Some(variable) && step > 0).then_some(step)
            }
            _ => None,
        })?;
        let way = end - starts.get(&variable)?;
        u64::try_from(way.max(0)).ok()?.div_ceil(step as u64).into()
    }
}

fn loaded(
    function: &Function,
    expression: Handle<Expression>,
) -> Option<Handle<naga::LocalVariable>> {
    let Expression::Load { pointer } = function.expressions[expression] else {
        return None;
    };
    match function.expressions[pointer] {
        Expression::LocalVariable(variable) => Some(variable),
        _ => None,
    }
}

/// A whole number that is known before the program runs.
fn number(module: &Module, function: &Function, expression: Handle<Expression>) -> Option<i64> {
    let literal = match function.expressions[expression] {
        Expression::Literal(literal) => literal,
        Expression::Constant(constant) => {
            match module.global_expressions[module.constants[constant].init] {
                Expression::Literal(literal) => literal,
                _ => return None,
            }
        }
        Expression::Unary {
            op: naga::UnaryOperator::Negate,
            expr,
        } => return number(module, function, expr).map(|n| -n),
        _ => return None,
    };
    match literal {
        Literal::I32(n) => Some(i64::from(n)),
        Literal::U32(n) => Some(i64::from(n)),
        Literal::I64(n) | Literal::AbstractInt(n) => Some(n),
        _ => None,
    }
}

fn of_expression(function: &Function, expression: Handle<Expression>) -> Work {
    match function.expressions[expression] {
        Expression::ImageSample { .. } | Expression::ImageLoad { .. } => Work {
            texture_reads: 1,
            instructions: 1,
        },
        Expression::Binary { .. }
        | Expression::Unary { .. }
        | Expression::Math { .. }
        | Expression::Select { .. }
        | Expression::Relational { .. }
        | Expression::Derivative { .. } => Work {
            texture_reads: 0,
            instructions: 1,
        },
        _ => Work::default(),
    }
}
