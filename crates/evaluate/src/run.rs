//! Running compiled programs.

use crate::code::*;
use crate::error::Error;
use crate::resources::{Address, Filter, Numbers, Resource, Resources, Texture};
use strahl_volume::{Control, Samples};

/// Turns after which a loop counts as endless: more than a ray has lattice points.
pub const MOST_TURNS: u32 = 1 << 25;

/// Operations, each of all lanes, after which a block of pixels counts as endless: loops within bounds and calls of
/// functions can be multiplied by one another.
pub const MOST_OPERATIONS: u64 = 1 << 30;

/// Operations between two looks at whether anybody still wants the picture.
const OPERATIONS_UNASKED: u64 = 1 << 16;

/// A program with what it reads, its prologue done.
pub struct Run<'a> {
    pub code: &'a Code,
    resources: &'a Resources<'a>,
    blocks: &'a [Vec<u32>],
    uniform: Vec<Lanes>,
    /// Asked at every turn of a loop, and every so many operations.
    control: Control,
    /// After which a block counts as endless.
    most_operations: u64,
}

impl<'a> Run<'a> {
    /// `blocks` are the words of the uniform blocks among the resources.
    pub fn new(code: &'a Code, resources: &'a Resources<'a>, blocks: &'a [Vec<u32>]) -> Run<'a> {
        let mut run = Run {
            code,
            resources,
            blocks,
            uniform: vec![Lanes::NONE; code.uniform_registers],
            control: Control::NONE,
            most_operations: MOST_OPERATIONS,
        };
        for (reg, bits) in &code.constants {
            run.uniform[*reg as usize] = Lanes([*bits; LANES]);
        }
        let mut state = State::new(&run);
        state.activate(Lanes::ALL);
        state.ops(&code.prologue);
        state.registers.truncate(code.uniform_registers);
        run.uniform = state.registers;
        run
    }

    /// The same with another number of operations after which a block counts as endless.
    pub fn bounded(self, most_operations: u64) -> Run<'a> {
        Run {
            most_operations,
            ..self
        }
    }

    /// The same under `control`.
    pub fn under(self, control: &Control) -> Run<'a> {
        Run {
            control: control.clone(),
            ..self
        }
    }
}

/// The registers of one block of lanes while they run.
pub struct State<'a> {
    run: &'a Run<'a>,
    pub registers: Vec<Lanes>,
    active: Lanes,
    is_any: bool,
    is_all: bool,
    killed: Lanes,
    /// Operations of this run so far, and at how many somebody is asked next.
    done: u64,
    asked_at: u64,
}

/// Lanes that have left the innermost loop or switch, and those that wait for the next turn.
struct Jumps {
    broken: Lanes,
    continued: Lanes,
}

impl Jumps {
    const NONE: Jumps = Jumps {
        broken: Lanes::NONE,
        continued: Lanes::NONE,
    };
}

#[inline(always)]
fn map(f: impl Fn(usize) -> u32) -> Lanes {
    let mut out = Lanes::NONE;
    for (lane, out) in out.0.iter_mut().enumerate() {
        *out = f(lane);
    }
    out
}

impl Lanes {
    fn and(&self, other: &Lanes) -> Lanes {
        map(|i| self.0[i] & other.0[i])
    }

    fn but(&self, other: &Lanes) -> Lanes {
        map(|i| self.0[i] & !other.0[i])
    }

    fn or(&self, other: &Lanes) -> Lanes {
        map(|i| self.0[i] | other.0[i])
    }
}

impl<'a> State<'a> {
    pub fn new(run: &'a Run<'a>) -> State<'a> {
        let mut registers = run.uniform.clone();
        registers.resize(run.code.registers.max(registers.len()), Lanes::NONE);
        State {
            run,
            registers,
            active: Lanes::NONE,
            is_any: false,
            is_all: false,
            killed: Lanes::NONE,
            done: 0,
            asked_at: OPERATIONS_UNASKED,
        }
    }

    /// Runs the active lanes; their inputs are in the registers. Gives those that were discarded.
    pub fn run(&mut self, active: Lanes) -> Result<Lanes, Error> {
        self.killed = Lanes::NONE;
        (self.done, self.asked_at) = (0, OPERATIONS_UNASKED);
        self.activate(active);
        let code = self.run.code;
        let mut jumps = Jumps::NONE;
        self.nodes(&code.body, &mut jumps)?;
        Ok(self.killed)
    }

    fn activate(&mut self, active: Lanes) {
        let (mut any, mut all) = (0, !0);
        for lane in active.0 {
            any |= lane;
            all &= lane;
        }
        self.is_any = any != 0;
        self.is_all = all != 0;
        self.active = active;
    }

    fn nodes(&mut self, nodes: &'a [Node], jumps: &mut Jumps) -> Result<(), Error> {
        for node in nodes {
            if !self.is_any {
                return Ok(());
            }
            self.done += 1;
            if self.done >= self.asked_at {
                self.ask()?;
            }
            match node {
                Node::Ops(ops) => {
                    self.done += ops.len() as u64;
                    self.ops(ops);
                }
                Node::If {
                    condition,
                    accept,
                    reject,
                } => {
                    let before = self.active;
                    let condition = self.registers[*condition as usize];
                    self.activate(before.and(&condition));
                    self.nodes(accept, jumps)?;
                    let after = self.active;
                    self.activate(before.but(&condition));
                    self.nodes(reject, jumps)?;
                    self.activate(after.or(&self.active));
                }
                Node::Switch { selector, cases } => self.switch(*selector, cases, jumps)?,
                Node::Loop {
                    body,
                    continuing,
                    break_if,
                } => {
                    let mut inner = Jumps::NONE;
                    let mut turns = 0;
                    loop {
                        self.nodes(body, &mut inner)?;
                        self.activate(self.active.or(&inner.continued));
                        inner.continued = Lanes::NONE;
                        self.nodes(continuing, &mut inner)?;
                        if let Some(condition) = break_if {
                            let condition = self.registers[*condition as usize];
                            let leaving = self.active.and(&condition);
                            inner.broken = inner.broken.or(&leaving);
                            self.activate(self.active.but(&condition));
                        }
                        if !self.is_any {
                            break;
                        }
                        self.run.control.check()?;
                        turns += 1;
                        if turns >= MOST_TURNS {
                            return Err(Error::Endless(MOST_TURNS));
                        }
                    }
                    self.activate(inner.broken);
                }
                Node::Break => {
                    jumps.broken = jumps.broken.or(&self.active);
                    self.activate(Lanes::NONE);
                }
                Node::Continue => {
                    jumps.continued = jumps.continued.or(&self.active);
                    self.activate(Lanes::NONE);
                }
                Node::Return => self.activate(Lanes::NONE),
                Node::Kill => {
                    self.killed = self.killed.or(&self.active);
                    self.activate(Lanes::NONE);
                }
                Node::Function(body) => self.function(body)?,
                Node::Call(index) => {
                    let code = self.run.code;
                    self.function(&code.shared[*index])?;
                }
            }
        }
        Ok(())
    }

    /// Whether there has been too much, or nobody wants more.
    #[cold]
    fn ask(&mut self) -> Result<(), Error> {
        self.asked_at = self.done + OPERATIONS_UNASKED;
        self.run.control.check()?;
        let most = self.run.most_operations;
        match self.done > most {
            true => Err(Error::TooMuch(most)),
            false => Ok(()),
        }
    }

    fn function(&mut self, body: &'a [Node]) -> Result<(), Error> {
        let before = self.active;
        let mut jumps = Jumps::NONE;
        self.nodes(body, &mut jumps)?;
        self.activate(before.but(&self.killed));
        Ok(())
    }

    fn switch(&mut self, selector: Reg, cases: &'a [Case], jumps: &mut Jumps) -> Result<(), Error> {
        let selector = self.registers[selector as usize];
        let before = self.active;
        // What no case names goes to the default, wherever that stands.
        let mut unnamed = before;
        for value in cases.iter().flat_map(|case| &case.values).flatten() {
            let named = map(|i| if selector.0[i] == *value { !0 } else { 0 });
            unnamed = unnamed.but(&named);
        }
        let mut inner = Jumps::NONE;
        let mut done = Lanes::NONE;
        let mut falling = Lanes::NONE;
        for case in cases {
            let mut entering = falling;
            for value in &case.values {
                let named = match value {
                    Some(value) => map(|i| {
                        if selector.0[i] == *value {
                            before.0[i]
                        } else {
                            0
                        }
                    }),
                    None => unnamed,
                };
                entering = entering.or(&named);
            }
            self.activate(entering);
            self.nodes(&case.body, &mut inner)?;
            if case.falls_through {
                falling = self.active;
            } else {
                falling = Lanes::NONE;
                done = done.or(&self.active);
            }
        }
        jumps.continued = jumps.continued.or(&inner.continued);
        let mut after = done.or(&falling).or(&inner.broken);
        if !cases.iter().any(|case| case.values.contains(&None)) {
            after = after.or(&unnamed);
        }
        self.activate(after);
        Ok(())
    }

    #[inline(always)]
    fn map1(&mut self, to: Reg, a: Reg, f: impl Fn(u32) -> u32) {
        let a = &self.registers[a as usize];
        let out = map(|i| f(a.0[i]));
        self.registers[to as usize] = out;
    }

    #[inline(always)]
    fn map2(&mut self, to: Reg, a: Reg, b: Reg, f: impl Fn(u32, u32) -> u32) {
        let (a, b) = (&self.registers[a as usize], &self.registers[b as usize]);
        let out = map(|i| f(a.0[i], b.0[i]));
        self.registers[to as usize] = out;
    }

    #[inline(always)]
    fn floats1(&mut self, to: Reg, a: Reg, f: impl Fn(f32) -> f32) {
        self.map1(to, a, |a| f(f32::from_bits(a)).to_bits());
    }

    #[inline(always)]
    fn floats2(&mut self, to: Reg, a: Reg, b: Reg, f: impl Fn(f32, f32) -> f32) {
        self.map2(to, a, b, |a, b| {
            f(f32::from_bits(a), f32::from_bits(b)).to_bits()
        });
    }

    #[inline(always)]
    fn compare(&mut self, to: Reg, a: Reg, b: Reg, f: impl Fn(f32, f32) -> bool) {
        self.map2(to, a, b, |a, b| {
            truth(f(f32::from_bits(a), f32::from_bits(b)))
        });
    }

    fn ops(&mut self, ops: &[Op]) {
        for op in ops {
            self.op(op);
        }
    }

    #[inline(always)]
    fn op(&mut self, op: &Op) {
        match *op {
            Op::Unary(op, to, a) => self.unary(op, to, a),
            Op::Binary(op, to, a, b) => self.binary(op, to, a, b),
            Op::Mix { to, a, b, t } => {
                let [a, b, t] = [a, b, t].map(|r| &self.registers[r as usize]);
                let f = |lanes: &Lanes, i: usize| f32::from_bits(lanes.0[i]);
                let out = map(|i| {
                    let t = f(t, i);
                    (f(a, i) * (1.0 - t) + f(b, i) * t).to_bits()
                });
                self.registers[to as usize] = out;
            }
            Op::Select {
                to,
                condition,
                accept,
                reject,
            } => {
                let [c, a, b] = [condition, accept, reject].map(|r| &self.registers[r as usize]);
                let out = map(|i| (a.0[i] & c.0[i]) | (b.0[i] & !c.0[i]));
                self.registers[to as usize] = out;
            }
            Op::Scalar1(f, to, a) => {
                let a = &self.registers[a as usize];
                let active = &self.active;
                let out = map(|i| if active.0[i] != 0 { f(a.0[i]) } else { 0 });
                self.registers[to as usize] = out;
            }
            Op::Scalar2(f, to, a, b) => {
                let (a, b) = (&self.registers[a as usize], &self.registers[b as usize]);
                let active = &self.active;
                let out = map(|i| {
                    if active.0[i] != 0 {
                        f(a.0[i], b.0[i])
                    } else {
                        0
                    }
                });
                self.registers[to as usize] = out;
            }
            Op::Scalar4(f, to, from) => {
                let from = from.map(|r| &self.registers[r as usize]);
                let active = &self.active;
                let out = map(|i| {
                    if active.0[i] != 0 {
                        f(from.map(|a| a.0[i]))
                    } else {
                        0
                    }
                });
                self.registers[to as usize] = out;
            }
            Op::Copy { to, from } => {
                self.registers[to as usize] = self.registers[from as usize];
            }
            Op::Store { to, from } => {
                if self.is_all {
                    self.registers[to as usize] = self.registers[from as usize];
                    return;
                }
                let (old, new) = (&self.registers[to as usize], &self.registers[from as usize]);
                let active = &self.active;
                let out = map(|i| (new.0[i] & active.0[i]) | (old.0[i] & !active.0[i]));
                self.registers[to as usize] = out;
            }
            Op::StoreAt {
                first,
                offset,
                from,
            } => {
                for lane in 0..LANES {
                    if self.active.0[lane] != 0 {
                        let offset = self.registers[offset as usize].0[lane];
                        let value = self.registers[from as usize].0[lane];
                        self.registers[(first + offset) as usize].0[lane] = value;
                    }
                }
            }
            Op::LoadAt { to, first, offset } => {
                let offset = &self.registers[offset as usize];
                let active = &self.active;
                let out = map(|i| {
                    // What an inactive lane has there may be any number.
                    let offset = offset.0[i] & active.0[i];
                    self.registers[(first + offset) as usize].0[i]
                });
                self.registers[to as usize] = out;
            }
            Op::Pick { to, ref of, index } => {
                let index = &self.registers[index as usize];
                let out = map(|i| {
                    let index = (index.0[i] as usize).min(of.len() - 1);
                    self.registers[of[index] as usize].0[i]
                });
                self.registers[to as usize] = out;
            }
            Op::Word { to, block, word } => {
                let word = self.run.blocks[block as usize][word as usize];
                self.registers[to as usize] = Lanes([word; LANES]);
            }
            Op::WordAt {
                to,
                block,
                word,
                offset,
            } => {
                let words = &self.run.blocks[block as usize];
                let offset = &self.registers[offset as usize];
                let active = &self.active;
                let out = map(|i| words[(word + (offset.0[i] & active.0[i])) as usize]);
                self.registers[to as usize] = out;
            }
            Op::Texel { to, texture, at } => {
                if let Resource::Texture(texture) = self.run.resources.at(texture) {
                    self.texel(texture, to, at);
                }
            }
            Op::Sample {
                to,
                texture,
                sampler,
                at,
            } => {
                let resources = self.run.resources;
                if let (Resource::Texture(texture), Resource::Sampler(sampler)) =
                    (resources.at(texture), resources.at(sampler))
                {
                    match sampler.filter {
                        Filter::Nearest => self.sample_nearest(texture, sampler.address, to, at),
                        Filter::Linear => self.sample_linear(texture, sampler.address, to, at),
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn unary(&mut self, op: Unary, to: Reg, a: Reg) {
        match op {
            Unary::NegF => self.map1(to, a, |a| a ^ 0x8000_0000),
            Unary::AbsF => self.map1(to, a, |a| a & 0x7FFF_FFFF),
            Unary::Ceil => self.floats1(to, a, |a| -floor(-a)),
            Unary::Floor => self.floats1(to, a, floor),
            Unary::Round => self.floats1(to, a, round),
            Unary::Trunc => self.floats1(to, a, trunc),
            Unary::Fract => self.floats1(to, a, |a| a - floor(a)),
            Unary::Sqrt => self.floats1(to, a, f32::sqrt),
            Unary::InverseSqrt => self.floats1(to, a, |a| 1.0 / a.sqrt()),
            Unary::Saturate => self.floats1(to, a, |a| min(max(a, 0.0), 1.0)),
            Unary::SignF => self.floats1(to, a, |a| {
                f32::from(u8::from(a > 0.0)) - f32::from(u8::from(a < 0.0))
            }),
            Unary::NegI => self.map1(to, a, u32::wrapping_neg),
            Unary::AbsI => self.map1(to, a, |a| (a as i32).wrapping_abs() as u32),
            Unary::SignI => self.map1(to, a, |a| (a as i32).signum() as u32),
            Unary::Not => self.map1(to, a, |a| !a),
            Unary::FloatOfSigned => self.map1(to, a, |a| (a as i32 as f32).to_bits()),
            Unary::FloatOfUnsigned => self.map1(to, a, |a| (a as f32).to_bits()),
            Unary::SignedOfFloat => self.map1(to, a, |a| f32::from_bits(a) as i32 as u32),
            Unary::UnsignedOfFloat => self.map1(to, a, |a| f32::from_bits(a) as u32),
            Unary::FloatOfBool => self.map1(to, a, |a| a & 1.0f32.to_bits()),
            Unary::NumberOfBool => self.map1(to, a, |a| a & 1),
            Unary::BoolOfNumber => self.map1(to, a, |a| truth(a != 0)),
            Unary::BoolOfFloat => self.map1(to, a, |a| truth(f32::from_bits(a) != 0.0)),
        }
    }

    #[inline(always)]
    fn binary(&mut self, op: Binary, to: Reg, a: Reg, b: Reg) {
        match op {
            Binary::AddF => self.floats2(to, a, b, |a, b| a + b),
            Binary::SubF => self.floats2(to, a, b, |a, b| a - b),
            Binary::MulF => self.floats2(to, a, b, |a, b| a * b),
            Binary::DivF => self.floats2(to, a, b, |a, b| a / b),
            Binary::RemF => self.floats2(to, a, b, |a, b| a - b * trunc(a / b)),
            Binary::MinF => self.floats2(to, a, b, min),
            Binary::MaxF => self.floats2(to, a, b, max),
            Binary::EqF => self.compare(to, a, b, |a, b| a == b),
            Binary::NeF => self.compare(to, a, b, |a, b| a != b),
            Binary::LtF => self.compare(to, a, b, |a, b| a < b),
            Binary::LeF => self.compare(to, a, b, |a, b| a <= b),
            Binary::AddI => self.map2(to, a, b, u32::wrapping_add),
            Binary::SubI => self.map2(to, a, b, u32::wrapping_sub),
            Binary::MulI => self.map2(to, a, b, u32::wrapping_mul),
            // By 0, and the smallest number by −1: WGSL gives the dividend, and no rest.
            Binary::DivS => self.map2(to, a, b, |a, b| match b as i32 {
                0 => a,
                b => (a as i32).wrapping_div(b) as u32,
            }),
            Binary::DivU => self.map2(to, a, b, |a, b| a.checked_div(b).unwrap_or(a)),
            Binary::RemS => self.map2(to, a, b, |a, b| match b as i32 {
                0 => 0,
                b => (a as i32).wrapping_rem(b) as u32,
            }),
            Binary::RemU => self.map2(to, a, b, |a, b| a.checked_rem(b).unwrap_or(0)),
            Binary::MinS => self.map2(to, a, b, |a, b| (a as i32).min(b as i32) as u32),
            Binary::MinU => self.map2(to, a, b, u32::min),
            Binary::MaxS => self.map2(to, a, b, |a, b| (a as i32).max(b as i32) as u32),
            Binary::MaxU => self.map2(to, a, b, u32::max),
            Binary::EqI => self.map2(to, a, b, |a, b| truth(a == b)),
            Binary::NeI => self.map2(to, a, b, |a, b| truth(a != b)),
            Binary::LtS => self.map2(to, a, b, |a, b| truth((a as i32) < b as i32)),
            Binary::LtU => self.map2(to, a, b, |a, b| truth(a < b)),
            Binary::LeS => self.map2(to, a, b, |a, b| truth(a as i32 <= b as i32)),
            Binary::LeU => self.map2(to, a, b, |a, b| truth(a <= b)),
            Binary::And => self.map2(to, a, b, |a, b| a & b),
            Binary::Or => self.map2(to, a, b, |a, b| a | b),
            Binary::Xor => self.map2(to, a, b, |a, b| a ^ b),
            Binary::Shl => self.map2(to, a, b, |a, b| a << (b & 31)),
            Binary::ShrS => self.map2(to, a, b, |a, b| ((a as i32) >> (b & 31)) as u32),
            Binary::ShrU => self.map2(to, a, b, |a, b| a >> (b & 31)),
        }
    }

    fn texel(&mut self, texture: &Texture, to: [Reg; 4], at: [Reg; 3]) {
        match texture.numbers() {
            Numbers::F32(s) => self.texel_of(texture, to, at, |i| s[i].to_bits()),
            Numbers::U32(s) => self.texel_of(texture, to, at, |i| s[i]),
            Numbers::I32(s) => self.texel_of(texture, to, at, |i| s[i] as u32),
            Numbers::Stored(samples) => match samples {
                Samples::U8(s) => self.texel_of(texture, to, at, |i| f32::from(s[i]).to_bits()),
                Samples::I8(s) => self.texel_of(texture, to, at, |i| f32::from(s[i]).to_bits()),
                Samples::U16(s) => self.texel_of(texture, to, at, |i| f32::from(s[i]).to_bits()),
                Samples::I16(s) => self.texel_of(texture, to, at, |i| f32::from(s[i]).to_bits()),
                Samples::U32(s) => self.texel_of(texture, to, at, |i| (s[i] as f32).to_bits()),
                Samples::I32(s) => self.texel_of(texture, to, at, |i| (s[i] as f32).to_bits()),
                Samples::F32(s) => self.texel_of(texture, to, at, |i| s[i].to_bits()),
                Samples::F64(s) => self.texel_of(texture, to, at, |i| (s[i] as f32).to_bits()),
            },
        }
    }

    #[inline(always)]
    fn texel_of(
        &mut self,
        texture: &Texture,
        to: [Reg; 4],
        at: [Reg; 3],
        read: impl Fn(usize) -> u32,
    ) {
        let dims = texture.dims();
        let channels = texture.channels() as usize;
        let [x, y, z] = at.map(|r| &self.registers[r as usize]);
        // Where each lane's texel begins; nothing outside.
        let mut places = [u64::MAX; LANES];
        for (lane, place) in places.iter_mut().enumerate() {
            let [x, y, z] = [x.0[lane], y.0[lane], z.0[lane]];
            let is_inside = x < dims[0] && y < dims[1] && z < dims[2];
            if is_inside && self.active.0[lane] != 0 {
                let index = x as u64 + dims[0] as u64 * (y as u64 + dims[1] as u64 * z as u64);
                *place = index * channels as u64;
            }
        }
        let one = texture.one();
        for (channel, to) in to.into_iter().enumerate() {
            if to == NOWHERE {
                continue;
            }
            let out = map(|lane| match places[lane] {
                u64::MAX => 0,
                place if channel < channels => read(place as usize + channel),
                _ if channel == 3 => one,
                _ => 0,
            });
            self.registers[to as usize] = out;
        }
    }

    fn sample_nearest(&mut self, texture: &Texture, address: Address, to: [Reg; 4], at: [Reg; 3]) {
        let dims = texture.dims();
        let mut found = [Lanes::NONE; 4];
        for lane in 0..LANES {
            if self.active.0[lane] == 0 {
                continue;
            }
            let axis = |a: usize| {
                let place = f32::from_bits(self.registers[at[a] as usize].0[lane]);
                let place = address.place(place, dims[a]).floor() as i64;
                address.texel(place, dims[a])
            };
            let texel = texture.floats([axis(0), axis(1), axis(2)]);
            for (found, number) in found.iter_mut().zip(texel) {
                found.0[lane] = number.to_bits();
            }
        }
        self.put(to, found);
    }

    fn sample_linear(&mut self, texture: &Texture, address: Address, to: [Reg; 4], at: [Reg; 3]) {
        let dims = texture.dims();
        let mut found = [Lanes::NONE; 4];
        for lane in 0..LANES {
            if self.active.0[lane] == 0 {
                continue;
            }
            let axis = |a: usize| {
                let place = f32::from_bits(self.registers[at[a] as usize].0[lane]);
                let place = address.place(place, dims[a]) - 0.5;
                let low = place.floor();
                let (first, part) = (low as i64, place - low);
                let texels = [first, first + 1].map(|i| address.texel(i, dims[a]));
                (texels, part)
            };
            let axes = [axis(0), axis(1), axis(2)];
            let mut sum = [0.0f32; 4];
            for corner in 0..8 {
                let mut weight = 1.0;
                let mut texel = [0; 3];
                for (a, (texels, part)) in axes.iter().enumerate() {
                    let side = corner >> a & 1;
                    texel[a] = texels[side];
                    weight *= if side == 1 { *part } else { 1.0 - part };
                }
                if weight > 0.0 {
                    for (sum, number) in sum.iter_mut().zip(texture.floats(texel)) {
                        *sum += weight * number;
                    }
                }
            }
            for (found, number) in found.iter_mut().zip(sum) {
                found.0[lane] = number.to_bits();
            }
        }
        self.put(to, found);
    }

    fn put(&mut self, to: [Reg; 4], found: [Lanes; 4]) {
        for (to, found) in to.into_iter().zip(found) {
            if to != NOWHERE {
                self.registers[to as usize] = found;
            }
        }
    }
}

/// The nearest whole number, the even one of two: without a branch, where processors have no instruction
/// for it that all of them know.
#[inline(always)]
fn round(a: f32) -> f32 {
    // From here on all floats are whole.
    const WHOLE: f32 = 8_388_608.0;
    let size = a.abs();
    let rounded = ((size + WHOLE) - WHOLE).copysign(a);
    if size < WHOLE { rounded } else { a }
}

#[inline(always)]
fn floor(a: f32) -> f32 {
    let rounded = round(a);
    let lower = if rounded > a { 1.0 } else { 0.0 };
    // No number has a floor of the other sign; of 0 it has to be said.
    (rounded - lower).copysign(a)
}

#[inline(always)]
fn trunc(a: f32) -> f32 {
    floor(a.abs()).copysign(a)
}

/// The smaller; the first where the second is NaN.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a < b { b } else { a }
}

#[inline(always)]
fn truth(is: bool) -> u32 {
    if is { !0 } else { 0 }
}

impl Address {
    /// A place from 0 to 1 in texels, kept near the texture.
    fn place(self, place: f32, texels: u32) -> f32 {
        let n = texels as f32;
        let place = match self {
            Address::ClampToEdge => place.clamp(-1.0, 2.0),
            Address::Repeat => place - place.floor(),
            Address::MirrorRepeat => place - 2.0 * (place * 0.5).floor(),
        };
        // Of what is no number, the first texel.
        if place.is_nan() { 0.0 } else { place * n }
    }

    fn texel(self, index: i64, texels: u32) -> u32 {
        let n = i64::from(texels);
        let index = match self {
            Address::ClampToEdge => index.clamp(0, n - 1),
            Address::Repeat => index.rem_euclid(n),
            Address::MirrorRepeat => {
                let index = index.rem_euclid(2 * n);
                index.min(2 * n - 1 - index)
            }
        };
        index as u32
    }
}

impl Texture<'_> {
    /// What stands in the fourth channel of a texture without one.
    fn one(&self) -> u32 {
        match self.numbers() {
            Numbers::F32(_) | Numbers::Stored(_) => 1.0f32.to_bits(),
            Numbers::U32(_) | Numbers::I32(_) => 1,
        }
    }

    /// The numbers of a texel inside.
    fn floats(&self, [x, y, z]: [u32; 3]) -> [f32; 4] {
        let dims = self.dims();
        let channels = self.channels() as usize;
        let index = x as usize + dims[0] as usize * (y as usize + dims[1] as usize * z as usize);
        let read = |i: usize| match self.numbers() {
            Numbers::F32(s) => s[i],
            Numbers::U32(s) => s[i] as f32,
            Numbers::I32(s) => s[i] as f32,
            Numbers::Stored(samples) => samples.get(i) as f32,
        };
        let mut texel = [0.0, 0.0, 0.0, 1.0];
        for (channel, number) in texel.iter_mut().enumerate().take(channels) {
            *number = read(index * channels + channel);
        }
        texel
    }
}

#[cfg(test)]
mod tests {
    use super::{floor, round, trunc};

    #[test]
    fn rounding_is_that_of_the_standard_library() {
        // Every 9973rd float, and what is special.
        let some = (0..=u32::MAX).step_by(9973).map(f32::from_bits);
        let special = [
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.5,
            2.5,
            8_388_607.5,
            -8_388_609.0,
            f32::INFINITY,
        ];
        for a in some.chain(special) {
            for (own, other) in [
                (floor(a), a.floor()),
                (-floor(-a), a.ceil()),
                (round(a), a.round_ties_even()),
                (trunc(a), a.trunc()),
            ] {
                let is_same = own.to_bits() == other.to_bits() || own.is_nan() && other.is_nan();
                assert!(is_same, "{a}: {own} and {other}");
            }
        }
    }
}
