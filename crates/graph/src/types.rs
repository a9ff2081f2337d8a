//! Types and meanings of ports.

use std::fmt;

/// The type of a port: that of a value in WGSL.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// A number or truth, or a vector of 2 to 4 of them.
    Vector(Scalar, usize),
    /// One of the types that every function may use, or a function's own struct.
    Struct(&'static Struct),
    /// What a function's own struct is called; its members are ports of their own.
    Own(String),
    /// A texture that is handed to a function: `texture_2d<f32>`.
    Texture,
    /// Any other type of WGSL, which only equals itself.
    Other(String),
}

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scalar {
    /// 32-bit float.
    F32,
    /// 32-bit signed.
    I32,
    /// 32-bit unsigned.
    U32,
    /// Truth.
    Bool,
}

/// A struct of the prelude.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct Struct {
    name: &'static str,
    members: &'static [(&'static str, Type, Option<Meaning>)],
}

const fn vector(components: usize) -> Type {
    Type::Vector(Scalar::F32, components)
}

static STRUCTS: [Struct; 6] = [
    Struct {
        name: "Surface",
        members: &[
            ("color", vector(3), Some(Meaning::LinearColor)),
            ("opacity", vector(1), None),
        ],
    },
    Struct {
        name: "Light",
        members: &[
            ("direction", vector(3), Some(Meaning::Direction)),
            ("radiance", vector(3), Some(Meaning::LinearColor)),
        ],
    },
    Struct {
        name: "Ray",
        members: &[
            ("origin_mm", vector(3), Some(Meaning::WorldPosition)),
            ("direction", vector(3), Some(Meaning::Direction)),
        ],
    },
    Struct {
        name: "Sample",
        members: &[
            ("value", vector(1), Some(Meaning::Value)),
            ("lattice_point", vector(1), Some(Meaning::LatticePoint)),
            ("position", vector(3), Some(Meaning::VoxelPosition)),
            ("to_eye", vector(3), Some(Meaning::Direction)),
        ],
    },
    // What the scene's composite remembers along a ray; only the composite reads it.
    Struct {
        name: "CompositeState",
        members: &[],
    },
    // What the runs of a ray over segments add up to.
    Struct {
        name: "Runs",
        members: &[
            ("color", vector(4), None),
            ("weight", vector(1), None),
            ("number", vector(1), None),
        ],
    },
];

/// What the numbers of a port are, where it matters: two ports that both say it have to say the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Meaning {
    /// `position.voxel`: voxel centers are whole numbers.
    VoxelPosition,
    /// `position.world`: patient space, mm.
    WorldPosition,
    /// `position.texture`: 0 to 1 over the sampled extent.
    TexturePosition,
    /// `direction.world`: length 1 or 0.
    Direction,
    /// `gradient.per_mm`: world space, not normalized.
    Gradient,
    /// `color.linear`: not multiplied by the opacity.
    LinearColor,
    /// `color.premultiplied`.
    PremultipliedColor,
    /// `opacity.reference`: of the reference length.
    ReferenceOpacity,
    /// `opacity.step`: of one step.
    StepOpacity,
    /// `value`: of the data, rescaled.
    Value,
    /// `length.mm`: a length, or a distance along the ray.
    Length,
    /// `lattice_point`: number of the sample and its jitter.
    LatticePoint,
}

/// Meaning, how it is written, and nodes that make it of another meaning.
type MeaningRow = (Meaning, &'static str, &'static [(Meaning, &'static str)]);

const MEANINGS: [MeaningRow; 12] = [
    (
        Meaning::VoxelPosition,
        "position.voxel",
        &[
            (Meaning::WorldPosition, "voxel_from_world"),
            (Meaning::TexturePosition, "voxel_from_texture"),
        ],
    ),
    (
        Meaning::WorldPosition,
        "position.world",
        &[(Meaning::VoxelPosition, "world_from_voxel")],
    ),
    (
        Meaning::TexturePosition,
        "position.texture",
        &[(Meaning::VoxelPosition, "texture_from_voxel")],
    ),
    (
        Meaning::Direction,
        "direction.world",
        &[(Meaning::Gradient, "normal_of_gradient")],
    ),
    (Meaning::Gradient, "gradient.per_mm", &[]),
    (
        Meaning::LinearColor,
        "color.linear",
        &[(Meaning::PremultipliedColor, "unpremultiply")],
    ),
    (
        Meaning::PremultipliedColor,
        "color.premultiplied",
        &[(Meaning::LinearColor, "premultiply")],
    ),
    (Meaning::ReferenceOpacity, "opacity.reference", &[]),
    (
        Meaning::StepOpacity,
        "opacity.step",
        &[(Meaning::ReferenceOpacity, "step_opacity")],
    ),
    (Meaning::Value, "value", &[]),
    (
        Meaning::Length,
        "length.mm",
        &[(Meaning::LatticePoint, "distance")],
    ),
    (Meaning::LatticePoint, "lattice_point", &[]),
];

impl Meaning {
    /// What is written so.
    pub fn of(text: &str) -> Option<Meaning> {
        let found = MEANINGS.iter().find(|(_, name, _)| *name == text);
        found.map(|(meaning, ..)| *meaning)
    }

    /// The pattern that makes this of `other`.
    pub fn conversion_from(self, other: Meaning) -> Option<&'static str> {
        let (.., conversions) = MEANINGS.iter().find(|(meaning, ..)| *meaning == self)?;
        let found = conversions.iter().find(|(from, _)| *from == other);
        found.map(|(_, pattern)| *pattern)
    }

    /// All of them, as they are written.
    pub fn names() -> impl Iterator<Item = &'static str> {
        MEANINGS.iter().map(|(_, name, _)| *name)
    }
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = MEANINGS.iter().find(|(meaning, ..)| meaning == self);
        f.write_str(found.map_or("", |(_, name, _)| name))
    }
}

impl Type {
    /// Truth.
    pub const BOOL: Type = Type::Vector(Scalar::Bool, 1);

    /// The type that WGSL writes so; `own` are structs of the function that it belongs to.
    pub fn of(text: &str) -> Type {
        if let Some(found) = STRUCTS.iter().find(|s| s.name == text) {
            return Type::Struct(found);
        }
        let scalar = |text: &str| match text {
            "f32" | "f" => Some(Scalar::F32),
            "i32" | "i" => Some(Scalar::I32),
            "u32" | "u" => Some(Scalar::U32),
            "bool" | "<bool>" => Some(Scalar::Bool),
            "<f32>" => Some(Scalar::F32),
            "<i32>" => Some(Scalar::I32),
            "<u32>" => Some(Scalar::U32),
            _ => None,
        };
        if let Some(scalar) = scalar(text) {
            return Type::Vector(scalar, 1);
        }
        if let Some(rest) = text.strip_prefix("vec")
            && let Some((digit, kind)) = rest.split_at_checked(1)
            && let (Ok(n @ 2..=4), Some(scalar)) = (digit.parse(), scalar(kind))
        {
            return Type::Vector(scalar, n);
        }
        if text == "texture_2d<f32>" {
            return Type::Texture;
        }
        Type::Other(text.to_owned())
    }

    /// What `member` of a value of this type is: a member of a struct, components of a vector.
    pub fn member(&self, member: &str) -> Option<(Type, Option<Meaning>)> {
        match self {
            Type::Struct(of) => {
                let found = of.members.iter().find(|(name, ..)| *name == member);
                found.map(|(_, ty, meaning)| (ty.clone(), *meaning))
            }
            Type::Vector(scalar, n @ 2..) => {
                let is_of = |set: &str| member.chars().all(|c| set[..*n].contains(c));
                let fits = (1..=4).contains(&member.len()) && (is_of("xyzw") || is_of("rgba"));
                fits.then_some((Type::Vector(*scalar, member.len()), None))
            }
            _ => None,
        }
    }

    /// The names of its members, for messages.
    pub fn members(&self) -> Vec<&'static str> {
        match self {
            Type::Struct(of) => of.members.iter().map(|(name, ..)| *name).collect(),
            Type::Vector(_, n @ 2..) => ["x", "y", "z", "w"][..*n].to_vec(),
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Type::Vector(scalar, n) => {
                let (long, short) = match scalar {
                    Scalar::F32 => ("f32", "f"),
                    Scalar::I32 => ("i32", "i"),
                    Scalar::U32 => ("u32", "u"),
                    Scalar::Bool => ("bool", "<bool>"),
                };
                match n {
                    1 => f.write_str(long),
                    n => write!(f, "vec{n}{short}"),
                }
            }
            Type::Struct(of) => f.write_str(of.name),
            Type::Texture => f.write_str("texture_2d<f32>"),
            Type::Own(name) | Type::Other(name) => f.write_str(name),
        }
    }
}
