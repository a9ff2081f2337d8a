//! The ray loop that functions are linked into.
//!
//! Its text does not change with the functions but with what is drawn: how many objects there are, how
//! many volumes they show, and how the textures of those are read. One object has a loop of its own,
//! which knows nothing of others.

use crate::error::Error;
use crate::limits::{MOST_MASKS, MOST_OBJECTS};
use crate::module::{Module, PRELUDE};
use crate::slot::{SLOTS, SUPPLIED};
use crate::token::tokens;
use std::collections::HashSet;
use std::fmt::Write;
use std::sync::{Arc, LazyLock};

/// The part of a program that is not exchanged: the ray loop, its resources and entry points. It
/// defines the functions of [`SUPPLIED`] but `lighting`, and calls those of slots.
/// [`ray_loop`] makes it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Skeleton {
    /// What it is called, in comments.
    pub name: String,
    /// What is in every program. The uniform block of the parameters is bound by the linker at group 0,
    /// binding [`PARAMETERS`](bindings::PARAMETERS).
    pub wgsl: Arc<str>,
    /// Texts that are put in if one of the functions that they define is called.
    pub parts: Vec<Arc<str>>,
    /// The order of the samples, from the eye and towards it: the second is put in if the composite
    /// is [back to front](Module::is_back_to_front), the first else.
    pub orders: [Arc<str>; 2],
    /// Functions that it brings itself, each under the name by which it calls it: the nodes of a graph.
    pub functions: Vec<(String, Arc<Module>)>,
    /// How many objects it draws. Several are drawn only by a composite that calls `look`, which
    /// mixes them.
    pub objects: usize,
}

/// How the texture of a volume is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Texels {
    /// `texture_3d<f32>` that the texture unit interpolates: 16-bit float, 8- and 16-bit unorm, and
    /// 32-bit float where the adapter can.
    Float,
    /// `texture_3d<f32>` that it does not: 32-bit float on many adapters.
    UnfilterableFloat,
    /// `texture_3d<u32>`.
    Unsigned,
    /// `texture_3d<i32>`.
    Signed,
    /// An atlas of pages in a `texture_3d<f32>`: a volume beyond the largest texture. [`PAGE_VOXELS`].
    FloatPages,
    /// An atlas in a `texture_3d<u32>`.
    UnsignedPages,
    /// An atlas in a `texture_3d<i32>`.
    SignedPages,
}

impl Texels {
    /// Whether the texture is an atlas of pages.
    pub fn is_paged(self) -> bool {
        matches!(
            self,
            Texels::FloatPages | Texels::UnsignedPages | Texels::SignedPages
        )
    }

    /// The type of the texture's components.
    fn component(self) -> &'static str {
        match self {
            Texels::Float | Texels::UnfilterableFloat | Texels::FloatPages => "f32",
            Texels::Unsigned | Texels::UnsignedPages => "u32",
            Texels::Signed | Texels::SignedPages => "i32",
        }
    }
}

/// What is drawn, as far as the text of the ray loop depends on it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct RayLoop {
    /// The textures, 1 to [`MOST_OBJECTS`].
    pub volumes: Vec<Texels>,
    /// Objects, 1 to [`MOST_OBJECTS`]; each shows one of the volumes, and several may show the same.
    pub objects: usize,
    /// Whether opaque geometry is behind the volumes, and not only the background.
    pub is_before_geometry: bool,
    /// Of what the functions that are drawn by depend.
    pub techniques: Techniques,
    /// Whether every value is known to be finite, so that nothing has to be checked: volumes of whole
    /// numbers, and only functions of the library.
    pub is_finite: bool,
    /// Whether runs of segments have the importance of their places, too.
    pub has_important_places: bool,
}

/// On what it depends by which technique a sample is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Techniques {
    /// There is one, but for the table, of which each object has its own.
    One,
    /// Each object has its own: technique number n is that of object n.
    OfObjects,
    /// Each segment of the one object has its own: technique number n + 1 is the Plan's n, number 0 says how
    /// segments are found.
    OfSegments,
}

/// Edge of a page of a paged volume, in voxels. Pages lie side by side without overlap.
pub const PAGE_VOXELS: u32 = 32;

/// Entries in a row of the transfer tables' texture.
pub const TABLE_ROW: u32 = 4096;

/// What the ray loop reports in the second target where nothing was hit, in mm.
pub const NOWHERE_MM: f32 = 3.0e38;

/// Where the resources of every program are bound, all in group 0 and for the fragment stage. A
/// program declares only those that it reads: [`Program::bindings`](crate::Program::bindings).
pub mod bindings {
    /// Uniform block `Frame`: camera, lattice and objects.
    pub const FRAME: u32 = 0;
    /// Uniform block `Parameters`: the parameters of all functions.
    pub const PARAMETERS: u32 = 1;
    /// Uniform block `ImportanceVolume`: where the importance volume lies and how it counts.
    pub const IMPORTANCE: u32 = 2;
    /// Sampler of the volumes that the texture unit interpolates: linear, clamped to the edge.
    pub const VOLUME_SAMPLER: u32 = 3;
    /// `texture_2d<f32>`, rgba: the transfer tables of all objects, in rows of
    /// [`TABLE_ROW`](crate::TABLE_ROW) entries. Each table begins at the start of a row.
    pub const TABLES: u32 = 4;
    /// `texture_3d<u32>`: per brick of [`BRICK_VOXELS`](crate::BRICK_VOXELS) an edge, 0 where nothing
    /// can be seen. The bricks of all objects, each from its `bricks_first` on.
    pub const BRICKS: u32 = 5;
    /// `texture_2d<f32>`: numbers from 0 to 1 for jitter, repeated over the picture.
    pub const NOISE_TILE: u32 = 6;
    /// `texture_2d<f32>`: how far along each pixel's ray opaque geometry lies, in mm from the ray's
    /// start; [`NOWHERE_MM`](crate::NOWHERE_MM) without. It covers the part that is drawn.
    pub const OPAQUE_MM: u32 = 7;
    /// `texture_3d<f32>`, [`MOST_MASKS`](crate::MOST_MASKS) of them from here on.
    pub const FIRST_MASK: u32 = 8;
    /// `texture_3d<u32>`, rg: the page tables of all paged volumes, each from the `pages_first` of the
    /// objects that show it on. x: column, row and slice of the page in the atlas, 10 bits each from
    /// the lowest; with bit 31 set the page is in no atlas, as all its texels are one number, whose
    /// float bits are y.
    pub const PAGES: u32 = 12;
    /// `texture_3d<u32>`: the number of each voxel's segment in the label volume.
    pub const LABELS: u32 = 14;
    /// `texture_2d<u32>`, rows of [`TABLE_ROW`](crate::TABLE_ROW) entries, seven for each segment: which technique
    /// draws it, 0 if it is hidden; the bits of what the color and opacity of its runs are multiplied by, and of their
    /// importance; its group, 0 without.
    pub const SEGMENTS: u32 = 15;
    /// `texture_2d<f32>`, rgba: what is behind the volumes, opaque geometry before the background. It
    /// covers the part that is drawn.
    pub const OPAQUE_COLOR: u32 = 13;
    /// `texture_3d`, one for each volume from here on.
    pub const FIRST_VOLUME: u32 = 16;
    /// `texture_2d<f32>`, rgba: the textures of a graph, [`TEXTURES`] of them from here on.
    pub const FIRST_TEXTURE: u32 = 32;
    /// Textures of a graph.
    pub const TEXTURES: u32 = 8;
}

/// The ray loop over these objects. Entry points: `vertex` (three vertices, no buffers), `fragment`
/// (location 0: linear, premultiplied, with the background) and `fragment_with_depth` (also location
/// 1: how far away in mm what the composite reported with `report_hit` lies, [`NOWHERE_MM`] without).
///
/// # Errors
/// [`Error::Objects`]: none, or too many.
pub fn ray_loop(what: &RayLoop) -> Result<Skeleton, Error> {
    let march = if what.techniques == Techniques::OfSegments {
        concat!(
            include_str!("../skeleton/segments.wgsl"),
            "\n",
            include_str!("../skeleton/segments_loop.wgsl")
        )
    } else if what.objects == 1 {
        include_str!("../skeleton/one.wgsl")
    } else {
        include_str!("../skeleton/several.wgsl")
    };
    let march = format!("{march}\n{}", include_str!("../skeleton/entry.wgsl"));
    skeleton(what, "ray loop", &march)
}

/// As [`ray_loop`], with a loop of the caller's: `march` is WGSL that defines
/// `fn march(pixel: vec2u) -> vec4f` over the functions of `skeleton/graph.wgsl`, and calls `functions` by
/// their names. `entry` defines the entry points, if it has some of its own.
///
/// # Errors
/// As [`ray_loop`].
pub fn graph_loop(
    what: &RayLoop,
    march: &str,
    entry: Option<&str>,
    functions: Vec<(String, Arc<Module>)>,
) -> Result<Skeleton, Error> {
    let own = if what.techniques == Techniques::OfSegments {
        concat!(
            include_str!("../skeleton/segments.wgsl"),
            "\n",
            include_str!("../skeleton/graph_segments.wgsl"),
            "\n",
            include_str!("../skeleton/graph_line.wgsl")
        )
    } else if what.objects == 1 {
        concat!(
            include_str!("../skeleton/graph_one.wgsl"),
            "\n",
            include_str!("../skeleton/graph_line.wgsl")
        )
    } else {
        include_str!("../skeleton/graph_several.wgsl")
    };
    let entry = entry.unwrap_or(include_str!("../skeleton/entry.wgsl"));
    let wgsl = format!(
        "{own}\n{}\n{march}\n{entry}",
        include_str!("../skeleton/graph.wgsl")
    );
    Ok(Skeleton {
        functions,
        // The graph mixes its objects itself.
        objects: 1,
        ..skeleton(what, "graph", &wgsl)?
    })
}

/// Words that the surroundings of a graph use: whoever writes a `march` calls nothing of its own so.
pub fn surrounding_words() -> &'static HashSet<&'static str> {
    static WORDS: LazyLock<HashSet<&'static str>> = LazyLock::new(|| {
        let texts = [
            include_str!("../skeleton/ray.wgsl"),
            include_str!("../skeleton/technique.wgsl"),
            include_str!("../skeleton/technique_of_object.wgsl"),
            include_str!("../skeleton/entry.wgsl"),
            include_str!("../skeleton/graph.wgsl"),
            include_str!("../skeleton/graph_one.wgsl"),
            include_str!("../skeleton/graph_line.wgsl"),
            include_str!("../skeleton/graph_several.wgsl"),
            include_str!("../skeleton/segments.wgsl"),
            include_str!("../skeleton/graph_segments.wgsl"),
            include_str!("../skeleton/importance.wgsl"),
            include_str!("../skeleton/runs_by_place.wgsl"),
            include_str!("../skeleton/forwards.wgsl"),
            include_str!("../skeleton/tile.wgsl"),
            include_str!("../skeleton/opaque_mm.wgsl"),
            include_str!("../skeleton/pages.wgsl"),
            include_str!("../skeleton/texel.wgsl"),
            include_str!("../skeleton/linear_by_texels.wgsl"),
            include_str!("../skeleton/values_any.wgsl"),
            include_str!("../skeleton/behind_geometry.wgsl"),
            PRELUDE,
            "volume volume_sampler stored texel_linear parameters Parameters march lighting illuminate light select vertex_out VertexOut receive at out instance is_inside CompositeState looked_at composite_of_look composite_of_sample run_of_look run_of_sample",
        ];
        let mut words: HashSet<_> = texts
            .iter()
            .flat_map(|text| tokens(text).into_iter().map(|token| token.text(text)))
            .collect();
        let of_slots = SLOTS
            .iter()
            .flat_map(|slot| slot.functions)
            .chain(&SUPPLIED);
        words.extend(of_slots.map(|function| function.name));
        words
    });
    &WORDS
}

fn skeleton(what: &RayLoop, kind: &str, march: &str) -> Result<Skeleton, Error> {
    let RayLoop {
        volumes,
        objects,
        is_before_geometry,
        techniques,
        is_finite,
        has_important_places,
    } = what;
    for (what, number) in [("volumes", volumes.len()), ("objects", *objects)] {
        if !(1..=MOST_OBJECTS).contains(&number) {
            return Err(Error::Objects {
                what,
                number,
                most: MOST_OBJECTS,
            });
        }
    }
    let (number, one) = (objects, *objects == 1);
    let name = match (objects, volumes.len()) {
        (1, _) => format!("{kind} over one object"),
        (_, 1) => format!("{kind} over {number} objects of one volume"),
        (_, n) => format!("{kind} over {number} objects of {n} volumes"),
    };
    let mut wgsl = format!("const OBJECTS: u32 = {number}u;\n\n");
    wgsl.push_str(&textures(volumes));
    let loop_over_objects = format!("{}\n{march}", include_str!("../skeleton/ray.wgsl"));
    match techniques {
        Techniques::One => wgsl.push_str(&loop_over_objects),
        Techniques::OfObjects => {
            wgsl.push_str(&of_techniques(&loop_over_objects));
            wgsl.push_str(include_str!("../skeleton/technique.wgsl"));
            wgsl.push_str(include_str!("../skeleton/technique_of_object.wgsl"));
        }
        Techniques::OfSegments => {
            wgsl.push_str(&of_techniques(&loop_over_objects));
            wgsl.push_str(include_str!("../skeleton/technique.wgsl"));
        }
    }
    let gives_looks = ["composite_of_look(", "run_of_look("]
        .iter()
        .any(|call| march.contains(call));
    let look = if gives_looks {
        include_str!("../skeleton/look_of_nodes.wgsl")
    } else if one {
        include_str!("../skeleton/look_of_one.wgsl")
    } else {
        include_str!("../skeleton/look_of_several.wgsl")
    };
    let behind = if *is_before_geometry {
        include_str!("../skeleton/behind_geometry.wgsl")
    } else {
        include_str!("../skeleton/behind_nothing.wgsl")
    };
    let values = if *is_finite {
        include_str!("../skeleton/values_finite.wgsl")
    } else {
        include_str!("../skeleton/values_any.wgsl")
    };
    let mut parts: Vec<Arc<str>> = vec![
        look.into(),
        behind.into(),
        values.into(),
        include_str!("../skeleton/tile.wgsl").into(),
        include_str!("../skeleton/opaque_mm.wgsl").into(),
        masks().into(),
        include_str!("../skeleton/importance.wgsl").into(),
        match has_important_places {
            true => include_str!("../skeleton/runs_by_place.wgsl").into(),
            false => include_str!("../skeleton/runs_anywhere.wgsl").into(),
        },
        include_str!("../skeleton/table_2d.wgsl").into(),
        include_str!("../skeleton/texel.wgsl").into(),
        include_str!("../skeleton/linear_by_texels.wgsl").into(),
        include_str!("../skeleton/pages.wgsl").into(),
        include_str!("../skeleton/composite_of_look.wgsl").into(),
        include_str!("../skeleton/composite_of_sample.wgsl").into(),
        include_str!("../skeleton/run_of_look.wgsl").into(),
        include_str!("../skeleton/run_of_sample.wgsl").into(),
        stored(volumes).into(),
        texel_linear(volumes).into(),
    ];
    if *techniques != Techniques::OfSegments {
        parts.push(include_str!("../skeleton/membership_of_one.wgsl").into());
        parts.push(include_str!("../skeleton/covered_by_nothing.wgsl").into());
    }
    Ok(Skeleton {
        name,
        wgsl: wgsl.into(),
        parts,
        orders: [
            include_str!("../skeleton/forwards.wgsl").into(),
            include_str!("../skeleton/backwards.wgsl").into(),
        ],
        functions: Vec::new(),
        objects: *objects,
    })
}

/// The loop with what belongs to a technique, where it is that of an object in `text`, read from the
/// technique.
fn of_techniques(text: &str) -> String {
    let of_object = "frame.objects[object()]";
    let domain = "technique_numbers(0u).zw";
    text.replace(&format!("{of_object}.table_domain"), domain)
        .replace(
            &format!("{of_object}.table_entries"),
            "u32(technique_numbers(0u).y)",
        )
        .replace(
            &format!("{of_object}.steps_per_reference"),
            "technique_numbers(1u).x",
        )
        .replace(
            "frame.objects[current].table_first",
            "u32(technique_numbers(0u).x)",
        )
}

/// The textures of the volumes.
fn textures(volumes: &[Texels]) -> String {
    let mut text = String::new();
    for (i, texels) in volumes.iter().enumerate() {
        let binding = bindings::FIRST_VOLUME + i as u32;
        let (name, component) = (texture(volumes, i), texels.component());
        let _ = writeln!(
            text,
            "@group(0) @binding({binding}) var {name}: texture_3d<{component}>;"
        );
    }
    text.push('\n');
    text
}

/// The masks, and the functions that read them.
fn masks() -> String {
    let mut text = String::new();
    for i in 0..MOST_MASKS {
        let binding = bindings::FIRST_MASK + i as u32;
        let _ = writeln!(
            text,
            "@group(0) @binding({binding}) var mask_{i}: texture_3d<f32>;"
        );
    }
    let mut of_each = |signature: &str, read: &dyn Fn(usize) -> String| {
        let _ = write!(text, "\nfn {signature} {{\n    switch index {{\n");
        for i in 0..MOST_MASKS {
            let case = match i + 1 == MOST_MASKS {
                true => "default".to_owned(),
                false => format!("case {i}u"),
            };
            let _ = writeln!(text, "        {case}: {{ return {}; }}", read(i));
        }
        text.push_str("    }\n}\n");
    };
    of_each("mask_dims(index: u32) -> vec3i", &|i| {
        format!("vec3i(textureDimensions(mask_{i}))")
    });
    of_each("mask_texel(index: u32, voxel: vec3i) -> f32", &|i| {
        format!("textureLoad(mask_{i}, voxel, 0).r")
    });
    text.push('\n');
    text.push_str(include_str!("../skeleton/mask.wgsl"));
    text
}

/// The function that reads a texel of the volume that the object shows.
fn stored(volumes: &[Texels]) -> String {
    let mut text = "// The texel of a voxel inside the grid.\n".to_owned();
    text.push_str("fn stored(voxel: vec3i) -> f32 {\n");
    let read = |i: usize, indent: &str| {
        let name = texture(volumes, i);
        if volumes[i].is_paged() {
            format!(
                "{indent}let place = in_pages(voxel);\n\
                 {indent}if place.is_constant {{\n{indent}    return place.constant;\n{indent}}}\n\
                 {indent}return f32(textureLoad({name}, place.texel, 0).r);\n"
            )
        } else {
            format!("{indent}return f32(textureLoad({name}, voxel, 0).r);\n")
        }
    };
    text.push_str(&of_each(volumes, read));
    text.push_str("}\n");
    text
}

/// The function that reads between texels, by the texture unit where it can.
fn texel_linear(volumes: &[Texels]) -> String {
    let mut text = String::new();
    let is_filterable = |texels: &Texels| *texels == Texels::Float;
    if volumes.iter().any(is_filterable) {
        let _ = writeln!(
            text,
            "/// Linear between texels.\n@group(0) @binding({}) var volume_sampler: sampler;\n",
            bindings::VOLUME_SAMPLER
        );
    }
    text.push_str("fn texel_linear(position: vec3f) -> f32 {\n");
    let read = |i: usize, indent: &str| {
        if is_filterable(&volumes[i]) {
            let name = texture(volumes, i);
            format!(
                "{indent}let place = (position + 0.5) / vec3f(dims());\n\
                 {indent}let texel = textureSampleLevel({name}, volume_sampler, place, 0.0).r;\n\
                 {indent}return texel * frame.objects[object()].slope + frame.objects[object()].intercept;\n"
            )
        } else {
            format!("{indent}return linear_by_texels(position);\n")
        }
    };
    text.push_str(&of_each(volumes, read));
    text.push_str("}\n");
    text
}

/// What is read from one volume, or from the one of several that the object shows.
fn of_each(volumes: &[Texels], read: impl Fn(usize, &str) -> String) -> String {
    if volumes.len() == 1 {
        return read(0, "    ");
    }
    let mut text = "    switch frame.objects[object()].volume {\n".to_owned();
    for i in 0..volumes.len() {
        let case = if i + 1 == volumes.len() {
            "default".to_owned()
        } else {
            format!("case {i}u")
        };
        let _ = writeln!(text, "        {case}: {{");
        text.push_str(&read(i, "            "));
        text.push_str("        }\n");
    }
    text.push_str("    }\n");
    text
}

fn texture(volumes: &[Texels], i: usize) -> String {
    if volumes.len() == 1 {
        "volume".to_owned()
    } else {
        format!("volume_{i}")
    }
}
