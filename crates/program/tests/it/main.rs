//! What a Plan becomes for a program.

mod parameter_blocks;
