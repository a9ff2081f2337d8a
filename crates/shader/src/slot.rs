//! The slots of the ray: the places at which a function can be exchanged, and what it has to look
//! like to stand there.

/// A place in the ray loop that holds a function, or several that are folded into one call.
#[derive(Debug)]
pub struct Slot {
    /// The name, also that of its (first) function.
    pub name: &'static str,
    /// What a function here is asked.
    pub meaning: &'static str,
    /// The functions that a module has to define to stand here.
    pub functions: &'static [Signature],
    /// How several functions become one call.
    pub fold: Fold,
    /// The body of the function that stands here when nobody says otherwise; the compiler removes
    /// it. Slots without one have to be filled if they are needed.
    pub null: Option<&'static str>,
}

/// What a function takes and gives, in the words of WGSL.
#[derive(Debug, PartialEq, Eq)]
pub struct Signature {
    /// The function's name.
    pub name: &'static str,
    /// Name and type of each argument. A module may use other names.
    pub arguments: &'static [(&'static str, &'static str)],
    /// The type of the result, empty for none. `State` is a struct that the module itself declares.
    pub result: &'static str,
}

/// How several functions of a slot become one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    /// There is only one.
    One,
    /// Each gets the result of the one before as its last argument.
    Chain,
    /// True if any is.
    Any,
    /// Each lights the surface, and the light adds up: the functions of `light` are called by the
    /// linked function `lighting`, each followed by `illuminate`.
    Lights,
}

const fn function(
    name: &'static str,
    arguments: &'static [(&'static str, &'static str)],
    result: &'static str,
) -> Signature {
    Signature {
        name,
        arguments,
        result,
    }
}

/// Every slot, in the order in which a ray meets them.
pub static SLOTS: [Slot; 13] = [
    Slot {
        name: "clip_ray",
        meaning: "shortens the interval of the ray (mm from its start) that is sampled at all; an end before the beginning leaves nothing",
        functions: &[function(
            "clip_ray",
            &[("ray", "Ray"), ("interval_mm", "vec2f")],
            "vec2f",
        )],
        fold: Fold::Chain,
        null: Some("return interval_mm;"),
    },
    Slot {
        name: "jitter",
        meaning: "where in its step the samples of a pixel's ray lie, in [0, 1); `frame` counts the pictures that are averaged",
        functions: &[function(
            "jitter",
            &[("pixel", "vec2u"), ("frame", "u32")],
            "f32",
        )],
        fold: Fold::One,
        null: Some("return 0.5;"),
    },
    Slot {
        name: "clip_sample",
        meaning: "whether the sample at a place in the world (mm) is dropped",
        functions: &[function("clip_sample", &[("place_mm", "vec3f")], "bool")],
        fold: Fold::Any,
        null: Some("return false;"),
    },
    Slot {
        name: "fetch",
        meaning: "the value of a voxel; indices beyond the border give the voxel at the border",
        functions: &[function("fetch", &[("voxel", "vec3i")], "f32")],
        fold: Fold::One,
        null: None,
    },
    Slot {
        name: "reconstruct",
        meaning: "the value at a position between voxels; voxel centres are whole numbers",
        functions: &[function("reconstruct", &[("position", "vec3f")], "f32")],
        fold: Fold::One,
        null: None,
    },
    Slot {
        name: "classify",
        meaning: "color and opacity of a value",
        functions: &[function(
            "classify",
            &[("value", "f32"), ("position", "vec3f")],
            "Surface",
        )],
        fold: Fold::One,
        null: None,
    },
    Slot {
        name: "gradient_input",
        meaning: "the field whose gradient is taken",
        functions: &[function("gradient_input", &[("position", "vec3f")], "f32")],
        fold: Fold::One,
        null: None,
    },
    Slot {
        name: "gradient",
        meaning: "the gradient in world space, per mm, not normalised",
        functions: &[function("gradient", &[("position", "vec3f")], "vec3f")],
        fold: Fold::One,
        null: Some("return vec3f(0.0);"),
    },
    Slot {
        name: "light",
        meaning: "direction and radiance of the light that reaches a place in the world (mm); `to_eye` is where the eye is",
        functions: &[function(
            "light",
            &[("place_mm", "vec3f"), ("to_eye", "vec3f")],
            "Light",
        )],
        fold: Fold::Lights,
        null: None,
    },
    Slot {
        name: "illuminate",
        meaning: "the light that a surface sends to the eye from one light, without ambient light; all vectors have length 1",
        functions: &[function(
            "illuminate",
            &[
                ("color", "vec3f"),
                ("normal", "vec3f"),
                ("to_eye", "vec3f"),
                ("light", "Light"),
            ],
            "vec3f",
        )],
        fold: Fold::One,
        null: Some("return vec3f(0.0);"),
    },
    Slot {
        name: "shade",
        meaning: "the look of a classified sample: its color under the lights, its opacity",
        functions: &[function(
            "shade",
            &[
                ("surface", "Surface"),
                ("position", "vec3f"),
                ("to_eye", "vec3f"),
            ],
            "Surface",
        )],
        fold: Fold::One,
        null: Some("return surface;"),
    },
    Slot {
        name: "illustrate",
        meaning: "what illustration makes of the color of a shaded sample",
        functions: &[function(
            "illustrate",
            &[
                ("color", "vec3f"),
                ("position", "vec3f"),
                ("to_eye", "vec3f"),
            ],
            "vec3f",
        )],
        fold: Fold::One,
        null: Some("return color;"),
    },
    Slot {
        name: "composite",
        meaning: "how the samples of a ray become a pixel: linear RGBA, premultiplied; `State` is the module's own struct",
        functions: &[
            function("composite_start", &[], "State"),
            function(
                "composite_add",
                &[("state", "State"), ("sample", "Sample")],
                "State",
            ),
            function("composite_done", &[("state", "State")], "bool"),
            function("composite_finish", &[("state", "State")], "vec4f"),
        ],
        fold: Fold::One,
        null: None,
    },
];

/// Functions that every module may call and no module replaces: the renderer or the linker
/// supplies them.
pub static SUPPLIED: [Signature; 29] = [
    function("object", &[], "u32"),
    function("dims", &[], "vec3i"),
    function("texel", &[("voxel", "vec3i")], "f32"),
    function("texel_linear", &[("position", "vec3f")], "f32"),
    function("table", &[("value", "f32")], "Surface"),
    function(
        "table_2d",
        &[("value", "f32"), ("share", "f32"), ("size", "vec2u")],
        "Surface",
    ),
    function("mask", &[("index", "u32"), ("place", "vec3f")], "f32"),
    function("tile", &[("pixel", "vec2u")], "f32"),
    function("opaque_mm", &[], "f32"),
    function("place_mm", &[("position", "vec3f")], "vec3f"),
    function("voxel_of", &[("place_mm", "vec3f")], "vec3f"),
    function("depth_mm", &[("position", "vec3f")], "f32"),
    function("step_mm", &[], "f32"),
    function("membership", &[("position", "vec3f")], "f32"),
    function("covered", &[], "f32"),
    function("importance_at", &[("position", "vec3f")], "f32"),
    function("in_camera", &[("v", "vec3f")], "vec3f"),
    function("table_domain", &[], "vec2f"),
    function(
        "gradient_per_mm",
        &[("gradient_per_voxel", "vec3f")],
        "vec3f",
    ),
    function(
        "above_rounding",
        &[("gradient_per_voxel", "vec3f"), ("largest", "vec3f")],
        "vec3f",
    ),
    function("opacity_of_step", &[("opacity", "f32")], "f32"),
    function("ray_position", &[("lattice_point", "f32")], "vec3f"),
    function("distance_mm", &[("lattice_point", "f32")], "f32"),
    function("report_hit", &[("lattice_point", "f32")], ""),
    function("look", &[("sample", "Sample")], "Surface"),
    function(
        "lighting",
        &[
            ("color", "vec3f"),
            ("normal", "vec3f"),
            ("position", "vec3f"),
            ("to_eye", "vec3f"),
        ],
        "vec3f",
    ),
    function("is_finite", &[("value", "f32")], "bool"),
    function("direction", &[("v", "vec3f")], "vec3f"),
    function("magnitude", &[("v", "vec3f")], "f32"),
];

/// The slot of this name.
pub fn slot(name: &str) -> Option<&'static Slot> {
    SLOTS.iter().find(|slot| slot.name == name)
}

impl PartialEq for Slot {
    fn eq(&self, other: &Slot) -> bool {
        self.name == other.name
    }
}

impl Eq for Slot {}

impl std::fmt::Display for Signature {
    /// As it is written in WGSL, without a body.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "fn {}(", self.name)?;
        for (i, (name, kind)) in self.arguments.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{name}: {kind}")?;
        }
        f.write_str(")")?;
        if self.result.is_empty() {
            return Ok(());
        }
        write!(f, " -> {}", self.result)
    }
}
