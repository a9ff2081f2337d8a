//! OpenEXR in a build without it: told apart, and refused.

use super::Recipe;
use crate::Error;
use std::io::{Read, Seek, Write};
use strahl_scene::Image;

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const WHY: &str = "it is not part of this build; build with the feature `exr`";

pub(super) fn is_exr(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

pub(super) fn write(
    _image: &Image,
    _background: Option<[f32; 3]>,
    _depth_mm: Option<&[f32]>,
    _half: bool,
    _recipe: Option<&Recipe>,
    _out: impl Write + Seek,
) -> Result<(), Error> {
    Err(Error::not_written("EXR", WHY))
}

pub(super) fn read_recipe(_file: impl Read) -> Result<Option<Recipe>, Error> {
    Err(Error::not_read("EXR", WHY))
}
