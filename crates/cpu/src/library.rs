//! The functions of the slots: a folder per slot, a file per function.
//!
//! Each function is small, works on all lanes of a packet and knows nothing of the loop. A slot's
//! own module holds the choice between its functions, made once per packet step.

pub mod classify;
pub mod clip_ray;
pub mod clip_sample;
pub mod composite;
pub mod fetch;
pub mod gradient;
pub mod illuminate;
pub mod illustrate;
pub mod jitter;
pub mod light;
pub mod reconstruct;
pub mod shade;
