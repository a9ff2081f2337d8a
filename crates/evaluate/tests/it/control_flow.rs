//! Lanes that part ways, against one lane after another.

use crate::{call, of_numbers};

#[track_caller]
fn check(wgsl: &str, truth: impl Fn(u32) -> u32) {
    let found = of_numbers(wgsl, 150);
    for (a, found) in (0..).zip(found) {
        assert_eq!(found, truth(a), "of {a}: {wgsl}");
    }
}

#[test]
fn branches() {
    check(
        "fn f(a: u32) -> u32 {
            var x = 1u;
            if a % 2u == 0u { x += a; if a % 3u == 0u { x *= 2u; } else { x += 7u; } }
            else if a > 70u { x = 5u; }
            return x;
        }",
        |a| match a {
            a if a % 6 == 0 => (1 + a) * 2,
            a if a % 2 == 0 => 1 + a + 7,
            a if a > 70 => 5,
            _ => 1,
        },
    );
}

#[test]
fn early_returns_also_from_called_functions() {
    check(
        "fn g(a: u32) -> u32 {
            if a % 5u == 0u { return 100u + a; }
            for (var i = 0u; i < a; i++) { if i * i > a { return i; } }
            return 3u;
        }
        fn f(a: u32) -> u32 {
            if a == 17u { return 1u; }
            let x = g(a) + g(a + 1u);
            if x > 120u { return x; }
            return x + 1000u;
        }",
        |a| {
            let g = |a: u32| match a {
                a if a % 5 == 0 => 100 + a,
                _ => (0..a).find(|i| i * i > a).unwrap_or(3),
            };
            let x = g(a) + g(a + 1);
            match a {
                17 => 1,
                _ if x > 120 => x,
                _ => x + 1000,
            }
        },
    );
}

#[test]
fn nested_loops_with_continue_and_break() {
    check(
        "fn f(a: u32) -> u32 {
            var sum = 0u;
            for (var i = 0u; i < a % 13u; i++) {
                if i == 4u { continue; }
                var k = 0u;
                while k < 9u {
                    k++;
                    if k == i { continue; }
                    if k * i > a { break; }
                    sum += k;
                }
                if sum > 200u { break; }
            }
            return sum;
        }",
        |a| {
            let mut sum = 0;
            for i in 0..a % 13 {
                if i == 4 {
                    continue;
                }
                let mut k = 0;
                while k < 9 {
                    k += 1;
                    if k == i {
                        continue;
                    }
                    if k * i > a {
                        break;
                    }
                    sum += k;
                }
                if sum > 200 {
                    break;
                }
            }
            sum
        },
    );
}

#[test]
fn continuing_and_break_if() {
    check(
        "fn f(a: u32) -> u32 {
            var i = 0u;
            var sum = a;
            loop {
                if i % 3u == 1u { continue; }
                sum += i;
                continuing {
                    i += 1u + a % 2u;
                    sum ^= 5u;
                    break if i > a % 20u;
                }
            }
            return sum;
        }",
        |a| {
            let (mut i, mut sum) = (0, a);
            loop {
                if i % 3 != 1 {
                    sum += i;
                }
                i += 1 + a % 2;
                sum ^= 5;
                if i > a % 20 {
                    return sum;
                }
            }
        },
    );
}

#[test]
fn switches_with_breaks_shared_cases_and_a_default_in_the_middle() {
    check(
        "fn f(a: u32) -> u32 {
            var x = 0u;
            for (var i = 0u; i < 3u; i++) {
                switch (a + i) % 7u {
                    case 0u, 3u: { x += 1u; }
                    case 1u: { if a > 60u { break; } x += 10u; }
                    default: { x += 100u; continue; }
                    case 5u: { x += 1000u; if a % 4u == 1u { return x; } }
                }
                x += 10000u;
            }
            return x;
        }",
        |a| {
            let mut x = 0;
            for i in 0..3 {
                match (a + i) % 7 {
                    0 | 3 => x += 1,
                    1 => x += if a > 60 { 0 } else { 10 },
                    5 => {
                        x += 1000;
                        if a % 4 == 1 {
                            return x;
                        }
                    }
                    _ => {
                        x += 100;
                        continue;
                    }
                }
                x += 10_000;
            }
            x
        },
    );
}

#[test]
fn a_switch_over_a_constant_takes_its_case() {
    check(
        "fn g(a: u32, which: u32) -> u32 {
            var x = a;
            switch which {
                case 1u: { if a > 9u { break; } x += 1u; }
                case 2u: { x += 2u; }
                default: { x += 3u; }
            }
            return x;
        }
        fn f(a: u32) -> u32 { return g(a, 1u) + 1000u * g(a, 2u) + 1000000u * g(a, 9u); }",
        |a| a + u32::from(a <= 9) + 1000 * (a + 2) + 1_000_000 * (a + 3),
    );
}

#[test]
fn short_circuits_do_not_run_the_right_side() {
    check(
        "var<private> count: u32 = 0u;
        fn g(a: u32) -> bool { count += 1u; return a % 2u == 0u; }
        fn f(a: u32) -> u32 {
            let x = a > 50u && g(a);
            let y = a > 100u || g(a + 1u);
            return count + 10u * u32(x) + 100u * u32(y);
        }",
        |a| {
            let count = u32::from(a > 50) + u32::from(a <= 100);
            let x = a > 50 && a % 2 == 0;
            let y = a > 100 || a % 2 == 1;
            count + 10 * u32::from(x) + 100 * u32::from(y)
        },
    );
}

#[test]
fn discarded_lanes_stop_and_others_go_on() {
    let results = call(
        "var<private> seen: u32 = 0u;
        fn g(a: u32) { if a % 3u == 0u { discard; } seen += 1u; }
        fn f(a: u32) -> u32 {
            for (var i = 0u; i < 2u; i++) { g(a + i); }
            return seen;
        }
        @fragment fn main(@location(0) @interpolate(flat) a: u32) -> @location(0) u32 { return f(a); }",
        &[&(0..100).collect::<Vec<u32>>()],
    );
    for (a, is_discarded) in (0..).zip(&results.is_discarded) {
        assert_eq!(*is_discarded, a % 3 == 0 || (a + 1) % 3 == 0, "{a}");
        assert!(*is_discarded || results.scalars[0][a] == 2);
    }
}

/// Large functions that are called from several places are compiled once.
#[test]
fn shared_functions_give_each_call_its_own_result() {
    let steps: String = (0..300).map(|i| format!("x = x * 3u + {i}u;\n")).collect();
    let text = format!(
        "fn g(a: u32, b: u32) -> u32 {{ var x = a; {steps} if b == 7u {{ return x; }} return x ^ b; }}
        fn f(a: u32) -> u32 {{
            var x = g(a, 7u);
            if a % 2u == 1u {{ x += g(a + 5u, 1u); }}
            return x - g(g(a, 2u), 7u);
        }}"
    );
    let g = |a: u32, b: u32| {
        let x = (0..300).fold(a, |x, i| x.wrapping_mul(3).wrapping_add(i));
        if b == 7 { x } else { x ^ b }
    };
    check(&text, |a| {
        let more = if a % 2 == 1 { g(a + 5, 1) } else { 0 };
        g(a, 7).wrapping_add(more).wrapping_sub(g(g(a, 2), 7))
    });
}
