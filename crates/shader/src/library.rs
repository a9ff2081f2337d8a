//! The functions that come with Strahl, each a file `library/SLOT/NAME.wgsl`.

use crate::error::Error;
use crate::module::Module;
use crate::slot::{SLOTS, Slot};
use std::sync::{Arc, LazyLock};

macro_rules! texts {
    ($($slot:literal: $($name:literal),+;)+) => {
        &[$($(($slot, $name, include_str!(concat!("../library/", $slot, "/", $name, ".wgsl")))),+),+]
    };
}

/// Slot, name, text.
static TEXTS: &[(&str, &str, &str)] = texts! {
    "clip_ray": "plane", "depth";
    "jitter": "hash", "sine_hash", "tile";
    "clip_sample": "box", "ellipsoid", "cylinder", "mask";
    "fetch": "texture", "marschner_lobb", "noise";
    "reconstruct": "nearest", "trilinear", "trilinear_sampler", "catmull_rom", "b_spline", "b_spline_sampler";
    "classify": "identity", "threshold", "table", "gradient_table", "pre_classified";
    "gradient_input": "value", "opacity";
    "gradient": "forward", "backward", "central", "central_9", "sobel", "b_spline";
    "light": "directional", "head", "point";
    "illuminate": "lambert", "phong", "blinn_phong", "cook_torrance";
    "shade": "lit", "lit_last_normal", "gradient_opacity";
    "composite": "front_to_back", "maximum", "minimum", "average", "first_hit", "mida", "gradient_maximum",
        "back_to_front", "entry", "exit", "normal", "normal_raw", "gradient_magnitude", "sample_count", "hit_depth";
};

static LIBRARY: LazyLock<Vec<Arc<Module>>> = LazyLock::new(|| {
    let parse = |&(slot, name, text): &(&str, &str, &str)| {
        let file = format!("library/{slot}/{name}.wgsl");
        match Module::built_in(name, &file, text) {
            Ok(module) => Arc::new(module),
            Err(error) => unreachable!("a test reads every built-in module: {error}"),
        }
    };
    TEXTS.iter().map(parse).collect()
});

/// Every function of the library, by slot.
pub fn library() -> &'static [Arc<Module>] {
    &LIBRARY
}

/// The function `name` of the slot `slot`.
///
/// # Errors
/// [`Error::Unknown`], with what there is.
pub fn built_in(slot: &str, name: &str) -> Result<Arc<Module>, Error> {
    let found = library()
        .iter()
        .find(|module| module.slot().name == slot && module.name() == name);
    found.cloned().ok_or_else(|| Error::Unknown {
        slot: slot.to_owned(),
        name: name.to_owned(),
        known: match SLOTS.iter().find(|s| s.name == slot) {
            Some(slot) => format!("{} has {}", slot.name, names(slot).join(", ")),
            None => {
                let slots: Vec<_> = SLOTS.iter().map(|slot| slot.name).collect();
                format!("the slots are {}", slots.join(", "))
            }
        },
    })
}

/// The names of the library's functions for a slot.
pub(crate) fn names(slot: &Slot) -> Vec<&'static str> {
    TEXTS
        .iter()
        .filter(|(of, ..)| *of == slot.name)
        .map(|(_, name, _)| *name)
        .collect()
}
