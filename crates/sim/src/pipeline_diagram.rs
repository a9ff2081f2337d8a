//! A diagram of chosen clocks as SVG: units from top to bottom, clocks from left to right, a colour per ray.

use crate::observer::{Observer, Wires};
use std::fmt::Write;
use std::ops::Range;

const ROWS: [&str; 8] = [
    "issue",
    "voxels and distance",
    "sort bus",
    "interpolated",
    "classified",
    "absorbed",
    "lit",
    "composited",
];

/// Keeps which ray is where in a window of clocks.
#[derive(Clone, Debug)]
pub struct PipelineDiagram {
    window: Range<u64>,
    half: usize,
    columns: Vec<Column>,
}

#[derive(Clone, Debug)]
struct Column {
    clock: u64,
    frozen: u32,
    rays: [Option<u16>; ROWS.len()],
    ended: Option<u16>,
}

impl PipelineDiagram {
    /// For these clocks; `rays` is the number of rays of a tile.
    pub fn new(window: Range<u64>, rays: usize) -> PipelineDiagram {
        PipelineDiagram {
            window,
            half: rays.max(1),
            columns: Vec::new(),
        }
    }

    /// The SVG file.
    pub fn to_svg(&self) -> String {
        const CELL: f64 = 22.0;
        const LEFT: f64 = 150.0;
        const TOP: f64 = 44.0;
        let clocks = (self.window.end - self.window.start) as f64;
        let width = LEFT + clocks * CELL + 10.0;
        let height = TOP + ROWS.len() as f64 * CELL + 40.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
        );
        let _ = writeln!(
            svg,
            "<text x=\"8\" y=\"16\" font-size=\"13\">clocks {} to {}; numbers are rays, a bar below is the second tile, a cross a ray that ends</text>",
            self.window.start,
            self.window.end.saturating_sub(1)
        );
        for (row, name) in ROWS.iter().enumerate() {
            let y = TOP + row as f64 * CELL;
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>",
                LEFT - 8.0,
                y + 15.0
            );
        }
        let x_of = |clock: u64| LEFT + (clock - self.window.start) as f64 * CELL;
        for clock in self.window.clone().filter(|c| c % 5 == 0) {
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#555\">{clock}</text>",
                x_of(clock) + 0.5 * CELL,
                TOP - 6.0
            );
        }
        for column in &self.columns {
            let x = x_of(column.clock);
            for (row, ray) in column.rays.iter().enumerate() {
                let y = TOP + row as f64 * CELL;
                let Some(ray) = ray else {
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"#f4f4f4\" stroke=\"#ddd\"/>"
                    );
                    continue;
                };
                let number = usize::from(*ray) % self.half;
                let hue = (number * 137) % 360;
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"hsl({hue},70%,80%)\" stroke=\"#999\"/>\
                     <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{number}</text>",
                    x + 0.5 * CELL,
                    y + 15.0
                );
                if usize::from(*ray) >= self.half {
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"2\" fill=\"#333\"/>",
                        x + 3.0,
                        y + CELL - 4.0,
                        CELL - 6.0
                    );
                }
                if row == 5 && column.ended == Some(*ray) {
                    let _ = writeln!(
                        svg,
                        "<path d=\"M{} {}l{CELL} {CELL}m0 -{CELL}l-{CELL} {CELL}\" stroke=\"#b00\" fill=\"none\"/>",
                        x, y
                    );
                }
            }
            if column.frozen > 0 {
                let first = x_of(column.clock + 1);
                let last = x_of((column.clock + 1 + u64::from(column.frozen)).min(self.window.end));
                let tall = ROWS.len() as f64 * CELL;
                let _ = writeln!(
                    svg,
                    "<rect x=\"{first}\" y=\"{TOP}\" width=\"{}\" height=\"{tall}\" fill=\"#cfe3f7\" stroke=\"#7aa6d0\"/>\
                     <text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#35648f\">frozen</text>",
                    (last - first).max(0.0),
                    0.5 * (first + last),
                    TOP + 0.5 * tall
                );
            }
        }
        svg.push_str("</svg>\n");
        svg
    }
}

impl Observer for PipelineDiagram {
    fn clock(&mut self, w: &Wires) {
        if !self.window.contains(&w.clock) {
            return;
        }
        self.columns.push(Column {
            clock: w.clock,
            frozen: w.frozen,
            rays: [
                w.issue.map(|r| r.slot.0),
                w.data.map(|r| r.slot.0),
                w.sort.map(|s| s.slot().0),
                w.sample.map(|s| s.slot.0),
                w.classified.map(|c| c.slot.0),
                w.visible.map(|v| v.slot.0),
                w.lit.map(|l| l.slot.0),
                w.composited.map(|slot| slot.0),
            ],
            ended: w.terminate.map(|t| t.0.0),
        });
    }
}

/// Two observers at once.
impl<A: Observer, B: Observer> Observer for (A, B) {
    const LOOKS: bool = A::LOOKS || B::LOOKS;

    fn clock(&mut self, wires: &Wires) {
        self.0.clock(wires);
        self.1.clock(wires);
    }

    fn tile(&mut self, clock: u64, tile: usize, half: usize) {
        self.0.tile(clock, tile, half);
        self.1.tile(clock, tile, half);
    }
}
