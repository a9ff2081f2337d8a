//! Single functions against plain arithmetic.

mod control_flow;
mod math;
mod memory;
mod refusals;
mod textures;

use naga::Module;
use strahl_evaluate::{Machine, Resources, Results};

/// The module of a text.
pub fn parse(wgsl: &str) -> Module {
    naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(wgsl)))
}

/// Runs function `f` of a text.
pub fn call(wgsl: &str, arguments: &[&[u32]]) -> Results {
    let module = parse(wgsl);
    let machine = Machine::new(&module, Resources::new()).unwrap();
    let lanes = arguments.first().map_or(1, |a| a.len());
    let results = machine
        .call("f", lanes, arguments)
        .unwrap_or_else(|error| panic!("{error}\n{wgsl}"));
    assert!(!results.scalars.is_empty() && results.scalars.iter().all(|s| s.len() == lanes));
    results
}

/// The first scalar of the result of `f(u32) -> u32`, for numbers from 0.
pub fn of_numbers(wgsl: &str, numbers: u32) -> Vec<u32> {
    let arguments: Vec<u32> = (0..numbers).collect();
    call(wgsl, &[&arguments]).scalars.swap_remove(0)
}

/// Numbers of their bits.
pub fn floats(bits: &[u32]) -> Vec<f32> {
    bits.iter().map(|bits| f32::from_bits(*bits)).collect()
}

/// Bits of numbers.
pub fn bits(floats: &[f32]) -> Vec<u32> {
    floats.iter().map(|v| v.to_bits()).collect()
}
