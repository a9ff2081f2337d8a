//! Tests of the crate from outside.

mod hostile;
mod library;
mod messages;
