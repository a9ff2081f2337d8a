//! Functions of single numbers, in their bits: what has no operation of its own.

fn f(bits: u32) -> f32 {
    f32::from_bits(bits)
}

macro_rules! of_floats {
    ($($name:ident $method:ident;)*) => {
        $(pub fn $name(a: u32) -> u32 {
            f(a).$method().to_bits()
        })*
    };
}

of_floats! {
    cos cos; cosh cosh; sin sin; sinh sinh; tan tan; tanh tanh;
    acos acos; asin asin; atan atan; asinh asinh; acosh acosh; atanh atanh;
    exp exp; exp2 exp2; log ln; log2 log2;
}

fn truth(is: bool) -> u32 {
    if is { !0 } else { 0 }
}

pub fn is_nan(a: u32) -> u32 {
    truth(f(a).is_nan())
}

pub fn is_inf(a: u32) -> u32 {
    truth(f(a).is_infinite())
}

pub fn atan2(y: u32, x: u32) -> u32 {
    f(y).atan2(f(x)).to_bits()
}

pub fn pow(a: u32, b: u32) -> u32 {
    f(a).powf(f(b)).to_bits()
}

/// a·2^b. In two steps, as 2^b may lie beyond the floats where the result does not.
pub fn ldexp(a: u32, b: u32) -> u32 {
    let exponent = (b as i32).clamp(-400, 400);
    let first = exponent.clamp(-126, 127);
    let second = (exponent - first).clamp(-126, 127);
    let third = (exponent - first - second).clamp(-126, 127);
    let power = |e: i32| f(((e + 127) as u32) << 23);
    (f(a) * power(first) * power(second) * power(third)).to_bits()
}

/// Fraction from ½ to 1 and exponent of a finite number that is not 0.
fn frexp(a: f32) -> (f32, i32) {
    if a == 0.0 || !a.is_finite() {
        return (a, 0);
    }
    // Numbers too small to have all bits are made larger first.
    let (a, shift) = if a.abs() < f32::MIN_POSITIVE {
        (a * 16_777_216.0, -24)
    } else {
        (a, 0)
    };
    let bits = a.to_bits();
    let exponent = ((bits >> 23) & 255) as i32 - 126;
    (f((bits & 0x807F_FFFF) | (126 << 23)), exponent + shift)
}

pub fn frexp_fraction(a: u32) -> u32 {
    frexp(f(a)).0.to_bits()
}

pub fn frexp_exponent(a: u32) -> u32 {
    frexp(f(a)).1 as u32
}

pub fn trailing_zeros(a: u32) -> u32 {
    a.trailing_zeros()
}

pub fn leading_zeros(a: u32) -> u32 {
    a.leading_zeros()
}

pub fn ones(a: u32) -> u32 {
    a.count_ones()
}

pub fn reversed(a: u32) -> u32 {
    a.reverse_bits()
}

pub fn first_trailing(a: u32) -> u32 {
    if a == 0 { !0 } else { a.trailing_zeros() }
}

pub fn first_leading(a: u32) -> u32 {
    if a == 0 { !0 } else { 31 - a.leading_zeros() }
}

pub fn first_leading_signed(a: u32) -> u32 {
    first_leading(if (a as i32) < 0 { !a } else { a })
}

/// Offset and count inside the word, as WGSL wants them.
fn bit_range(offset: u32, count: u32) -> (u32, u32) {
    let offset = offset.min(32);
    (offset, count.min(32 - offset))
}

pub fn extract_unsigned([a, offset, count, _]: [u32; 4]) -> u32 {
    let (offset, count) = bit_range(offset, count);
    if count == 0 {
        return 0;
    }
    (a << (32 - offset - count)) >> (32 - count)
}

pub fn extract_signed([a, offset, count, _]: [u32; 4]) -> u32 {
    let (offset, count) = bit_range(offset, count);
    if count == 0 {
        return 0;
    }
    (((a << (32 - offset - count)) as i32) >> (32 - count)) as u32
}

pub fn insert_bits([a, new, offset, count]: [u32; 4]) -> u32 {
    let (offset, count) = bit_range(offset, count);
    if count == 0 {
        return a;
    }
    let mask = (!0 >> (32 - count)) << offset;
    (a & !mask) | ((new << offset) & mask)
}

/// A number from −1 to 1 as a whole one from −most to most.
fn snorm(a: u32, most: f32) -> i32 {
    (0.5 + most * f(a).clamp(-1.0, 1.0)).floor() as i32
}

fn unorm(a: u32, most: f32) -> u32 {
    (0.5 + most * f(a).clamp(0.0, 1.0)).floor() as u32
}

fn bytes(parts: [u8; 4]) -> u32 {
    u32::from_le_bytes(parts)
}

fn halves(low: u16, high: u16) -> u32 {
    u32::from(low) | u32::from(high) << 16
}

pub fn pack4x8snorm(a: [u32; 4]) -> u32 {
    bytes(a.map(|a| snorm(a, 127.0) as i8 as u8))
}

pub fn pack4x8unorm(a: [u32; 4]) -> u32 {
    bytes(a.map(|a| unorm(a, 255.0) as u8))
}

pub fn pack2x16snorm([a, b, ..]: [u32; 4]) -> u32 {
    halves(snorm(a, 32_767.0) as u16, snorm(b, 32_767.0) as u16)
}

pub fn pack2x16unorm([a, b, ..]: [u32; 4]) -> u32 {
    halves(unorm(a, 65_535.0) as u16, unorm(b, 65_535.0) as u16)
}

pub fn pack2x16float([a, b, ..]: [u32; 4]) -> u32 {
    halves(half(f(a)), half(f(b)))
}

pub fn pack4x8(a: [u32; 4]) -> u32 {
    bytes(a.map(|a| a as u8))
}

pub fn pack4xi8clamp(a: [u32; 4]) -> u32 {
    bytes(a.map(|a| (a as i32).clamp(-128, 127) as u8))
}

pub fn pack4xu8clamp(a: [u32; 4]) -> u32 {
    bytes(a.map(|a| a.min(255) as u8))
}

fn byte(a: u32, part: u32) -> u8 {
    (a >> (8 * (part & 3))) as u8
}

fn short(a: u32, part: u32) -> u16 {
    (a >> (16 * (part & 1))) as u16
}

pub fn unpack4x8snorm(a: u32, part: u32) -> u32 {
    (f32::from(byte(a, part) as i8) / 127.0).max(-1.0).to_bits()
}

pub fn unpack4x8unorm(a: u32, part: u32) -> u32 {
    (f32::from(byte(a, part)) / 255.0).to_bits()
}

pub fn unpack2x16snorm(a: u32, part: u32) -> u32 {
    (f32::from(short(a, part) as i16) / 32_767.0)
        .max(-1.0)
        .to_bits()
}

pub fn unpack2x16unorm(a: u32, part: u32) -> u32 {
    (f32::from(short(a, part)) / 65_535.0).to_bits()
}

pub fn unpack2x16float(a: u32, part: u32) -> u32 {
    of_half(short(a, part)).to_bits()
}

pub fn unpack4xi8(a: u32, part: u32) -> u32 {
    i32::from(byte(a, part) as i8) as u32
}

pub fn unpack4xu8(a: u32, part: u32) -> u32 {
    u32::from(byte(a, part))
}

pub fn dot4i8(a: u32, b: u32) -> u32 {
    let product = |i| i32::from(byte(a, i) as i8) * i32::from(byte(b, i) as i8);
    (0..4).map(product).sum::<i32>() as u32
}

pub fn dot4u8(a: u32, b: u32) -> u32 {
    (0..4)
        .map(|i| u32::from(byte(a, i)) * u32::from(byte(b, i)))
        .sum()
}

pub fn quantize_to_f16(a: u32) -> u32 {
    of_half(half(f(a))).to_bits()
}

/// The nearest 16-bit float, ties to even.
fn half(a: f32) -> u16 {
    let sign = ((a.to_bits() >> 16) & 0x8000) as u16;
    let size = a.abs();
    if size.is_nan() {
        return sign | 0x7E00;
    }
    if size >= 65_520.0 {
        return sign | 0x7C00;
    }
    if size < 6.103_515_6e-5 {
        // Steps of 2⁻²⁴.
        return sign | (size * 16_777_216.0).round_ties_even() as u16;
    }
    let bits = size.to_bits();
    let rounded = bits + 0xFFF + ((bits >> 13) & 1);
    sign | ((rounded - (112 << 23)) >> 13) as u16
}

fn of_half(a: u16) -> f32 {
    let sign = if a & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (u32::from(a >> 10) & 31, u32::from(a & 1023));
    let size = match exponent {
        0 => fraction as f32 / 16_777_216.0,
        31 if fraction == 0 => f32::INFINITY,
        31 => f32::NAN,
        _ => f((exponent + 112) << 23 | fraction << 13),
    };
    sign * size
}
