//! DICOM run-length encoding: one run-length coded segment per byte plane, high bytes first
//! (PS3.5, annex G).
//!
//! | bytes | meaning                                                    |
//! |-------|------------------------------------------------------------|
//! | 0–3   | number of segments u32                                     |
//! | 4–63  | where each segment begins, 15 × u32                        |
//! | …     | control byte n as i8: 0…127 copy n + 1 bytes; −127…−1      |
//! |       | repeat the next byte 1 − n times; −128 nothing             |

/// The bytes of a frame of `sample_bytes`-byte samples in little endian, `frame.len()` of them: plane by plane, if
/// there are several `components`.
///
/// # Errors
/// What is wrong with the data.
pub(super) fn decode(
    data: &[u8],
    sample_bytes: usize,
    components: usize,
    frame: &mut [u8],
) -> Result<(), String> {
    let word = |at: usize| -> Option<usize> {
        let bytes = data.get(at..at + 4)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes) as usize)
    };
    let segments = word(0).ok_or("it has no header")?;
    if segments != sample_bytes * components {
        return Err(format!(
            "it has {segments} segments; {components} samples of {sample_bytes} bytes need {}",
            sample_bytes * components
        ));
    }
    let plane_bytes = frame.len() / components;
    for segment in 0..segments {
        let begin = word(4 + 4 * segment).ok_or("its header is cut off")?;
        let end = match segment + 1 < segments {
            true => word(8 + 4 * segment).ok_or("its header is cut off")?,
            false => data.len(),
        };
        let source = data
            .get(begin.max(64)..end)
            .ok_or_else(|| format!("segment {segment} lies outside of the data"))?;
        let (component, byte) = (segment / sample_bytes, segment % sample_bytes);
        let plane = frame[component * plane_bytes..][..plane_bytes]
            .iter_mut()
            .skip(sample_bytes - 1 - byte)
            .step_by(sample_bytes);
        unpack(source, plane)
            .ok_or_else(|| format!("segment {segment} ends before the frame is full"))?;
    }
    Ok(())
}

/// Fills the whole plane, or `None` if there is not enough.
fn unpack<'a>(
    mut source: &[u8],
    mut plane: impl ExactSizeIterator<Item = &'a mut u8>,
) -> Option<()> {
    while plane.len() > 0 {
        let (&control, rest) = source.split_first()?;
        source = rest;
        match control {
            0..=127 => {
                let count = usize::from(control) + 1;
                let (literal, rest) = source.split_at_checked(count.min(plane.len()))?;
                for (into, byte) in plane.by_ref().take(count).zip(literal) {
                    *into = *byte;
                }
                source = rest;
            }
            128 => {}
            129..=255 => {
                let (&byte, rest) = source.split_first()?;
                source = rest;
                plane
                    .by_ref()
                    .take(257 - usize::from(control))
                    .for_each(|into| *into = byte);
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_literals_and_planes() {
        let mut data = vec![0; 64];
        data[0] = 2;
        data[4] = 64;
        // High bytes: 1 four times. Low bytes: 10, 20, nothing, then 30 twice.
        data.extend([0xFD, 1, 0x01, 10, 20, 0x80, 0xFF, 30]);
        data[8] = 66;
        let mut frame = [0; 8];
        decode(&data, 2, 1, &mut frame).unwrap();
        assert_eq!(frame, [10, 1, 20, 1, 30, 1, 30, 1]);
    }

    #[test]
    fn every_prefix_is_an_error() {
        let mut data = vec![0; 64];
        data[0] = 1;
        data[4] = 64;
        data.extend([0x02, 1, 2, 3, 0xFE, 9]);
        for n in 0..data.len() {
            assert!(decode(&data[..n], 1, 1, &mut [0; 6]).is_err(), "{n} bytes");
        }
        let mut frame = [0; 6];
        decode(&data, 1, 1, &mut frame).unwrap();
        assert_eq!(frame, [1, 2, 3, 9, 9, 9]);
    }

    #[test]
    fn components_lie_plane_by_plane() {
        let mut data = vec![0; 64];
        data[0] = 3;
        (data[4], data[8], data[12]) = (64, 66, 68);
        data.extend([0xFF, 1, 0xFF, 2, 0xFF, 3]);
        let mut frame = [0; 6];
        decode(&data, 1, 3, &mut frame).unwrap();
        assert_eq!(frame, [1, 1, 2, 2, 3, 3]);
        assert!(decode(&data, 2, 1, &mut frame).is_err());
    }
}
