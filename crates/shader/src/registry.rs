//! The registry: every function of the library, as `library/registry.txt` and the WGSL texts say. `build.rs` makes from
//! them the table [`FUNCTIONS`], the enums of the Plan (a variant per function, its parameters as fields), and the macro
//! [`for_each_function`](crate::for_each_function) for whatever else has a piece of code per function.

use crate::error::Error;
use crate::parameter::{Parameter, ParameterRelation, Scalar};
use crate::slot::SLOTS;
use std::borrow::Cow;

include!(concat!(env!("OUT_DIR"), "/registry.rs"));

/// A function of the library. All of it is known without reading WGSL.
#[derive(Debug)]
pub struct Function {
    /// The name of its slot.
    pub slot: &'static str,
    /// Its name, and that of its files.
    pub name: &'static str,
    /// The name in scenes: with `-` for `_`.
    pub word: &'static str,
    /// Older names, which are still accepted.
    pub was: &'static [&'static str],
    /// Whether the text is its own.
    pub has_text: bool,
    /// The function that this one is only another way to run.
    pub is_way_of: Option<&'static str>,
    /// The WGSL text.
    pub text: &'static str,
    /// What it does.
    pub meaning: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// A composite: which bricks it can leave out.
    pub skips: Skips,
    /// A composite: whether it asks for the looks of samples, not for values.
    pub adds_looks: bool,
    /// A composite: whether several layers can be drawn by it.
    pub mixes_layers: bool,
    /// A composite: whether one number of a ray makes the pixel.
    pub keeps_one_number: bool,
    /// A composite: whether what it shows has a place, so that it can be lit.
    pub has_place: bool,
}

/// Which bricks a composite can leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Skips {
    /// None.
    Nothing,
    /// Those in which the classification shows nothing.
    Clear,
    /// It depends on the values of its parameters: `strahl_scene::visibility` knows.
    Own,
}

impl Function {
    /// The function `name` of a slot: by its name or an older one, with `-` for `_` if so wanted.
    pub fn find(slot: &str, name: &str) -> Option<&'static Function> {
        let name = name.replace('-', "_");
        let own = Function::of_slot(slot);
        own.into_iter()
            .find(|f| f.name == name || f.was.contains(&name.as_str()))
    }

    /// The same, with a message.
    ///
    /// # Errors
    /// [`Error::Unknown`], with what there is.
    pub fn named(slot: &str, name: &str) -> Result<&'static Function, Error> {
        Function::find(slot, name).ok_or_else(|| Error::Unknown {
            slot: slot.to_owned(),
            name: name.to_owned(),
            known: match SLOTS.iter().find(|s| s.name == slot) {
                Some(slot) => format!(
                    "{} has {}",
                    slot.name,
                    Function::names(slot.name).join(", ")
                ),
                None => {
                    let slots: Vec<_> = SLOTS.iter().map(|slot| slot.name).collect();
                    format!("the slots are {}", slots.join(", "))
                }
            },
        })
    }

    /// The names of the functions of a slot.
    pub fn names(slot: &str) -> Vec<&'static str> {
        Function::of_slot(slot).map(|f| f.name).collect()
    }

    /// The functions of a slot.
    pub fn of_slot(slot: &str) -> impl Iterator<Item = &'static Function> {
        FUNCTIONS.iter().filter(move |f| f.slot == slot)
    }

    /// The parameter `name`.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// The first number of the default of a parameter; 0 if there is none of this name.
    pub fn default_of(&self, parameter: &str) -> f64 {
        let found = self.parameter(parameter);
        found
            .and_then(|p| p.default.first())
            .copied()
            .unwrap_or(0.0)
    }
}

/// Composite rules by which several layers can be drawn, as scenes call them: `one, two or three`.
pub fn mixing_rules() -> String {
    let mixing: Vec<_> = Function::of_slot("composite")
        .filter(|function| function.mixes_layers)
        .map(|function| function.word)
        .collect();
    match &mixing[..] {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        few => few.concat(),
    }
}

impl Composite {
    /// Whether a run of samples of one segment can become one sample by it.
    pub fn is_local(self) -> bool {
        !matches!(self, Composite::BackToFront | Composite::Debug(_))
    }

    /// Whether several layers can be drawn by it: it adds up looks of samples, not values.
    pub fn mixes_layers(self) -> bool {
        self.function().mixes_layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_as_they_are_were_and_are_written_in_scenes() {
        for (name, now) in [
            ("emission_absorption", "emission_absorption"),
            ("emission-absorption", "emission_absorption"),
            ("front_to_back", "emission_absorption"),
            ("maximum", "mip"),
            ("minimum", "minip"),
            ("gradient_maximum", "gmip"),
            ("normal_raw", "gradient_raw"),
            ("hit_depth", "depth"),
        ] {
            let found = Function::find("composite", name).map(|f| f.name);
            assert_eq!(found, Some(now), "{name}");
        }
        assert_eq!(Function::find("fetch", "texture").unwrap().name, "stored");
        assert!(Function::find("fetch", "maximum").is_none());
    }

    #[test]
    fn no_name_of_a_slot_means_two_functions() {
        for function in &FUNCTIONS {
            for name in function.was.iter().chain([&function.name]) {
                let same = Function::of_slot(function.slot)
                    .filter(|f| f.name == *name || f.was.contains(name));
                assert_eq!(same.count(), 1, "{}/{name}", function.slot);
            }
        }
    }

    #[test]
    fn variants_and_functions_go_both_ways() {
        for function in Function::of_slot("composite") {
            let value = |name: &str| function.default_of(name);
            let composite = Composite::of(function.name, value).unwrap();
            assert_eq!(composite.function().name, function.name);
            for (name, found) in composite.values() {
                assert_eq!(found as f32, function.default_of(name) as f32, "{name}");
            }
            assert_eq!(composite.values().len(), function.parameters.len());
        }
        assert_eq!(Illuminate::of("mip", |_| 0.0), None);
    }
}
