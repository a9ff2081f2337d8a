//! What a program is compiled to: operations on registers that hold one number per lane.

/// Pixels, or vertices, that run side by side: a block of 8² pixels.
pub const LANES: usize = 64;

/// Pixels along an edge of a block.
pub const BLOCK: usize = 8;

/// The bits of one scalar per lane; a truth value has all bits or none.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Lanes(pub [u32; LANES]);

impl Lanes {
    pub const NONE: Lanes = Lanes([0; LANES]);
    pub const ALL: Lanes = Lanes([!0; LANES]);
}

/// A register: its place in the file of them.
pub type Reg = u32;

/// A result that nobody reads.
pub const NOWHERE: Reg = Reg::MAX;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    NegF,
    AbsF,
    Ceil,
    Floor,
    Round,
    Trunc,
    Fract,
    Sqrt,
    InverseSqrt,
    Saturate,
    SignF,
    NegI,
    AbsI,
    SignI,
    Not,
    FloatOfSigned,
    FloatOfUnsigned,
    SignedOfFloat,
    UnsignedOfFloat,
    /// 1 or 0 as a float.
    FloatOfBool,
    /// 1 or 0 as a whole number.
    NumberOfBool,
    /// Not 0.
    BoolOfNumber,
    /// Neither 0 nor −0.
    BoolOfFloat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    AddF,
    SubF,
    MulF,
    DivF,
    RemF,
    MinF,
    MaxF,
    EqF,
    NeF,
    LtF,
    LeF,
    AddI,
    SubI,
    MulI,
    DivS,
    DivU,
    RemS,
    RemU,
    MinS,
    MinU,
    MaxS,
    MaxU,
    EqI,
    NeI,
    LtS,
    LtU,
    LeS,
    LeU,
    And,
    Or,
    Xor,
    Shl,
    ShrS,
    ShrU,
}

/// One step for all lanes. Except where it says so, lanes that are not active are computed too: what
/// they get is never read.
#[derive(Clone, Debug)]
pub enum Op {
    Unary(Unary, Reg, Reg),
    Binary(Binary, Reg, Reg, Reg),
    /// Linear between a and b: a·(1 − t) + b·t.
    Mix {
        to: Reg,
        a: Reg,
        b: Reg,
        t: Reg,
    },
    Select {
        to: Reg,
        condition: Reg,
        accept: Reg,
        reject: Reg,
    },
    /// A function of one scalar; active lanes only.
    Scalar1(fn(u32) -> u32, Reg, Reg),
    /// Of two.
    Scalar2(fn(u32, u32) -> u32, Reg, Reg, Reg),
    /// Of up to four.
    Scalar4(fn([u32; 4]) -> u32, Reg, [Reg; 4]),
    Copy {
        to: Reg,
        from: Reg,
    },
    /// Active lanes only.
    Store {
        to: Reg,
        from: Reg,
    },
    /// Into register `first` + offset of the lane; active lanes only.
    StoreAt {
        first: Reg,
        offset: Reg,
        from: Reg,
    },
    /// From register `first` + offset of the lane.
    LoadAt {
        to: Reg,
        first: Reg,
        offset: Reg,
    },
    /// The register of a list that the lane's index names.
    Pick {
        to: Reg,
        of: Box<[Reg]>,
        index: Reg,
    },
    /// A word of a uniform block.
    Word {
        to: Reg,
        block: u32,
        word: u32,
    },
    /// The same, at an offset that each lane has.
    WordAt {
        to: Reg,
        block: u32,
        word: u32,
        offset: Reg,
    },
    /// A texel: zeros outside. Active lanes only.
    Texel {
        to: [Reg; 4],
        texture: u32,
        at: [Reg; 3],
    },
    /// Between texels. Active lanes only.
    Sample {
        to: [Reg; 4],
        texture: u32,
        sampler: u32,
        at: [Reg; 3],
    },
}

/// Control flow.
#[derive(Clone, Debug)]
pub enum Node {
    Ops(Vec<Op>),
    If {
        condition: Reg,
        accept: Vec<Node>,
        reject: Vec<Node>,
    },
    Switch {
        selector: Reg,
        cases: Vec<Case>,
    },
    Loop {
        body: Vec<Node>,
        continuing: Vec<Node>,
        break_if: Option<Reg>,
    },
    Break,
    Continue,
    /// Ends the innermost [`Node::Function`].
    Return,
    Kill,
    /// The body of a function that returns early.
    Function(Vec<Node>),
    /// A body that several calls share.
    Call(usize),
}

#[derive(Clone, Debug)]
pub struct Case {
    /// Values; `None` is the default.
    pub values: Vec<Option<u32>>,
    pub body: Vec<Node>,
    pub falls_through: bool,
}

/// How an operation uses a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Read,
    Write,
}

impl Op {
    /// Calls `f` for every register that it names, those read first.
    pub fn registers(&mut self, f: &mut dyn FnMut(&mut Reg, Role)) {
        use Role::{Read, Write};
        match self {
            Op::Unary(_, to, a) | Op::Scalar1(_, to, a) => {
                f(a, Read);
                f(to, Write);
            }
            Op::Binary(_, to, a, b) | Op::Scalar2(_, to, a, b) => {
                f(a, Read);
                f(b, Read);
                f(to, Write);
            }
            Op::Mix { to, a, b, t } => {
                f(a, Read);
                f(b, Read);
                f(t, Read);
                f(to, Write);
            }
            Op::Select {
                to,
                condition,
                accept,
                reject,
            } => {
                f(condition, Read);
                f(accept, Read);
                f(reject, Read);
                f(to, Write);
            }
            Op::Scalar4(_, to, from) => {
                from.iter_mut().for_each(|a| f(a, Read));
                f(to, Write);
            }
            Op::Copy { to, from } | Op::Store { to, from } => {
                f(from, Read);
                f(to, Write);
            }
            Op::StoreAt {
                first,
                offset,
                from,
            } => {
                f(offset, Read);
                f(from, Read);
                f(first, Write);
            }
            Op::LoadAt { to, first, offset } => {
                f(offset, Read);
                f(first, Read);
                f(to, Write);
            }
            Op::Pick { to, of, index } => {
                f(index, Read);
                of.iter_mut().for_each(|a| f(a, Read));
                f(to, Write);
            }
            Op::Word { to, .. } => f(to, Write),
            Op::WordAt { to, offset, .. } => {
                f(offset, Read);
                f(to, Write);
            }
            Op::Texel { to, at, .. } | Op::Sample { to, at, .. } => {
                at.iter_mut().for_each(|a| f(a, Read));
                to.iter_mut()
                    .filter(|to| **to != NOWHERE)
                    .for_each(|to| f(to, Write));
            }
        }
    }
}

/// A program ready to run.
#[derive(Clone, Debug)]
pub struct Code {
    /// Registers in all.
    pub registers: usize,
    /// What is the same for all lanes and all blocks, computed once; it writes the first registers.
    pub prologue: Vec<Op>,
    /// Registers with constants.
    pub constants: Vec<(Reg, u32)>,
    /// Those of the first registers that do not change after the prologue.
    pub uniform_registers: usize,
    pub body: Vec<Node>,
    /// Bodies that several calls share.
    pub shared: Vec<Vec<Node>>,
    /// Registers of the arguments, scalar by scalar.
    pub inputs: Vec<Reg>,
    /// Registers of the result.
    pub outputs: Vec<Reg>,
}
