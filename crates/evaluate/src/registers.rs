//! Which register of the file holds which value.
//!
//! What nobody reads is dropped, and values that live one after another share a register, so that a
//! block's numbers stay in the nearest cache: M. Poletto and V. Sarkar (1999), "Linear scan register
//! allocation", over the program as it is written, with a loop as one long step for what comes from before it.

use crate::code::{Code, NOWHERE, Node, Op, Reg, Role};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The class of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The same in all lanes, from the prologue on.
    Uniform,
    /// Written once, read afterwards.
    Value,
    /// Written and read at any time.
    Variable,
}

/// Gives `code`, in which every value has a register of its own, as few as it needs.
pub fn allocate(mut code: Code, classes: &[Class]) -> Code {
    drop_unread(&mut code, classes);
    let mut map = vec![NOWHERE; classes.len()];
    let mut next: Reg = 0;
    // Uniform ones first, only those that are still there, then the variables in their order.
    let mut is_kept: Vec<bool> = classes.iter().map(|c| *c == Class::Variable).collect();
    for op in &mut code.prologue {
        op.registers(&mut |reg, _| is_kept[*reg as usize] = true);
    }
    for nodes in std::iter::once(&mut code.body).chain(&mut code.shared) {
        each_register(nodes, &mut |reg, _| is_kept[*reg as usize] = true);
    }
    code.constants.retain(|(reg, _)| is_kept[*reg as usize]);
    code.constants.sort_unstable();
    for class in [Class::Uniform, Class::Variable] {
        for (reg, place) in map.iter_mut().enumerate() {
            if classes[reg] == class && is_kept[reg] {
                *place = next;
                next += 1;
            }
        }
        if class == Class::Uniform {
            code.uniform_registers = next as usize;
        }
    }
    let Code { body, shared, .. } = &mut code;
    for nodes in std::iter::once(body).chain(shared) {
        next = place(&mut lives(nodes, classes), next, &mut map);
    }
    let mut renamed = |reg: &mut Reg, _| *reg = map[*reg as usize];
    for op in &mut code.prologue {
        op.registers(&mut renamed);
    }
    for nodes in std::iter::once(&mut code.body).chain(&mut code.shared) {
        each_register(nodes, &mut renamed);
    }
    for (reg, _) in &mut code.constants {
        renamed(reg, Role::Write);
    }
    for reg in code.inputs.iter_mut().chain(&mut code.outputs) {
        renamed(reg, Role::Read);
    }
    code.registers = next as usize;
    code
}

/// Calls `f` for every register, in the order of the program.
fn each_register(nodes: &mut [Node], f: &mut dyn FnMut(&mut Reg, Role)) {
    for node in nodes {
        match node {
            Node::Ops(ops) => ops.iter_mut().for_each(|op| op.registers(f)),
            Node::If {
                condition,
                accept,
                reject,
            } => {
                f(condition, Role::Read);
                each_register(accept, f);
                each_register(reject, f);
            }
            Node::Switch { selector, cases } => {
                f(selector, Role::Read);
                for case in cases {
                    each_register(&mut case.body, f);
                }
            }
            Node::Loop {
                body,
                continuing,
                break_if,
            } => {
                each_register(body, f);
                each_register(continuing, f);
                if let Some(condition) = break_if {
                    f(condition, Role::Read);
                }
            }
            Node::Function(body) => each_register(body, f),
            Node::Break | Node::Continue | Node::Return | Node::Kill | Node::Call(_) => {}
        }
    }
}

/// Drops operations whose results nobody reads.
fn drop_unread(code: &mut Code, classes: &[Class]) {
    let mut reads = vec![0usize; classes.len()];
    let mut count = |reg: &mut Reg, role| {
        if role == Role::Read {
            reads[*reg as usize] += 1;
        }
    };
    for op in &mut code.prologue {
        op.registers(&mut count);
    }
    for nodes in std::iter::once(&mut code.body).chain(&mut code.shared) {
        each_register(nodes, &mut count);
    }
    for nodes in std::iter::once(&mut code.body).chain(&mut code.shared) {
        drop_unread_of(nodes, classes, &mut reads);
    }
    drop_unread_ops(&mut code.prologue, classes, &mut reads);
}

fn drop_unread_of(nodes: &mut Vec<Node>, classes: &[Class], reads: &mut [usize]) {
    for node in nodes.iter_mut().rev() {
        match node {
            Node::Ops(ops) => drop_unread_ops(ops, classes, reads),
            Node::If { accept, reject, .. } => {
                drop_unread_of(reject, classes, reads);
                drop_unread_of(accept, classes, reads);
            }
            Node::Switch { cases, .. } => {
                for case in cases.iter_mut().rev() {
                    drop_unread_of(&mut case.body, classes, reads);
                }
            }
            Node::Loop {
                body, continuing, ..
            } => {
                drop_unread_of(continuing, classes, reads);
                drop_unread_of(body, classes, reads);
            }
            Node::Function(body) => drop_unread_of(body, classes, reads),
            Node::Break | Node::Continue | Node::Return | Node::Kill | Node::Call(_) => {}
        }
    }
    nodes.retain(|node| !matches!(node, Node::Ops(ops) if ops.is_empty()));
}

fn drop_unread_ops(ops: &mut Vec<Op>, classes: &[Class], reads: &mut [usize]) {
    let mut kept = Vec::with_capacity(ops.len());
    for mut op in ops.drain(..).rev() {
        if let Op::Texel { to, .. } | Op::Sample { to, .. } = &mut op {
            for to in to.iter_mut() {
                if *to != NOWHERE && reads[*to as usize] == 0 {
                    *to = NOWHERE;
                }
            }
        }
        let mut is_read = false;
        op.registers(&mut |reg, role| {
            let reg = *reg as usize;
            is_read |= role == Role::Write && (classes[reg] == Class::Variable || reads[reg] > 0);
        });
        if is_read {
            kept.push(op);
        } else {
            op.registers(&mut |reg, role| {
                if role == Role::Read {
                    reads[*reg as usize] -= 1;
                }
            });
        }
    }
    kept.reverse();
    *ops = kept;
}

/// From where to where a value lives.
#[derive(Clone, Copy)]
struct Life {
    reg: Reg,
    start: usize,
    end: usize,
}

/// The lives of the values of a body.
fn lives(nodes: &mut [Node], classes: &[Class]) -> Vec<Life> {
    let mut walk = Walk {
        classes,
        position: 0,
        lives: Vec::new(),
        life_of: vec![usize::MAX; classes.len()],
        loops: Vec::new(),
    };
    walk.nodes(nodes);
    walk.lives
}

struct Walk<'c> {
    classes: &'c [Class],
    position: usize,
    lives: Vec<Life>,
    /// Which life a register has.
    life_of: Vec<usize>,
    /// Of the loops around: where they begin, and what they read from before that.
    loops: Vec<(usize, Vec<usize>)>,
}

impl Walk<'_> {
    fn register(&mut self, reg: Reg, role: Role) {
        if self.classes[reg as usize] != Class::Value {
            return;
        }
        let mut life = self.life_of[reg as usize];
        if life == usize::MAX {
            debug_assert_eq!(
                role,
                Role::Write,
                "register {reg} is read before it is written"
            );
            life = self.lives.len();
            self.life_of[reg as usize] = life;
            self.lives.push(Life {
                reg,
                start: self.position,
                end: self.position,
            });
        }
        self.lives[life].end = self.position;
        let start = self.lives[life].start;
        if let Some((_, before)) = self.loops.iter_mut().find(|(begin, _)| *begin > start) {
            before.push(life);
        }
    }

    fn nodes(&mut self, nodes: &mut [Node]) {
        for node in nodes {
            self.position += 1;
            match node {
                Node::Ops(ops) => {
                    for op in ops {
                        self.position += 1;
                        op.registers(&mut |reg, role| self.register(*reg, role));
                    }
                }
                Node::If {
                    condition,
                    accept,
                    reject,
                } => {
                    self.register(*condition, Role::Read);
                    self.nodes(accept);
                    self.nodes(reject);
                }
                Node::Switch { selector, cases } => {
                    // The later cases look at it again.
                    let selector = *selector;
                    for case in cases {
                        self.register(selector, Role::Read);
                        self.nodes(&mut case.body);
                        self.position += 1;
                    }
                    self.register(selector, Role::Read);
                }
                Node::Loop {
                    body,
                    continuing,
                    break_if,
                } => {
                    self.loops.push((self.position, Vec::new()));
                    self.nodes(body);
                    self.nodes(continuing);
                    self.position += 1;
                    if let Some(condition) = break_if {
                        self.register(*condition, Role::Read);
                    }
                    if let Some((_, before)) = self.loops.pop() {
                        for life in before {
                            self.lives[life].end = self.position;
                        }
                    }
                }
                Node::Function(body) => self.nodes(body),
                Node::Break | Node::Continue | Node::Return | Node::Kill | Node::Call(_) => {}
            }
        }
    }
}

/// Places values from register `first` on; gives the register behind the last.
fn place(lives: &mut [Life], first: Reg, map: &mut [Reg]) -> Reg {
    lives.sort_by_key(|life| life.start);
    let mut next = first;
    let mut free: Vec<Reg> = Vec::new();
    let mut living: BinaryHeap<Reverse<(usize, Reg)>> = BinaryHeap::new();
    for life in lives.iter() {
        while let Some(Reverse((end, place))) = living.peek().copied() {
            if end >= life.start {
                break;
            }
            living.pop();
            free.push(place);
        }
        let place = free.pop().unwrap_or_else(|| {
            next += 1;
            next - 1
        });
        map[life.reg as usize] = place;
        living.push(Reverse((life.end, place)));
    }
    next
}
