//! What is not covered is refused before it runs, by name.

use crate::parse;
use strahl_evaluate::{Error, Machine, Resources};

#[test]
fn what_is_not_covered_is_named() {
    for (text, words) in [
        (
            "fn edge(a: f32) -> f32 { return dpdx(a); }
            @fragment fn main(@location(0) a: f32) -> @location(0) vec4f { return vec4f(edge(a)); }",
            "no derivative over pixels, which function edge uses",
        ),
        (
            "@group(0) @binding(0) var<storage, read_write> all: array<f32, 4>;
            @fragment fn main() -> @location(0) vec4f { all[0] = 1.0; return vec4f(all[1]); }",
            "address space Storage",
        ),
        (
            "@group(0) @binding(0) var t: texture_depth_2d;
            @fragment fn main() -> @location(0) vec4f { return vec4f(textureLoad(t, vec2i(0), 0)); }",
            "texture of type",
        ),
        (
            "@fragment fn main() -> @location(0) vec4f { var a: array<f32, 20000>; return vec4f(a[1]); }",
            "variable of more than",
        ),
    ] {
        let module = parse(text);
        let refused = Machine::new(&module, Resources::new()).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
        assert!(matches!(refused, Error::NotCovered { .. }), "{refused}");
    }
}

/// What no entry point reaches is nobody's concern until it is called.
#[test]
fn functions_that_are_not_reached_are_not_refused() {
    let module = parse(
        "fn edge(a: f32) -> f32 { return dpdx(a); }
        @fragment fn main(@location(0) a: f32) -> @location(0) vec4f { return vec4f(a); }",
    );
    let machine = Machine::new(&module, Resources::new()).unwrap();
    assert!(machine.call("main", 1, &[&[0]]).is_ok());
    assert!(machine.call("edge", 1, &[&[0]]).is_err());
}

#[test]
fn loops_without_end_end() {
    let module = parse(
        "@fragment fn main(@location(0) a: f32) -> @location(0) vec4f {
            var x = a;
            loop { x += 1.0; if x < -5.0 { break; } }
            return vec4f(x);
        }",
    );
    let machine = Machine::new(&module, Resources::new()).unwrap();
    let endless = machine.call("main", 1, &[&[0]]).unwrap_err();
    assert!(matches!(endless, Error::Endless(_)), "{endless}");
}

/// Loops within bounds and calls of functions, multiplied by one another.
#[test]
fn trees_of_calls_end() {
    let mut text = "fn c0(a: f32) -> f32 { return a * 1.1; }".to_owned();
    for i in 1..50 {
        let below = i - 1;
        text += &format!("fn c{i}(a: f32) -> f32 {{ return c{below}(a) + c{below}(a + 1.0); }}");
    }
    text +=
        "@fragment fn main(@location(0) a: f32) -> @location(0) vec4f { return vec4f(c49(a)); }";
    let loops = "@fragment fn main(@location(0) a: f32) -> @location(0) vec4f {
        var x = a;
        for (var i = 0; i < 1000000; i++) { for (var j = 0; j < 1000000; j++) { x += 1.0; } }
        return vec4f(x);
    }";
    for text in [&*text, loops] {
        let module = parse(text);
        let machine = Machine::new(&module, Resources::new()).unwrap();
        let machine = machine.with_most_operations(1 << 20);
        let endless = machine.call("main", 1, &[&[0]]).unwrap_err();
        assert!(matches!(endless, Error::TooMuch(_)), "{endless}");
    }
}
