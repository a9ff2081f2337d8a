//! JPEG-LS, lossless and near-lossless (ITU-T T.87; the LOCO-I algorithm of Weinberger, Seroussi and Sapiro, IEEE
//! Transactions on Image Processing 9(8), 2000).
//!
//! Our own, because the decoders at hand are a C++ library (the program shall build with a Rust
//! toolchain alone) and a large young tree of crates around another DICOM library.
//! Departures: palettes (LSE 2 and 3), oversize frames (LSE 4), subsampled components, point transforms, the color
//! transforms of HP and an unknown number of lines (DNL) are refused; DICOM's images have none.

/// What the frame says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FrameHeader {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Bits of a sample, 2 to 16.
    pub(super) bits: u32,
    /// The numbers by which scans name the components, in the order of the components.
    names: Vec<u8>,
}

impl FrameHeader {
    /// Of a start of frame, which must be of `columns` × `rows` pixels of `components` samples.
    fn of(
        segment: &Segment,
        columns: usize,
        rows: usize,
        components: usize,
    ) -> Result<Self, String> {
        let header = FrameHeader {
            bits: u32::from(segment.byte(0)?),
            rows: segment.word(1)?,
            columns: segment.word(3)?,
            names: segment.body[6.min(segment.body.len())..]
                .chunks_exact(3)
                .map(|component| component[0])
                .collect(),
        };
        let count = usize::from(segment.byte(5)?);
        if (header.columns, header.rows) != (columns, rows) {
            return Err(format!(
                "it holds {}×{} samples, the header states {columns}×{rows}",
                header.columns, header.rows
            ));
        }
        if !(2..=16).contains(&header.bits) || count != components {
            return Err(format!(
                "it has {count} components of {} bits; allowed are {components} of 2 to 16 bits",
                header.bits
            ));
        }
        if segment.body.len() != 6 + 3 * count {
            return Err(segment.too_short());
        }
        let factors = segment.body[6..].chunks_exact(3).map(|entry| entry[1]);
        if count > 1 && factors.clone().any(|factors| factors != 0x11) {
            return Err("its components have different sizes (subsampled color)".into());
        }
        Ok(header)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Preset {
    max_value: i32,
    thresholds: [i32; 3],
    reset: i32,
}

impl Preset {
    fn of(segment: &Segment) -> Result<Preset, String> {
        let kind = segment.byte(0)?;
        if kind != 1 {
            return Err(format!(
                "preset parameters of kind {kind} are not supported"
            ));
        }
        let word = |i: usize| segment.word(i).map(|word| word as i32);
        Ok(Preset {
            max_value: word(1)?,
            thresholds: [word(3)?, word(5)?, word(7)?],
            reset: word(9)?,
        })
    }
}

/// What follows a marker.
struct Segment<'a> {
    marker: u8,
    body: &'a [u8],
    /// Where the next one begins, from the beginning of the data.
    end: usize,
}

impl Segment<'_> {
    /// The one at byte `at`, behind fill bytes if there are any.
    fn at(data: &[u8], mut at: usize) -> Result<Segment<'_>, String> {
        while data.get(at..at + 2) == Some(&[0xFF, 0xFF]) {
            at += 1;
        }
        let marker = match data.get(at..at + 2) {
            Some(&[0xFF, marker]) => marker,
            Some(_) => return Err(format!("there is no marker at byte {at}")),
            None => return Err(ENDS_EARLY.into()),
        };
        let length = data
            .get(at + 2..at + 4)
            .map(|b| usize::from(b[0]) << 8 | usize::from(b[1]))
            .ok_or(ENDS_EARLY)?
            .max(2);
        let end = at + 2 + length;
        let body = data.get(at + 4..end).ok_or("a marker is cut off")?;
        Ok(Segment { marker, body, end })
    }

    fn byte(&self, i: usize) -> Result<u8, String> {
        let byte = self.body.get(i).copied();
        byte.ok_or_else(|| self.too_short())
    }

    fn word(&self, i: usize) -> Result<usize, String> {
        Ok(usize::from(self.byte(i)?) << 8 | usize::from(self.byte(i + 1)?))
    }

    fn too_short(&self) -> String {
        format!("the marker FF {:02X} has a wrong length", self.marker)
    }

    /// The rows of a restart interval.
    fn restart_rows(&self) -> Result<usize, String> {
        if !(2..=4).contains(&self.body.len()) {
            let n = self.body.len();
            return Err(format!("a restart interval of {n} bytes is not allowed"));
        }
        let bytes = self.body.iter();
        Ok(bytes.fold(0, |rows, byte| rows << 8 | usize::from(*byte)))
    }
}

const ENDS_EARLY: &str = "it ends before its samples";

/// Decodes a frame of exactly `columns` × `rows` pixels into `samples`, row by row, with the `components` of a pixel
/// side by side.
///
/// # Errors
/// What is wrong with the data, or which part of the standard is not supported.
pub(super) fn decode(
    data: &[u8],
    columns: usize,
    rows: usize,
    components: usize,
    samples: &mut [u16],
) -> Result<FrameHeader, String> {
    if data.first_chunk() != Some(&[0xFF, 0xD8]) {
        return Err("it does not begin with FF D8".into());
    }
    let mut at = 2;
    let mut frame = None;
    let mut preset = Preset::default();
    let mut restart_rows = 0;
    let mut is_decoded = vec![false; components];
    loop {
        let segment = Segment::at(data, at)?;
        at = segment.end;
        match segment.marker {
            0xF7 => frame = Some(FrameHeader::of(&segment, columns, rows, components)?),
            0xF8 => preset = Preset::of(&segment)?,
            0xDD => restart_rows = segment.restart_rows()?,
            // Start of scan.
            0xDA => {
                let header = frame
                    .as_ref()
                    .ok_or("its samples come before the frame header")?;
                let scan = Scan::of(&segment, header)?;
                for component in &scan.components {
                    if std::mem::replace(&mut is_decoded[*component], true) {
                        return Err(format!("component {} is in two scans", component + 1));
                    }
                }
                let coding = Coding::new(header, preset, scan.near)?;
                let rest = data.get(at..).ok_or(ENDS_EARLY)?;
                let rest = coding.scan(&scan, rest, header, restart_rows, samples)?;
                if is_decoded.iter().all(|is_decoded| *is_decoded) {
                    return Ok(header.clone());
                }
                at = data.len() - rest.len();
            }
            0xD9 => return Err(ENDS_EARLY.into()),
            0xE8 if segment
                .body
                .strip_prefix(b"mrfx")
                .is_some_and(|rest| rest[..] != [0]) =>
            {
                return Err("its colors went through a transform of HP (mrfx), which is not part of the standard".into());
            }
            0xE0..=0xEF | 0xFE => {}
            other => {
                return Err(format!(
                    "the marker FF {other:02X} does not belong into JPEG-LS"
                ));
            }
        }
    }
}

/// In which order the samples of several components come.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Interleave {
    /// Row by row, one component after the other.
    Rows,
    /// Pixel by pixel.
    Pixels,
}

/// What a scan says of itself.
struct Scan {
    /// Which components of the frame it holds, counted from 0.
    components: Vec<usize>,
    near: i32,
    interleave: Interleave,
}

impl Scan {
    fn of(segment: &Segment, header: &FrameHeader) -> Result<Scan, String> {
        let count = usize::from(segment.byte(0)?);
        if segment.body.len() != 4 + 2 * count {
            return Err(segment.too_short());
        }
        let (entries, tail) = segment.body[1..].split_at(2 * count);
        let mut components = Vec::new();
        for entry in entries.chunks_exact(2) {
            let &[name, table] = entry else { continue };
            // A single component is the one that is meant, whatever its name.
            let found = match header.names.len() {
                1 => Some(0),
                _ => header.names.iter().position(|known| *known == name),
            };
            components.push(found.ok_or_else(|| {
                format!(
                    "a scan names component {name}; the frame has {:?}",
                    header.names
                )
            })?);
            if table != 0 {
                return Err("mapping tables are not supported".into());
            }
        }
        if tail[2] & 15 != 0 {
            return Err("point transforms are not supported".into());
        }
        let interleave = match (tail[1], count) {
            (_, 0) => return Err("a scan has no component".into()),
            (_, 1) | (1, _) => Interleave::Rows,
            (2, _) => Interleave::Pixels,
            (mode, _) => {
                return Err(format!(
                    "a scan of {count} components has the interleave mode {mode}; allowed are 1 (line) and 2 (sample)"
                ));
            }
        };
        Ok(Scan {
            components,
            near: tail[0].into(),
            interleave,
        })
    }
}

/// The constants of a scan (T.87, A.2.1 and C.2.4.1.1).
struct Coding {
    max_value: i32,
    near: i32,
    thresholds: [i32; 3],
    reset: i32,
    range: i32,
    /// Bits of a quantized prediction error.
    error_bits: u32,
    /// The longest code word.
    limit: u32,
}

impl Coding {
    fn new(header: &FrameHeader, preset: Preset, near: i32) -> Result<Coding, String> {
        let full = (1 << header.bits) - 1;
        let max_value = match preset.max_value {
            0 => full,
            max => max,
        };
        if max_value > full || near > (max_value / 2).min(255) {
            return Err(format!(
                "its largest value is {max_value} and its error {near}; {} bits allow {full} and {}",
                header.bits,
                (max_value.min(full) / 2).min(255)
            ));
        }
        // CLAMP of C.2.4.1.1.1: out of range gives the lower bound.
        let clamp = |value: i32, low: i32| match value > max_value || value < low {
            true => low,
            false => value,
        };
        let defaults = if max_value >= 128 {
            let factor = (max_value.min(4095) + 128) / 256;
            [
                factor + 2 + 3 * near,
                4 * factor + 3 + 5 * near,
                17 * factor + 4 + 7 * near,
            ]
        } else {
            let factor = 256 / (max_value + 1);
            [
                (3 / factor + 3 * near).max(2),
                (7 / factor + 5 * near).max(3),
                (21 / factor + 7 * near).max(4),
            ]
        };
        let mut thresholds = [0; 3];
        let mut low = near + 1;
        for i in 0..3 {
            thresholds[i] = match preset.thresholds[i] {
                0 => clamp(defaults[i], low),
                given if given < low || given > max_value => {
                    return Err(format!(
                        "its threshold {} is {given}; allowed are {low} to {max_value}",
                        i + 1
                    ));
                }
                given => given,
            };
            low = thresholds[i];
        }
        let reset = match preset.reset {
            0 => 64,
            reset @ 3.. => reset,
            reset => return Err(format!("its reset value is {reset}; allowed are 3 or more")),
        };
        let range = (max_value + 2 * near) / (2 * near + 1) + 1;
        let bits = |n: i32| 32 - ((n - 1) as u32).leading_zeros();
        let sample_bits = bits(max_value + 1).max(2);
        Ok(Coding {
            max_value,
            near,
            thresholds,
            reset,
            range,
            error_bits: bits(range),
            limit: 2 * (sample_bits + sample_bits.max(8)),
        })
    }

    /// Decodes a scan and returns what follows it.
    fn scan<'a>(
        &self,
        scan: &Scan,
        data: &'a [u8],
        header: &FrameHeader,
        restart_rows: usize,
        samples: &mut [u16],
    ) -> Result<&'a [u8], String> {
        let numbers_per_row = header.columns * header.names.len();
        let rows_per_interval = match restart_rows {
            0 => header.rows,
            n => n,
        };
        let mut data = data;
        for (number, part) in samples
            .chunks_mut(rows_per_interval.saturating_mul(numbers_per_row))
            .enumerate()
        {
            if number > 0 {
                let expected = 0xD0 + (number - 1) as u8 % 8;
                if data.first_chunk() != Some(&[0xFF, expected]) {
                    return Err(format!("the restart marker FF {expected:02X} is missing"));
                }
                data = &data[2..];
            }
            let mut state = State::new(self);
            let mut bits = Bits::new(data);
            state.rows(&mut bits, scan, header, part)?;
            data = bits.after_segment();
        }
        Ok(data)
    }

    fn quantized(&self, difference: i32) -> i32 {
        let [t1, t2, t3] = self.thresholds;
        let size = difference.abs();
        let level = if size <= self.near {
            0
        } else if size < t1 {
            1
        } else if size < t2 {
            2
        } else if size < t3 {
            3
        } else {
            4
        };
        level * difference.signum()
    }

    /// A prediction and its error put together, modulo the range (A.4.5).
    fn reconstructed(&self, predicted: i32, error: i32) -> i32 {
        let step = 2 * self.near + 1;
        let value = predicted + error * step;
        let value = if value < -self.near {
            value + self.range * step
        } else if value > self.max_value + self.near {
            value - self.range * step
        } else {
            value
        };
        value.clamp(0, self.max_value)
    }
}

/// Statistics of one context: A, B, C, N of the standard.
#[derive(Clone, Copy)]
struct Context {
    size: i32,
    bias: i32,
    correction: i32,
    count: i32,
}

/// Statistics of a run's interruption.
#[derive(Clone, Copy)]
struct RunContext {
    size: i32,
    count: i32,
    negative: i32,
}

/// The order of run lengths (A.2.1).
const RUN_ORDER: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// The rows of a component that a scan remembers, with a sample more at both ends: index x + 1 is column x.
struct Lines {
    above: Vec<i32>,
    line: Vec<i32>,
    run_index: usize,
}

impl Lines {
    fn new(columns: usize) -> Lines {
        Lines {
            above: vec![0; columns + 2],
            line: vec![0; columns + 2],
            run_index: 0,
        }
    }

    /// Goes on to the next row.
    fn advance(&mut self, columns: usize) {
        std::mem::swap(&mut self.above, &mut self.line);
        self.above[columns + 1] = self.above[columns];
        self.line[0] = self.above[1];
    }

    /// The context of sample x, 0 in runs, and its neighbors: left, above, above left.
    fn context(&self, coding: &Coding, x: usize) -> (i32, [i32; 3]) {
        let (above, line) = (&self.above, &self.line);
        let (a, b, c, d) = (line[x - 1], above[x], above[x - 1], above[x + 1]);
        let q =
            81 * coding.quantized(d - b) + 9 * coding.quantized(b - c) + coding.quantized(c - a);
        (q, [a, b, c])
    }
}

/// What a restart interval has learned; its components share it.
struct State<'a> {
    coding: &'a Coding,
    contexts: Vec<Context>,
    runs: [RunContext; 2],
}

impl State<'_> {
    fn new(coding: &Coding) -> State<'_> {
        let size = ((coding.range + 32) / 64).max(2);
        State {
            coding,
            contexts: vec![
                Context {
                    size,
                    bias: 0,
                    correction: 0,
                    count: 1,
                };
                // 9·9·9 differences, of which one half is the negative of the other.
                365
            ],
            runs: [RunContext {
                size,
                count: 1,
                negative: 0,
            }; 2],
        }
    }

    /// Rows of all components of a frame, of which those of the scan are filled in.
    fn rows(
        &mut self,
        bits: &mut Bits,
        scan: &Scan,
        header: &FrameHeader,
        rows: &mut [u16],
    ) -> Result<(), String> {
        let (columns, count) = (header.columns, header.names.len());
        let mut components: Vec<Lines> = scan
            .components
            .iter()
            .map(|_| Lines::new(columns))
            .collect();
        for row in rows.chunks_exact_mut(columns * count) {
            for lines in &mut components {
                lines.advance(columns);
            }
            match scan.interleave {
                Interleave::Rows => {
                    for lines in &mut components {
                        self.line(bits, columns, lines)?;
                    }
                }
                Interleave::Pixels => self.line_of_pixels(bits, columns, &mut components)?,
            }
            for (lines, component) in components.iter().zip(&scan.components) {
                let into = row[*component..].iter_mut().step_by(count);
                for (into, value) in into.zip(&lines.line[1..]) {
                    *into = *value as u16;
                }
            }
        }
        Ok(())
    }

    fn line(&mut self, bits: &mut Bits, columns: usize, lines: &mut Lines) -> Result<(), String> {
        let mut x = 1;
        while x <= columns {
            let (q, neighbors) = lines.context(self.coding, x);
            if q != 0 {
                lines.line[x] = self.regular(bits, q, neighbors)?;
                x += 1;
                continue;
            }
            let left = neighbors[0];
            let length = run_length(bits, &mut lines.run_index, columns + 1 - x)?;
            lines.line[x..x + length].fill(left);
            x += length;
            if x <= columns {
                let above = lines.above[x];
                let is_flat = (left - above).abs() <= self.coding.near;
                lines.line[x] = self.interruption(bits, lines.run_index, is_flat, left, above)?;
                lines.run_index = lines.run_index.saturating_sub(1);
                x += 1;
            }
        }
        Ok(())
    }

    /// A row of all components, pixel by pixel. A run is one of all components, and they share its order.
    fn line_of_pixels(
        &mut self,
        bits: &mut Bits,
        columns: usize,
        components: &mut [Lines],
    ) -> Result<(), String> {
        let coding = self.coding;
        let mut run_index = components.first().map_or(0, |lines| lines.run_index);
        let mut x = 1;
        while x <= columns {
            if components
                .iter()
                .any(|lines| lines.context(coding, x).0 != 0)
            {
                for lines in components.iter_mut() {
                    let (q, neighbors) = lines.context(coding, x);
                    lines.line[x] = self.regular(bits, q, neighbors)?;
                }
                x += 1;
                continue;
            }
            let length = run_length(bits, &mut run_index, columns + 1 - x)?;
            for lines in components.iter_mut() {
                let left = lines.line[x - 1];
                lines.line[x..x + length].fill(left);
            }
            x += length;
            if x <= columns {
                for lines in components.iter_mut() {
                    let (left, above) = (lines.line[x - 1], lines.above[x]);
                    // The run may have ended for another component, so nothing follows from equal neighbors.
                    lines.line[x] = self.interruption(bits, run_index, false, left, above)?;
                }
                run_index = run_index.saturating_sub(1);
                x += 1;
            }
        }
        for lines in components {
            lines.run_index = run_index;
        }
        Ok(())
    }

    /// A sample by prediction (A.4 to A.6).
    fn regular(&mut self, bits: &mut Bits, q: i32, [a, b, c]: [i32; 3]) -> Result<i32, String> {
        let coding = self.coding;
        // In a pixel of several components, q may be 0 here.
        let sign = if q < 0 { -1 } else { 1 };
        let context = &mut self.contexts[q.unsigned_abs() as usize];
        let edge = if c >= a.max(b) {
            a.min(b)
        } else if c <= a.min(b) {
            a.max(b)
        } else {
            a + b - c
        };
        let predicted = (edge + sign * context.correction).clamp(0, coding.max_value);
        let k = order(context.count, context.size);
        let mapped = bits.golomb(k, coding.limit, coding.error_bits)?;
        // A.5.2: with this bias the code of −1 is shorter than that of 0.
        let is_swapped = coding.near == 0 && k == 0 && 2 * context.bias <= -context.count;
        let error = match (mapped & 1 == 1, is_swapped) {
            (false, false) => mapped / 2,
            (true, false) => -(mapped / 2) - 1,
            (true, true) => mapped / 2,
            (false, true) => -(mapped / 2) - 1,
        };
        if error.abs() > coding.range {
            return Err("a prediction error is out of range".into());
        }
        context.bias += error * (2 * coding.near + 1);
        context.size = context.size.saturating_add(error.abs());
        if context.count == coding.reset {
            context.size >>= 1;
            context.bias >>= 1;
            context.count >>= 1;
        }
        context.count += 1;
        if context.bias <= -context.count {
            context.bias = (context.bias + context.count).max(1 - context.count);
            context.correction = (context.correction - 1).max(-128);
        } else if context.bias > 0 {
            context.bias = (context.bias - context.count).min(0);
            context.correction = (context.correction + 1).min(127);
        }
        Ok(coding.reconstructed(predicted, sign * error))
    }

    /// The sample after a run, by the one before the run or the one above (A.7.2).
    fn interruption(
        &mut self,
        bits: &mut Bits,
        run_index: usize,
        is_flat: bool,
        a: i32,
        b: i32,
    ) -> Result<i32, String> {
        let coding = self.coding;
        let kind = i32::from(is_flat);
        let context = &mut self.runs[kind as usize];
        let k = order(
            context.count,
            context.size.saturating_add(kind * (context.count >> 1)),
        );
        let limit = coding.limit - RUN_ORDER[run_index] - 1;
        let mapped = bits.golomb(k, limit, coding.error_bits)?;
        let folded = mapped + kind;
        let map = folded & 1;
        let size = (folded + map) / 2;
        if size > coding.range {
            return Err("a prediction error is out of range".into());
        }
        let is_negative = (k != 0 || 2 * context.negative >= context.count) == (map == 1);
        let error = if is_negative { -size } else { size };
        if error < 0 {
            context.negative += 1;
        }
        context.size = context.size.saturating_add((mapped + 1 - kind) >> 1);
        if context.count == coding.reset {
            context.size >>= 1;
            context.count >>= 1;
            context.negative >>= 1;
        }
        context.count += 1;
        Ok(match is_flat {
            true => coding.reconstructed(a, error),
            false => coding.reconstructed(b, if a > b { -error } else { error }),
        })
    }
}

/// How many samples repeat the one before, at most `left` (A.7.1).
fn run_length(bits: &mut Bits, run_index: &mut usize, left: usize) -> Result<usize, String> {
    let mut length = 0;
    while bits.read(1)? == 1 {
        let whole = 1 << RUN_ORDER[*run_index];
        if whole <= left - length {
            *run_index = (*run_index + 1).min(RUN_ORDER.len() - 1);
        }
        length = left.min(length + whole);
        if length == left {
            return Ok(length);
        }
    }
    length += bits.read(RUN_ORDER[*run_index])? as usize;
    if length > left {
        return Err("a run is longer than its row".into());
    }
    Ok(length)
}

/// The order of the Golomb code: the smallest k with count·2^k ≥ size (A.5.1).
fn order(count: i32, size: i32) -> u32 {
    let mut k = 0;
    while k < 24 && i64::from(count) << k < i64::from(size) {
        k += 1;
    }
    k
}

/// The bits of a scan. A byte after FF holds seven bits only; FF with more ends the data.
struct Bits<'a> {
    data: &'a [u8],
    at: usize,
    held: u64,
    held_bits: u32,
    after_ff: bool,
}

impl<'a> Bits<'a> {
    fn new(data: &'a [u8]) -> Bits<'a> {
        Bits {
            data,
            at: 0,
            held: 0,
            held_bits: 0,
            after_ff: false,
        }
    }

    /// Takes bytes until at least 32 bits are held or the data ends.
    fn fill(&mut self) {
        while self.held_bits <= 48 {
            let Some(&byte) = self.data.get(self.at) else {
                return;
            };
            if self.after_ff {
                self.held = self.held << 7 | u64::from(byte);
                self.held_bits += 7;
            } else {
                // FF before a marker, or at the very end, is not data.
                if byte == 0xFF && self.data.get(self.at + 1).is_none_or(|next| *next >= 0x80) {
                    return;
                }
                self.held = self.held << 8 | u64::from(byte);
                self.held_bits += 8;
            }
            self.after_ff = byte == 0xFF;
            self.at += 1;
        }
    }

    /// The next `n` ≤ 32 bits.
    fn read(&mut self, n: u32) -> Result<u32, String> {
        if self.held_bits < n {
            self.fill();
            if self.held_bits < n {
                return Err("it ends before its last sample".into());
            }
        }
        self.held_bits -= n;
        Ok((self.held >> self.held_bits & ((1 << n) - 1)) as u32)
    }

    /// A number in the limited Golomb code (A.5.3).
    fn golomb(&mut self, k: u32, limit: u32, error_bits: u32) -> Result<i32, String> {
        let longest = limit.saturating_sub(error_bits + 1);
        let mut zeros = 0;
        loop {
            if self.held_bits == 0 {
                self.fill();
                if self.held_bits == 0 {
                    return Err("it ends before its last sample".into());
                }
            }
            let run = (self.held << (64 - self.held_bits))
                .leading_zeros()
                .min(self.held_bits);
            zeros += run;
            self.held_bits -= run;
            if zeros > longest {
                return Err("a code word is too long".into());
            }
            if self.held_bits > 0 {
                self.held_bits -= 1;
                break;
            }
        }
        if zeros < longest {
            Ok((zeros << k | self.read(k)?) as i32)
        } else {
            Ok(self.read(error_bits)? as i32 + 1)
        }
    }

    /// What follows the segment: its last byte is filled up with zeros.
    fn after_segment(mut self) -> &'a [u8] {
        self.fill();
        &self.data[self.at..]
    }
}
