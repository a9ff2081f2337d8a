//! NumPy `.npy`, version 1.0: an array of shape (z, y, x) in C order.
//!
//! | offset | bytes  | content                                                   |
//! |--------|--------|-----------------------------------------------------------|
//! | 0      | 6      | 93 `NUMPY`                                                |
//! | 6      | 2      | version 1, 0                                              |
//! | 8      | u16 LE | length of the text, which is padded so that samples begin at a multiple of 64 |
//! | 10     |        | `{'descr': '<i2', 'fortran_order': False, 'shape': (z, y, x), }`, blanks, line break |

use super::raw::{self, Packing};
use super::voxels::Voxels;
use crate::SampleType;
use crate::error::Error;
use std::io::Write;

pub(crate) fn write(voxels: &Voxels, out: &mut dyn Write) -> Result<(), Error> {
    let descr = match raw::value_type_of(voxels.all) {
        SampleType::U8 => "|u1",
        SampleType::I8 => "|i1",
        SampleType::U16 => "<u2",
        SampleType::I16 => "<i2",
        SampleType::U32 => "<u4",
        SampleType::I32 => "<i4",
        SampleType::F32 => "<f4",
        SampleType::F64 => "<f8",
    };
    let [nx, ny, nz] = voxels.first.grid().dims();
    let mut text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    // At most some 130 bytes.
    out.write_all(&(text.len() as u16).to_le_bytes())?;
    out.write_all(text.as_bytes())?;
    raw::write_values(voxels, Packing::None, out)
}
