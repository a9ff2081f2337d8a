//! Whether renderers keep docs/plan.md: against the truth, closed forms, and themselves.

mod agree;
mod cut_lattice;
mod evaluate;
mod extreme_volumes;
mod flat_regions;
mod formulas;
mod goldens;
mod gpu;
mod graph;
mod importance;
mod keys;
mod metamorphic;
mod orientation;
mod parameters;
mod plans_by_hand;
mod random;
mod same_bytes;
mod scene_segments;
mod segments;
mod sim;
mod simple;
mod techniques;
mod transmittance;
mod twins;
mod values;
mod variants;
