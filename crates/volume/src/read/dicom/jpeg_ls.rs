//! JPEG-LS, lossless and near-lossless, of one component (ITU-T T.87; the LOCO-I algorithm of
//! Weinberger, Seroussi and Sapiro, IEEE Transactions on Image Processing 9(8), 2000).
//!
//! Our own, because the decoders at hand are a C++ library (the program shall build with a Rust
//! toolchain alone) and a large young tree of crates around another DICOM library.
//! Departures: palettes (LSE 2 and 3), oversize frames (LSE 4), several components, point
//! transforms and an unknown number of lines (DNL) are refused; DICOM's gray images have none.

/// What the frame says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameHeader {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Bits of a sample, 2 to 16.
    pub(super) bits: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Preset {
    max_value: i32,
    thresholds: [i32; 3],
    reset: i32,
}

/// Decodes a frame of exactly `columns` × `rows` samples into `samples`, row by row.
///
/// # Errors
/// What is wrong with the data, or which part of the standard is not supported.
pub(super) fn decode(
    data: &[u8],
    columns: usize,
    rows: usize,
    samples: &mut [u16],
) -> Result<FrameHeader, String> {
    let mut at = 2;
    if data.first_chunk() != Some(&[0xFF, 0xD8]) {
        return Err("it does not begin with FF D8".into());
    }
    let mut frame = None;
    let mut preset = Preset::default();
    let mut restart_rows = 0;
    loop {
        let marker = match data.get(at..at + 2) {
            Some(&[0xFF, 0xFF]) => {
                at += 1;
                continue;
            }
            Some(&[0xFF, marker]) => marker,
            Some(_) => return Err(format!("there is no marker at byte {at}")),
            None => return Err("it ends before its samples".into()),
        };
        let length = data
            .get(at + 2..at + 4)
            .map(|b| usize::from(b[0]) << 8 | usize::from(b[1]))
            .ok_or("it ends before its samples")?;
        let body = data
            .get(at + 4..(at + 2 + length).max(at + 4))
            .ok_or("a marker is cut off")?;
        at += 2 + length.max(2);
        let word = |i: usize| -> Result<i32, String> {
            match body.get(i..i + 2) {
                Some(b) => Ok(i32::from(b[0]) << 8 | i32::from(b[1])),
                None => Err(format!("the marker FF {marker:02X} is too short")),
            }
        };
        match marker {
            // Start of a JPEG-LS frame.
            0xF7 => {
                let header = FrameHeader {
                    bits: (word(0)? >> 8) as u32,
                    rows: word(1)? as usize,
                    columns: word(3)? as usize,
                };
                let components = word(4)? & 0xFF;
                if header.columns != columns || header.rows != rows {
                    return Err(format!(
                        "it holds {}×{} samples, the header states {columns}×{rows}",
                        header.columns, header.rows
                    ));
                }
                if !(2..=16).contains(&header.bits) || components != 1 {
                    return Err(format!(
                        "it has {components} components of {} bits; allowed are 1 of 2 to 16 bits",
                        header.bits
                    ));
                }
                frame = Some(header);
            }
            // Preset parameters.
            0xF8 => match word(0)? >> 8 {
                1 => {
                    preset = Preset {
                        max_value: word(1)?,
                        thresholds: [word(3)?, word(5)?, word(7)?],
                        reset: word(9)?,
                    };
                }
                kind => {
                    return Err(format!(
                        "preset parameters of kind {kind} are not supported"
                    ));
                }
            },
            // Restart interval, in rows.
            0xDD => {
                restart_rows = match body.len() {
                    2 => word(0)? as usize,
                    3 => (word(0)? as usize) << 8 | usize::from(body[2]),
                    4 => (word(0)? as usize) << 16 | word(2)? as usize,
                    n => return Err(format!("a restart interval of {n} bytes is not allowed")),
                };
            }
            // Start of scan.
            0xDA => {
                let header = frame.ok_or("its samples come before the frame header")?;
                // Number of components, component, its table, NEAR, interleaving, point transform.
                let &[1, _, table, near, _, transform] = body else {
                    return Err("only scans of one component are supported".into());
                };
                if table != 0 || transform & 15 != 0 {
                    return Err("mapping tables and point transforms are not supported".into());
                }
                let coding = Coding::new(&header, preset, near.into())?;
                coding.scan(
                    data.get(at..).ok_or("it ends before its samples")?,
                    columns,
                    restart_rows,
                    samples,
                )?;
                return Ok(header);
            }
            0xD9 => return Err("it ends before its samples".into()),
            0xE0..=0xEF | 0xFE => {}
            other => {
                return Err(format!(
                    "the marker FF {other:02X} does not belong into JPEG-LS"
                ));
            }
        }
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
                (3 / factor).max(2) + 3 * near,
                (7 / factor).max(3) + 5 * near,
                (21 / factor).max(4) + 7 * near,
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

    fn scan(
        &self,
        data: &[u8],
        columns: usize,
        restart_rows: usize,
        samples: &mut [u16],
    ) -> Result<(), String> {
        let rows_per_interval = match restart_rows {
            0 => samples.len() / columns,
            n => n,
        };
        let mut data = data;
        for (number, part) in samples
            .chunks_mut(rows_per_interval.saturating_mul(columns))
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
            state.rows(&mut bits, columns, part)?;
            data = bits.after_segment();
        }
        Ok(())
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

struct State<'a> {
    coding: &'a Coding,
    contexts: Vec<Context>,
    runs: [RunContext; 2],
    run_index: usize,
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
            run_index: 0,
        }
    }

    fn rows(&mut self, bits: &mut Bits, columns: usize, rows: &mut [u16]) -> Result<(), String> {
        // Two lines with a sample more at both ends: index x + 1 is column x.
        let mut above = vec![0i32; columns + 2];
        let mut line = vec![0i32; columns + 2];
        for row in rows.chunks_exact_mut(columns) {
            above[columns + 1] = above[columns];
            line[0] = above[1];
            self.line(bits, columns, &above, &mut line)?;
            for (into, value) in row.iter_mut().zip(&line[1..]) {
                *into = *value as u16;
            }
            std::mem::swap(&mut above, &mut line);
        }
        Ok(())
    }

    fn line(
        &mut self,
        bits: &mut Bits,
        columns: usize,
        above: &[i32],
        line: &mut [i32],
    ) -> Result<(), String> {
        let mut x = 1;
        while x <= columns {
            let (a, b, c, d) = (line[x - 1], above[x], above[x - 1], above[x + 1]);
            let q = 81 * self.coding.quantized(d - b)
                + 9 * self.coding.quantized(b - c)
                + self.coding.quantized(c - a);
            if q != 0 {
                line[x] = self.regular(bits, q, [a, b, c])?;
                x += 1;
                continue;
            }
            let length = self.run_length(bits, columns + 1 - x)?;
            line[x..x + length].fill(a);
            x += length;
            if x <= columns {
                line[x] = self.interruption(bits, a, above[x])?;
                self.run_index = self.run_index.saturating_sub(1);
                x += 1;
            }
        }
        Ok(())
    }

    /// A sample by prediction (A.4 to A.6).
    fn regular(&mut self, bits: &mut Bits, q: i32, [a, b, c]: [i32; 3]) -> Result<i32, String> {
        let coding = self.coding;
        let sign = q.signum();
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

    /// How many samples repeat the one before, at most `left` (A.7.1).
    fn run_length(&mut self, bits: &mut Bits, left: usize) -> Result<usize, String> {
        let mut length = 0;
        while bits.read(1)? == 1 {
            let whole = 1 << RUN_ORDER[self.run_index];
            if whole <= left - length {
                self.run_index = (self.run_index + 1).min(RUN_ORDER.len() - 1);
            }
            length = left.min(length + whole);
            if length == left {
                return Ok(length);
            }
        }
        length += bits.read(RUN_ORDER[self.run_index])? as usize;
        if length > left {
            return Err("a run is longer than its row".into());
        }
        Ok(length)
    }

    /// The sample after a run (A.7.2).
    fn interruption(&mut self, bits: &mut Bits, a: i32, b: i32) -> Result<i32, String> {
        let coding = self.coding;
        let is_flat = (a - b).abs() <= coding.near;
        let kind = i32::from(is_flat);
        let context = &mut self.runs[kind as usize];
        let k = order(
            context.count,
            context.size.saturating_add(kind * (context.count >> 1)),
        );
        let limit = coding.limit - RUN_ORDER[self.run_index] - 1;
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
