//! Walking over the statements of a function.

use naga::{Block, Statement};

/// Calls `f` for every statement, however deep.
pub fn each_statement<'m>(block: &'m Block, f: &mut dyn FnMut(&'m Statement)) {
    for statement in block.iter() {
        f(statement);
        match statement {
            Statement::Block(block) => each_statement(block, f),
            Statement::If { accept, reject, .. } => {
                each_statement(accept, f);
                each_statement(reject, f);
            }
            Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| each_statement(&case.body, f));
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                each_statement(body, f);
                each_statement(continuing, f);
            }
            _ => {}
        }
    }
}
