//! Programs made ready to run, function by function.

use crate::code::{Code, LANES, Lanes};
use crate::compile::compile;
use crate::error::Error;
use crate::resources::{Resource, Resources};
use crate::run::{MOST_OPERATIONS, Run, State};
use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{Binding, Function, Module, ScalarKind, ShaderStage, Type, TypeInner};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A module with what it reads, ready to run: any of its entry points and functions, any number of lanes.
///
/// ```
/// use strahl_evaluate::{Machine, Resources};
/// let module = naga::front::wgsl::parse_str("
///     @vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
///         return vec4f(f32(index & 1u), f32(index >> 1u), 0.0, 1.0);
///     }
/// ")?;
/// let machine = Machine::new(&module, Resources::new())?;
/// let results = machine.call("corner", 3, &[&[0, 1, 2]])?;
/// let x: Vec<f32> = results.scalars[0].iter().map(|bits| f32::from_bits(*bits)).collect();
/// assert_eq!(x, [0.0, 1.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Machine<'m> {
    module: &'m Module,
    info: ModuleInfo,
    resources: Resources<'m>,
    /// The words of each uniform block among the resources.
    blocks: Vec<Vec<u32>>,
    compiled: Mutex<HashMap<String, Arc<Code>>>,
    most_operations: u64,
}

/// What a call gives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Results {
    /// The bits of each scalar of the result, lane by lane, in the order of [`Machine::outputs`].
    pub scalars: Vec<Vec<u32>>,
    /// The lanes that were discarded: their results mean nothing.
    pub is_discarded: Vec<bool>,
}

/// A scalar that a function takes or gives. Vectors, matrices and structs are taken apart in the order
/// of their declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Argument and members, such as `corner.normal`; empty for a result that is no struct.
    pub name: String,
    /// Which scalar of them, from 0.
    pub part: u32,
    /// What an entry point's is bound to, with how it is to be interpolated.
    pub binding: Option<Binding>,
    /// How its bits are to be read; truth values are all bits or none.
    pub kind: ScalarKind,
}

impl<'m> Machine<'m> {
    /// Checks `module` and compiles its vertex and fragment entry points with what they read. Other
    /// functions are compiled when they are called.
    ///
    /// # Errors
    /// The module is not valid, does what is not covered, or reads what is not among `resources`.
    pub fn new(module: &'m Module, resources: Resources<'m>) -> Result<Machine<'m>, Error> {
        let machine = Machine::unprepared(module, resources)?;
        for entry in &module.entry_points {
            if matches!(entry.stage, ShaderStage::Vertex | ShaderStage::Fragment) {
                machine.code(&entry.name)?;
            }
        }
        Ok(machine)
    }

    /// The same with nothing compiled yet.
    pub(crate) fn unprepared(
        module: &'m Module,
        resources: Resources<'m>,
    ) -> Result<Machine<'m>, Error> {
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(module)
            .map_err(|error| Error::Invalid(error.into_inner().to_string()))?;
        let blocks = (0..resources.len() as u32)
            .map(|i| match resources.at(i) {
                Resource::Uniform(bytes) => words(bytes),
                _ => Vec::new(),
            })
            .collect();
        Ok(Machine {
            module,
            info,
            resources,
            blocks,
            compiled: Mutex::default(),
            most_operations: MOST_OPERATIONS,
        })
    }

    /// The same with another number of operations, each of 64 lanes at once, after which a call counts as endless;
    /// without, 2³⁰.
    #[must_use]
    pub fn with_most_operations(self, most_operations: u64) -> Machine<'m> {
        Machine {
            most_operations,
            ..self
        }
    }

    /// Changes the bytes of a uniform block; what else is bound, and what is compiled, stays.
    ///
    /// # Errors
    /// No block of this size is bound there.
    pub fn set_uniform(&mut self, group: u32, binding: u32, bytes: &[u8]) -> Result<(), Error> {
        let wrong = |problem: &str| Error::Resource {
            name: "a uniform block".into(),
            group,
            binding,
            problem: problem.into(),
        };
        let index = self.resources.place(group, binding);
        let index = index.ok_or_else(|| wrong("nothing is bound there"))?;
        let words = words(bytes);
        if !matches!(self.resources.at(index as u32), Resource::Uniform(_))
            || words.len() != self.blocks[index].len()
        {
            return Err(wrong("what is bound there is no block of this size"));
        }
        self.blocks[index] = words;
        Ok(())
    }

    pub(crate) fn has(&self, group: u32, binding: u32) -> bool {
        self.resources.place(group, binding).is_some()
    }

    fn function(&self, name: &str) -> Result<(&'m Function, &FunctionInfo), Error> {
        let entry_points = &self.module.entry_points;
        if let Some(index) = entry_points.iter().position(|entry| entry.name == name) {
            let function = &entry_points[index].function;
            return Ok((function, self.info.get_entry_point(index)));
        }
        let mut functions = self.module.functions.iter();
        let found = functions.find(|(_, function)| function.name.as_deref() == Some(name));
        if let Some((handle, function)) = found {
            return Ok((function, &self.info[handle]));
        }
        let entries = entry_points.iter().map(|entry| entry.name.as_str());
        let others = self.module.functions.iter();
        let others = others.filter_map(|(_, function)| function.name.as_deref());
        Err(Error::NoFunction {
            name: name.to_owned(),
            known: entries.chain(others).collect::<Vec<_>>().join(", "),
        })
    }

    pub(crate) fn code(&self, name: &str) -> Result<Arc<Code>, Error> {
        let compiled = || self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(code) = compiled().get(name) {
            return Ok(code.clone());
        }
        let (function, info) = self.function(name)?;
        let code = compile(
            self.module,
            &self.info,
            &self.resources,
            function,
            info,
            name,
        )?;
        let code = Arc::new(code);
        compiled().insert(name.to_owned(), code.clone());
        Ok(code)
    }

    pub(crate) fn prepared<'a>(&'a self, code: &'a Code) -> Run<'a> {
        Run::new(code, &self.resources, &self.blocks).bounded(self.most_operations)
    }

    /// What function `name` takes, scalar by scalar.
    ///
    /// # Errors
    /// There is no such function.
    pub fn inputs(&self, name: &str) -> Result<Vec<Component>, Error> {
        let mut components = Vec::new();
        for argument in &self.function(name)?.0.arguments {
            let ty = &self.module.types[argument.ty];
            let name = argument.name.clone().unwrap_or_default();
            self.add_components(ty, name, argument.binding.as_ref(), 0, &mut components);
        }
        Ok(components)
    }

    /// What function `name` gives, scalar by scalar.
    ///
    /// # Errors
    /// There is no such function.
    pub fn outputs(&self, name: &str) -> Result<Vec<Component>, Error> {
        let mut components = Vec::new();
        if let Some(result) = &self.function(name)?.0.result {
            let ty = &self.module.types[result.ty];
            self.add_components(
                ty,
                String::new(),
                result.binding.as_ref(),
                0,
                &mut components,
            );
        }
        Ok(components)
    }

    /// Gives the part behind the last.
    fn add_components(
        &self,
        ty: &Type,
        name: String,
        binding: Option<&Binding>,
        part: u32,
        components: &mut Vec<Component>,
    ) -> u32 {
        let mut add = |number: u32, kind| {
            components.extend((part..part + number).map(|part| Component {
                name: name.clone(),
                part,
                binding: binding.cloned(),
                kind,
            }));
            part + number
        };
        match &ty.inner {
            TypeInner::Scalar(scalar) => add(1, scalar.kind),
            TypeInner::Vector { size, scalar } => add(*size as u32, scalar.kind),
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => add(*columns as u32 * *rows as u32, scalar.kind),
            TypeInner::Array {
                base,
                size: naga::ArraySize::Constant(size),
                ..
            } => {
                let mut part = part;
                for _ in 0..size.get() {
                    let base = &self.module.types[*base];
                    part = self.add_components(base, name.clone(), binding, part, components);
                }
                part
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    let own = member.name.clone().unwrap_or_default();
                    let name = if name.is_empty() {
                        own
                    } else {
                        format!("{name}.{own}")
                    };
                    let binding = member.binding.as_ref();
                    let ty = &self.module.types[member.ty];
                    self.add_components(ty, name, binding, 0, components);
                }
                part
            }
            _ => part,
        }
    }

    /// Runs entry point or function `name` for as many `lanes`. `arguments` are the bits of every scalar
    /// that [`Machine::inputs`] lists, lane by lane.
    ///
    /// # Errors
    /// There is no such function, it does what is not covered, a loop of it does not end, or the arguments
    /// are not those of so many lanes.
    pub fn call(&self, name: &str, lanes: usize, arguments: &[&[u32]]) -> Result<Results, Error> {
        let code = self.code(name)?;
        let wrong = |given: String| Error::Arguments {
            function: name.to_owned(),
            takes: code.inputs.len(),
            given,
        };
        if arguments.len() != code.inputs.len() {
            return Err(wrong(arguments.len().to_string()));
        }
        if let Some(short) = arguments.iter().find(|a| a.len() != lanes) {
            return Err(wrong(format!("{} lanes of {lanes}", short.len())));
        }
        let run = self.prepared(&code);
        let mut state = State::new(&run);
        let mut results = Results {
            scalars: vec![Vec::with_capacity(lanes); code.outputs.len()],
            is_discarded: Vec::with_capacity(lanes),
        };
        for first in (0..lanes).step_by(LANES) {
            let number = LANES.min(lanes - first);
            let mut active = Lanes::NONE;
            active.0[..number].fill(!0);
            for (register, argument) in code.inputs.iter().zip(arguments) {
                let register = &mut state.registers[*register as usize];
                register.0[..number].copy_from_slice(&argument[first..first + number]);
            }
            let killed = state.run(active)?;
            for (scalar, register) in results.scalars.iter_mut().zip(&code.outputs) {
                scalar.extend_from_slice(&state.registers[*register as usize].0[..number]);
            }
            let discarded = killed.0[..number].iter().map(|lane| *lane != 0);
            results.is_discarded.extend(discarded);
        }
        Ok(results)
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    let word = |bytes: &[u8]| {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        u32::from_le_bytes(word)
    };
    bytes.chunks(4).map(word).collect()
}
