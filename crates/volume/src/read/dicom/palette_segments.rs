//! Tables of a palette in segments (PS3.3, C.7.9.2).
//!
//! | segment | numbers | colors |
//! |---|---|---|
//! | discrete | 0, n, n numbers | these |
//! | linear | 1, n, end | n in even steps from the color before it, which is not repeated, to the end |
//! | indirect | 2, n, offset (4 bytes, low part first) | n segments of the other kinds again, from this byte on |

/// A segment as it is stored.
enum Segment<'a> {
    Discrete(&'a [u16]),
    Linear { colors: u16, end: u16 },
    Indirect { segments: u16, byte: usize },
}

/// The segments of one color.
pub(super) struct Segments<'a> {
    /// As they are stored, of 8 or 16 bits.
    pub(super) numbers: &'a [u16],
    pub(super) are_wide: bool,
}

impl Segments<'_> {
    /// The `entries` colors of the segments.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn colors(&self, entries: usize) -> Result<Vec<u16>, String> {
        let mut colors = Vec::new();
        let mut at = 0;
        // Behind an odd number of bytes lies one more that belongs to no segment.
        while at < self.numbers.len() && colors.len() < entries {
            let (segment, next) = self.segment(at)?;
            match segment {
                Segment::Indirect { segments, byte } => {
                    self.copy(segments, byte, entries, &mut colors)?;
                }
                other => append(&other, entries, &mut colors)?,
            }
            at = next;
        }
        if colors.len() < entries {
            return Err(format!(
                "its segments make {} of {entries} colors",
                colors.len()
            ));
        }
        if self.numbers.len() - at > usize::from(!self.are_wide) {
            return Err(format!("its segments make more than {entries} colors"));
        }
        Ok(colors)
    }

    /// Appends the segments that an indirect one names.
    fn copy(
        &self,
        segments: u16,
        byte: usize,
        entries: usize,
        colors: &mut Vec<u16>,
    ) -> Result<(), String> {
        let bytes = if self.are_wide { 2 } else { 1 };
        if !byte.is_multiple_of(bytes) {
            return Err(format!("an indirect segment names the odd byte {byte}"));
        }
        let mut at = byte / bytes;
        for _ in 0..segments {
            let (segment, next) = self.segment(at)?;
            append(&segment, entries, colors)?;
            at = next;
        }
        Ok(())
    }

    /// The segment at a number, and where the next one begins.
    fn segment(&self, at: usize) -> Result<(Segment<'_>, usize), String> {
        let cut_off = || format!("the segment at number {at} is cut off");
        let rest = self.numbers.get(at..).ok_or_else(cut_off)?;
        let number = |i: usize| rest.get(i).copied().ok_or_else(cut_off);
        let (kind, length) = (number(0)?, number(1)?);
        if length == 0 {
            return Err(format!("the segment at number {at} is of length 0"));
        }
        Ok(match kind {
            0 => {
                let end = 2 + usize::from(length);
                let colors = rest.get(2..end).ok_or_else(cut_off)?;
                (Segment::Discrete(colors), at + end)
            }
            1 => {
                let (colors, end) = (length, number(2)?);
                (Segment::Linear { colors, end }, at + 3)
            }
            2 => {
                let (numbers, bits) = if self.are_wide { (2, 16) } else { (4, 8) };
                let mut byte = 0;
                for i in (0..numbers).rev() {
                    byte = byte << bits | usize::from(number(2 + i)?);
                }
                let segments = length;
                (Segment::Indirect { segments, byte }, at + 2 + numbers)
            }
            other => {
                return Err(format!(
                    "the segment at number {at} is of kind {other}; allowed are 0 (discrete), 1 (linear) and 2 (indirect)"
                ));
            }
        })
    }
}

/// Appends the colors of a segment that is not indirect.
fn append(segment: &Segment, entries: usize, colors: &mut Vec<u16>) -> Result<(), String> {
    let added = match segment {
        Segment::Discrete(numbers) => numbers.len(),
        Segment::Linear { colors, .. } => usize::from(*colors),
        Segment::Indirect { .. } => {
            return Err("an indirect segment names another indirect one".into());
        }
    };
    if colors.len() + added > entries {
        return Err(format!("its segments make more than {entries} colors"));
    }
    match segment {
        Segment::Discrete(numbers) => colors.extend_from_slice(numbers),
        Segment::Linear { end, .. } => {
            let begin = *colors.last().ok_or("a linear segment comes first")?;
            let (begin, end) = (f64::from(begin), f64::from(*end));
            let step = (end - begin) / added as f64;
            colors.extend((1..=added).map(|i| (begin + step * i as f64).round() as u16));
        }
        Segment::Indirect { .. } => {}
    }
    Ok(())
}
