//! Waveforms of a window of clocks as VCD (IEEE 1364), one time unit per half clock.

use crate::messages::{Wire, wires};
use crate::observer::{Observer, Wires};
use crate::spec::Spec;
use std::fmt::Write;
use std::ops::Range;

/// Keeps the words on all wires of a window of clocks.
#[derive(Clone, Debug)]
pub struct Waveform {
    window: Range<u64>,
    wires: Vec<Wire>,
    clock_mhz: f64,
    /// Clock and words, only when one has changed.
    changes: Vec<(u64, Vec<Option<i64>>)>,
}

impl Waveform {
    /// For these clocks.
    pub fn new(spec: &Spec, window: Range<u64>) -> Waveform {
        Waveform {
            window,
            wires: wires(spec),
            clock_mhz: spec.clock_mhz,
            changes: Vec::new(),
        }
    }

    fn keep(&mut self, clock: u64, words: Vec<Option<i64>>) {
        if self.changes.last().is_none_or(|(_, last)| *last != words) {
            self.changes.push((clock, words));
        }
    }

    /// The VCD file.
    pub fn to_vcd(&self) -> String {
        let mut text = String::new();
        let half_ps = (0.5e6 / self.clock_mhz).round().max(1.0) as u64;
        let _ = writeln!(
            text,
            "$version strahl sim $end\n$timescale 1ps $end\n$scope module processor $end"
        );
        let _ = writeln!(text, "$var wire 1 ! clk $end");
        let mut unit = "";
        for (i, wire) in self.wires.iter().enumerate() {
            if wire.unit != unit {
                if !unit.is_empty() {
                    let _ = writeln!(text, "$upscope $end");
                }
                unit = wire.unit;
                let _ = writeln!(text, "$scope module {unit} $end");
            }
            let _ = writeln!(
                text,
                "$var wire {} {} {} $end",
                wire.bits,
                code(i),
                wire.name
            );
        }
        let _ = writeln!(text, "$upscope $end\n$upscope $end\n$enddefinitions $end");
        let mut changes = self.changes.iter().peekable();
        let mut last: Vec<Option<i64>> = Vec::new();
        for clock in self.window.clone() {
            let _ = writeln!(text, "#{}\n1!", 2 * clock * half_ps);
            if let Some((_, words)) = changes.next_if(|(at, _)| *at == clock) {
                for (i, (wire, word)) in self.wires.iter().zip(words).enumerate() {
                    if last.get(i) != Some(word) {
                        let _ = writeln!(text, "{}", value(wire, *word, &code(i)));
                    }
                }
                last.clone_from(words);
            }
            let _ = writeln!(text, "#{}\n0!", (2 * clock + 1) * half_ps);
        }
        text
    }
}

impl Observer for Waveform {
    fn clock(&mut self, w: &Wires) {
        if w.clock >= self.window.end || w.clock + u64::from(w.frozen) < self.window.start {
            return;
        }
        let valid = |is: bool| Some(i64::from(is));
        let words = vec![
            valid(w.issue.is_some()),
            w.issue.map(|r| i64::from(r.slot.0)),
            Some(w.waiting as i64),
            w.issue.map(|r| i64::from(r.position[0])),
            w.issue.map(|r| i64::from(r.position[1])),
            w.issue.map(|r| i64::from(r.position[2])),
            w.issue.map(|r| i64::from(r.plane)),
            valid(false),
            valid(w.data.is_some()),
            w.data.map(|r| i64::from(r.slot.0)),
            valid(w.sort.is_some_and(|s| s.key().is_some())),
            w.sort.map(|s| i64::from(s.slot().0)),
            w.sort.and_then(|s| s.key()).map(i64::from),
            valid(w.sample.is_some()),
            w.sample.map(|s| i64::from(s.slot.0)),
            w.sample.map(|s| i64::from(s.value)),
            w.sample.map(|s| i64::from(s.gradient[0])),
            w.sample.map(|s| i64::from(s.gradient[1])),
            w.sample.map(|s| i64::from(s.gradient[2])),
            valid(w.classified.is_some()),
            w.classified.map(|c| i64::from(c.slot.0)),
            w.classified.map(|c| i64::from(c.opacity)),
            valid(w.visible.is_some()),
            w.visible.map(|v| i64::from(v.slot.0)),
            w.visible.map(|v| i64::from(v.weight)),
            valid(w.terminate.is_some()),
            w.terminate.map(|t| i64::from(t.0.0)),
            valid(w.lit.is_some()),
            w.lit.map(|l| i64::from(l.slot.0)),
            w.lit.map(|l| i64::from(l.intensity[0])),
        ];
        debug_assert_eq!(words.len(), self.wires.len());
        let at = w.clock.max(self.window.start);
        if w.frozen > 0 {
            // The edge comes late: the words stay, and `freeze` is high until it does.
            let mut held = words.clone();
            self.keep(at, words);
            if let Some(freeze) = self.wires.iter().position(|wire| wire.name == "freeze") {
                held[freeze] = valid(true);
            }
            if w.clock + 1 < self.window.end {
                self.keep(at.max(w.clock + 1), held);
            }
        } else {
            self.keep(at, words);
        }
    }
}

fn value(wire: &Wire, word: Option<i64>, code: &str) -> String {
    match (wire.bits, word) {
        (1, Some(word)) => format!("{word}{code}"),
        (1, None) => format!("x{code}"),
        (bits, Some(word)) => {
            let word = word & ((1i64 << bits) - 1);
            format!("b{word:b} {code}")
        }
        (_, None) => format!("bx {code}"),
    }
}

/// Short names of variables: printable characters behind `!`, which is the clock.
fn code(index: usize) -> String {
    char::from(b'"' + index as u8).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, VolumeStore, jaw, no_progress, run};

    /// The first read opens rows: `freeze` is high from the next clock on, for as long as that takes.
    #[test]
    fn freeze_is_high_while_the_memory_holds() {
        let volume = VolumeStore::new(&jaw([16, 16, 8]).unwrap()).unwrap();
        let spec = Spec::default();
        let mut waveform = Waveform::new(&spec, 0..20);
        let frame = Frame::new(&spec, &volume).unwrap();
        run(&frame, &mut waveform, &no_progress).unwrap();
        let vcd = waveform.to_vcd();
        let index = waveform.wires.iter().position(|w| w.name == "freeze");
        let freeze = code(index.unwrap());
        let mut clock = "";
        let mut high = Vec::new();
        for line in vcd.lines() {
            if let Some(time) = line.strip_prefix('#') {
                clock = time;
            } else if line == format!("1{freeze}") || line == format!("0{freeze}") {
                high.push((clock, line.starts_with('1')));
            }
        }
        // 6 clocks for rows that were closed; a clock of 100 MHz has 10,000 ps.
        assert_eq!(high, [("0", false), ("10000", true), ("70000", false)]);
    }
}
