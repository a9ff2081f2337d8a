//! Which reads of variables need no copy.
//!
//! A value that was read has to stay when its variable changes. Within one run of expressions nothing
//! changes, so what is read and used up there can be taken from the variable's own registers.

use super::statements::each_statement;
use naga::{Expression, Function, Handle, MathFunction, Statement};

/// For every expression, whether its value may be needed after its own run of expressions.
pub fn outlive(function: &Function) -> Vec<bool> {
    let mut outlive = vec![false; function.expressions.len()];
    let mut run_of = vec![usize::MAX; function.expressions.len()];
    let mut runs = 0;
    each_statement(&function.body, &mut |statement| {
        let mut used = |handle: &Handle<Expression>| outlive[handle.index()] = true;
        match statement {
            Statement::Emit(range) => {
                runs += 1;
                for handle in range.clone() {
                    run_of[handle.index()] = runs;
                }
            }
            Statement::If { condition, .. } => used(condition),
            Statement::Switch { selector, .. } => used(selector),
            Statement::Loop { break_if, .. } => break_if.iter().for_each(used),
            Statement::Return { value } => value.iter().for_each(used),
            Statement::Store { pointer, value } => {
                used(pointer);
                used(value);
            }
            Statement::Call { arguments, .. } => arguments.iter().for_each(used),
            _ => {}
        }
    });
    let handles: Vec<_> = function.expressions.iter().collect();
    // Users come after what they use.
    for (handle, expression) in handles.into_iter().rev() {
        let is_kept = outlive[handle.index()] && hands_on(expression);
        operands(expression, &mut |operand| {
            let is_elsewhere = run_of[operand.index()] != run_of[handle.index()];
            outlive[operand.index()] |= is_kept || is_elsewhere;
        });
    }
    outlive
}

/// Whether registers of an operand may be among those of the value.
fn hands_on(expression: &Expression) -> bool {
    match expression {
        Expression::Unary { .. }
        | Expression::Binary { .. }
        | Expression::Select { .. }
        | Expression::Load { .. }
        | Expression::ImageLoad { .. }
        | Expression::ImageSample { .. } => false,
        Expression::Math { fun, .. } => matches!(
            fun,
            MathFunction::Abs | MathFunction::Transpose | MathFunction::Determinant
        ),
        _ => true,
    }
}

fn operands(expression: &Expression, f: &mut dyn FnMut(Handle<Expression>)) {
    match expression {
        Expression::Compose { components, .. } => components.iter().for_each(|c| f(*c)),
        Expression::Access { base, index } => {
            f(*base);
            f(*index);
        }
        Expression::AccessIndex { base, .. } => f(*base),
        Expression::Splat { value, .. } => f(*value),
        Expression::Swizzle { vector, .. } => f(*vector),
        Expression::Load { pointer } => f(*pointer),
        Expression::ImageSample { coordinate, .. } | Expression::ImageLoad { coordinate, .. } => {
            f(*coordinate);
        }
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => f(*expr),
        Expression::Binary { left, right, .. } => {
            f(*left);
            f(*right);
        }
        Expression::Select {
            condition,
            accept,
            reject,
        } => {
            f(*condition);
            f(*accept);
            f(*reject);
        }
        Expression::Relational { argument, .. } => f(*argument),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => {
            f(*arg);
            [arg1, arg2, arg3].into_iter().flatten().for_each(|a| f(*a));
        }
        // The others read no values, or are not covered.
        _ => {}
    }
}
