//! The functions that come with Strahl, read: each a file `library/SLOT/NAME.wgsl`.

use crate::error::Error;
use crate::module::Module;
use crate::registry::{FUNCTIONS, Function};
use std::sync::{Arc, LazyLock};

static LIBRARY: LazyLock<Vec<Arc<Module>>> = LazyLock::new(|| {
    let parse = |function: &Function| {
        let Function { slot, name, .. } = function;
        let file = format!("library/{slot}/{name}.wgsl");
        match Module::built_in(name, &file, function.text) {
            Ok(module) => Arc::new(module),
            Err(error) => unreachable!("a test reads every built-in module: {error}"),
        }
    };
    FUNCTIONS.iter().filter(|f| f.has_text).map(parse).collect()
});

/// Every function of the library with a text of its own, by slot.
pub fn library() -> &'static [Arc<Module>] {
    &LIBRARY
}

/// The function `name` of the slot `slot`; older names and those of scenes do, too.
///
/// # Errors
/// [`Error::Unknown`], with what there is.
pub fn built_in(slot: &str, name: &str) -> Result<Arc<Module>, Error> {
    let function = Function::named(slot, name)?;
    let same =
        |module: &&Arc<Module>| module.slot().name == slot && module.source() == function.text;
    match library().iter().find(same) {
        Some(module) => Ok(module.clone()),
        None => unreachable!("the library has the text of every function"),
    }
}
