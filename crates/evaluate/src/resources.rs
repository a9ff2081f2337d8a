//! What a program reads: uniform blocks, textures and samplers.

use crate::error::Error;
use naga::{GlobalVariable, Handle, ImageClass, ImageDimension, Module, ScalarKind, TypeInner};
use std::borrow::Cow;
use strahl_volume::Samples;

/// What a program reads, by group and binding.
///
/// ```
/// use strahl_evaluate::{Numbers, Resource, Resources, Texture};
/// let ramp = Texture::new([4, 1, 1], 1, Numbers::F32(vec![0.0, 1.0, 2.0, 3.0].into()))?;
/// let resources = Resources::new()
///     .with(0, 0, Resource::Uniform(vec![0; 16]))
///     .with(0, 4, Resource::Texture(ramp));
/// # Ok::<(), strahl_evaluate::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Resources<'r> {
    bound: Vec<([u32; 2], Resource<'r>)>,
}

/// A resource.
#[derive(Clone, Debug)]
pub enum Resource<'r> {
    /// The bytes of a uniform block.
    Uniform(Vec<u8>),
    /// A texture of one level.
    Texture(Texture<'r>),
    /// How a texture is read between its texels.
    Sampler(Sampler),
}

/// A texture of one, two or three dimensions and one level, x fastest.
#[derive(Clone, Debug)]
pub struct Texture<'r> {
    dims: [u32; 3],
    channels: u32,
    numbers: Numbers<'r>,
}

/// The numbers of a texture, texel by texel.
#[derive(Clone, Debug)]
pub enum Numbers<'r> {
    /// For `texture_…<f32>`.
    F32(Cow<'r, [f32]>),
    /// For `texture_…<u32>`.
    U32(Cow<'r, [u32]>),
    /// For `texture_…<i32>`.
    I32(Cow<'r, [i32]>),
    /// Stored numbers of a volume, as they are, for `texture_…<f32>`.
    Stored(&'r Samples),
}

/// How a texture is read between its texels. Weights are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Between texels or at the nearest.
    pub filter: Filter,
    /// Beyond the edge.
    pub address: Address,
}

/// Between texels or at the nearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// At the nearest.
    Nearest,
    /// Between texels.
    #[default]
    Linear,
}

/// Beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Address {
    /// The texel at the edge goes on.
    #[default]
    ClampToEdge,
    /// The texture begins again.
    Repeat,
    /// It goes back and forth.
    MirrorRepeat,
}

impl<'r> Resources<'r> {
    /// Nothing.
    pub fn new() -> Resources<'r> {
        Resources::default()
    }

    /// The same with a resource more, in place of what was bound there.
    pub fn with(mut self, group: u32, binding: u32, resource: Resource<'r>) -> Resources<'r> {
        self.put(group, binding, resource);
        self
    }

    /// Binds a resource, in place of what was bound there.
    pub fn put(&mut self, group: u32, binding: u32, resource: Resource<'r>) {
        let place = [group, binding];
        match self.bound.iter_mut().find(|(at, _)| *at == place) {
            Some((_, bound)) => *bound = resource,
            None => self.bound.push((place, resource)),
        }
    }

    pub(crate) fn at(&self, index: u32) -> &Resource<'r> {
        &self.bound[index as usize].1
    }

    pub(crate) fn len(&self) -> usize {
        self.bound.len()
    }

    pub(crate) fn place(&self, group: u32, binding: u32) -> Option<usize> {
        self.bound
            .iter()
            .position(|(at, _)| *at == [group, binding])
    }

    /// The number of the resource that a variable of a module stands for.
    pub(crate) fn bound(
        &self,
        module: &Module,
        handle: Handle<GlobalVariable>,
    ) -> Result<u32, Error> {
        let variable = &module.global_variables[handle];
        let binding = variable.binding.unwrap_or(naga::ResourceBinding {
            group: u32::MAX,
            binding: u32::MAX,
        });
        let wrong = |problem: String| Error::Resource {
            name: variable.name.clone().unwrap_or_default(),
            group: binding.group,
            binding: binding.binding,
            problem,
        };
        let index = self.place(binding.group, binding.binding);
        let index = index.ok_or_else(|| wrong("nothing is bound there".into()))?;
        let ty = &module.types[variable.ty].inner;
        match (&self.bound[index].1, ty) {
            (Resource::Uniform(bytes), ty) if !is_handle(ty) => {
                let needs = ty.size(module.to_ctx()) as usize;
                if bytes.len() < needs {
                    return Err(wrong(format!(
                        "the block has {needs} bytes, {} are bound",
                        bytes.len()
                    )));
                }
            }
            (Resource::Sampler(_), TypeInner::Sampler { .. }) => {}
            (
                Resource::Texture(texture),
                TypeInner::Image {
                    dim,
                    class: ImageClass::Sampled { kind, .. },
                    ..
                },
            ) => {
                let own = match texture.numbers {
                    Numbers::F32(_) | Numbers::Stored(_) => ScalarKind::Float,
                    Numbers::U32(_) => ScalarKind::Uint,
                    Numbers::I32(_) => ScalarKind::Sint,
                };
                if own != *kind {
                    return Err(wrong(format!(
                        "the texture is of {kind:?} numbers, {own:?} are bound"
                    )));
                }
                let [_, height, depth] = texture.dims;
                let is_flat = match dim {
                    ImageDimension::D1 => height == 1 && depth == 1,
                    ImageDimension::D2 => depth == 1,
                    _ => true,
                };
                if !is_flat {
                    return Err(wrong(format!(
                        "the texture is {dim:?}, one of {:?} texels is bound",
                        texture.dims
                    )));
                }
            }
            (_, ty) => return Err(wrong(format!("what is bound there is no {}", kind(ty)))),
        }
        Ok(index as u32)
    }
}

fn is_handle(ty: &TypeInner) -> bool {
    matches!(ty, TypeInner::Image { .. } | TypeInner::Sampler { .. })
}

fn kind(ty: &TypeInner) -> &'static str {
    match ty {
        TypeInner::Image { .. } => "texture of this kind",
        TypeInner::Sampler { .. } => "sampler",
        _ => "uniform block",
    }
}

impl<'r> Texture<'r> {
    /// `dims` texels (1 along what it does not have) of `channels` numbers.
    ///
    /// # Errors
    /// The numbers are not as many as the texels need, or the channels not 1 to 4.
    pub fn new(dims: [u32; 3], channels: u32, numbers: Numbers<'r>) -> Result<Texture<'r>, Error> {
        let given = match &numbers {
            Numbers::F32(numbers) => numbers.len(),
            Numbers::U32(numbers) => numbers.len(),
            Numbers::I32(numbers) => numbers.len(),
            Numbers::Stored(samples) => samples.len(),
        };
        let texels = dims.iter().map(|n| u64::from(*n)).product::<u64>();
        if !(1..=4).contains(&channels)
            || texels * u64::from(channels) != given as u64
            || texels == 0
        {
            return Err(Error::Texture {
                dims,
                channels,
                given,
            });
        }
        Ok(Texture {
            dims,
            channels,
            numbers,
        })
    }

    /// Texels along each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    pub(crate) fn channels(&self) -> u32 {
        self.channels
    }

    pub(crate) fn numbers(&self) -> &Numbers<'r> {
        &self.numbers
    }
}
