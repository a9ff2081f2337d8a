//! Line charts as SVG, for reports.

use std::fmt::Write;

/// A chart of several lines over one axis.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Name of the horizontal axis, with its unit.
    pub x: String,
    /// Name of the vertical axis, with its unit.
    pub y: String,
    /// The lines: name and points.
    pub lines: Vec<(String, Vec<[f64; 2]>)>,
    /// Whether the vertical axis is logarithmic.
    pub is_logarithmic: bool,
}

const COLORS: [&str; 8] = [
    "#1f6fb4", "#d1541b", "#3a9a3c", "#8d4bb4", "#a8842c", "#c0392b", "#16a0a0", "#555555",
];

impl Chart {
    /// The SVG.
    pub fn to_svg(&self) -> String {
        const W: f64 = 720.0;
        const H: f64 = 400.0;
        const LEFT: f64 = 78.0;
        const RIGHT: f64 = 200.0;
        const TOP: f64 = 40.0;
        const BOTTOM: f64 = 52.0;
        let all = || self.lines.iter().flat_map(|(_, points)| points);
        let (mut x0, mut x1) = bounds(all().map(|p| p[0]));
        let (mut y0, mut y1) = bounds(
            all()
                .map(|p| p[1])
                .filter(|y| !self.is_logarithmic || *y > 0.0),
        );
        if x0 == x1 {
            (x0, x1) = (x0 - 1.0, x1 + 1.0);
        }
        let scale = |y: f64| {
            if self.is_logarithmic {
                y.max(1e-12).log10()
            } else {
                y
            }
        };
        if self.is_logarithmic {
            (y0, y1) = (y0.log10().floor(), y1.log10().ceil());
        } else {
            y0 = y0.min(0.0);
            y1 += 0.05 * (y1 - y0);
        }
        if y0 >= y1 {
            y1 = y0 + 1.0;
        }
        let px = |x: f64| LEFT + (x - x0) / (x1 - x0) * (W - LEFT - RIGHT);
        let py = |y: f64| H - BOTTOM - (y - y0) / (y1 - y0) * (H - TOP - BOTTOM);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {W} {H}\" width=\"{W}\" height=\"{H}\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <rect width=\"{W}\" height=\"{H}\" fill=\"white\"/>\n<text x=\"{LEFT}\" y=\"22\" font-size=\"14\">{}</text>\n",
            escape(&self.title)
        );
        for tick in ticks(y0, y1, if self.is_logarithmic { 12 } else { 6 }) {
            let y = py(tick);
            let label = if self.is_logarithmic {
                number(10f64.powf(tick))
            } else {
                number(tick)
            };
            let _ = writeln!(
                svg,
                "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                W - RIGHT,
                LEFT - 6.0,
                y + 4.0
            );
        }
        for tick in ticks(x0, x1, 8) {
            let x = px(tick);
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{}\" y2=\"{}\" stroke=\"#999\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                H - BOTTOM,
                H - BOTTOM + 5.0,
                H - BOTTOM + 19.0,
                number(tick)
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"M{LEFT} {TOP}V{}H{}\" stroke=\"#333\" fill=\"none\"/>\n<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
             <text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            H - BOTTOM,
            W - RIGHT,
            0.5 * (LEFT + W - RIGHT),
            H - 12.0,
            escape(&self.x),
            0.5 * (TOP + H - BOTTOM),
            escape(&self.y)
        );
        for (i, (name, points)) in self.lines.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let mut path = String::new();
            for (k, [x, y]) in points.iter().enumerate() {
                let _ = write!(
                    path,
                    "{}{:.1} {:.1}",
                    if k == 0 { 'M' } else { 'L' },
                    px(*x),
                    py(scale(*y))
                );
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{color}\"/>",
                    px(*x),
                    py(scale(*y))
                );
            }
            let y = TOP + 16.0 * i as f64 + 8.0;
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" stroke=\"{color}\" stroke-width=\"1.8\" fill=\"none\"/>\n\
                 <rect x=\"{}\" y=\"{}\" width=\"12\" height=\"4\" fill=\"{color}\"/><text x=\"{}\" y=\"{y}\">{}</text>",
                W - RIGHT + 12.0,
                y - 6.0,
                W - RIGHT + 30.0,
                escape(name)
            );
        }
        svg.push_str("</svg>\n");
        svg
    }
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|v| v.is_finite()) {
        lo = lo.min(value);
        hi = hi.max(value);
    }
    if lo > hi { (0.0, 1.0) } else { (lo, hi) }
}

/// Round numbers within the bounds.
fn ticks(lo: f64, hi: f64, about: usize) -> Vec<f64> {
    let rough = (hi - lo) / about as f64;
    let unit = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * unit)
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(unit * 10.0);
    let first = (lo / step).ceil() as i64;
    let last = (hi / step + 1e-9).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "" | "-" | "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Text for SVG and HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
