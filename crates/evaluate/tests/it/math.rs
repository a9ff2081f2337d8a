//! Every built-in function of WGSL, on random numbers.

use crate::{bits, call, floats};
use proptest::prelude::*;

/// `f(a, b, c)` as WGSL and in double precision.
type FloatCase = (&'static str, fn(f64, f64, f64) -> f64);

const OF_FLOATS: &[FloatCase] = &[
    ("a + b", |a, b, _| a + b),
    ("a - b", |a, b, _| a - b),
    ("a * b", |a, b, _| a * b),
    ("a / b", |a, b, _| a / b),
    ("-a", |a, _, _| -a),
    ("abs(a)", |a, _, _| a.abs()),
    ("min(a, b)", |a, b, _| a.min(b)),
    ("max(a, b)", |a, b, _| a.max(b)),
    ("clamp(a, -abs(b), abs(c))", |a, b, c| {
        a.clamp(-b.abs(), c.abs())
    }),
    ("saturate(a)", |a, _, _| a.clamp(0.0, 1.0)),
    ("sign(a)", |a, _, _| if a == 0.0 { 0.0 } else { a.signum() }),
    ("ceil(a)", |a, _, _| a.ceil()),
    ("floor(a)", |a, _, _| a.floor()),
    ("round(a)", |a, _, _| a.round_ties_even()),
    ("trunc(a)", |a, _, _| a.trunc()),
    ("sqrt(abs(a))", |a, _, _| a.abs().sqrt()),
    ("inverseSqrt(abs(a) + 0.1)", |a, _, _| {
        1.0 / (a.abs() + f64::from(0.1f32)).sqrt()
    }),
    ("radians(a)", |a, _, _| a.to_radians()),
    ("degrees(a)", |a, _, _| a.to_degrees()),
    ("fma(a, b, c)", |a, b, c| a * b + c),
    ("mix(a, b, c)", |a, b, c| a * (1.0 - c) + b * c),
    ("step(a, b)", |a, b, _| f64::from(u8::from(a <= b))),
    ("smoothstep(0.0, 4.0, a)", |a, _, _| {
        let t = (a / 4.0).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }),
    ("smoothstep(3.0, -1.0, a)", |a, _, _| {
        let t = ((3.0 - a) / 4.0).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }),
    ("sin(a)", |a, _, _| a.sin()),
    ("cos(a)", |a, _, _| a.cos()),
    ("atan(a)", |a, _, _| a.atan()),
    ("atan2(a, b)", |a, b, _| a.atan2(b)),
    ("sinh(0.3 * a)", |a, _, _| (f64::from(0.3f32) * a).sinh()),
    ("cosh(0.3 * a)", |a, _, _| (f64::from(0.3f32) * a).cosh()),
    ("tanh(a)", |a, _, _| a.tanh()),
    ("asinh(a)", |a, _, _| a.asinh()),
    ("acosh(1.5 + abs(a))", |a, _, _| (1.5 + a.abs()).acosh()),
    ("exp(a)", |a, _, _| a.exp()),
    ("exp2(a)", |a, _, _| a.exp2()),
    ("log(abs(a) + 2.0)", |a, _, _| (a.abs() + 2.0).ln()),
    ("log2(abs(a) + 2.0)", |a, _, _| (a.abs() + 2.0).log2()),
    ("pow(abs(a) + 0.5, b)", |a, b, _| (a.abs() + 0.5).powf(b)),
    ("ldexp(a, 3)", |a, _, _| 8.0 * a),
    ("ldexp(a, -140)", |a, _, _| a * 2f64.powi(-140)),
    ("distance(a, b)", |a, b, _| (a - b).abs()),
    ("length(a)", |a, _, _| a.abs()),
    ("length(vec2f(a, b))", |a, b, _| a.hypot(b)),
    ("length(vec3f(a, b, c))", |a, b, c| {
        (a * a + b * b + c * c).sqrt()
    }),
    ("distance(vec3f(a, b, c), vec3f(c, a, b))", |a, b, c| {
        ((a - c).powi(2) + (b - a).powi(2) + (c - b).powi(2)).sqrt()
    }),
    ("dot(vec3f(a, b, c), vec3f(b, c, a))", |a, b, c| {
        a * b + b * c + c * a
    }),
    ("cross(vec3f(a, b, c), vec3f(b, c, a)).x", |a, b, c| {
        b * a - c * c
    }),
    ("cross(vec3f(a, b, c), vec3f(b, c, a)).y", |a, b, c| {
        c * b - a * a
    }),
    ("cross(vec3f(a, b, c), vec3f(b, c, a)).z", |a, b, c| {
        a * c - b * b
    }),
    ("normalize(vec3f(a, b, 1.0 + abs(c))).y", |a, b, c| {
        b / (a * a + b * b + (1.0 + c.abs()).powi(2)).sqrt()
    }),
    ("reflect(vec2f(a, b), vec2f(0.6, 0.8)).x", |a, b, _| {
        a - 2.0 * (0.6 * a + 0.8 * b) * 0.6
    }),
    (
        "refract(normalize(vec2f(a, -10.0)), vec2f(0.0, 1.0), 0.5).y",
        |a, _, _| {
            let d = -10.0 / a.hypot(10.0);
            0.5 * d - (0.5 * d + (1.0 - 0.25 * (1.0 - d * d)).sqrt())
        },
    ),
    (
        "refract(vec2f(0.8, -0.6), vec2f(0.0, 1.0), 2.0).x + a",
        |a, _, _| a,
    ),
    (
        "faceForward(vec2f(a, b), vec2f(c, 0.0), vec2f(1.0, 0.0)).y",
        |_, b, c| {
            if c < 0.0 { b } else { -b }
        },
    ),
    ("determinant(mat2x2f(a, b, c, 2.0))", |a, b, c| {
        2.0 * a - b * c
    }),
    (
        "determinant(mat3x3f(a, b, c, 1.0, 2.0, 3.0, 0.0, 1.0, 4.0))",
        |a, b, c| a * 5.0 - b * 4.0 + c,
    ),
    (
        "transpose(mat2x3f(a, b, c, 1.0, 2.0, 3.0))[1].x",
        |_, b, _| b,
    ),
    (
        "(mat2x3f(a, b, c, 1.0, 2.0, 3.0) * vec2f(b, c)).z",
        |_, b, c| c * b + 3.0 * c,
    ),
    (
        "(vec3f(a, b, c) * mat2x3f(a, b, c, 1.0, 2.0, 3.0)).y",
        |a, b, c| a + 2.0 * b + 3.0 * c,
    ),
    (
        "(mat2x2f(a, b, c, 1.0) * mat2x2f(1.0, 2.0, a, b))[1].x",
        |a, b, c| a * a + c * b,
    ),
    ("(mat2x2f(a, b, c, 1.0) * c)[0].y", |_, b, c| b * c),
    (
        "(mat2x2f(a, b, c, 1.0) + mat2x2f(1.0, 1.0, 1.0, 1.0))[1].x",
        |_, _, c| c + 1.0,
    ),
    (
        "select(a, b, c > 0.0)",
        |a, b, c| if c > 0.0 { b } else { a },
    ),
    ("modf(a).whole", |a, _, _| a.trunc()),
    ("modf(vec2f(a, b)).fract.y", |_, b, _| b.fract()),
    ("ldexp(frexp(a).fract, frexp(a).exp)", |a, _, _| a),
    ("abs(frexp(a + 0.001).fract)", |a, _, _| {
        let mut v = (a as f32 + 0.001).abs();
        while v >= 1.0 {
            v /= 2.0;
        }
        while v > 0.0 && v < 0.5 {
            v *= 2.0;
        }
        f64::from(v)
    }),
    ("f32(i32(a))", |a, _, _| a.trunc()),
    ("f32(u32(a))", |a, _, _| a.trunc().max(0.0)),
    ("f32(a > b)", |a, b, _| f64::from(u8::from(a > b))),
    ("f32(bool(i32(a)))", |a, _, _| {
        f64::from(u8::from(a.trunc() != 0.0))
    }),
    ("vec4f(a, b, c, 1.0).wzyx.y", |_, _, c| c),
    ("vec2f(a).y * vec3(b).z", |a, b, _| a * b),
    ("f32(all(vec2(a, b) < vec2(c)))", |a, b, c| {
        f64::from(u8::from(a < c && b < c))
    }),
    ("f32(any(vec2(a, b) >= vec2(c)))", |a, b, c| {
        f64::from(u8::from(a >= c || b >= c))
    }),
    ("f32(a != b && !(b <= c))", |a, b, c| {
        f64::from(u8::from(a != b && b > c))
    }),
    ("f32(a == b || b <= c)", |a, b, c| {
        f64::from(u8::from(a == b || b <= c))
    }),
    ("bitcast<f32>(bitcast<u32>(a) ^ 0x80000000u)", |a, _, _| -a),
    ("bitcast<f32>(bitcast<i32>(a))", |a, _, _| a),
];

/// Near their ends in single precision only.
const OF_SHARES: &[FloatCase] = &[
    ("asin(a)", |a, _, _| a.asin()),
    ("acos(a)", |a, _, _| a.acos()),
    ("atanh(0.9 * a)", |a, _, _| (f64::from(0.9f32) * a).atanh()),
    ("tan(a)", |a, _, _| a.tan()),
    ("fract(a)", |a, _, _| a - a.floor()),
];

/// What is packed and unpacked again, which of the three numbers that is, the least, and steps up to 1.
const PACKED: &[(&str, usize, f32, f32)] = &[
    (
        "unpack4x8snorm(pack4x8snorm(vec4f(a, b, c, 1.0))).y",
        1,
        -1.0,
        127.0,
    ),
    (
        "unpack4x8unorm(pack4x8unorm(vec4f(a, b, c, 1.0))).z",
        2,
        0.0,
        255.0,
    ),
    (
        "unpack2x16snorm(pack2x16snorm(vec2f(a, b))).x",
        0,
        -1.0,
        32_767.0,
    ),
    (
        "unpack2x16unorm(pack2x16unorm(vec2f(a, b))).y",
        1,
        0.0,
        65_535.0,
    ),
];

fn compare(functions: &[FloatCase], inputs: &[[f32; 3]]) {
    let arguments = [0, 1, 2].map(|i| bits(&inputs.iter().map(|v| v[i]).collect::<Vec<_>>()));
    let arguments: Vec<&[u32]> = arguments.iter().map(Vec::as_slice).collect();
    for (wgsl, truth) in functions {
        let text = format!("fn f(a: f32, b: f32, c: f32) -> f32 {{ return {wgsl}; }}");
        let found = floats(&call(&text, &arguments).scalars[0]);
        for ([a, b, c], found) in inputs.iter().zip(found) {
            let truth = truth(f64::from(*a), f64::from(*b), f64::from(*c)) as f32;
            // As much as the terms may cancel.
            let size = truth
                .abs()
                .max(a.abs().max(b.abs()).max(c.abs()).powi(2))
                .max(1.0);
            let is_near = (found - truth).abs() <= 4e-6 * size
                || found == truth
                || (found.is_nan() && truth.is_nan());
            assert!(is_near, "{wgsl} of {a}, {b}, {c}: {found}, not {truth}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(12) })]

    #[test]
    fn functions_of_floats_are_those_of_wgsl(
        mut inputs in prop::collection::vec(prop::array::uniform3(-9.0f32..9.0), 70)
    ) {
        inputs.extend([[0.5, 0.0, -0.5], [2.5, 2.5, 1.0], [-0.0, 1.0, 0.0], [-3.5, -1.0, 2.5]]);
        compare(OF_FLOATS, &inputs);
    }

    #[test]
    fn functions_of_shares_are_those_of_wgsl(
        inputs in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 70)
    ) {
        compare(OF_SHARES, &inputs);
    }

    #[test]
    fn packed_numbers_are_off_by_half_a_step(
        inputs in prop::collection::vec(prop::array::uniform3(-1.3f32..1.3), 70)
    ) {
        let arguments = [0, 1, 2].map(|i| bits(&inputs.iter().map(|v| v[i]).collect::<Vec<_>>()));
        let arguments: Vec<&[u32]> = arguments.iter().map(Vec::as_slice).collect();
        for (wgsl, which, low, step) in PACKED {
            let text = format!("fn f(a: f32, b: f32, c: f32) -> f32 {{ return {wgsl}; }}");
            let found = floats(&call(&text, &arguments).scalars[0]);
            for (input, found) in inputs.iter().zip(found) {
                let truth = input[*which].clamp(*low, 1.0);
                prop_assert!((found - truth).abs() <= 0.501 / step, "{} of {:?}: {}", wgsl, input, found);
            }
        }
    }

    #[test]
    fn functions_of_whole_numbers_are_those_of_wgsl(
        mut inputs in prop::collection::vec(prop::array::uniform3(any::<u32>()), 70)
    ) {
        let edges = [0, 1, 2, 31, 32, 33, 0x7FFF_FFFF, 0x8000_0000, !0];
        inputs.extend(edges.iter().flat_map(|a| edges.map(|b| [*a, b, a % 37])));
        let arguments = [0, 1, 2].map(|i| inputs.iter().map(|v| v[i]).collect::<Vec<_>>());
        let arguments: Vec<&[u32]> = arguments.iter().map(Vec::as_slice).collect();
        for (wgsl, truth) in OF_NUMBERS {
            let text = format!(
                "fn f(a: u32, b: u32, c: u32) -> u32 {{ let i = bitcast<i32>(a); let k = bitcast<i32>(b); return u32({wgsl}); }}"
            );
            let found = call(&text, &arguments).scalars.swap_remove(0);
            for ([a, b, c], found) in inputs.iter().zip(found) {
                let truth = truth(*a, *b, *c);
                prop_assert_eq!(found, truth, "{} of {}, {}, {}", wgsl, a, b, c);
            }
        }
    }
}

/// `f(a, b, c)` of u32, with i and k the same as i32.
type WholeNumberCase = (&'static str, fn(u32, u32, u32) -> u32);

const OF_NUMBERS: &[WholeNumberCase] = &[
    ("a + b", |a, b, _| a.wrapping_add(b)),
    ("a - b", |a, b, _| a.wrapping_sub(b)),
    ("a * b", |a, b, _| a.wrapping_mul(b)),
    ("a / b", |a, b, _| a.checked_div(b).unwrap_or(a)),
    ("a % b", |a, b, _| if b == 0 { 0 } else { a % b }),
    ("i / k", |a, b, _| match (a as i32, b as i32) {
        (i, 0) => i as u32,
        (i, k) => i.wrapping_div(k) as u32,
    }),
    ("i % k", |a, b, _| match (a as i32, b as i32) {
        (_, 0) => 0,
        (i, k) => i.wrapping_rem(k) as u32,
    }),
    ("-i", |a, _, _| a.wrapping_neg()),
    ("~a", |a, _, _| !a),
    ("a & b", |a, b, _| a & b),
    ("a | b", |a, b, _| a | b),
    ("a ^ b", |a, b, _| a ^ b),
    ("a << (b & 31u)", |a, b, _| a << (b & 31)),
    ("a >> (b & 31u)", |a, b, _| a >> (b & 31)),
    ("i >> (b & 31u)", |a, b, _| ((a as i32) >> (b & 31)) as u32),
    ("abs(i)", |a, _, _| (a as i32).wrapping_abs() as u32),
    ("sign(i)", |a, _, _| (a as i32).signum() as u32),
    ("min(a, b)", |a, b, _| a.min(b)),
    ("max(a, b)", |a, b, _| a.max(b)),
    ("min(i, k)", |a, b, _| (a as i32).min(b as i32) as u32),
    ("max(i, k)", |a, b, _| (a as i32).max(b as i32) as u32),
    ("clamp(a, min(b, c), max(b, c))", |a, b, c| {
        a.clamp(b.min(c), b.max(c))
    }),
    ("clamp(i, -5, 7)", |a, _, _| (a as i32).clamp(-5, 7) as u32),
    ("dot(vec2u(a, b), vec2u(b, c))", |a, b, c| {
        a.wrapping_mul(b).wrapping_add(b.wrapping_mul(c))
    }),
    ("countOneBits(a)", |a, _, _| a.count_ones()),
    ("countLeadingZeros(a)", |a, _, _| a.leading_zeros()),
    ("countTrailingZeros(a)", |a, _, _| a.trailing_zeros()),
    ("reverseBits(a)", |a, _, _| a.reverse_bits()),
    ("firstTrailingBit(a)", |a, _, _| {
        if a == 0 { !0 } else { a.trailing_zeros() }
    }),
    ("firstLeadingBit(a)", |a, _, _| {
        if a == 0 { !0 } else { 31 - a.leading_zeros() }
    }),
    ("firstLeadingBit(i)", |a, _, _| match a as i32 {
        0 | -1 => !0,
        i if i < 0 => 31 - (!a).leading_zeros(),
        _ => 31 - a.leading_zeros(),
    }),
    ("extractBits(a, c, b % 40u)", |a, b, c| {
        let (offset, count) = (c.min(32), (b % 40).min(32 - c.min(32)));
        let mask = if count == 32 { !0 } else { (1 << count) - 1 };
        a.checked_shr(offset).unwrap_or(0) & mask
    }),
    ("extractBits(i, 4u, 9u)", |a, _, _| {
        (((a << 19) as i32) >> 23) as u32
    }),
    ("insertBits(a, b, 5u, 11u)", |a, b, _| {
        let mask = 0x7FF << 5;
        (a & !mask) | ((b << 5) & mask)
    }),
    ("insertBits(a, b, 32u, c)", |a, _, _| a),
    ("u32(a < b)", |a, b, _| u32::from(a < b)),
    ("u32(i < k)", |a, b, _| u32::from((a as i32) < b as i32)),
    ("u32(i >= k)", |a, b, _| u32::from(a as i32 >= b as i32)),
    ("u32(a <= b)", |a, b, _| u32::from(a <= b)),
    ("u32(a == b) + 2u * u32(a != c)", |a, b, c| {
        u32::from(a == b) + 2 * u32::from(a != c)
    }),
    ("f32(a)", |a, _, _| (a as f32) as u32),
    ("i32(f32(i))", |a, _, _| (a as i32 as f32) as i32 as u32),
    ("pack4xU8(vec4u(a, b, c, 7u))", |a, b, c| {
        (a & 255) | (b & 255) << 8 | (c & 255) << 16 | 7 << 24
    }),
    ("pack4xU8Clamp(vec4u(a, b, c, 7u))", |a, b, c| {
        a.min(255) | b.min(255) << 8 | c.min(255) << 16 | 7 << 24
    }),
    ("pack4xI8Clamp(vec4i(i, k, 1, 2))", |a, b, _| {
        let byte = |v: u32| u32::from((v as i32).clamp(-128, 127) as u8);
        byte(a) | byte(b) << 8 | 1 << 16 | 2 << 24
    }),
    ("unpack4xU8(a).z", |a, _, _| (a >> 16) & 255),
    ("unpack4xI8(a).y", |a, _, _| {
        i32::from((a >> 8) as u8 as i8) as u32
    }),
    ("dot4U8Packed(a, b)", |a, b, _| {
        (0..4)
            .map(|i| (a >> (8 * i) & 255) * (b >> (8 * i) & 255))
            .sum()
    }),
    ("dot4I8Packed(a, b)", |a, b, _| {
        let byte = |v: u32, i: i32| i32::from((v >> (8 * i)) as u8 as i8);
        (0..4).map(|i| byte(a, i) * byte(b, i)).sum::<i32>() as u32
    }),
];

#[test]
fn halves_are_rounded_to_the_nearest() {
    // Half floats whose value is known, and what lies just beside them.
    let numbers = [
        (1.0, 0x3C00),
        (-2.0, 0xC000),
        (65_504.0, 0x7BFF),
        (65_519.0, 0x7BFF),
        (65_520.0, 0x7C00),
        (f32::INFINITY, 0x7C00),
        (5.960_464_5e-8, 0x0001),
        (2.980_232e-8, 0x0000),
        (6.103_515_6e-5, 0x0400),
        (0.333_333_34, 0x3555),
        (1.000_488_3, 0x3C00),
        (1.001_464_8, 0x3C02),
        (0.0, 0),
    ];
    let inputs: Vec<f32> = numbers.iter().map(|(v, _)| *v).collect();
    let text = "fn f(a: f32) -> u32 { return pack2x16float(vec2f(a, 0.0)); }";
    let found = call(text, &[&bits(&inputs)]).scalars.swap_remove(0);
    for ((number, half), found) in numbers.iter().zip(found) {
        assert_eq!(found, *half, "{number}");
    }
    let text =
        "fn f(a: u32) -> f32 { return unpack2x16float(pack2x16float(unpack2x16float(a))).x; }";
    let every: Vec<u32> = (0..0x7C00).collect();
    let wide = floats(&call(text, &[&every]).scalars[0]);
    for (half, wide) in every.iter().zip(&wide) {
        let exponent = (half >> 10) as i32;
        let fraction = f64::from(half & 1023) / 1024.0;
        let truth = match exponent {
            0 => fraction * 2f64.powi(-14),
            e => (1.0 + fraction) * 2f64.powi(e - 15),
        };
        assert_eq!(f64::from(*wide), truth, "{half:#x}");
    }
    let text = "fn f(a: f32) -> f32 { return quantizeToF16(a); }";
    assert_eq!(
        floats(&call(text, &[&bits(&[0.1, 3.0])]).scalars[0]),
        [0.099_975_586, 3.0]
    );
}

#[test]
fn numbers_that_are_none_stay_so() {
    let text = "fn f(a: f32) -> vec3f { return vec3f(a, a - a, f32(a != a)); }";
    let found = call(text, &[&bits(&[f32::NAN, f32::INFINITY, 1.0])]).scalars;
    assert!(f32::from_bits(found[0][0]).is_nan() && f32::from_bits(found[1][1]).is_nan());
    assert_eq!(floats(&found[2]), [1.0, 0.0, 0.0]);
    let text = "fn f(a: f32) -> vec2i { return vec2i(i32(a), bitcast<i32>(u32(a))); }";
    let found = call(text, &[&bits(&[f32::NAN, 1e20, -1e20, -1.5])]).scalars;
    assert_eq!(
        found[0],
        [0, i32::MAX as u32, i32::MIN as u32, -1i32 as u32]
    );
    assert_eq!(found[1], [0, u32::MAX, 0, 0]);
}
