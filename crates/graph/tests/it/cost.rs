//! What the generated programs cost beside hand-written ones: texture fetches, operations, SPIR-V.

#[path = "../../benches/cases.rs"]
mod cases;

use cases::CASES;
use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::collections::HashMap;
use strahl_program::{Functions, loop_of};
use strahl_shader::{Program, Texels, Work};

/// Samples of a ray, for which the work of the ray is spread.
const SAMPLES: u64 = 64;

/// The longest way through `march` in SPIR-V, with all calls, each loop turned once: what computes, and what reads textures.
fn spir_v(program: &Program) -> (u64, u64) {
    let module = program.naga();
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(module)
        .unwrap();
    let options = spv::Options {
        flags: spv::WriterFlags::DEBUG,
        ..spv::Options::default()
    };
    let words = spv::write_vec(module, &info, &options, None).unwrap();
    let mut names = HashMap::new();
    let mut functions: HashMap<u32, (u64, u64)> = HashMap::new();
    let mut blocks: Vec<Block> = Vec::new();
    let (mut current, mut march) = (0, None);
    let mut at = 5;
    while at < words.len() {
        let (length, op) = ((words[at] >> 16) as usize, words[at] & 0xFFFF);
        let operands = &words[at + 1..at + length];
        at += length;
        match op {
            OP_NAME => {
                let bytes: Vec<u8> = operands[1..].iter().flat_map(|w| w.to_le_bytes()).collect();
                let end = bytes.iter().position(|b| *b == 0).unwrap();
                names.insert(
                    operands[0],
                    String::from_utf8(bytes[..end].to_vec()).unwrap(),
                );
            }
            OP_FUNCTION => {
                current = operands[1];
                blocks.clear();
            }
            OP_LABEL => blocks.push(Block {
                label: operands[0],
                ..Block::default()
            }),
            OP_FUNCTION_END => {
                let cost = longest(&blocks);
                functions.insert(current, cost);
                if names.get(&current).is_some_and(|n| n == "march") {
                    march = Some(cost);
                }
            }
            _ => {
                let Some(block) = blocks.last_mut() else {
                    continue;
                };
                match op {
                    // Callees come first.
                    OP_FUNCTION_CALL => {
                        let callee = functions[&operands[2]];
                        block.cost.0 += callee.0;
                        block.cost.1 += callee.1;
                    }
                    OP_BRANCH => block.next.push(operands[0]),
                    OP_BRANCH_CONDITIONAL => block.next.extend(&operands[1..3]),
                    OP_SWITCH => {
                        block.next.push(operands[1]);
                        block
                            .next
                            .extend(operands[2..].chunks(2).map(|case| case[1]));
                    }
                    op if OP_IMAGES.contains(&op) => {
                        block.cost.0 += 1;
                        block.cost.1 += 1;
                    }
                    op if OP_EXT_INST == op || OP_ARITHMETIC.contains(&op) => block.cost.0 += 1,
                    _ => {}
                }
            }
        }
    }
    march.unwrap()
}

const OP_NAME: u32 = 5;
const OP_EXT_INST: u32 = 12;
const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_END: u32 = 56;
const OP_FUNCTION_CALL: u32 = 57;
/// Samples, fetches and gathers.
const OP_IMAGES: std::ops::RangeInclusive<u32> = 87..=98;
/// Conversions, arithmetic, logic, comparisons, bits: OpConvertFToU to OpBitCount.
const OP_ARITHMETIC: std::ops::RangeInclusive<u32> = 109..=205;
const OP_LABEL: u32 = 248;
const OP_BRANCH: u32 = 249;
const OP_BRANCH_CONDITIONAL: u32 = 250;
const OP_SWITCH: u32 = 251;

#[derive(Default)]
struct Block {
    label: u32,
    cost: (u64, u64),
    next: Vec<u32>,
}

/// Ways back are left out; a block is dominated by those before it.
fn longest(blocks: &[Block]) -> (u64, u64) {
    let place: HashMap<u32, usize> = blocks
        .iter()
        .enumerate()
        .map(|(i, b)| (b.label, i))
        .collect();
    let mut cost = vec![None; blocks.len()];
    fn from(
        i: usize,
        blocks: &[Block],
        place: &HashMap<u32, usize>,
        cost: &mut Vec<Option<(u64, u64)>>,
        open: &mut Vec<bool>,
    ) -> (u64, u64) {
        if let Some(known) = cost[i] {
            return known;
        }
        open[i] = true;
        let mut rest = (0, 0);
        for next in &blocks[i].next {
            let next = place[next];
            // A way back to a block that we come from.
            if open[next] {
                continue;
            }
            let way = from(next, blocks, place, cost, open);
            rest = (rest.0.max(way.0), rest.1.max(way.1));
        }
        open[i] = false;
        let all = (rest.0 + blocks[i].cost.0, rest.1 + blocks[i].cost.1);
        cost[i] = Some(all);
        all
    }
    let mut open = vec![false; blocks.len()];
    from(0, blocks, &place, &mut cost, &mut open)
}

#[test]
fn a_graph_costs_what_hand_written_code_costs() {
    for case in &CASES {
        let volumes = case.volumes();
        let plan = case.plan(&volumes);
        let functions = Functions::of(&plan, true, |_, t| f64::from(t)).unwrap();
        let what = loop_of(&plan, Texels::Float);
        let generated = case.generated(&plan, &what, &functions);
        let (by_hand, _) = case.by_hand(&what, &functions);
        let (ours, theirs) = (generated.program.cost(), by_hand.cost());
        let total = |ray: Work, sample: Work| ray + sample * SAMPLES;
        let (all, all_by_hand) = (
            total(ours.per_ray, ours.per_sample),
            total(theirs.per_ray, theirs.per_sample),
        );
        let (spir_v, spir_v_by_hand) = (spir_v(&generated.program), spir_v(&by_hand));
        println!(
            "{}: {} nodes; per ray {:?} by hand {:?}; per sample {:?} by hand {:?}; SPIR-V {spir_v:?} by hand {spir_v_by_hand:?}",
            case.name,
            case.graph(&plan).nodes.len(),
            ours.per_ray,
            theirs.per_ray,
            ours.per_sample,
            theirs.per_sample,
        );
        assert!(theirs.per_sample.instructions > 20, "{}", case.name);
        assert_eq!(
            ours.per_ray.texture_reads, theirs.per_ray.texture_reads,
            "{}",
            case.name
        );
        assert_eq!(
            ours.per_sample.texture_reads, theirs.per_sample.texture_reads,
            "{}",
            case.name
        );
        assert_eq!(spir_v.1, spir_v_by_hand.1, "{}", case.name);
        let is_near = |ours: u64, theirs: u64| 100 * ours <= 102 * theirs;
        assert!(
            is_near(ours.per_sample.instructions, theirs.per_sample.instructions),
            "{}",
            case.name
        );
        assert!(is_near(spir_v.0, spir_v_by_hand.0), "{}", case.name);
        assert!(
            is_near(all.instructions, all_by_hand.instructions),
            "{}",
            case.name
        );
    }
}
