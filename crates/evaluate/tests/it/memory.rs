//! Variables, pointers, arrays, structs, uniform blocks; what goes in and out of entry points.

use crate::{bits, floats, of_numbers, parse};
use naga::{Binding, BuiltIn, ScalarKind};
use strahl_evaluate::{Error, Machine, Resource, Resources};

#[test]
fn arrays_structs_and_pointers() {
    let found = of_numbers(
        "struct Part { weight: f32, at: vec3u, flags: array<u32, 3> }
        var<private> kept: array<Part, 2>;
        const FIRST = array(5u, 6u, 7u, 8u);
        fn bump(at: ptr<function, u32>, by: u32) { *at += by; }
        fn f(a: u32) -> u32 {
            var numbers = array<u32, 4>(1u, 2u, 3u, 4u);
            numbers[a % 4u] += 10u;
            bump(&numbers[(a + 1u) % 4u], a);
            kept[a % 2u].at[a % 3u] = 100u;
            kept[1].flags = array<u32, 3>(a, 2u * a, 3u * a);
            var v = vec3u(1u, 2u, 3u);
            v = v.zxy;
            v[a % 3u] += 1u;
            let rows = kept[1].flags;
            let picked = FIRST[a % 4u];
            return numbers[0] + numbers[3] + kept[0].at.x + kept[1].at[1] + rows[a % 3u] + v.x + picked;
        }",
        120,
    );
    for (a, found) in (0u32..).zip(found) {
        let mut numbers = [1, 2, 3, 4];
        numbers[a as usize % 4] += 10;
        numbers[(a as usize + 1) % 4] += a;
        let at = |part: u32, axis: u32| u32::from(a % 2 == part && a % 3 == axis) * 100;
        let mut v = [3, 1, 2];
        v[a as usize % 3] += 1;
        let sum = numbers[0] + numbers[3] + at(0, 0) + at(1, 1) + a * (a % 3 + 1) + v[0];
        assert_eq!(found, sum + 5 + a % 4, "{a}");
    }
}

/// A value that was read stays, whatever is written afterwards.
#[test]
fn what_is_read_does_not_change_with_its_variable() {
    let found = of_numbers(
        "fn f(a: u32) -> u32 {
            var v = vec2u(a, 2u * a);
            let before = v;
            v = v.yx;
            let x = v.x;
            v.x = 7u;
            var sum = before.x + 10u * x + 100u * v.x;
            for (var i = 0u; i < 3u; i++) { let old = sum; sum += i; sum = sum + (sum - old); }
            return sum;
        }",
        9,
    );
    let truth = |a: u32| a + 20 * a + 700 + 6;
    assert_eq!(found, (0..9).map(truth).collect::<Vec<_>>());
}

#[test]
fn indices_outside_are_those_of_the_last() {
    let found = of_numbers(
        "fn f(a: u32) -> u32 {
            var numbers = array<u32, 3>(10u, 20u, 30u);
            numbers[a] += 1u;
            let i = i32(a) - 2;
            let v = vec2u(5u, 6u);
            return numbers[0] + 100u * numbers[i] + 100000u * v[a];
        }",
        5,
    );
    // Below 0 is beyond the end, too.
    let [a, b, c] = [0, 1, 2].map(|a: usize| {
        let mut numbers = [10, 20, 30];
        numbers[a] += 1;
        let at = if a < 2 { 2 } else { 0 };
        numbers[0] + 100 * numbers[at] + 100_000 * [5, 6][a.min(1)]
    });
    assert_eq!(found, [a, b, c, 10 + 2000 + 600_000, 10 + 3100 + 600_000]);
}

const BLOCK: &str = "
    struct Row { a: vec3f, b: f32, m: mat2x3f }
    struct Block { first: vec2u, rows: array<Row, 3>, last: array<vec4f, 2> }
    @group(0) @binding(2) var<uniform> block: Block;
    fn f(i: u32) -> vec4f {
        let row = block.rows[i];
        return vec4f(row.a.z, row.b, block.rows[i].m[1].y, block.last[i & 1u][i] + f32(block.first.y));
    }
    @fragment fn main() -> @location(0) vec4f { return f(0u); }";

#[test]
fn uniform_blocks_are_read_where_wgsl_lays_them() {
    let words: Vec<u32> = (0..64).map(|i| (i as f32).to_bits()).collect();
    let mut bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    // first: words 0 and 1; rows from word 4, each of 4 + 8 words; last from word 40.
    bytes[4..8].copy_from_slice(&1000u32.to_le_bytes());
    bytes.truncate(48 * 4);
    let module = parse(BLOCK);
    let resources = Resources::new().with(0, 2, Resource::Uniform(bytes.clone()));
    let mut machine = Machine::new(&module, resources).unwrap();
    let results = machine.call("f", 3, &[&[0, 1, 2]]).unwrap();
    let expected = |i: u32| {
        let row = 4 + 12 * i;
        [
            row + 2,
            row + 3,
            row + 4 + 4 + 1,
            40 + 4 * (i & 1) + i + 1000,
        ]
        .map(|w| w as f32)
    };
    for i in 0..3 {
        let found: Vec<f32> = results
            .scalars
            .iter()
            .map(|s| f32::from_bits(s[i]))
            .collect();
        assert_eq!(found, expected(i as u32));
    }
    bytes[4..8].copy_from_slice(&2000u32.to_le_bytes());
    machine.set_uniform(0, 2, &bytes).unwrap();
    let changed = machine.call("f", 1, &[&[0]]).unwrap();
    assert_eq!(f32::from_bits(changed.scalars[3][0]), 2040.0);
    assert!(machine.set_uniform(0, 3, &bytes).is_err() && machine.set_uniform(0, 2, &[]).is_err());
}

#[test]
fn blocks_that_are_missing_or_short_are_refused_by_name() {
    let module = parse(BLOCK);
    for (resources, words) in [
        (Resources::new(), "nothing is bound"),
        (
            Resources::new().with(0, 2, Resource::Uniform(vec![0; 20])),
            "has 192 bytes, 20 are bound",
        ),
    ] {
        let message = Machine::new(&module, resources).unwrap_err().to_string();
        assert!(message.contains("block (group 0, binding 2)"), "{message}");
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn entry_points_say_what_they_take_and_give() {
    let module = parse(
        "struct Corner { @builtin(position) clip: vec4f, @location(0) color: vec3f, @location(1) @interpolate(flat) id: u32 }
        @vertex fn corner(@builtin(vertex_index) index: u32, @location(3) at: vec2f) -> Corner {
            return Corner(vec4f(at, 0.0, 1.0), vec3f(at, 1.0), index * 2u);
        }
        @fragment fn color(corner: Corner) -> @location(0) vec4f {
            return vec4f(corner.color, f32(corner.id)) + vec4f(corner.clip.x);
        }",
    );
    let machine = Machine::new(&module, Resources::new()).unwrap();
    let inputs = machine.inputs("corner").unwrap();
    assert_eq!(inputs.len(), 3);
    assert_eq!(
        inputs[0].binding,
        Some(Binding::BuiltIn(BuiltIn::VertexIndex))
    );
    assert_eq!((inputs[2].name.as_str(), inputs[2].part), ("at", 1));
    let outputs = machine.outputs("corner").unwrap();
    let names: Vec<_> = outputs.iter().map(|o| (o.name.as_str(), o.part)).collect();
    assert_eq!(names[3..6], [("clip", 3), ("color", 0), ("color", 1)]);
    assert_eq!(outputs[7].kind, ScalarKind::Uint);
    let y = bits(&[0.25, 0.5]);
    let corners = machine
        .call("corner", 2, &[&[4, 5], &bits(&[-1.0, 3.0]), &y])
        .unwrap();
    assert_eq!(floats(&corners.scalars[0]), [-1.0, 3.0]);
    assert_eq!(corners.scalars[7], [8, 10]);
    let varyings: Vec<&[u32]> = corners.scalars.iter().map(Vec::as_slice).collect();
    let colors = machine.call("color", 2, &varyings).unwrap();
    assert_eq!(floats(&colors.scalars[1]), [-0.75, 3.5]);
    assert_eq!(floats(&colors.scalars[3]), [7.0, 13.0]);

    let wrong = machine.call("corner", 2, &[&[4, 5]]).unwrap_err();
    assert!(
        matches!(wrong, Error::Arguments { takes: 3, .. }),
        "{wrong}"
    );
    let short = machine.call("color", 3, &varyings).unwrap_err();
    assert!(short.to_string().contains("2 lanes of 3"), "{short}");
    let gone = machine.call("colour", 1, &[]).unwrap_err().to_string();
    assert!(gone.contains("there are: corner, color"), "{gone}");
}
