//! Curves as SVG, both axes logarithmic.

use anyhow::{Result, anyhow, ensure};
use plotters::coord::combinators::BindKeyPoints;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use std::path::Path;

/// Curves over one quantity.
pub struct Plot<'t> {
    pub title: &'t str,
    /// Name of the horizontal axis, with its unit.
    pub x: &'t str,
    /// Name of the vertical axis, with its unit.
    pub y: &'t str,
    /// Name and points of each curve; all numbers > 0.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

/// Told apart by lightness, too.
const COLORS: [RGBColor; 6] = [
    RGBColor(31, 111, 180),
    RGBColor(209, 84, 27),
    RGBColor(58, 154, 60),
    RGBColor(120, 175, 225),
    RGBColor(245, 170, 120),
    RGBColor(150, 210, 150),
];

impl Plot<'_> {
    /// Writes the drawing.
    ///
    /// # Errors
    /// There is nothing to draw, a number is not above 0, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let points = || self.curves.iter().flat_map(|(_, points)| points);
        ensure!(
            points().count() > 0 && points().all(|(x, y)| *x > 0.0 && *y > 0.0),
            "{} has no points, or some that have no logarithm",
            self.title
        );
        let mut xs: Vec<f64> = points().map(|point| point.0).collect();
        xs.sort_by(f64::total_cmp);
        xs.dedup();
        let (least, most) = points().fold((f64::INFINITY, 0.0_f64), |(least, most), point| {
            (least.min(point.1), most.max(point.1))
        });
        let ticks = ticks(least, most);
        // A little air, so that marks at the ends are whole.
        let x_range = (xs[0] / 1.1..xs[xs.len() - 1] * 1.1).log_scale();
        let y_range = (ticks[0]..ticks[ticks.len() - 1]).log_scale();
        self.draw(
            path,
            x_range.with_key_points(xs),
            y_range.with_key_points(ticks),
        )
        .map_err(|why| anyhow!("cannot write {}: {why}", path.display()))
    }

    fn draw<X, Y>(&self, path: &Path, x: X, y: Y) -> Result<(), Box<dyn std::error::Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let area = SVGBackend::new(path, (760, 440)).into_drawing_area();
        // Both light and dark pages show it.
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(self.title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style(("sans-serif", 14))
            .label_style(("sans-serif", 13))
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(215, 215, 215))
            .x_label_formatter(&|value| value.to_string())
            .y_label_formatter(&|value| value.to_string())
            .draw()?;
        for ((name, points), color) in self.curves.iter().zip(COLORS.into_iter().cycle()) {
            chart
                .draw_series(LineSeries::new(
                    points.iter().copied(),
                    color.stroke_width(2),
                ))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 22, y)], color.stroke_width(2))
                });
            let marks = points
                .iter()
                .map(|&point| Circle::new(point, 3, color.filled()));
            chart.draw_series(marks)?;
        }
        chart
            .configure_series_labels()
            .position(self.place_of_names())
            .label_font(("sans-serif", 13))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(180, 180, 180))
            .draw()?;
        area.present()?;
        Ok(())
    }
}

impl Plot<'_> {
    /// The upper corner on the side where the curves are lower.
    fn place_of_names(&self) -> SeriesLabelPosition {
        let end = |last: bool| {
            let points = self.curves.iter().filter_map(|(_, points)| {
                let point = if last { points.last() } else { points.first() };
                Some(point?.1)
            });
            points.fold(0.0, f64::max)
        };
        if end(false) > end(true) {
            SeriesLabelPosition::UpperRight
        } else {
            SeriesLabelPosition::UpperLeft
        }
    }
}

/// 1, 2, 5, 10, … from the last one not above `least` to the first one not below `most`.
fn ticks(least: f64, most: f64) -> Vec<f64> {
    let all: Vec<f64> = (-9..=12)
        .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)))
        // So that they are printed as they are meant.
        .map(|tick| format!("{tick:.1e}").parse().expect("a number"))
        .collect();
    let first = all.iter().rposition(|&tick| tick <= least).unwrap_or(0);
    let last = all.iter().position(|&tick| tick >= most);
    let last = last.unwrap_or(all.len() - 1).max(first + 1);
    all[first..=last].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_enclose_what_is_drawn() {
        assert_eq!(ticks(3.0, 40.0), [2.0, 5.0, 10.0, 20.0, 50.0]);
        assert_eq!(ticks(0.1, 0.1), [0.1, 0.2]);
    }

    #[test]
    fn a_drawing_names_axes_and_curves() {
        let path = std::env::temp_dir().join(format!("strahl-plot-{}.svg", std::process::id()));
        let mut plot = Plot {
            title: "Cost",
            x: "edge, voxels",
            y: "time, ms",
            curves: vec![("shaded".to_owned(), vec![(64.0, 3.0), (128.0, 9.0)])],
        };
        plot.write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        for name in ["Cost", "edge, voxels", "time, ms", "shaded", "64", "128"] {
            assert!(text.contains(name), "{name} is missing");
        }
        plot.curves[0].1[0].1 = 0.0;
        assert!(plot.write(&path).is_err());
    }
}
