//! A linked program.

use crate::cost::Cost;
use crate::error::Error;
use crate::module::Module;
use std::sync::Arc;

/// The text of a program, and what a renderer has to know to run it.
#[derive(Debug)]
pub struct Program {
    wgsl: String,
    blocks: Vec<Block>,
    parameter_bytes: u32,
    /// Sorted by where they start.
    passages: Vec<Passage>,
    naga: naga::Module,
}

/// The parameters of one function in the uniform block of all.
#[derive(Clone, Debug)]
pub struct Block {
    /// The function's name in the program, such as `clip_ray_1`.
    pub label: String,
    pub(crate) type_name: String,
    /// The module.
    pub module: Arc<Module>,
    /// Where its struct begins in the uniform block, in bytes.
    pub offset: u32,
}

/// A piece of a module's text in the program.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    /// Byte in the program.
    pub start: usize,
    pub module: Arc<Module>,
    /// Byte in the module.
    pub from: usize,
}

/// A place in a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The module's file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
}

impl Program {
    pub(crate) fn new(
        wgsl: String,
        blocks: Vec<Block>,
        parameter_bytes: u32,
        passages: Vec<Passage>,
        naga: naga::Module,
    ) -> Program {
        Program {
            wgsl,
            blocks,
            parameter_bytes,
            passages,
            naga,
        }
    }

    /// The bindings of group 0 that it declares, ascending: see [`bindings`](crate::bindings).
    pub fn bindings(&self) -> Vec<u32> {
        let variables = self.naga.global_variables.iter();
        let bound = variables.filter_map(|(_, variable)| variable.binding.as_ref());
        let mut found: Vec<_> = bound.map(|b| b.binding).collect();
        found.sort_unstable();
        found
    }

    /// The text as naga understands it.
    pub fn naga(&self) -> &naga::Module {
        &self.naga
    }

    /// What it costs at most, per ray and per sample.
    pub fn cost(&self) -> Cost {
        Cost::of(&self.naga)
    }

    /// The text, made to be read, with a comment at each function.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// The parameter blocks, in the order of the uniform block.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The size of the uniform block of all parameters; 0 if there is none.
    pub fn parameter_bytes(&self) -> u32 {
        self.parameter_bytes
    }

    /// The bytes of the uniform block with every parameter at its default.
    pub fn default_parameters(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.parameter_bytes as usize];
        for block in &self.blocks {
            for parameter in block.module.parameters() {
                parameter.write(&parameter.default, &mut bytes[block.offset as usize..]);
            }
        }
        bytes
    }

    /// Writes a value into the bytes of the uniform block.
    ///
    /// # Errors
    /// [`Error::Parameter`]: no such function or parameter, or a value that it cannot take.
    ///
    /// # Panics
    /// If `bytes` is shorter than [`Program::parameter_bytes`].
    pub fn set(
        &self,
        bytes: &mut [u8],
        label: &str,
        parameter: &str,
        value: &[f64],
    ) -> Result<(), Error> {
        let wrong = |problem: String| Error::Parameter {
            module: label.to_owned(),
            parameter: parameter.to_owned(),
            problem,
        };
        let block = self.blocks.iter().find(|block| block.label == label);
        let block = block.ok_or_else(|| {
            let known: Vec<_> = self.blocks.iter().map(|b| b.label.as_str()).collect();
            wrong(format!(
                "cannot be set: no such function takes parameters; those that do are {}",
                known.join(", ")
            ))
        })?;
        let parameters = block.module.parameters();
        let found = parameters.iter().find(|p| p.name == parameter);
        let found = found.ok_or_else(|| {
            let known: Vec<_> = parameters.iter().map(|p| &*p.name).collect();
            wrong(format!("does not exist; there are {}", known.join(", ")))
        })?;
        found.check(value).map_err(wrong)?;
        found.write(value, &mut bytes[block.offset as usize..]);
        Ok(())
    }

    /// The place in a module that byte `at` of the program comes from; `None` for what the linker
    /// or the skeleton wrote.
    pub fn origin(&self, at: usize) -> Option<Origin> {
        let next = self.passages.partition_point(|p| p.start <= at);
        let passage = self.passages.get(next.checked_sub(1)?)?;
        let source = passage.module.source();
        let byte = passage.from + (at - passage.start);
        // Behind the last passage of a module comes text of the linker.
        let end = self.passages.get(next).map_or(self.wgsl.len(), |p| p.start);
        if byte >= source.len() && at < end {
            return None;
        }
        let before = source.get(..passage.from)?;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Some(Origin {
            file: passage.module.file().to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        })
    }
}
