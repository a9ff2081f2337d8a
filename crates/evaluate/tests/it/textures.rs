//! Texels and what lies between them.

use crate::{bits, floats, parse};
use proptest::prelude::*;
use strahl_evaluate::{
    Address, Error, Filter, Machine, Numbers, Resource, Resources, Sampler, Texture,
};
use strahl_volume::Samples;

const DIMS: [u32; 3] = [3, 4, 2];

fn volume(numbers: Numbers) -> Resource {
    Resource::Texture(Texture::new(DIMS, 1, numbers).unwrap())
}

#[test]
fn texels_of_every_kind_and_zeros_outside() {
    let stored = Samples::I16((0..24).map(|i| i - 5).collect());
    for (kind, numbers, one) in [
        (
            "f32",
            Numbers::F32((0..24).map(|i| i as f32 - 5.0).collect()),
            1,
        ),
        ("f32", Numbers::Stored(&stored), 1),
        ("i32", Numbers::I32((0..24).map(|i| i - 5).collect()), 1),
        (
            "u32",
            Numbers::U32((0..24).map(|i| (i - 5) as u32).collect()),
            1,
        ),
    ] {
        let module = parse(&format!(
            "@group(1) @binding(7) var t: texture_3d<{kind}>;
            fn f(x: i32, y: i32, z: i32) -> vec4i {{ return vec4i(textureLoad(t, vec3i(x, y, z), 0)); }}
            fn size() -> vec3u {{ return textureDimensions(t); }}"
        ));
        let machine = Machine::new(&module, Resources::new().with(1, 7, volume(numbers))).unwrap();
        let (mut x, mut y, mut z, mut expected) = (vec![], vec![], vec![], vec![]);
        for at in 0..6 * 7 * 5 {
            let [u, v, w] = [at % 6 - 1, at / 6 % 7 - 1, at / 42 - 1];
            let is_inside = (0..3).contains(&u) && (0..4).contains(&v) && (0..2).contains(&w);
            expected.push(if is_inside {
                u + 3 * (v + 4 * w) - 5
            } else {
                0
            } as u32);
            x.push(u as u32);
            y.push(v as u32);
            z.push(w as u32);
        }
        let found = machine.call("f", x.len(), &[&x, &y, &z]).unwrap();
        assert_eq!(found.scalars[0], expected, "{kind}");
        // The middle is inside: the fourth channel of a texture without one is 1.
        let inside = machine.call("f", 1, &[&[1], &[1], &[1]]).unwrap();
        let rest: Vec<u32> = inside.scalars[1..].iter().map(|s| s[0]).collect();
        assert_eq!(rest, [0, 0, one]);
        let size = machine.call("size", 1, &[]).unwrap();
        assert_eq!(size.scalars.concat(), DIMS);
    }
}

fn sampled(filter: Filter, address: Address, dims: [u32; 3], places: &[[f32; 3]]) -> Vec<f32> {
    let module = parse(
        "@group(0) @binding(0) var t: texture_3d<f32>;
        @group(0) @binding(1) var s: sampler;
        fn f(x: f32, y: f32, z: f32) -> f32 { return textureSampleLevel(t, s, vec3f(x, y, z), 0.0).x; }",
    );
    let numbers = Numbers::F32((0..dims.iter().product()).map(number).collect());
    let resources = Resources::new()
        .with(
            0,
            0,
            Resource::Texture(Texture::new(dims, 1, numbers).unwrap()),
        )
        .with(0, 1, Resource::Sampler(Sampler { filter, address }));
    let machine = Machine::new(&module, resources).unwrap();
    let axis = |a: usize| bits(&places.iter().map(|p| p[a]).collect::<Vec<_>>());
    let found = machine.call("f", places.len(), &[&axis(0), &axis(1), &axis(2)]);
    floats(&found.unwrap().scalars[0])
}

fn number(i: u32) -> f32 {
    (i * 7 % 11) as f32
}

/// Where a texel lies beyond the edge.
fn wrapped(i: i64, n: i64, address: Address) -> i64 {
    match address {
        Address::ClampToEdge => i.clamp(0, n - 1),
        Address::Repeat => i.rem_euclid(n),
        Address::MirrorRepeat => {
            let i = i.rem_euclid(2 * n);
            if i < n { i } else { 2 * n - 1 - i }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(40) })]

    #[test]
    fn samplers_weigh_exactly(
        places in prop::collection::vec(prop::array::uniform3(-1.7f32..2.9), 80)
    ) {
        for address in [Address::ClampToEdge, Address::Repeat, Address::MirrorRepeat] {
            let at = |[x, y, z]: [i64; 3]| {
                let [x, y, z] = [0, 1, 2].map(|a| {
                    wrapped([x, y, z][a], i64::from(DIMS[a]), address) as u32
                });
                f64::from(number(x + DIMS[0] * (y + DIMS[1] * z)))
            };
            let linear = sampled(Filter::Linear, address, DIMS, &places);
            let nearest = sampled(Filter::Nearest, address, DIMS, &places);
            for (i, place) in places.iter().enumerate() {
                let texels = [0, 1, 2].map(|a| f64::from(place[a]) * f64::from(DIMS[a]));
                let low = texels.map(|t| (t - 0.5).floor());
                let mut truth = 0.0;
                for corner in 0..8 {
                    let side = [0, 1, 2].map(|a| i64::from(corner >> a & 1));
                    let weight: f64 = (0..3)
                        .map(|a| {
                            let part = texels[a] - 0.5 - low[a];
                            if side[a] == 1 { part } else { 1.0 - part }
                        })
                        .product();
                    truth += weight * at([0, 1, 2].map(|a| low[a] as i64 + side[a]));
                }
                prop_assert!((f64::from(linear[i]) - truth).abs() < 1e-4, "{:?}: {} {}", place, linear[i], truth);
                // Not where rounding decides.
                if texels.iter().all(|t| (t - t.round()).abs() > 1e-4) {
                    prop_assert_eq!(f64::from(nearest[i]), at(texels.map(|t| t.floor() as i64)));
                }
            }
        }
    }
}

#[test]
fn places_that_are_no_numbers_read_a_texel() {
    let places = [
        [f32::NAN; 3],
        [f32::INFINITY; 3],
        [-f32::INFINITY, 1e30, 0.5],
    ];
    for address in [Address::ClampToEdge, Address::Repeat, Address::MirrorRepeat] {
        for filter in [Filter::Linear, Filter::Nearest] {
            let found = sampled(filter, address, DIMS, &places);
            assert!(found.iter().all(|v| (0.0..=10.0).contains(v)), "{found:?}");
        }
    }
}

#[test]
fn flat_textures_with_channels() {
    let module = parse(
        "@group(0) @binding(0) var t: texture_2d<f32>;
        @group(0) @binding(1) var s: sampler;
        @fragment fn f(@location(0) at: vec2f) -> @location(0) vec4f { return textureSample(t, s, at); }",
    );
    let numbers = Numbers::F32(vec![0.0, 10.0, 100.0, 4.0, 20.0, 300.0].into());
    let texture = Texture::new([2, 1, 1], 3, numbers).unwrap();
    let resources = Resources::new()
        .with(0, 0, Resource::Texture(texture))
        .with(0, 1, Resource::Sampler(Sampler::default()));
    let machine = Machine::new(&module, resources).unwrap();
    let found = machine
        .call("f", 2, &[&bits(&[0.5, 0.0]), &bits(&[0.5, 0.9])])
        .unwrap();
    let found: Vec<_> = found.scalars.iter().map(|s| floats(s)).collect();
    assert_eq!(
        found,
        [[2.0, 0.0], [15.0, 10.0], [200.0, 100.0], [1.0, 1.0]]
    );
}

#[test]
fn textures_of_another_kind_are_refused() {
    let module = parse(
        "@group(0) @binding(0) var t: texture_3d<u32>;
        @fragment fn f() -> @location(0) vec4u { return textureLoad(t, vec3i(0), 0); }",
    );
    let refuse = |resource| {
        let refused = Machine::new(&module, Resources::new().with(0, 0, resource)).unwrap_err();
        assert!(matches!(refused, Error::Resource { .. }), "{refused}");
        refused.to_string()
    };
    let floats = refuse(volume(Numbers::F32(vec![0.0; 24].into())));
    assert!(
        floats.contains("of Uint numbers, Float are bound"),
        "{floats}"
    );
    let block = refuse(Resource::Uniform(vec![0; 64]));
    assert!(block.contains("no texture"), "{block}");
    let short = Texture::new(DIMS, 2, Numbers::F32(vec![0.0; 24].into())).unwrap_err();
    assert!(short.to_string().contains("24 numbers"), "{short}");
}
