//! Which bricks of a volume can matter to a picture: what every renderer's skipping rests on.
//!
//! Only bricks that provably change nothing are left out; rounding is on the side of looking.

mod clips;
mod even;
mod opacity;

pub use clips::dropped;
pub use even::even_cubes;
pub use opacity::most_opacity;

use crate::plan::{Classify, Composite, Fetch, Field, Plan, Reconstruct};
use crate::transfer::{Places, TransferTable};
use strahl_shader::registry::Skips;
use strahl_volume::bricks::{BrickRange, Bricks};
use strahl_volume::{Cancelled, ContentId, Control, Key, Rescale};

/// What each brick of an object, x fastest, can give to a ray.
#[derive(Clone, Debug, PartialEq)]
pub enum Contribution {
    /// The rule needs every sample.
    Every,
    /// Whether any sample inside can change a pixel.
    Visible(Vec<bool>),
    /// An upper bound of the values inside: nothing where the ray has seen more.
    Largest(Vec<f32>),
    /// A lower bound: nothing where the ray has seen less.
    Smallest(Vec<f32>),
}

/// All that the [`Contribution`] of an object's bricks depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct ContributionKey {
    /// The volume that the bricks are those of.
    source: ContentId,
    /// Of the bricks: cells along the edge, voxels beyond.
    edge: usize,
    reach: usize,
    fetch: Fetch,
    reconstruct: Reconstruct,
    classify: Classify,
    composite: Composite,
    rescale: Rescale,
    table: TransferTable,
    is_known: bool,
}

impl ContributionKey {
    /// That of layer number `layer`, whose renderer reconstructs from the volume `source` with these `bricks`.
    pub fn new(plan: &Plan, layer: usize, source: ContentId, bricks: &Bricks) -> ContributionKey {
        let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
        ContributionKey {
            source,
            edge: bricks.edge(),
            reach: bricks.reach(),
            fetch: field.fetch,
            reconstruct: field.reconstruct,
            classify: technique.classify,
            composite: technique.composite,
            rescale: field.rescale,
            table: technique.table.clone(),
            is_known: is_known(plan),
        }
    }

    /// Bytes that the key itself takes.
    pub fn table_bytes(&self) -> usize {
        size_of_val(self.table.entries()) + size_of::<ContributionKey>()
    }
}

impl Key for ContributionKey {
    type Value = Contribution;

    const NAME: &str = "visible bricks";

    fn bytes(&self, value: &Contribution) -> usize {
        let of_bricks = match value {
            Contribution::Every => 0,
            Contribution::Visible(visible) => visible.len(),
            Contribution::Largest(values) | Contribution::Smallest(values) => 4 * values.len(),
        };
        self.table_bytes() + of_bricks
    }
}

/// Whether no function of the user changes values in a way that nobody knows.
fn is_known(plan: &Plan) -> bool {
    !plan.modules.iter().any(|module| {
        let slot = module.module.slot().name;
        ["fetch", "reconstruct", "classify", "composite"].contains(&slot)
    })
}

impl Contribution {
    /// What the `bricks` of layer number `layer` can give. They are those of the numbers that the
    /// renderer reconstructs from: of the coefficients if the B-spline interpolates.
    ///
    /// # Errors
    /// `control` was cancelled.
    pub fn of(
        plan: &Plan,
        layer: usize,
        bricks: &Bricks,
        control: &Control,
    ) -> Result<Contribution, Cancelled> {
        let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
        if field.fetch != Fetch::Stored || !is_known(plan) {
            return Ok(Contribution::Every);
        }
        let rescale = rescale_of(field);
        let values = |range: BrickRange| values(range, rescale);
        let way = field.reconstruct;
        let opaque = Opaque::new(&technique.table);
        let visible = |range: BrickRange| {
            let (lo, hi) = values(range);
            !range.is_empty() && shows(technique.classify, &opaque, lo, hi)
        };
        Ok(match technique.composite {
            Composite::Mida { low, high, .. } => {
                let rises = |range: BrickRange| {
                    let (lo, hi) = values(range);
                    !range.is_empty() && if low < high { hi > low } else { lo < low }
                };
                let matters = |range: BrickRange| visible(range) || rises(range);
                Contribution::Visible(of_reached(bricks, way, matters, control)?)
            }
            Composite::FirstHit { threshold } => {
                let hit = |range: BrickRange| !range.is_empty() && values(range).1 >= threshold;
                Contribution::Visible(of_reached(bricks, way, hit, control)?)
            }
            Composite::Mip => {
                let largest = |range| values(range).1;
                Contribution::Largest(of_reached(bricks, way, largest, control)?)
            }
            Composite::Minip => {
                let smallest = |range| values(range).0;
                Contribution::Smallest(of_reached(bricks, way, smallest, control)?)
            }
            composite => match composite.function().skips {
                Skips::Clear => Contribution::Visible(of_reached(bricks, way, visible, control)?),
                Skips::Nothing | Skips::Own => Contribution::Every,
            },
        })
    }
}

/// The way from numbers that the renderer reconstructs from to the values of a field.
fn rescale_of(field: &Field) -> Rescale {
    match field.reconstruct {
        // Coefficients are values.
        Reconstruct::BSplineInterpolating => Rescale::IDENTITY,
        _ => field.rescale,
    }
}

/// Bounds of the values that reconstruction can give inside a brick: its range, rescaled, and
/// widened by more than interpolation and rescaling can round (some 20 operations of 2⁻²⁴ each).
fn values(range: BrickRange, rescale: Rescale) -> (f32, f32) {
    let (a, b) = (
        rescale.value(f64::from(range.lo)),
        rescale.value(f64::from(range.hi)),
    );
    let largest = f64::from(range.lo.abs().max(range.hi.abs()));
    let size = rescale.slope.abs() * largest + rescale.intercept.abs();
    // Differences of such numbers overflow.
    if !(largest < 1e37 && size < 1e37) {
        return (f32::NEG_INFINITY, f32::INFINITY);
    }
    let margin = size / f64::from(1 << 18);
    ((a.min(b) - margin) as f32, (a.max(b) + margin) as f32)
}

/// What `of` makes of the numbers that reconstruction can reach from inside each brick; of closer ones where the bricks
/// have the reach of cubic kernels.
fn of_reached<T: Copy + Default + Send>(
    bricks: &Bricks,
    reconstruct: Reconstruct,
    of: impl Fn(BrickRange) -> T + Sync,
    control: &Control,
) -> Result<Vec<T>, Cancelled> {
    match reconstruct {
        Reconstruct::Nearest | Reconstruct::Trilinear => bricks.map_under(control, of),
        // Four voxels along each axis reach one further; the weights add up to 1 and none is negative.
        Reconstruct::BSpline | Reconstruct::BSplineInterpolating => {
            of_reached_further(bricks, of, control)
        }
        // The weights along an axis lie between −1/8 and 9/8 at the most, so that a value leaves the
        // range by up to ((5/4)³ − 1)/2 of its width.
        Reconstruct::CatmullRom => {
            let wider = |BrickRange { lo, hi }| {
                let by = if lo > hi { 0.0 } else { (hi - lo) * 0.48 };
                BrickRange {
                    lo: lo - by,
                    hi: hi + by,
                }
            };
            of_reached_further(bricks, |range| of(wider(range)), control)
        }
    }
}

/// What `of` makes of the numbers in each brick and those one voxel further out.
fn of_reached_further<T: Copy + Default + Send>(
    bricks: &Bricks,
    of: impl Fn(BrickRange) -> T + Sync,
    control: &Control,
) -> Result<Vec<T>, Cancelled> {
    if bricks.reach() > 0 {
        return bricks.map_under(control, of);
    }
    // The next bricks hold them.
    let ranges = bricks.ranges().collect();
    let join = |range: &mut BrickRange, other: &BrickRange| *range = range.joined(*other);
    let ranges = joined_with_neighbors(bricks.dims(), ranges, join, control)?;
    Ok(ranges.into_iter().map(of).collect())
}

/// What each brick and the 26 around it have, joined.
fn joined_with_neighbors<T: Copy>(
    dims: [usize; 3],
    mut of_bricks: Vec<T>,
    join: impl Fn(&mut T, &T),
    control: &Control,
) -> Result<Vec<T>, Cancelled> {
    let mut stride = 1;
    for edge in dims {
        control.check()?;
        let before = of_bricks.clone();
        let lines = of_bricks.chunks_exact_mut(stride * edge);
        for (line, before) in lines.zip(before.chunks_exact(stride * edge)) {
            // The next one along the axis, and the one before.
            for (brick, ahead) in line.iter_mut().zip(&before[stride..]) {
                join(brick, ahead);
            }
            for (brick, behind) in line[stride..].iter_mut().zip(before) {
                join(brick, behind);
            }
        }
        stride *= edge;
    }
    Ok(of_bricks)
}

/// Whether a classification shows anything of an interval.
fn shows(classify: Classify, table: &Opaque, lo: f32, hi: f32) -> bool {
    let grey = |black: f32, white: f32| {
        if black < white {
            hi > black
        } else {
            lo < black
        }
    };
    match classify {
        Classify::Table
        | Classify::GradientTable { .. }
        | Classify::ValueGradient { .. }
        | Classify::PreClassified => table.any(lo, hi),
        Classify::Identity { black, white } => grey(black, white),
        Classify::Threshold {
            threshold,
            black,
            white,
        } => hi > threshold && grey(black, white),
    }
}

/// Whether a transfer function shows anything of an interval: what
/// [`TransferTable::max_opacity`] > 0 says, in constant time.
struct Opaque {
    places: Places,
    /// Number of visible entries before each entry.
    before: Vec<u32>,
}

impl Opaque {
    fn new(table: &TransferTable) -> Opaque {
        let mut before = vec![0];
        for entry in table.entries() {
            before.push(before[before.len() - 1] + u32::from(entry[3] > 0.0));
        }
        Opaque {
            places: table.places(),
            before,
        }
    }

    /// Whether any value from `lo` to `hi` is visible.
    fn any(&self, lo: f32, hi: f32) -> bool {
        let entries = self.places.beside(lo, hi);
        self.before[entries.end] > self.before[entries.start]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn visibility_is_max_opacity(
            opaque in proptest::collection::vec(any::<bool>(), 2..60),
            lo in -2f32..2.0,
            width in 0f32..1.0,
        ) {
            let entries = opaque.iter().map(|&o| [0.0, 0.0, 0.0, f32::from(u8::from(o))]);
            let table = TransferTable::new([-1.0, 1.0], 1.0, entries.collect());
            prop_assert_eq!(
                Opaque::new(&table).any(lo, lo + width),
                table.max_opacity(lo, lo + width) > 0.0
            );
        }

        #[test]
        fn around_are_the_bricks_that_touch(
            dims in proptest::array::uniform3(1usize..6),
            seed in any::<u64>(),
        ) {
            let number = dims.iter().product::<usize>();
            let numbers: Vec<u8> = (0..number as u64)
                .map(|i| ((i + 1).wrapping_mul(seed | 1) >> 32) as u8)
                .collect();
            let larger = |most: &mut u8, other: &u8| *most = (*most).max(*other);
            let largest = joined_with_neighbors(dims, numbers.clone(), larger, &Control::NONE);
            let largest = largest.unwrap();
            let place = |i: usize| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            for (i, got) in largest.iter().enumerate() {
                let touches = |j: &usize| (0..3).all(|axis| place(i)[axis].abs_diff(place(*j)[axis]) <= 1);
                let want = (0..number).filter(touches).map(|j| numbers[j]).max();
                prop_assert_eq!(Some(*got), want);
            }
        }
    }
}
