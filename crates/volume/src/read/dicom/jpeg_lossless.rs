//! JPEG lossless, sequential, with Huffman codes (ITU-T T.81, annex H; process 14, marker SOF3): all seven
//! predictors, 2 to 16 bits, point transforms, restart intervals, components in one scan or in several.
//!
//! Our own, because the decoder at hand predicts from shifted samples where there is a point transform, and goes on
//! predicting across restart markers: it gives noise without a word.
//! Departures: subsampled components and an unknown number of lines (DNL) are refused; DICOM has none.

/// Decodes a frame of exactly `columns` × `rows` samples of `components` components into `samples`: row by row, the
/// components of a sample side by side.
///
/// # Errors
/// What is wrong with the data, or which part of the standard is not supported.
pub(super) fn decode(
    data: &[u8],
    columns: usize,
    rows: usize,
    components: usize,
    samples: &mut [u16],
) -> Result<(), String> {
    assert_eq!(samples.len(), columns * rows * components);
    if data.first_chunk() != Some(&[0xFF, 0xD8]) {
        return Err("it does not begin with FF D8".into());
    }
    let mut stream = Stream {
        frame: Frame {
            columns,
            rows,
            bits: 0,
            ids: Vec::new(),
        },
        tables: Default::default(),
        restart_interval: 0,
    };
    let mut decoded = vec![false; components];
    let mut at = 2;
    while decoded.contains(&false) {
        let marker = match data.get(at..at + 2) {
            Some(&[0xFF, 0xFF]) => {
                at += 1;
                continue;
            }
            Some(&[0xFF, marker]) => marker,
            Some(_) => return Err(format!("there is no marker at byte {at}")),
            None => return Err("it ends before its samples".into()),
        };
        let length = data.get(at + 2..at + 4).map(|b| word(b) as usize);
        let body = length
            .filter(|length| *length >= 2)
            .and_then(|length| data.get(at + 4..at + 2 + length))
            .ok_or("it ends before its samples")?;
        at += 4 + body.len();
        match marker {
            0xC3 => stream.frame_header(body, components)?,
            0xC4 => stream.huffman_tables(body)?,
            0xDD => match body {
                &[high, low] => stream.restart_interval = word(&[high, low]) as usize,
                _ => return Err("its restart interval is not of 2 bytes".into()),
            },
            0xDA => {
                let scan = stream.scan_header(body)?;
                for part in &scan.parts {
                    if std::mem::replace(&mut decoded[part.component], true) {
                        return Err(format!("component {} comes twice", part.component + 1));
                    }
                }
                at += scan.decode(&data[at..], components, samples)?;
            }
            0xD9 => return Err("it ends before its samples".into()),
            0xE0..=0xEF | 0xFE => {}
            other => {
                return Err(format!(
                    "the marker FF {other:02X} does not belong into lossless JPEG"
                ));
            }
        }
    }
    Ok(())
}

fn word(bytes: &[u8]) -> u32 {
    u32::from(bytes[0]) << 8 | u32::from(bytes[1])
}

/// What holds for the scans that follow.
struct Stream {
    frame: Frame,
    tables: [Option<Huffman>; 4],
    /// In samples; 0 for none.
    restart_interval: usize,
}

struct Frame {
    columns: usize,
    rows: usize,
    /// Bits of a sample; 0 before the frame header.
    bits: u32,
    /// What the file calls each component.
    ids: Vec<u8>,
}

impl Stream {
    fn frame_header(&mut self, body: &[u8], components: usize) -> Result<(), String> {
        if self.frame.bits != 0 {
            return Err("it has two frame headers".into());
        }
        let (&[bits, y1, y2, x1, x2, count], rest) = body
            .split_first_chunk()
            .ok_or("its frame header is cut off")?;
        let (rows, columns) = (word(&[y1, y2]) as usize, word(&[x1, x2]) as usize);
        let frame = &mut self.frame;
        if (columns, rows, usize::from(count)) != (frame.columns, frame.rows, components) {
            return Err(format!(
                "it holds {columns}×{rows} samples of {count} components, the header states {}×{} of {components}",
                frame.columns, frame.rows
            ));
        }
        if !(2..=16).contains(&bits) {
            return Err(format!(
                "it has samples of {bits} bits; allowed are 2 to 16"
            ));
        }
        if rest.len() != 3 * components {
            return Err("its frame header is cut off".into());
        }
        for component in rest.chunks_exact(3) {
            if component[1] != 0x11 {
                return Err("subsampled components are not supported".into());
            }
            frame.ids.push(component[0]);
        }
        frame.bits = bits.into();
        Ok(())
    }

    fn huffman_tables(&mut self, body: &[u8]) -> Result<(), String> {
        let mut rest = body;
        while let Some((&[kind], after)) = rest.split_first_chunk() {
            let (lengths, after) = after
                .split_first_chunk::<16>()
                .ok_or("a Huffman table is cut off")?;
            let codes = lengths.iter().map(|n| usize::from(*n)).sum();
            let categories = after.get(..codes).ok_or("a Huffman table is cut off")?;
            rest = &after[codes..];
            // Lossless JPEG has tables of class 0 only.
            let into = self.tables.get_mut(usize::from(kind));
            let into = into.ok_or_else(|| format!("there is no Huffman table {kind:02X}"))?;
            *into = Some(Huffman::new(lengths, categories)?);
        }
        Ok(())
    }

    fn scan_header(&self, body: &[u8]) -> Result<Scan<'_>, String> {
        let frame = &self.frame;
        if frame.bits == 0 {
            return Err("its samples come before the frame header".into());
        }
        let (&count, rest) = body.split_first().ok_or("its scan header is cut off")?;
        let count = usize::from(count);
        if count == 0 || rest.len() != 2 * count + 3 {
            return Err("its scan header has the wrong length".into());
        }
        let (listed, parameters) = rest.split_at(2 * count);
        let mut parts = Vec::new();
        for part in listed.chunks_exact(2) {
            let component = frame.ids.iter().position(|id| *id == part[0]);
            let table = self.tables.get(usize::from(part[1] >> 4));
            parts.push(Part {
                component: component.ok_or_else(|| format!("there is no component {}", part[0]))?,
                table: table
                    .and_then(Option::as_ref)
                    .ok_or_else(|| format!("there is no Huffman table {}", part[1] >> 4))?,
            });
        }
        let (predictor, shift) = (parameters[0], u32::from(parameters[2] & 15));
        if !(1..=7).contains(&predictor) {
            return Err(format!("its predictor is {predictor}; allowed are 1 to 7"));
        }
        if shift >= frame.bits {
            return Err(format!(
                "its point transform is {shift}; allowed are 0 to {}",
                frame.bits - 1
            ));
        }
        // T.81, H.1.1: so that every interval begins with a row.
        if !self.restart_interval.is_multiple_of(frame.columns) {
            return Err(format!(
                "its restart interval is {}; allowed are whole rows of {} samples",
                self.restart_interval, frame.columns
            ));
        }
        Ok(Scan {
            frame,
            parts,
            predictor,
            shift,
            interval_rows: self.restart_interval / frame.columns,
        })
    }
}

/// A component of a scan.
struct Part<'a> {
    component: usize,
    table: &'a Huffman,
}

struct Scan<'a> {
    frame: &'a Frame,
    parts: Vec<Part<'a>>,
    predictor: u8,
    /// The point transform: low bits that were left out.
    shift: u32,
    /// Rows between two restart markers; 0 for none.
    interval_rows: usize,
}

impl Scan<'_> {
    /// Decodes all its samples and returns how many bytes they took.
    fn decode(&self, data: &[u8], pitch: usize, samples: &mut [u16]) -> Result<usize, String> {
        let mut bits = Bits::new(data);
        let row_samples = self.frame.columns * pitch;
        for row in 0..self.frame.rows {
            let starts =
                row == 0 || (self.interval_rows > 0 && row.is_multiple_of(self.interval_rows));
            if starts && row > 0 {
                bits.restart((row / self.interval_rows - 1) as u8 % 8)?;
            }
            let (before, here) = samples.split_at_mut(row * row_samples);
            let above = &before[before.len() - if row > 0 { row_samples } else { 0 }..];
            let above = (!starts).then_some(above);
            self.row(&mut bits, above, &mut here[..row_samples], pitch)?;
        }
        // Predictions need the shifted samples, so they are put right at the end.
        if self.shift > 0 {
            for part in &self.parts {
                let own = samples.iter_mut().skip(part.component).step_by(pitch);
                own.for_each(|sample| *sample <<= self.shift);
            }
        }
        Ok(bits.end())
    }

    /// One row of all components; `above` is the row before it in its restart interval.
    fn row(
        &self,
        bits: &mut Bits,
        above: Option<&[u16]>,
        row: &mut [u16],
        pitch: usize,
    ) -> Result<(), String> {
        for column in 0..self.frame.columns {
            for part in &self.parts {
                let at = column * pitch + part.component;
                let predicted = match (above, column) {
                    (None, 0) => 1 << (self.frame.bits - self.shift - 1),
                    (None, _) => i32::from(row[at - pitch]),
                    (Some(above), 0) => i32::from(above[at]),
                    (Some(above), _) => self.predicted(
                        i32::from(row[at - pitch]),
                        i32::from(above[at]),
                        i32::from(above[at - pitch]),
                    ),
                };
                // Modulo 2^16 (H.1.2.1).
                row[at] = (predicted + part.table.difference(bits)?) as u16;
            }
        }
        Ok(())
    }

    /// From the samples to the left, above, and above to the left (table H.1).
    fn predicted(&self, left: i32, above: i32, corner: i32) -> i32 {
        match self.predictor {
            1 => left,
            2 => above,
            3 => corner,
            4 => left + above - corner,
            5 => left + ((above - corner) >> 1),
            6 => above + ((left - corner) >> 1),
            _ => (left + above) >> 1,
        }
    }
}

/// Codes up to this length are looked up at once.
const SHORT_BITS: u32 = 8;

/// Codes for the number of bits of a difference (annex C).
struct Huffman {
    /// Category and length of the code that begins with these bits; length 0 for longer codes.
    short: Box<[(u8, u8); 1 << SHORT_BITS]>,
    /// For each length: the first code, how many there are, and where their categories begin.
    long: [(u32, u32, usize); 17],
    categories: Vec<u8>,
}

impl Huffman {
    fn new(lengths: &[u8; 16], categories: &[u8]) -> Result<Huffman, String> {
        if let Some(category) = categories.iter().find(|category| **category > 16) {
            return Err(format!(
                "a Huffman table has differences of {category} bits; allowed are 0 to 16"
            ));
        }
        let mut table = Huffman {
            short: Box::new([(0, 0); 1 << SHORT_BITS]),
            long: [(0, 0, 0); 17],
            categories: categories.to_vec(),
        };
        let (mut code, mut first) = (0u32, 0usize);
        for (length, &count) in (1u32..).zip(lengths) {
            let count = u32::from(count);
            if code + count > 1 << length {
                return Err("a Huffman table has more codes than fit".into());
            }
            table.long[length as usize] = (code, count, first);
            if length <= SHORT_BITS {
                for k in 0..count {
                    let entry = (categories[first + k as usize], length as u8);
                    let start = ((code + k) << (SHORT_BITS - length)) as usize;
                    table.short[start..start + (1 << (SHORT_BITS - length))].fill(entry);
                }
            }
            first += count as usize;
            code = (code + count) << 1;
        }
        Ok(table)
    }

    fn category(&self, bits: &mut Bits) -> Result<u32, String> {
        let ahead = bits.peek(16);
        let (category, length) = self.short[(ahead >> (16 - SHORT_BITS)) as usize];
        if length > 0 {
            bits.take(length.into())?;
            return Ok(category.into());
        }
        for length in SHORT_BITS + 1..=16 {
            let (first, count, start) = self.long[length as usize];
            let code = ahead >> (16 - length);
            if code >= first && code - first < count {
                bits.take(length)?;
                return Ok(self.categories[start + (code - first) as usize].into());
            }
        }
        Err("there are bits that are no code of its Huffman table".into())
    }

    /// A difference (H.1.2.2): a category, then that many bits; 16 has none and stands for 32768.
    fn difference(&self, bits: &mut Bits) -> Result<i32, String> {
        let category = self.category(bits)?;
        if category == 0 || category == 16 {
            return Ok(if category == 16 { 32768 } else { 0 });
        }
        let value = bits.peek(category) as i32;
        bits.take(category)?;
        let is_negative = value < 1 << (category - 1);
        Ok(if is_negative {
            value - (1 << category) + 1
        } else {
            value
        })
    }
}

/// Bits of entropy-coded data, the highest of a byte first; a zero behind FF is left out.
struct Bits<'a> {
    data: &'a [u8],
    /// The next byte that is not in `held`.
    at: usize,
    held: u64,
    held_bits: u32,
    /// How many of the held bits lie behind the data: before a marker, or the end of the file.
    missing_bits: u32,
}

impl Bits<'_> {
    fn new(data: &[u8]) -> Bits<'_> {
        Bits {
            data,
            at: 0,
            held: 0,
            held_bits: 0,
            missing_bits: 0,
        }
    }

    fn fill(&mut self) {
        while self.held_bits <= 48 {
            let byte = match self.data.get(self.at..) {
                Some([0xFF, 0, ..]) => {
                    self.at += 2;
                    0xFF
                }
                Some([0xFF, ..]) | Some([]) | None => {
                    self.missing_bits += 8;
                    0
                }
                Some([byte, ..]) => {
                    self.at += 1;
                    *byte
                }
            };
            self.held = self.held << 8 | u64::from(byte);
            self.held_bits += 8;
        }
    }

    /// The next `count` bits, at most 16; zeros behind the end.
    fn peek(&mut self, count: u32) -> u32 {
        if self.held_bits < count {
            self.fill();
        }
        (self.held >> (self.held_bits - count)) as u32 & ((1 << count) - 1)
    }

    /// Takes bits that were peeked at.
    fn take(&mut self, count: u32) -> Result<(), String> {
        self.held_bits -= count;
        match self.held_bits < self.missing_bits {
            true => Err("its samples are cut off".into()),
            false => Ok(()),
        }
    }

    /// Goes on behind the restart marker of this number.
    fn restart(&mut self, number: u8) -> Result<(), String> {
        // Whole bytes that are still held were not needed, which does not happen in sound data.
        let unread = (self.held_bits - self.missing_bits) / 8;
        // A marker may have any number of FF before it.
        while self.data.get(self.at..self.at + 2) == Some(&[0xFF, 0xFF]) {
            self.at += 1;
        }
        let marker = [0xFF, 0xD0 + number];
        if unread > 0 || self.data.get(self.at..self.at + 2) != Some(&marker) {
            return Err(format!(
                "the restart marker FF {:02X} is missing",
                marker[1]
            ));
        }
        *self = Bits {
            at: self.at + 2,
            ..Bits::new(self.data)
        };
        Ok(())
    }

    /// Where the next marker can be looked for.
    fn end(&self) -> usize {
        let mut at = self.at.min(self.data.len());
        // What was read ahead is entropy-coded: no marker stands in it.
        while at < self.data.len() && !matches!(self.data[at..], [0xFF, 1..=0xFE, ..]) {
            at += 1;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes lossless JPEG by the book, so that every variant is met.
    struct Encoder {
        bits: u32,
        predictor: u8,
        shift: u32,
        interval_rows: usize,
        one_scan_each: bool,
    }

    impl Encoder {
        fn encode(&self, columns: usize, components: usize, samples: &[u16]) -> Vec<u8> {
            let rows = samples.len() / columns / components;
            let mut out = vec![0xFF, 0xD8, 0xFF, 0xC3, 0, 8 + 3 * components as u8];
            out.push(self.bits as u8);
            for edge in [rows, columns] {
                out.extend((edge as u16).to_be_bytes());
            }
            out.push(components as u8);
            (0..components).for_each(|c| out.extend([c as u8 + 1, 0x11, 0]));
            // 17 categories: 15 codes of 4 bits, then one of 5 bits, one of 9.
            out.extend([
                0xFF, 0xC4, 0, 36, 0, 0, 0, 0, 15, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0,
            ]);
            out.extend(0..17u8);
            if self.interval_rows > 0 {
                out.extend([0xFF, 0xDD, 0, 4]);
                out.extend(((self.interval_rows * columns) as u16).to_be_bytes());
            }
            let all: Vec<usize> = (0..components).collect();
            let scans: Vec<&[usize]> = match self.one_scan_each {
                true => all.chunks(1).collect(),
                false => vec![&all],
            };
            for scan in scans {
                out.extend([0xFF, 0xDA, 0, 6 + 2 * scan.len() as u8, scan.len() as u8]);
                scan.iter().for_each(|c| out.extend([*c as u8 + 1, 0]));
                out.extend([self.predictor, 0, self.shift as u8]);
                self.scan(columns, components, scan, samples, &mut out);
            }
            out.extend([0xFF, 0xD9]);
            out
        }

        fn scan(
            &self,
            columns: usize,
            pitch: usize,
            parts: &[usize],
            samples: &[u16],
            out: &mut Vec<u8>,
        ) {
            let rows = samples.len() / columns / pitch;
            let at = |row: usize, column: usize, part: usize| {
                i32::from(samples[(row * columns + column) * pitch + part] >> self.shift)
            };
            let mut text = String::new();
            for row in 0..rows {
                let interval = match self.interval_rows {
                    0 => rows,
                    n => n,
                };
                let first = row % interval == 0;
                if first && row > 0 {
                    flush(&mut text, out);
                    out.extend([0xFF, 0xD0 + ((row / interval - 1) % 8) as u8]);
                }
                for column in 0..columns {
                    for &part in parts {
                        let predicted = match (first, column) {
                            (true, 0) => 1 << (self.bits - self.shift - 1),
                            (true, _) => at(row, column - 1, part),
                            (false, 0) => at(row - 1, column, part),
                            (false, _) => {
                                let a = at(row, column - 1, part);
                                let b = at(row - 1, column, part);
                                let c = at(row - 1, column - 1, part);
                                match self.predictor {
                                    1 => a,
                                    2 => b,
                                    3 => c,
                                    4 => a + b - c,
                                    5 => a + (b - c).div_euclid(2),
                                    6 => b + (a - c).div_euclid(2),
                                    _ => (a + b) / 2,
                                }
                            }
                        };
                        let mut difference = (at(row, column, part) - predicted).rem_euclid(65536);
                        if difference > 32768 {
                            difference -= 65536;
                        }
                        let category = 32 - difference.unsigned_abs().leading_zeros();
                        text += &match category {
                            0..=14 => format!("{category:04b}"),
                            15 => "11110".into(),
                            _ => "111110000".into(),
                        };
                        if (1..16).contains(&category) {
                            let low = if difference < 0 {
                                difference - 1
                            } else {
                                difference
                            };
                            let low = low as u32 & ((1 << category) - 1);
                            text += &format!("{low:0width$b}", width = category as usize);
                        }
                    }
                }
            }
            flush(&mut text, out);
        }
    }

    fn flush(text: &mut String, out: &mut Vec<u8>) {
        while !text.len().is_multiple_of(8) {
            text.push('1');
        }
        for byte in text.as_bytes().chunks(8) {
            let byte = u8::from_str_radix(std::str::from_utf8(byte).unwrap(), 2).unwrap();
            out.push(byte);
            if byte == 0xFF {
                out.push(0);
            }
        }
        text.clear();
    }

    fn noise(count: usize, bits: u32) -> Vec<u16> {
        let mut state = 1u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16 >> (16 - bits)
        };
        (0..count).map(next).collect()
    }

    #[test]
    fn every_predictor_precision_and_interval_comes_back() {
        let (columns, rows) = (7, 9);
        for predictor in 1..=7 {
            for bits in 2..=16 {
                for (components, one_scan_each) in [(1, false), (3, false), (3, true)] {
                    for interval_rows in [0, 1, 2] {
                        let encoder = Encoder {
                            bits,
                            predictor,
                            shift: (bits % 3).min(bits - 1),
                            interval_rows,
                            one_scan_each,
                        };
                        let mut samples = noise(columns * rows * components, bits);
                        let file = encoder.encode(columns, components, &samples);
                        let mut found = vec![0; samples.len()];
                        decode(&file, columns, rows, components, &mut found).unwrap();
                        let mask = u16::MAX << encoder.shift;
                        samples.iter_mut().for_each(|sample| *sample &= mask);
                        assert_eq!(found, samples, "predictor {predictor}, {bits} bits");
                    }
                }
            }
        }
    }

    #[test]
    fn a_difference_of_32768_has_no_further_bits() {
        let samples = [0, 32768, 0, 32768, 65535, 32767];
        let encoder = Encoder {
            bits: 16,
            predictor: 1,
            shift: 0,
            interval_rows: 0,
            one_scan_each: false,
        };
        let mut found = [0; 6];
        decode(&encoder.encode(3, 1, &samples), 3, 2, 1, &mut found).unwrap();
        assert_eq!(found, samples);
    }

    #[test]
    fn damage_is_an_error_and_no_panic() {
        let samples = noise(60, 12);
        let encoder = Encoder {
            bits: 12,
            predictor: 4,
            shift: 0,
            interval_rows: 1,
            one_scan_each: false,
        };
        let file = encoder.encode(6, 1, &samples);
        let mut found = [0; 60];
        for length in 0..file.len() - 2 {
            let result = decode(&file[..length], 6, 10, 1, &mut found);
            assert!(result.is_err(), "cut to {length} bytes");
        }
        for at in 0..file.len() {
            for bit in 0..8 {
                let mut damaged = file.clone();
                damaged[at] ^= 1 << bit;
                let _ = decode(&damaged, 6, 10, 1, &mut found);
            }
        }
        let why = decode(&file, 5, 12, 1, &mut found).unwrap_err();
        assert!(why.contains("6×10 samples of 1 components"), "{why}");
    }
}
