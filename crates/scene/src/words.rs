//! The words of scenes that choose a function of the library, made from its registry: what can be chosen, what it is
//! called and what it does are said there.

use crate::plan;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_shader::for_each_function;
use strahl_shader::registry::Function;

/// An enum of words: those that are given, which choose no function, then one per entry of the registry.
macro_rules! words {
    (
        $(#[$doc:meta])*
        $words:ident of $slot:literal, $a_word:literal
        { $($(#[$own_doc:meta])* $own:ident $own_word:literal,)* }
        $(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        pub enum $words {
            $($(#[$own_doc])* #[serde(rename = $own_word)] $own,)*
            $(#[doc = $meaning] #[serde(rename = $word)] $variant,)*
        }

        impl $words {
            /// Every one of them.
            pub const ALL: [$words; [$($own_word,)* $($word,)*].len()] =
                [$($words::$own,)* $($words::$variant,)*];

            /// The name used in scenes and on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $($words::$own => $own_word,)*
                    $($words::$variant => $word,)*
                }
            }

            /// The function that it chooses, if it chooses one.
            pub fn function(self) -> Option<&'static Function> {
                Function::find($slot, self.name())
            }
        }

        impl std::str::FromStr for $words {
            type Err = String;

            fn from_str(name: &str) -> Result<$words, String> {
                let mut all = $words::ALL.into_iter();
                all.find(|word| word.name() == name).ok_or_else(|| {
                    let names = $words::ALL.map($words::name).join(", ");
                    format!("{name:?} is not {}; known are {names}", $a_word)
                })
            }
        }
    };
}

/// Words that each are a variant of the Plan; what `value` gives are its parameters.
macro_rules! in_plan {
    ($words:ident -> $plan:ident
        $(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        impl $words {
            /// Its variant in the Plan, with the values that `value` gives for its parameters.
            pub(crate) fn plan(self, value: impl Fn(&str) -> f64) -> plan::$plan {
                match self {
                    $($words::$variant => plan::$plan::$variant {
                        $($field: value(stringify!($field)) as _),*
                    },)*
                }
            }
        }
    };
}

/// The same where no variant has a parameter.
macro_rules! same_in_plan {
    ($words:ident
        $(; $meaning:literal $variant:ident $name:ident $word:literal {})*) => {
        impl From<$words> for plan::$words {
            fn from(word: $words) -> plan::$words {
                match word {
                    $($words::$variant => plan::$words::$variant,)*
                }
            }
        }
    };
}

for_each_function! { Composite => in_plan! { Method -> Composite } }
for_each_function! { DebugView => in_plan! { DebugView -> DebugView } }
for_each_function! { GradientMethod => same_in_plan! { GradientMethod } }
for_each_function! { GradientInput => same_in_plan! { GradientInput } }
for_each_function! { Reconstruct => same_in_plan! { Reconstruct } }

for_each_function! { Composite => words! {
    /// The composite rule: how the samples of a ray become a pixel.
    Method of "composite", "a method" {}
} }

for_each_function! { DebugView => words! {
    /// A view of the rendering process. "The first sample" is the first one that is not
    /// transparent.
    DebugView of "composite", "a debug view" {}
} }

for_each_function! { GradientMethod => words! {
    /// An estimate of the gradient.
    GradientMethod of "gradient", "an estimate of the gradient" {}
} }

for_each_function! { GradientInput => words! {
    /// The input of the gradient.
    GradientInput of "gradient_input", "an input of the gradient" {}
} }

for_each_function! { Reconstruct => words! {
    /// Interpolation between voxels.
    Reconstruct of "reconstruct", "a reconstruction" {}
} }

for_each_function! { Illuminate => words! {
    /// A shading model.
    ShadingModel of "illuminate", "a shading model" {
        /// The color of the transfer function, unchanged.
        Unlit "unlit",
        /// The color as it is, the opacity by the gradient: borders stay, insides fade.
        GradientOpacity "gradient-opacity",
    }
} }

impl Method {
    /// Whether one number per ray makes the pixel; without a word about shading it is unlit then.
    pub fn is_projection(self) -> bool {
        self.function().is_some_and(|f| f.keeps_one_number)
    }

    /// Whether a run of samples of one segment can become one sample by it.
    pub fn is_local(self) -> bool {
        self.plan(|_| 0.0).is_local()
    }

    /// Whether its function has this parameter.
    pub(crate) fn has(self, parameter: &str) -> bool {
        self.function()
            .is_some_and(|f| f.parameter(parameter).is_some())
    }
}

impl ShadingModel {
    /// Whether light falls on surfaces.
    pub fn is_lit(self) -> bool {
        self.function().is_some()
    }

    /// Whether its function has this parameter.
    pub(crate) fn has(self, parameter: &str) -> bool {
        self.function()
            .is_some_and(|f| f.parameter(parameter).is_some())
    }

    /// What it does with one light; `None` where none falls.
    pub(crate) fn illuminate(self, value: impl Fn(&str) -> f64) -> Option<plan::Illuminate> {
        plan::Illuminate::of(self.function()?.name, value)
    }

    /// Those on which light falls, in words.
    pub(crate) fn lit() -> String {
        let lit: Vec<_> = (ShadingModel::ALL.into_iter())
            .filter(|model| model.is_lit())
            .map(ShadingModel::name)
            .collect();
        match &lit[..] {
            [] => String::new(),
            [one] => (*one).to_owned(),
            [others @ .., last] => format!("{} or {last}", others.join(", ")),
        }
    }
}
