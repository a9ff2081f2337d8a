//! From naga's expressions and statements to operations on registers.
//!
//! A value is a list of registers, one per scalar: composing, splatting and swizzling cost nothing. What
//! depends on constants and uniform blocks only goes into the prologue, which runs once per picture.
//! Functions are compiled where they are called, as WGSL knows no recursion, so that what is constant
//! there is constant in them; large ones that are called from several places are shared.

mod math;
mod reads;
mod statements;

use crate::code::*;
use crate::error::Error;
use crate::registers::{Class, allocate};
use crate::resources::{Resource, Resources};
use crate::scalar;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, ArraySize, BinaryOperator, Block, Expression, Function, GlobalVariable, Handle,
    ImageClass, ImageDimension, ImageQuery, Literal, Module, RelationalFunction, Scalar,
    ScalarKind, Statement, SwitchValue, TypeInner, UnaryOperator, VectorSize,
};
use statements::each_statement;
use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

/// A function with at most this many expressions, its callees counted in, is compiled at every call.
const SMALL: usize = 400;

/// A variable of more scalars than this is refused: it would be one register each.
const MOST_SCALARS: usize = 1 << 14;

/// The types of variables and pointers are borrowed where the module has them.
type Inner<'m> = Cow<'m, TypeInner>;

/// What an expression is.
#[derive(Clone, Debug)]
enum Value<'m> {
    Scalars(Rc<[Reg]>),
    Place(Place<'m>),
    Texture(Handle<GlobalVariable>),
    Sampler(Handle<GlobalVariable>),
}

/// What a pointer points to.
#[derive(Clone, Debug)]
struct Place<'m> {
    memory: Memory,
    ty: Inner<'m>,
    /// Registers of a variable, words of a block.
    offset: u32,
    /// What is added to it in each lane.
    dynamic: Option<Reg>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Memory {
    /// From this register on.
    Variable(Reg),
    /// Resource number.
    Block(u32),
}

/// A function that calls share.
#[derive(Clone)]
struct Shared {
    index: usize,
    arguments: Vec<Rc<[Reg]>>,
    result: Rc<[Reg]>,
}

pub struct Compiler<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    resources: &'m Resources<'m>,
    classes: Vec<Class>,
    prologue: Vec<Op>,
    /// Constants by their bits.
    constants: HashMap<u32, Reg>,
    bits: HashMap<Reg, u32>,
    words: HashMap<(u32, u32), Reg>,
    globals: HashMap<Handle<GlobalVariable>, Reg>,
    /// Initial values of private variables.
    initial: Vec<Op>,
    nodes: Vec<Node>,
    shared: HashMap<Handle<Function>, Shared>,
    bodies: Vec<Vec<Node>>,
    weights: HashMap<Handle<Function>, usize>,
    outlive: HashMap<*const Function, Rc<[bool]>>,
    calls: HashMap<Handle<Function>, usize>,
    /// The name of the function of now, for messages.
    function: String,
}

/// A function while it is compiled.
struct Scope<'m> {
    function: &'m Function,
    info: &'m FunctionInfo,
    values: Vec<Option<Value<'m>>>,
    arguments: Vec<Value<'m>>,
    locals: Vec<Reg>,
    /// Of each expression, whether its value is needed after what follows it at once.
    outlive: Rc<[bool]>,
    /// Where early returns put the result.
    result: Option<Rc<[Reg]>>,
}

/// Compiles an entry point or a function.
pub fn compile<'m>(
    module: &'m Module,
    info: &'m ModuleInfo,
    resources: &'m Resources<'m>,
    function: &'m Function,
    function_info: &'m FunctionInfo,
    name: &str,
) -> Result<Code, Error> {
    let mut compiler = Compiler {
        module,
        info,
        resources,
        classes: Vec::new(),
        prologue: Vec::new(),
        constants: HashMap::new(),
        bits: HashMap::new(),
        words: HashMap::new(),
        globals: HashMap::new(),
        initial: Vec::new(),
        nodes: Vec::new(),
        shared: HashMap::new(),
        bodies: Vec::new(),
        weights: HashMap::new(),
        outlive: HashMap::new(),
        calls: HashMap::new(),
        function: name.to_owned(),
    };
    compiler.count_calls(&function.body);
    for (_, called) in module.functions.iter() {
        compiler.count_calls(&called.body);
    }
    let mut inputs = Vec::new();
    let mut arguments = Vec::new();
    for argument in &function.arguments {
        let registers = compiler.variable_of(&module.types[argument.ty].inner)?;
        inputs.extend_from_slice(&registers);
        arguments.push(Value::Scalars(registers));
    }
    let result = compiler.instance(function, function_info, arguments, name)?;
    // The result has to outlive the body.
    let mut outputs = Vec::new();
    for from in result.iter() {
        let to = compiler.register(Class::Variable);
        compiler.op(Op::Copy { to, from: *from });
        outputs.push(to);
    }
    let mut body = vec![Node::Ops(std::mem::take(&mut compiler.initial))];
    body.append(&mut compiler.nodes);
    Ok(allocate(
        Code {
            registers: 0,
            prologue: compiler.prologue,
            constants: compiler.bits.into_iter().collect(),
            uniform_registers: 0,
            body,
            shared: compiler.bodies,
            inputs,
            outputs,
        },
        &compiler.classes,
    ))
}

impl<'m> Compiler<'m> {
    fn missing(&self, what: impl Into<String>) -> Error {
        Error::NotCovered {
            what: what.into(),
            function: self.function.clone(),
        }
    }

    // Registers and operations.

    fn register(&mut self, class: Class) -> Reg {
        self.classes.push(class);
        (self.classes.len() - 1) as Reg
    }

    fn constant(&mut self, bits: u32) -> Reg {
        if let Some(found) = self.constants.get(&bits) {
            return *found;
        }
        let register = self.register(Class::Uniform);
        self.constants.insert(bits, register);
        self.bits.insert(register, bits);
        register
    }

    fn float(&mut self, value: f32) -> Reg {
        self.constant(value.to_bits())
    }

    fn op(&mut self, op: Op) {
        if let Some(Node::Ops(ops)) = self.nodes.last_mut() {
            ops.push(op);
        } else {
            self.nodes.push(Node::Ops(vec![op]));
        }
    }

    /// An operation without effects, whose result depends on `from` only.
    fn pure(&mut self, from: &[Reg], make: impl FnOnce(Reg) -> Op) -> Reg {
        let is_uniform = |reg: &Reg| self.classes[*reg as usize] == Class::Uniform;
        if from.iter().all(is_uniform) {
            let to = self.register(Class::Uniform);
            self.prologue.push(make(to));
            return to;
        }
        let to = self.register(Class::Value);
        self.op(make(to));
        to
    }

    fn unary(&mut self, op: Unary, a: Reg) -> Reg {
        self.pure(&[a], |to| Op::Unary(op, to, a))
    }

    fn binary(&mut self, op: Binary, a: Reg, b: Reg) -> Reg {
        self.pure(&[a, b], |to| Op::Binary(op, to, a, b))
    }

    fn select(&mut self, condition: Reg, accept: Reg, reject: Reg) -> Reg {
        self.pure(&[condition, accept, reject], |to| Op::Select {
            to,
            condition,
            accept,
            reject,
        })
    }

    fn scalar1(&mut self, f: fn(u32) -> u32, a: Reg) -> Reg {
        self.pure(&[a], |to| Op::Scalar1(f, to, a))
    }

    fn scalar2(&mut self, f: fn(u32, u32) -> u32, a: Reg, b: Reg) -> Reg {
        self.pure(&[a, b], |to| Op::Scalar2(f, to, a, b))
    }

    fn scalar4(&mut self, f: fn([u32; 4]) -> u32, from: [Reg; 4]) -> Reg {
        self.pure(&from, |to| Op::Scalar4(f, to, from))
    }

    fn word(&mut self, block: u32, word: u32) -> Reg {
        if let Some(found) = self.words.get(&(block, word)) {
            return *found;
        }
        let to = self.register(Class::Uniform);
        self.prologue.push(Op::Word { to, block, word });
        self.words.insert((block, word), to);
        to
    }

    // Types.

    fn inner(&self, ty: Handle<naga::Type>) -> Inner<'m> {
        Cow::Borrowed(&self.module.types[ty].inner)
    }

    /// The scalars of a type, and the word at which each lies in a uniform block.
    fn scalars(&self, ty: &TypeInner) -> Result<Vec<(Scalar, u32)>, Error> {
        let mut found = Vec::new();
        self.add_scalars(ty, 0, &mut found)?;
        Ok(found)
    }

    fn add_scalars(
        &self,
        ty: &TypeInner,
        word: u32,
        found: &mut Vec<(Scalar, u32)>,
    ) -> Result<(), Error> {
        if found.len() > MOST_SCALARS {
            return Err(self.missing(format!("variable of more than {MOST_SCALARS} scalars")));
        }
        match ty {
            TypeInner::Scalar(scalar) => found.push((self.checked(*scalar)?, word)),
            TypeInner::Vector { size, scalar } => {
                let scalar = self.checked(*scalar)?;
                found.extend((0..*size as u32).map(|i| (scalar, word + i)));
            }
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => {
                let scalar = self.checked(*scalar)?;
                for column in 0..*columns as u32 {
                    let word = word + column * column_words(*rows);
                    found.extend((0..*rows as u32).map(|i| (scalar, word + i)));
                }
            }
            TypeInner::Array { base, size, stride } => {
                let ArraySize::Constant(size) = size else {
                    return Err(self.missing("array of a length that is not constant"));
                };
                for i in 0..size.get() {
                    let base = &self.module.types[*base].inner;
                    self.add_scalars(base, word + i * stride / 4, found)?;
                }
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    let ty = &self.module.types[member.ty].inner;
                    self.add_scalars(ty, word + member.offset / 4, found)?;
                }
            }
            other => return Err(self.missing(format!("value of type {other:?}"))),
        }
        Ok(())
    }

    fn checked(&self, scalar: Scalar) -> Result<Scalar, Error> {
        let is_covered = match scalar.kind {
            ScalarKind::Bool => true,
            ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint => scalar.width == 4,
            ScalarKind::AbstractInt | ScalarKind::AbstractFloat => false,
        };
        if is_covered {
            return Ok(scalar);
        }
        let bits = 8 * u32::from(scalar.width);
        Err(self.missing(format!("number of {bits} bits ({:?})", scalar.kind)))
    }

    fn variable_of(&mut self, ty: &TypeInner) -> Result<Rc<[Reg]>, Error> {
        let number = self.scalars(ty)?.len();
        Ok((0..number)
            .map(|_| self.register(Class::Variable))
            .collect())
    }

    // Functions.

    fn count_calls(&mut self, block: &'m Block) {
        each_statement(block, &mut |statement| {
            if let Statement::Call { function, .. } = statement {
                *self.calls.entry(*function).or_default() += 1;
            }
        });
    }

    /// Expressions of a function and all that it calls.
    fn weight(&mut self, function: Handle<Function>) -> usize {
        if let Some(found) = self.weights.get(&function) {
            return *found;
        }
        let mut called = Vec::new();
        let body = &self.module.functions[function];
        each_statement(&body.body, &mut |statement| {
            if let Statement::Call { function, .. } = statement {
                called.push(*function);
            }
        });
        let own = body.expressions.len();
        let weight = called
            .into_iter()
            .fold(own, |sum, f| sum.saturating_add(self.weight(f)));
        self.weights.insert(function, weight);
        weight
    }

    fn outlive(&mut self, function: &'m Function) -> Rc<[bool]> {
        let key: *const Function = function;
        let found = self.outlive.get(&key).cloned();
        found.unwrap_or_else(|| {
            let outlive: Rc<[bool]> = reads::outlive(function).into();
            self.outlive.insert(key, outlive.clone());
            outlive
        })
    }

    /// The body of `function` with these arguments, from here on; gives the registers of its result.
    fn instance(
        &mut self,
        function: &'m Function,
        info: &'m FunctionInfo,
        arguments: Vec<Value<'m>>,
        name: &str,
    ) -> Result<Rc<[Reg]>, Error> {
        let outer = std::mem::replace(&mut self.function, name.to_owned());
        let mut scope = Scope {
            function,
            info,
            values: vec![None; function.expressions.len()],
            arguments,
            locals: Vec::new(),
            outlive: self.outlive(function),
            result: None,
        };
        let early = returns_early(&function.body);
        let before = early.then(|| std::mem::take(&mut self.nodes));
        for (_, local) in function.local_variables.iter() {
            let registers = self.variable_of(&self.module.types[local.ty].inner)?;
            let initial = match local.init {
                Some(init) => self.scalars_of(&mut scope, init)?,
                None => vec![self.constant(0); registers.len()].into(),
            };
            for (to, from) in registers.iter().zip(initial.iter()) {
                self.op(Op::Copy {
                    to: *to,
                    from: *from,
                });
            }
            scope.locals.push(registers.first().copied().unwrap_or(0));
        }
        if early && let Some(result) = &function.result {
            scope.result = Some(self.variable_of(&self.module.types[result.ty].inner)?);
        }
        let tail = self.block(&mut scope, &function.body)?;
        if let Some(before) = before {
            let body = std::mem::replace(&mut self.nodes, before);
            self.nodes.push(Node::Function(body));
        }
        self.function = outer;
        Ok(scope.result.or(tail).unwrap_or_else(|| [].into()))
    }

    fn call(
        &mut self,
        scope: &mut Scope<'m>,
        function: Handle<Function>,
        arguments: &[Handle<Expression>],
    ) -> Result<Rc<[Reg]>, Error> {
        let called = &self.module.functions[function];
        let name = called.name.clone().unwrap_or_default();
        let mut values = Vec::new();
        for argument in arguments {
            values.push(self.value(scope, *argument)?);
        }
        let is_plain = values.iter().all(|v| matches!(v, Value::Scalars(_)));
        let is_once = self.calls.get(&function) == Some(&1);
        if !is_plain || is_once || self.weight(function) <= SMALL {
            return self.instance(called, &self.info[function], values, &name);
        }
        let shared = match self.shared.get(&function) {
            Some(shared) => shared.clone(),
            None => {
                let outer = std::mem::take(&mut self.nodes);
                let mut registers = Vec::new();
                for argument in &called.arguments {
                    registers.push(self.variable_of(&self.module.types[argument.ty].inner)?);
                }
                let arguments = registers.iter().cloned().map(Value::Scalars).collect();
                let result = self.instance(called, &self.info[function], arguments, &name)?;
                // Its values live only while it runs.
                let mut kept = Vec::new();
                for from in result.iter() {
                    let to = self.register(Class::Variable);
                    self.op(Op::Copy { to, from: *from });
                    kept.push(to);
                }
                let body = std::mem::replace(&mut self.nodes, outer);
                self.bodies.push(body);
                let shared = Shared {
                    index: self.bodies.len() - 1,
                    arguments: registers,
                    result: kept.into(),
                };
                self.shared.insert(function, shared.clone());
                shared
            }
        };
        for (value, registers) in values.iter().zip(&shared.arguments) {
            if let Value::Scalars(from) = value {
                for (to, from) in registers.iter().zip(from.iter()) {
                    self.op(Op::Copy {
                        to: *to,
                        from: *from,
                    });
                }
            }
        }
        self.nodes.push(Node::Call(shared.index));
        // The next call writes the same registers.
        let result = shared.result.iter().map(|from| {
            let to = self.register(Class::Value);
            self.op(Op::Copy { to, from: *from });
            to
        });
        Ok(result.collect::<Vec<_>>().into())
    }

    // Statements.

    fn inside(&mut self, scope: &mut Scope<'m>, block: &'m Block) -> Result<Vec<Node>, Error> {
        let outer = std::mem::take(&mut self.nodes);
        self.block(scope, block)?;
        Ok(std::mem::replace(&mut self.nodes, outer))
    }

    /// Gives the result if the block ends with a return and no other is there.
    fn block(
        &mut self,
        scope: &mut Scope<'m>,
        block: &'m Block,
    ) -> Result<Option<Rc<[Reg]>>, Error> {
        for statement in block.iter() {
            match statement {
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        let value = self.expression(scope, expression)?;
                        scope.values[expression.index()] = Some(value);
                    }
                }
                Statement::Block(block) => {
                    let tail = self.block(scope, block)?;
                    if tail.is_some() {
                        return Ok(tail);
                    }
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    let condition = self.scalars_of(scope, *condition)?[0];
                    let accept = self.inside(scope, accept)?;
                    let reject = self.inside(scope, reject)?;
                    self.nodes.push(Node::If {
                        condition,
                        accept,
                        reject,
                    });
                }
                Statement::Switch { selector, cases } => {
                    let selector = self.scalars_of(scope, *selector)?[0];
                    self.switch(scope, selector, cases)?;
                }
                Statement::Loop {
                    body,
                    continuing,
                    break_if,
                } => {
                    let body = self.inside(scope, body)?;
                    let outer = std::mem::take(&mut self.nodes);
                    self.block(scope, continuing)?;
                    let break_if = match break_if {
                        Some(condition) => Some(self.scalars_of(scope, *condition)?[0]),
                        None => None,
                    };
                    let continuing = std::mem::replace(&mut self.nodes, outer);
                    self.nodes.push(Node::Loop {
                        body,
                        continuing,
                        break_if,
                    });
                }
                Statement::Break => self.nodes.push(Node::Break),
                Statement::Continue => self.nodes.push(Node::Continue),
                Statement::Return { value } => {
                    let value = match value {
                        Some(value) => self.scalars_of(scope, *value)?,
                        None => [].into(),
                    };
                    let early = returns_early(&scope.function.body);
                    if !early {
                        return Ok(Some(value));
                    }
                    if let Some(result) = scope.result.clone() {
                        self.store(&result, &value);
                    }
                    self.nodes.push(Node::Return);
                }
                Statement::Kill => self.nodes.push(Node::Kill),
                Statement::Store { pointer, value } => {
                    let value = self.scalars_of(scope, *value)?;
                    let place = self.place(scope, *pointer)?;
                    let Memory::Variable(first) = place.memory else {
                        return Err(self.missing("write into a buffer"));
                    };
                    match place.dynamic {
                        None => {
                            let first = first + place.offset;
                            let registers: Vec<_> = (first..).take(value.len()).collect();
                            self.store(&registers, &value);
                        }
                        Some(offset) => {
                            for (i, from) in (0..).zip(value.iter()) {
                                self.op(Op::StoreAt {
                                    first: first + place.offset + i,
                                    offset,
                                    from: *from,
                                });
                            }
                        }
                    }
                }
                Statement::Call {
                    function,
                    arguments,
                    result,
                } => {
                    let value = self.call(scope, *function, arguments)?;
                    if let Some(result) = result {
                        scope.values[result.index()] = Some(Value::Scalars(value));
                    }
                }
                other => return Err(self.missing(statement_name(other))),
            }
        }
        Ok(None)
    }

    fn store(&mut self, to: &[Reg], from: &[Reg]) {
        for (to, from) in to.iter().zip(from.iter()) {
            self.op(Op::Store {
                to: *to,
                from: *from,
            });
        }
    }

    fn switch(
        &mut self,
        scope: &mut Scope<'m>,
        selector: Reg,
        cases: &'m [naga::SwitchCase],
    ) -> Result<(), Error> {
        // What a constant selects is known here.
        if let Some(bits) = self.bits.get(&selector).copied() {
            let of = |value: &SwitchValue| match *value {
                SwitchValue::I32(v) => Some(v as u32),
                SwitchValue::U32(v) => Some(v),
                SwitchValue::Default => None,
            };
            let chosen = cases.iter().position(|case| of(&case.value) == Some(bits));
            let chosen = chosen.or_else(|| cases.iter().position(|c| of(&c.value).is_none()));
            let Some(mut chosen) = chosen else {
                return Ok(());
            };
            let outer = std::mem::take(&mut self.nodes);
            loop {
                self.block(scope, &cases[chosen].body)?;
                if !cases[chosen].fall_through || chosen + 1 == cases.len() {
                    break;
                }
                chosen += 1;
            }
            let body = std::mem::replace(&mut self.nodes, outer);
            self.nodes.push(Node::Switch {
                selector,
                cases: vec![Case {
                    values: vec![None],
                    body,
                    falls_through: false,
                }],
            });
            return Ok(());
        }
        let mut compiled = Vec::new();
        for case in cases {
            let value = match case.value {
                SwitchValue::I32(value) => Some(value as u32),
                SwitchValue::U32(value) => Some(value),
                SwitchValue::Default => None,
            };
            compiled.push(Case {
                values: vec![value],
                body: self.inside(scope, &case.body)?,
                falls_through: case.fall_through,
            });
        }
        self.nodes.push(Node::Switch {
            selector,
            cases: compiled,
        });
        Ok(())
    }

    // Expressions.

    fn value(
        &mut self,
        scope: &mut Scope<'m>,
        expression: Handle<Expression>,
    ) -> Result<Value<'m>, Error> {
        if let Some(value) = &scope.values[expression.index()] {
            return Ok(value.clone());
        }
        let value = self.expression(scope, expression)?;
        // What is not emitted has the same value everywhere.
        if scope.function.expressions[expression].needs_pre_emit() {
            scope.values[expression.index()] = Some(value.clone());
        }
        Ok(value)
    }

    fn scalars_of(
        &mut self,
        scope: &mut Scope<'m>,
        expression: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, Error> {
        match self.value(scope, expression)? {
            Value::Scalars(registers) => Ok(registers),
            _ => Err(self.missing("pointer or resource as a value")),
        }
    }

    fn place(
        &mut self,
        scope: &mut Scope<'m>,
        expression: Handle<Expression>,
    ) -> Result<Place<'m>, Error> {
        match self.value(scope, expression)? {
            Value::Place(place) => Ok(place),
            _ => Err(self.missing("value as a pointer")),
        }
    }

    fn type_of(&self, scope: &Scope<'m>, expression: Handle<Expression>) -> &'m TypeInner {
        scope.info[expression].ty.inner_with(&self.module.types)
    }

    fn kind_of(
        &self,
        scope: &Scope<'m>,
        expression: Handle<Expression>,
    ) -> Result<ScalarKind, Error> {
        match self.type_of(scope, expression).scalar() {
            Some(scalar) => Ok(self.checked(scalar)?.kind),
            None => Err(self.missing("arithmetic on what is no number")),
        }
    }

    fn expression(
        &mut self,
        scope: &mut Scope<'m>,
        handle: Handle<Expression>,
    ) -> Result<Value<'m>, Error> {
        let scalars: Rc<[Reg]> = match &scope.function.expressions[handle] {
            Expression::Literal(literal) => [self.literal(literal)?].into(),
            Expression::Constant(constant) => {
                self.global_value(self.module.constants[*constant].init)?
            }
            Expression::ZeroValue(ty) => self.zero(*ty)?,
            Expression::Override(_) => return Err(self.missing("override")),
            Expression::Compose { components, .. } => {
                let mut registers = Vec::new();
                for component in components {
                    registers.extend_from_slice(&self.scalars_of(scope, *component)?);
                }
                registers.into()
            }
            Expression::Access { base, index } => return self.access(scope, *base, *index),
            Expression::AccessIndex { base, index } => {
                return match self.value(scope, *base)? {
                    Value::Place(place) => Ok(Value::Place(self.part(place, *index)?)),
                    Value::Scalars(registers) => {
                        let ty = self.type_of(scope, *base);
                        let (start, len) = self.part_of_scalars(ty, *index)?;
                        Ok(Value::Scalars(registers[start..start + len].into()))
                    }
                    _ => Err(self.missing("array of resources")),
                };
            }
            Expression::Splat { size, value } => {
                let register = self.scalars_of(scope, *value)?[0];
                vec![register; *size as usize].into()
            }
            Expression::Swizzle {
                size,
                vector,
                pattern,
            } => {
                let vector = self.scalars_of(scope, *vector)?;
                let pattern = &pattern[..*size as usize];
                pattern.iter().map(|c| vector[*c as usize]).collect()
            }
            Expression::FunctionArgument(index) => {
                return Ok(scope.arguments[*index as usize].clone());
            }
            Expression::GlobalVariable(global) => return self.global(*global),
            Expression::LocalVariable(local) => {
                let ty = scope.function.local_variables[*local].ty;
                return Ok(Value::Place(Place {
                    memory: Memory::Variable(scope.locals[local.index()]),
                    ty: self.inner(ty),
                    offset: 0,
                    dynamic: None,
                }));
            }
            Expression::Load { pointer } => {
                let place = self.place(scope, *pointer)?;
                self.load(place, scope.outlive[handle.index()])?
            }
            Expression::ImageSample {
                image,
                sampler,
                gather,
                coordinate,
                array_index,
                offset,
                depth_ref,
                clamp_to_edge,
                // Every texture has one level.
                level: _,
            } => {
                for (is_there, what) in [
                    (gather.is_some(), "textureGather"),
                    (array_index.is_some(), "array of textures"),
                    (offset.is_some(), "offset of texels"),
                    (depth_ref.is_some(), "comparison of depths"),
                    (*clamp_to_edge, "textureSampleBaseClampToEdge"),
                ] {
                    if is_there {
                        return Err(self.missing(what));
                    }
                }
                let (texture, _) = self.texture(scope, *image)?;
                let Value::Sampler(sampler) = self.value(scope, *sampler)? else {
                    return Err(self.missing("sampler that is no global variable"));
                };
                let sampler = self.bound(sampler)?;
                let at = self.scalars_of(scope, *coordinate)?;
                let at = self.three(&at);
                let to = [0; 4].map(|_| self.register(Class::Value));
                self.op(Op::Sample {
                    to,
                    texture,
                    sampler,
                    at,
                });
                to.into()
            }
            Expression::ImageLoad {
                image,
                coordinate,
                array_index,
                sample,
                level: _,
            } => {
                if array_index.is_some() || sample.is_some() {
                    return Err(self.missing("array of textures, or texture of several samples"));
                }
                let (texture, _) = self.texture(scope, *image)?;
                let at = self.scalars_of(scope, *coordinate)?;
                let at = self.three(&at);
                let to = [0; 4].map(|_| self.register(Class::Value));
                self.op(Op::Texel { to, texture, at });
                to.into()
            }
            Expression::ImageQuery { image, query } => {
                let (texture, dimension) = self.texture(scope, *image)?;
                let Resource::Texture(texture) = self.resources.at(texture) else {
                    return Err(self.missing("texture that is no texture"));
                };
                let dims = texture.dims();
                let numbers = match query {
                    ImageQuery::Size { .. } => dims[..dimension].to_vec(),
                    ImageQuery::NumLevels | ImageQuery::NumSamples => vec![1],
                    ImageQuery::NumLayers => return Err(self.missing("array of textures")),
                };
                numbers.into_iter().map(|n| self.constant(n)).collect()
            }
            Expression::Unary { op, expr } => {
                let kind = self.kind_of(scope, *expr)?;
                let op = match (op, kind) {
                    (UnaryOperator::Negate, ScalarKind::Float) => Unary::NegF,
                    (UnaryOperator::Negate, _) => Unary::NegI,
                    (UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot, _) => Unary::Not,
                };
                let from = self.scalars_of(scope, *expr)?;
                from.iter().map(|a| self.unary(op, *a)).collect()
            }
            Expression::Binary { op, left, right } => {
                self.binary_expression(scope, *op, *left, *right)?
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                let condition = self.scalars_of(scope, *condition)?;
                let accept = self.scalars_of(scope, *accept)?;
                let reject = self.scalars_of(scope, *reject)?;
                (0..accept.len())
                    .map(|i| {
                        let condition = condition[i.min(condition.len() - 1)];
                        self.select(condition, accept[i], reject[i])
                    })
                    .collect()
            }
            Expression::Relational { fun, argument } => {
                let from = self.scalars_of(scope, *argument)?;
                match fun {
                    RelationalFunction::All => [self.folded(Binary::And, &from)].into(),
                    RelationalFunction::Any => [self.folded(Binary::Or, &from)].into(),
                    RelationalFunction::IsNan => from
                        .iter()
                        .map(|a| self.scalar1(scalar::is_nan, *a))
                        .collect(),
                    RelationalFunction::IsInf => from
                        .iter()
                        .map(|a| self.scalar1(scalar::is_inf, *a))
                        .collect(),
                }
            }
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3,
            } => self.math(scope, *fun, *arg, [*arg1, *arg2, *arg3])?,
            Expression::As {
                expr,
                kind,
                convert,
            } => {
                let from = self.kind_of(scope, *expr)?;
                let registers = self.scalars_of(scope, *expr)?;
                match convert {
                    None => registers,
                    Some(width) => {
                        let to = Scalar {
                            kind: *kind,
                            width: *width,
                        };
                        let to = self.checked(to)?.kind;
                        registers
                            .iter()
                            .map(|a| self.converted(*a, from, to))
                            .collect()
                    }
                }
            }
            Expression::Derivative { .. } => return Err(self.missing("derivative over pixels")),
            Expression::CallResult(_) => return Err(self.missing("result before its call")),
            other => return Err(self.missing(expression_name(other))),
        };
        Ok(Value::Scalars(scalars))
    }

    fn folded(&mut self, op: Binary, registers: &[Reg]) -> Reg {
        let mut all = registers[0];
        for register in &registers[1..] {
            all = self.binary(op, all, *register);
        }
        all
    }

    fn three(&mut self, at: &[Reg]) -> [Reg; 3] {
        let zero = self.constant(0);
        [0, 1, 2].map(|i| at.get(i).copied().unwrap_or(zero))
    }

    fn literal(&mut self, literal: &Literal) -> Result<Reg, Error> {
        Ok(match *literal {
            Literal::F32(value) => self.float(value),
            Literal::U32(value) => self.constant(value),
            Literal::I32(value) => self.constant(value as u32),
            Literal::Bool(value) => self.constant(if value { !0 } else { 0 }),
            other => return Err(self.missing(format!("number {other:?}"))),
        })
    }

    fn zero(&mut self, ty: Handle<naga::Type>) -> Result<Rc<[Reg]>, Error> {
        let number = self.scalars(&self.module.types[ty].inner)?.len();
        Ok(vec![self.constant(0); number].into())
    }

    /// A constant expression of the module.
    fn global_value(&mut self, handle: Handle<Expression>) -> Result<Rc<[Reg]>, Error> {
        Ok(match &self.module.global_expressions[handle] {
            Expression::Literal(literal) => [self.literal(literal)?].into(),
            Expression::Constant(constant) => {
                self.global_value(self.module.constants[*constant].init)?
            }
            Expression::ZeroValue(ty) => self.zero(*ty)?,
            Expression::Compose { components, .. } => {
                let mut registers = Vec::new();
                for component in components {
                    registers.extend_from_slice(&self.global_value(*component)?);
                }
                registers.into()
            }
            Expression::Splat { size, value } => {
                let register = self.global_value(*value)?[0];
                vec![register; *size as usize].into()
            }
            other => return Err(self.missing(format!("constant {}", expression_name(other)))),
        })
    }

    // Memory.

    fn global(&mut self, handle: Handle<GlobalVariable>) -> Result<Value<'m>, Error> {
        let variable = &self.module.global_variables[handle];
        let ty = self.inner(variable.ty);
        match variable.space {
            AddressSpace::Private => {
                let first = match self.globals.get(&handle) {
                    Some(first) => *first,
                    None => {
                        let registers = self.variable_of(&ty)?;
                        let initial = match variable.init {
                            Some(init) => self.global_value(init)?,
                            None => self.zero(variable.ty)?,
                        };
                        let pairs = registers.iter().zip(initial.iter());
                        self.initial.extend(pairs.map(|(to, from)| Op::Copy {
                            to: *to,
                            from: *from,
                        }));
                        let first = registers.first().copied().unwrap_or(0);
                        self.globals.insert(handle, first);
                        first
                    }
                };
                Ok(Value::Place(Place {
                    memory: Memory::Variable(first),
                    ty,
                    offset: 0,
                    dynamic: None,
                }))
            }
            AddressSpace::Uniform => Ok(Value::Place(Place {
                memory: Memory::Block(self.bound(handle)?),
                ty,
                offset: 0,
                dynamic: None,
            })),
            AddressSpace::Handle => match *ty {
                TypeInner::Image { .. } => Ok(Value::Texture(handle)),
                TypeInner::Sampler { comparison: false } => Ok(Value::Sampler(handle)),
                _ => Err(self.missing(format!("resource of type {ty:?}"))),
            },
            space => Err(self.missing(format!("variable in the address space {space:?}"))),
        }
    }

    /// The resource of a global variable, checked.
    fn bound(&self, handle: Handle<GlobalVariable>) -> Result<u32, Error> {
        self.resources.bound(self.module, handle)
    }

    fn texture(
        &mut self,
        scope: &mut Scope<'m>,
        image: Handle<Expression>,
    ) -> Result<(u32, usize), Error> {
        let Value::Texture(handle) = self.value(scope, image)? else {
            return Err(self.missing("texture that is no global variable"));
        };
        let ty = &self.module.types[self.module.global_variables[handle].ty].inner;
        let TypeInner::Image {
            dim,
            arrayed: false,
            class: ImageClass::Sampled { multi: false, .. },
        } = ty
        else {
            return Err(self.missing(format!("texture of type {ty:?}")));
        };
        let dimension = match dim {
            ImageDimension::D1 => 1,
            ImageDimension::D2 => 2,
            ImageDimension::D3 => 3,
            ImageDimension::Cube => return Err(self.missing("cube texture")),
        };
        Ok((self.bound(handle)?, dimension))
    }

    /// Where part `index` of a value begins among its scalars, and how many it has.
    fn part_of_scalars(&self, ty: &TypeInner, index: u32) -> Result<(usize, usize), Error> {
        let index = index as usize;
        Ok(match ty {
            TypeInner::Struct { members, .. } => {
                let len = |member: &naga::StructMember| -> Result<usize, Error> {
                    Ok(self.scalars(&self.module.types[member.ty].inner)?.len())
                };
                let mut start = 0;
                for member in &members[..index] {
                    start += len(member)?;
                }
                (start, len(&members[index])?)
            }
            TypeInner::Array { base, .. } => {
                let len = self.scalars(&self.module.types[*base].inner)?.len();
                (index * len, len)
            }
            TypeInner::Matrix { rows, .. } => (index * *rows as usize, *rows as usize),
            TypeInner::Vector { .. } => (index, 1),
            other => return Err(self.missing(format!("part of {other:?}"))),
        })
    }

    /// The type of the elements of a composite without names, how many there are, and how far apart
    /// they are: in scalars, and in words of a block.
    fn elements(&self, ty: &TypeInner) -> Result<(Inner<'m>, u32, u32, u32), Error> {
        Ok(match *ty {
            TypeInner::Array { base, size, stride } => {
                let ArraySize::Constant(number) = size else {
                    return Err(self.missing("array of a length that is not constant"));
                };
                let base = self.inner(base);
                let scalars = self.scalars(&base)?.len() as u32;
                (base, number.get(), scalars, stride / 4)
            }
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => {
                let column = TypeInner::Vector { size: rows, scalar };
                let words = column_words(rows);
                (Cow::Owned(column), columns as u32, rows as u32, words)
            }
            TypeInner::Vector { size, scalar } => {
                (Cow::Owned(TypeInner::Scalar(scalar)), size as u32, 1, 1)
            }
            ref other => return Err(self.missing(format!("element of {other:?}"))),
        })
    }

    fn part(&self, place: Place<'m>, index: u32) -> Result<Place<'m>, Error> {
        if let TypeInner::Struct { members, .. } = &*place.ty {
            let member = &members[index as usize];
            let step = match place.memory {
                Memory::Variable(_) => self.part_of_scalars(&place.ty, index)?.0 as u32,
                Memory::Block(_) => member.offset / 4,
            };
            return Ok(Place {
                ty: self.inner(member.ty),
                offset: place.offset + step,
                ..place
            });
        }
        let (ty, _, scalars, words) = self.elements(&place.ty)?;
        let stride = match place.memory {
            Memory::Variable(_) => scalars,
            Memory::Block(_) => words,
        };
        Ok(Place {
            ty,
            offset: place.offset + index * stride,
            ..place
        })
    }

    fn access(
        &mut self,
        scope: &mut Scope<'m>,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Value<'m>, Error> {
        let index = self.scalars_of(scope, index)?[0];
        let known = self.bits.get(&index).copied();
        match self.value(scope, base)? {
            Value::Place(place) => {
                let (ty, number, scalars, words) = self.elements(&place.ty)?;
                // Indices beyond the end, and below 0, are those of the last element.
                if let Some(known) = known {
                    return Ok(Value::Place(self.part(place, known.min(number - 1))?));
                }
                let stride = match place.memory {
                    Memory::Variable(_) => scalars,
                    Memory::Block(_) => words,
                };
                let offset = self.clamped(index, number, stride);
                let offset = match place.dynamic {
                    Some(before) => self.binary(Binary::AddI, before, offset),
                    None => offset,
                };
                Ok(Value::Place(Place {
                    ty,
                    dynamic: Some(offset),
                    ..place
                }))
            }
            Value::Scalars(registers) => {
                let (_, number, scalars, _) = self.elements(self.type_of(scope, base))?;
                let len = scalars as usize;
                if let Some(known) = known {
                    let start = known.min(number - 1) as usize * len;
                    return Ok(Value::Scalars(registers[start..start + len].into()));
                }
                let index = self.clamped(index, number, 1);
                let picked = (0..len).map(|i| {
                    let of: Box<[Reg]> = registers.iter().copied().skip(i).step_by(len).collect();
                    let mut from = of.to_vec();
                    from.push(index);
                    self.pure(&from, |to| Op::Pick { to, of, index })
                });
                Ok(Value::Scalars(picked.collect::<Vec<_>>().into()))
            }
            _ => Err(self.missing("array of resources")),
        }
    }

    fn clamped(&mut self, index: Reg, number: u32, stride: u32) -> Reg {
        let last = self.constant(number - 1);
        let index = self.binary(Binary::MinU, index, last);
        if stride == 1 {
            return index;
        }
        let stride = self.constant(stride);
        self.binary(Binary::MulI, index, stride)
    }

    /// `is_kept` says whether what is read has to stay when the variable changes.
    fn load(&mut self, place: Place<'m>, is_kept: bool) -> Result<Rc<[Reg]>, Error> {
        let scalars = self.scalars(&place.ty)?;
        let loaded = (0..)
            .zip(scalars)
            .map(|(i, (_, word))| match (place.memory, place.dynamic) {
                (Memory::Variable(first), None) if !is_kept => first + place.offset + i,
                (Memory::Variable(first), None) => {
                    let to = self.register(Class::Value);
                    let from = first + place.offset + i;
                    self.op(Op::Copy { to, from });
                    to
                }
                (Memory::Variable(first), Some(offset)) => {
                    let to = self.register(Class::Value);
                    let first = first + place.offset + i;
                    self.op(Op::LoadAt { to, first, offset });
                    to
                }
                (Memory::Block(block), None) => self.word(block, place.offset + word),
                (Memory::Block(block), Some(offset)) => {
                    let word = place.offset + word;
                    self.pure(&[offset], |to| Op::WordAt {
                        to,
                        block,
                        word,
                        offset,
                    })
                }
            });
        Ok(loaded.collect::<Vec<_>>().into())
    }

    // Arithmetic.

    fn converted(&mut self, a: Reg, from: ScalarKind, to: ScalarKind) -> Reg {
        use ScalarKind::{Bool, Float, Sint, Uint};
        let op = match (from, to) {
            (Sint, Float) => Unary::FloatOfSigned,
            (Uint, Float) => Unary::FloatOfUnsigned,
            (Bool, Float) => Unary::FloatOfBool,
            (Float, Sint) => Unary::SignedOfFloat,
            (Float, Uint) => Unary::UnsignedOfFloat,
            (Bool, Sint | Uint) => Unary::NumberOfBool,
            (Sint | Uint, Bool) => Unary::BoolOfNumber,
            (Float, Bool) => Unary::BoolOfFloat,
            _ => return a,
        };
        self.unary(op, a)
    }

    fn dot(&mut self, kind: ScalarKind, a: &[Reg], b: &[Reg]) -> Reg {
        let (add, mul) = match kind {
            ScalarKind::Float => (Binary::AddF, Binary::MulF),
            _ => (Binary::AddI, Binary::MulI),
        };
        let mut sum = self.binary(mul, a[0], b[0]);
        for (a, b) in a.iter().zip(b).skip(1) {
            let product = self.binary(mul, *a, *b);
            sum = self.binary(add, sum, product);
        }
        sum
    }

    fn binary_expression(
        &mut self,
        scope: &mut Scope<'m>,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, Error> {
        let kind = self.kind_of(scope, left)?;
        let (a_type, b_type) = (self.type_of(scope, left), self.type_of(scope, right));
        let a = self.scalars_of(scope, left)?;
        let b = self.scalars_of(scope, right)?;
        if op == BinaryOperator::Multiply {
            // The columns of a matrix lie one after another.
            match (a_type, b_type) {
                (
                    TypeInner::Matrix { rows, .. },
                    TypeInner::Vector { .. } | TypeInner::Matrix { .. },
                ) => {
                    let rows = *rows as usize;
                    let inner = a.len() / rows;
                    return Ok(b
                        .chunks(inner)
                        .flat_map(|column| {
                            (0..rows)
                                .map(|row| {
                                    let row: Vec<_> =
                                        a.iter().copied().skip(row).step_by(rows).collect();
                                    self.dot(kind, &row, column)
                                })
                                .collect::<Vec<_>>()
                        })
                        .collect());
                }
                (TypeInner::Vector { .. }, TypeInner::Matrix { .. }) => {
                    return Ok(b
                        .chunks(a.len())
                        .map(|column| self.dot(kind, &a, column))
                        .collect());
                }
                _ => {}
            }
        }
        let len = a.len().max(b.len());
        (0..len)
            .map(|i| {
                let a = a[i.min(a.len() - 1)];
                let b = b[i.min(b.len() - 1)];
                self.binary_scalar(op, kind, a, b)
            })
            .collect()
    }

    fn binary_scalar(
        &mut self,
        op: BinaryOperator,
        kind: ScalarKind,
        a: Reg,
        b: Reg,
    ) -> Result<Reg, Error> {
        use BinaryOperator as B;
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
        let (op, a, b) = match op {
            B::Add => (of(Binary::AddF, Binary::AddI, Binary::AddI), a, b),
            B::Subtract => (of(Binary::SubF, Binary::SubI, Binary::SubI), a, b),
            B::Multiply => (of(Binary::MulF, Binary::MulI, Binary::MulI), a, b),
            B::Divide => (of(Binary::DivF, Binary::DivS, Binary::DivU), a, b),
            B::Modulo => (of(Binary::RemF, Binary::RemS, Binary::RemU), a, b),
            B::Equal => (of(Binary::EqF, Binary::EqI, Binary::EqI), a, b),
            B::NotEqual => (of(Binary::NeF, Binary::NeI, Binary::NeI), a, b),
            B::Less => (of(Binary::LtF, Binary::LtS, Binary::LtU), a, b),
            B::LessEqual => (of(Binary::LeF, Binary::LeS, Binary::LeU), a, b),
            B::Greater => (of(Binary::LtF, Binary::LtS, Binary::LtU), b, a),
            B::GreaterEqual => (of(Binary::LeF, Binary::LeS, Binary::LeU), b, a),
            B::And | B::LogicalAnd => (Binary::And, a, b),
            B::InclusiveOr | B::LogicalOr => (Binary::Or, a, b),
            B::ExclusiveOr => (Binary::Xor, a, b),
            B::ShiftLeft => (Binary::Shl, a, b),
            B::ShiftRight => (of(Binary::ShrU, Binary::ShrS, Binary::ShrU), a, b),
        };
        Ok(self.binary(op, a, b))
    }
}

/// Words between the columns of a matrix in a uniform block.
fn column_words(rows: VectorSize) -> u32 {
    match rows {
        VectorSize::Bi => 2,
        VectorSize::Tri | VectorSize::Quad => 4,
    }
}

/// Whether a function returns anywhere but at its end.
fn returns_early(body: &Block) -> bool {
    let mut returns = 0;
    each_statement(body, &mut |statement| {
        returns += usize::from(matches!(statement, Statement::Return { .. }));
    });
    let at_end = matches!(body.last(), Some(Statement::Return { .. }));
    returns > usize::from(at_end)
}

fn statement_name(statement: &Statement) -> &'static str {
    match statement {
        Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => "barrier",
        Statement::ImageStore { .. } => "write into a texture",
        Statement::Atomic { .. } | Statement::ImageAtomic { .. } => "atomic operation",
        Statement::WorkGroupUniformLoad { .. } => "workgroupUniformLoad",
        Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => "ray query",
        Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. } => "subgroup operation",
        _ => "statement of this kind",
    }
}

fn expression_name(expression: &Expression) -> &'static str {
    match expression {
        Expression::ArrayLength(_) => "arrayLength",
        Expression::AtomicResult { .. } => "atomic operation",
        Expression::Override(_) => "override",
        Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
            "subgroup operation"
        }
        _ => "expression of this kind",
    }
}
