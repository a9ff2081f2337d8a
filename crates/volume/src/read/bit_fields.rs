//! Numbers of 1 to 16 bits, packed without gaps, the highest bit of a byte first: rows of TIFF and PNG.

/// The first `count` numbers of `bits` bits each.
pub(crate) fn unpacked(packed: &[u8], bits: u32, count: usize) -> impl Iterator<Item = u16> + '_ {
    debug_assert!((1..=16).contains(&bits));
    let mut bytes = packed.iter();
    let (mut held, mut held_bits) = (0u32, 0);
    std::iter::from_fn(move || {
        while held_bits < bits {
            held = held << 8 | u32::from(*bytes.next()?);
            held_bits += 8;
        }
        held_bits -= bits;
        let number = held >> held_bits;
        held &= (1 << held_bits) - 1;
        Some(number as u16)
    })
    .take(count)
}

#[cfg(test)]
mod tests {
    use super::unpacked;

    #[test]
    fn numbers_lie_highest_bit_first() {
        let all = |packed: &[u8], bits, count| unpacked(packed, bits, count).collect::<Vec<_>>();
        assert_eq!(all(&[0b1010_0000], 1, 3), [1, 0, 1]);
        assert_eq!(all(&[0b1101_0010], 2, 4), [3, 1, 0, 2]);
        assert_eq!(all(&[0x12, 0x30], 4, 3), [1, 2, 3]);
        assert_eq!(all(&[0xab, 0xcd, 0xef], 12, 2), [0xabc, 0xdef]);
        assert_eq!(all(&[0xff, 0xff], 16, 1), [0xffff]);
        assert_eq!(all(&[0xff], 12, 1), [0; 0]);
    }
}
