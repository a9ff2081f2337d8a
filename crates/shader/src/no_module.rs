use crate::parameter::Parameter;
use crate::slot::Slot;

/// A checked shader function. There are none in builds without the feature `link`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Module {}

impl Module {
    /// The slot that it can stand in.
    pub fn slot(&self) -> &'static Slot {
        match *self {}
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        match *self {}
    }

    /// Its parameters, in the order of the struct.
    pub fn parameters(&self) -> &[Parameter] {
        match *self {}
    }
}
