//! Several volumes, or several boards with a part each: pictures drawn apart and merged with *over* (document §8.3).
//!
//! All volumes share one image plane, so that planes and pixels mean the same for each. On a board volumes are drawn one
//! after the other, each beginning with closed rows; boards work at the same time. Parts of a volume share the layer of
//! voxels at the cut, and have the very samples that the whole has, each in one of them.
//!
//! The host merges: beside its light every pixel also sends how much light it lets pass. Boxes of volumes and parts do not
//! overlap, so the samples of a ray in one of them all lie before those in another; the first plane of each says which.

use crate::counters::Counters;
use crate::observer::{NoObserver, Observer};
use crate::processor::{Progress, Run, run};
use crate::rays::RaySetup;
use crate::spec::{Axis, Spec};
use crate::subject::Subject;
use crate::volume_store::VolumeStore;
use crate::{Error, Frame};

/// A picture to be merged, before black.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The picture, and how much light it lets pass.
    pub run: Run,
    /// Plane of the first sample of each pixel (first row at the top); none if it has no ray.
    pub first_planes: Vec<Option<u32>>,
}

impl Layer {
    /// The layer of a frame that was run with `look.background` 0.
    pub fn new(frame: &Frame, run: Run) -> Layer {
        let [width, height] = frame.setup.size;
        let rows = (0..height).rev();
        let pixels = rows.flat_map(|y| (0..width).map(move |x| (x, y)));
        let first_planes = pixels
            .map(|(x, y)| frame.setup.ray(x, y).map(|ray| ray.plane))
            .collect();
        Layer { run, first_planes }
    }
}

/// Lays layers over each other, in each pixel from the nearest to the farthest, before a background of 0 to 1. Counts are
/// added up, clocks too. If a volume moves, its layer alone is drawn again.
///
/// # Panics
/// If the pictures differ in size, or there is none.
pub fn over(layers: &[Layer], background: f32) -> Run {
    let mut merged = layers[0].run.clone();
    merged.counters = Counters::default();
    for layer in layers {
        assert_eq!(layer.run.size, merged.size, "pictures of different size");
        merged.counters.add(&layer.run.counters);
        merged.is_complete &= layer.run.is_complete;
    }
    let mut order: Vec<usize> = (0..layers.len()).collect();
    for pixel in 0..merged.picture.len() {
        order.sort_by_key(|i| layers[*i].first_planes[pixel]);
        let mut passing = 1.0;
        let mut grey = 0.0;
        let mut color = [0.0; 3];
        let (mut stalls, mut changes, mut has_ended) = (0, 0, false);
        for i in &order {
            let run = &layers[*i].run;
            if layers[*i].first_planes[pixel].is_none() {
                continue;
            }
            grey += passing * run.picture[pixel];
            if let Some(theirs) = &run.color {
                for (c, theirs) in color.iter_mut().zip(theirs[pixel]) {
                    *c += passing * theirs;
                }
            }
            passing *= run.passing[pixel];
            stalls += run.stalls_of_pixel[pixel];
            changes += run.thesis_changes_of_pixel[pixel];
            has_ended |= run.ended_early[pixel];
        }
        merged.picture[pixel] = (grey + passing * background).min(1.0);
        if let Some(all) = &mut merged.color {
            all[pixel] = color.map(|c| (c + passing * background).min(1.0));
        }
        merged.passing[pixel] = passing;
        merged.stalls_of_pixel[pixel] = stalls;
        merged.thesis_changes_of_pixel[pixel] = changes;
        merged.ended_early[pixel] = has_ended;
    }
    merged
}

/// All runs of a merged picture.
#[derive(Clone, Debug)]
pub(crate) struct Boards {
    /// The volumes of each board.
    boards: Vec<Vec<Frame>>,
    background: f32,
}

impl Boards {
    /// Settles all runs.
    pub fn new(spec: &Spec, subject: &Subject) -> Result<Boards, Error> {
        let merge = &spec.merge;
        if subject.others.len() != merge.volumes.len() {
            let problem = format!("{} of them are loaded", subject.others.len());
            return Err(Error::field("merge.volumes", merge.volumes.len(), problem));
        }
        let places = [[0; 3]]
            .into_iter()
            .chain(merge.volumes.iter().map(|v| v.at));
        let stores = [subject.volume].into_iter().chain(&subject.others);
        let volumes: Vec<(&VolumeStore, [i32; 3])> = stores.zip(places).collect();
        let corner = |at: [i32; 3], volume: &VolumeStore| {
            std::array::from_fn::<i32, 3, _>(|i| at[i] + volume.dims[i] as i32)
        };
        for (i, (volume, at)) in volumes.iter().enumerate() {
            for (other, there) in &volumes[..i] {
                let (a, b) = (corner(*at, volume), corner(*there, other));
                if (0..3).all(|axis| at[axis] < b[axis] && there[axis] < a[axis]) {
                    let problem = format!(
                        "its box of {:?} voxels overlaps {}, which fills {there:?} up to {b:?}",
                        volume.dims, other.name
                    );
                    return Err(Error::field("merge.volumes.at", format!("{at:?}"), problem));
                }
            }
        }
        let low: [i32; 3] = std::array::from_fn(|axis| {
            let all = volumes.iter().map(|(_, at)| at[axis]);
            all.min().unwrap_or(0)
        });
        let high: [i32; 3] = std::array::from_fn(|axis| {
            let all = volumes.iter().map(|(v, at)| corner(*at, v)[axis]);
            all.max().unwrap_or(0)
        });
        let hull = std::array::from_fn(|axis| (high[axis] - low[axis]) as usize);

        let mut one = spec.clone();
        one.merge = Default::default();
        // The background lies behind all; buses are shared evenly, by as many boards as there are to each.
        one.look.background = 0.0;
        one.host.bus_mb_per_s *= f64::from(merge.buses) / f64::from(merge.boards);
        let setup = RaySetup::new(&one, hull)?;
        let axis = match merge.cut {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        let mut boards: Vec<Vec<Frame>> = (0..merge.boards).map(|_| Vec::new()).collect();
        for (i, (volume, at)) in volumes.iter().enumerate() {
            let mut spec = one.clone();
            if let Some(placed) = i.checked_sub(1).map(|i| &merge.volumes[i])
                && !placed.opacity.is_empty()
            {
                spec.look.opacity = placed.opacity.clone();
            }
            let within = setup.within(std::array::from_fn(|i| at[i] - low[i]), volume.dims);
            let cells = volume.dims[axis] - 1;
            if merge.boards as usize > cells {
                let problem = format!(
                    "{} has {cells} cells along {:?}: at most so many",
                    volume.name, merge.cut
                );
                return Err(Error::field("merge.boards", merge.boards, problem));
            }
            for (board, frames) in boards.iter_mut().enumerate() {
                let bound = |board: usize| board * cells / merge.boards as usize;
                let (first, behind) = (bound(board), bound(board + 1));
                let frame = if merge.boards == 1 {
                    Frame::of_setup(&spec, volume, within.clone())?
                } else {
                    // Rounding may carry a sample just out of the volume: the outer parts take it.
                    let open = [
                        if board == 0 { i32::MIN } else { first as i32 },
                        if behind == cells {
                            i32::MAX
                        } else {
                            behind as i32
                        },
                    ];
                    let part = volume.part(axis, first..behind + 1);
                    Frame::of_setup(&spec, &part, within.cut(axis, open))?
                };
                frames.push(frame);
            }
        }
        for frames in &mut boards {
            let needed: u64 = frames.iter().map(|f| f.layout.rows_needed[0]).sum();
            let most = frames[0].layout.rows_needed[1];
            if needed > most {
                let problem = format!(
                    "the volumes of a board need {needed} rows in every bank, its memory has {most}"
                );
                return Err(Error::field("memory.rows", spec.memory.rows, problem));
            }
            for frame in frames {
                frame.result_bytes += spec.widths.transmittance.div_ceil(8);
            }
        }

        Ok(Boards {
            boards,
            background: spec.look.background as f32,
        })
    }

    /// Draws all volumes on all boards.
    pub fn run(&self, observer: &mut impl Observer, progress: Progress) -> Result<Run, Error> {
        let boards = &self.boards;
        let runs = boards.iter().map(Vec::len).sum::<usize>();
        let tiles = boards[0][0].setup.tile_count();
        let total = runs * tiles;
        let mut observer = Some(observer);
        let mut layers = Vec::new();
        let mut clocks_of_part = vec![0; boards.len()];
        'all: for (board, frames) in boards.iter().enumerate() {
            for frame in frames {
                let before = layers.len() * tiles;
                let told = |drawn: usize, _: usize| progress(before + drawn, total);
                let drawn = match observer.take() {
                    Some(observer) => run(frame, observer, &told)?,
                    None => run(frame, &mut NoObserver, &told)?,
                };
                clocks_of_part[board] += drawn.counters.clocks;
                let is_complete = drawn.is_complete;
                layers.push(Layer::new(frame, drawn));
                if !is_complete {
                    break 'all;
                }
            }
        }
        let mut merged = over(&layers, self.background);
        merged.counters.clocks = clocks_of_part.iter().copied().max().unwrap_or(0);
        if boards.len() > 1 {
            merged.clocks_of_part = clocks_of_part;
        }
        merged.is_complete &= layers.len() == runs;
        Ok(merged)
    }
}
