//! `strahl info`: what is in a volume file.

mod label_list;

use super::load::load_labels;
use crate::flags::InfoFlags;
use crate::print::{self, number};
use anyhow::Result;
use label_list::LabelList;
use serde_json::{Value, json};
use std::fmt::Write as _;
use strahl::volume::read::LoadedVolume;
use strahl::volume::{Grid, Modality, Samples, Statistics, Volume, VolumeHeader};

/// Shares of the voxels for which quantiles are printed.
const QUANTILES: [f64; 5] = [0.01, 0.25, 0.5, 0.75, 0.99];

/// Keys of the header that are printed.
const MOST_ENTRIES: usize = 100;

pub fn run(flags: &InfoFlags, quiet: bool) -> Result<()> {
    if flags.adapters {
        return adapters(flags.json);
    }
    let name = match flags.volume.as_slice() {
        [one] => one.display().to_string(),
        [first, ..] => format!("{} and {} more", first.display(), flags.volume.len() - 1),
        [] => String::new(),
    };
    let mut loaded = load_labels(
        &flags.volume,
        &flags.read,
        &flags.labels,
        &flags.memory,
        quiet,
    )?;
    let name = match flags.anonymous {
        true => {
            loaded.volume = loaded.volume.anonymous();
            "volume".to_owned()
        }
        false => name,
    };
    let mut content = Content::of(loaded);
    if let [picture] = flags.volume.as_slice()
        && crate::flags::is_picture(picture)
        && let Ok(Some(_)) = strahl::Recipe::of_file(picture)
    {
        content
            .notes
            .push("the picture carries a scene, which `strahl scene show` prints".to_owned());
    }
    if flags.json {
        let json = serde_json::to_string_pretty(&as_json(&name, &content))?;
        print::out(&(json + "\n"))
    } else {
        print::out(&print::harmless(&as_text(&name, &content)))
    }
}

/// What is printed of a volume.
struct Content {
    header: VolumeHeader,
    /// If the numbers are object ids.
    labels: Option<LabelList>,
    /// Shares and the values that these shares of the voxels lie below.
    quantiles: [[f64; 2]; 5],
    notes: Vec<String>,
}

impl Content {
    fn of(loaded: LoadedVolume) -> Content {
        let header = loaded.volume.header();
        let quantiles = quantiles(&loaded.volume);
        let mut notes = loaded.notes;
        let list = |labels| LabelList::of(loaded.volume, labels);
        let labels = match loaded.labels.map(list).transpose() {
            Ok(labels) => labels,
            Err(error) => {
                notes.push(format!("the numbers are no object ids: {error}"));
                None
            }
        };
        Content {
            header,
            labels,
            quantiles,
            notes,
        }
    }
}

#[cfg(not(feature = "gpu"))]
fn adapters(_json: bool) -> Result<()> {
    anyhow::bail!(
        "this program was built without the feature `gpu`, so it uses no graphics adapter"
    )
}

/// The graphics adapters, the best first.
#[cfg(feature = "gpu")]
fn adapters(json: bool) -> Result<()> {
    let adapters = strahl::gpu::adapters();
    if json {
        let list: Vec<Value> = adapters
            .iter()
            .map(|a| json!({"name": a.name, "backend": a.backend, "driver": a.driver, "software": a.is_software}))
            .collect();
        return print::out(&(serde_json::to_string_pretty(&list)? + "\n"));
    }
    if adapters.is_empty() {
        return print::out(&format!("{}\n", strahl::gpu::Error::NoAdapter));
    }
    print::out(
        &adapters
            .iter()
            .map(|a| format!("{a}\n"))
            .collect::<String>(),
    )
}

fn as_text(name: &str, content: &Content) -> String {
    let volume = &content.header;
    let VolumeHeader {
        grid,
        metadata,
        statistics,
        ..
    } = volume;
    let mut rows: Vec<(&str, String)> = Vec::new();
    let mut row = |key, value: String| rows.push((key, value));

    row("format", metadata.format.clone());
    if !metadata.name.is_empty() && !name.ends_with(&metadata.name) {
        row("name", metadata.name.clone());
    }
    let dims = grid.dims().map(|n| n.to_string()).join(" × ");
    let stored = (grid.voxel_count() * volume.sample_type.size()) as u64;
    let voxels = number(grid.voxel_count() as f64);
    row(
        "dimensions",
        format!("{dims} ({voxels} voxels, {})", print::bytes(stored)),
    );
    let rescale = volume.rescale;
    let meaning = match (rescale.slope, rescale.intercept) {
        (1.0, 0.0) => String::new(),
        (slope, intercept) => format!(", value = {slope} · stored + {intercept}"),
    };
    row("type", format!("{}{meaning}", volume.sample_type));
    let unit = if metadata.has_length_unit {
        "mm"
    } else {
        "(no unit in the file; taken as mm)"
    };
    let triple = |v: [f64; 3]| v.map(number).join(" × ");
    row(
        "spacing",
        format!("{} {unit}", triple(grid.spacing_mm().to_array())),
    );
    let (lo, hi) = grid.bounds_mm();
    row("extent", format!("{} mm", triple((hi - lo).to_array())));
    row("orientation", orientation(grid));
    let matrix = matrix(grid);
    for (i, key) in ["world from", "  voxel", ""].into_iter().enumerate() {
        let [a, b, c, d] = matrix[i].map(|v| format!("{v:>10.4}"));
        row(key, format!("{a} {b} {c} {d}"));
    }
    if let Some(modality) = metadata.modality {
        row("modality", modality_name(modality).into());
    }
    if metadata.time_points > 1 {
        let (index, count) = (metadata.time_index, metadata.time_points);
        row("time point", format!("{index} of 0 to {}", count - 1));
    }
    if metadata.components.count > 1 {
        let kind = if metadata.components.are_colors {
            "colors"
        } else {
            "numbers"
        };
        row(
            "components",
            format!("{} {kind} per voxel", metadata.components.count),
        );
    }
    let unit = metadata
        .value_unit
        .as_ref()
        .map(|u| format!(" {u}"))
        .unwrap_or_default();
    // Label ids have no order: quantiles of them mean nothing.
    if let Some(labels) = &content.labels {
        row("values", labels.range());
    } else {
        let [lo, hi] = statistics.range.map(number);
        row("values", format!("{lo} to {hi}{unit}"));
        if statistics.not_finite > 0 {
            row("not finite", number(statistics.not_finite as f64));
        }
        let rows = content
            .quantiles
            .map(|[share, value]| format!("{}%: {}", share * 100.0, number(value)));
        row("quantiles", rows.join("   "));
    }

    let mut text = format!("{name}\n");
    for (key, value) in rows {
        let _ = writeln!(text, "  {key:<12} {value}");
    }
    if content.labels.is_none() {
        text.push_str(&histogram(statistics));
    }
    if !metadata.entries.is_empty() {
        text.push_str("\n  from the header:\n");
        // Those of segments are in the list of labels.
        let is_of_segment = |key: &str| {
            let rest = key.strip_prefix("Segment");
            rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        };
        let has_labels = content.labels.is_some();
        let (of_segments, others): (Vec<_>, Vec<_>) = metadata
            .entries
            .iter()
            .partition(|(key, _)| has_labels && is_of_segment(key));
        for (key, value) in others.iter().take(MOST_ENTRIES) {
            let _ = writeln!(text, "    {key}: {value}");
        }
        let left_out = of_segments.len() + others.len().saturating_sub(MOST_ENTRIES);
        if left_out > 0 {
            let _ = writeln!(text, "    … and {left_out} more; --json prints them");
        }
    }
    if let Some(labels) = &content.labels {
        text.push('\n');
        text.push_str(&labels.as_text());
    }
    for note in &content.notes {
        let _ = writeln!(text, "\n  note: {note}");
    }
    text
}

/// Of whole numbers by the histogram. Its bins are too wide for floats, of which many may be one value: theirs are those of
/// voxels, of all or of every n-th.
fn quantiles(volume: &Volume) -> [[f64; 2]; 5] {
    let (statistics, rescale) = (volume.statistics(), volume.rescale());
    let mut sorted: Vec<f64> = match volume.samples() {
        Samples::F32(samples) => evenly(samples).map(|number| f64::from(*number)).collect(),
        Samples::F64(samples) => evenly(samples).copied().collect(),
        _ => {
            return QUANTILES.map(|share| [share, statistics.whole_quantile(share, rescale.slope)]);
        }
    };
    sorted.retain(|number| number.is_finite());
    for number in &mut sorted {
        *number = rescale.slope * *number + rescale.intercept;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    QUANTILES.map(|share| {
        let at = (share * sorted.len() as f64) as usize;
        let last = sorted.len().saturating_sub(1);
        [share, sorted.get(at.min(last)).copied().unwrap_or(f64::NAN)]
    })
}

/// At most a million of them, as far apart as each other.
fn evenly<T>(samples: &[T]) -> impl Iterator<Item = &T> {
    const MOST: usize = 1 << 20;
    // Odd, so that not all lie in one column of a volume whose width is a power of two.
    let step = samples.len().div_ceil(MOST) | 1;
    samples.iter().step_by(step)
}

/// The orientation code and its meaning.
fn orientation(grid: &Grid) -> String {
    let code = grid.orientation();
    let words: Vec<_> = code
        .chars()
        .map(|c| match c {
            'R' => "right",
            'L' => "left",
            'A' => "front",
            'P' => "back",
            'S' => "head",
            _ => "feet",
        })
        .collect();
    format!(
        "{code} (x, y, z run towards the patient's {})",
        words.join(", ")
    )
}

/// Eight rows of text; logarithmic, since air would hide everything else.
fn histogram(statistics: &Statistics) -> String {
    const COLUMNS: usize = 64;
    const ROWS: usize = 6;
    const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let bins = statistics.histogram.len();
    let columns = COLUMNS.min(bins);
    let mut counts = vec![0u64; columns];
    for (bin, count) in statistics.histogram.iter().enumerate() {
        counts[bin * columns / bins] += count;
    }
    let log = |count: u64| ((count + 1) as f64).ln();
    let most = counts
        .iter()
        .map(|&c| log(c))
        .fold(f64::MIN_POSITIVE, f64::max);
    let mut text = String::from("  histogram (logarithmic)\n");
    for row in (0..ROWS).rev() {
        let line: String = counts
            .iter()
            .map(|&count| {
                let height = log(count) / most * (ROWS * 8) as f64;
                let mut eighths = (height.round() as usize).saturating_sub(row * 8).min(8);
                if row == 0 && count > 0 {
                    eighths = eighths.max(1);
                }
                BLOCKS[eighths]
            })
            .collect();
        let _ = writeln!(text, "    {}", line.trim_end());
    }
    let [lo, hi] = statistics.range.map(number);
    let gap = columns
        .saturating_sub(lo.chars().count() + hi.chars().count())
        .max(1);
    let _ = writeln!(text, "    {lo}{}{hi}", " ".repeat(gap));
    text
}

fn matrix(grid: &Grid) -> [[f64; 4]; 4] {
    let (m, t) = (
        grid.world_from_voxel().matrix3,
        grid.world_from_voxel().translation,
    );
    let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

fn modality_name(modality: Modality) -> &'static str {
    match modality {
        Modality::Ct => "CT",
        Modality::Mr => "MR",
        Modality::Nuclear => "nuclear medicine",
        Modality::Ultrasound => "ultrasound",
        Modality::Microscopy => "microscopy",
        Modality::Simulation => "simulation",
    }
}

fn as_json(name: &str, content: &Content) -> Value {
    let volume = &content.header;
    let VolumeHeader {
        grid,
        metadata,
        statistics,
        ..
    } = volume;
    let (lo, hi) = grid.bounds_mm();
    let are_values = content.labels.is_none();
    let quantiles = are_values.then_some(content.quantiles);
    let entries = metadata
        .entries
        .iter()
        .map(|(key, value)| json!([key, value]));
    json!({
        "file": name,
        "format": metadata.format,
        "name": metadata.name,
        "dims": grid.dims(),
        "type": volume.sample_type.name(),
        "slope": volume.rescale.slope,
        "intercept": volume.rescale.intercept,
        "spacing_mm": grid.spacing_mm().to_array(),
        "has_length_unit": metadata.has_length_unit,
        "orientation": grid.orientation(),
        "world_from_voxel": matrix(grid),
        "bounds_mm": [lo.to_array(), hi.to_array()],
        "modality": metadata.modality.map(modality_name),
        "value_unit": metadata.value_unit,
        "time_points": metadata.time_points,
        "time_index": metadata.time_index,
        "components": metadata.components.count,
        "are_colors": metadata.components.are_colors,
        "range": statistics.range,
        "quantiles": quantiles,
        "not_finite": statistics.not_finite,
        "histogram": are_values.then_some(&statistics.histogram),
        "metadata": entries.collect::<Vec<_>>(),
        "labels": content.labels.as_ref().map(LabelList::as_json),
        "notes": content.notes,
    })
}
