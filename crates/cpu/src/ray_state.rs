//! How far a ray has come, as plain data.

/// All that a ray has become on its way, and how far it has come: copied out and put back, it goes on as if nothing had
/// happened.
///
/// What a ray needs beside its number of lattice points depends on the composite of the Plan:
///
/// | composite | fields |
/// |---|---|
/// | emission–absorption, `back_to_front` | `color`, `alpha` |
/// | `mida` | `color`, `alpha`, `value`; with a `blend` above 0 also `place`, and in `number` the value there |
/// | `mip`, `minip` | `value`, `place`, `number` |
/// | `average` | `value`, `lost`, `number`, `place` |
/// | `gmip` | `value`, `number` |
/// | `first_hit` | `alpha`, `place`: until the ray is finished, the number of the lattice point that was hit |
/// | debug views | `color`, `alpha`; `sample_count`: `number` |
/// | any other | what its file in `library/composite` says |
///
/// Shading that keeps the last normal needs `last_normal`. Segments of a label volume need `segment`, `technique`,
/// `importance` and what begins with `seen` and `hit`, and for groups what rules of sampling look back at: `known` is the group,
/// `values` the color of its runs and `last_alpha` their opacity, `gradient` what their rule remembers and the importance of their places; the fields of the composite are then those of the run that goes on. Of the rules of sampling
///
/// - `regular` and `adaptive` need nothing more. (A run of `adaptive` that begins in an interval is done in it: the ray
///   then stands behind the interval.)
/// - `by-opacity` needs `last_alpha`; its strides may end behind an interval, too.
/// - `refine`, `split` and `integrated` look back: a segment goes from the lattice point before to the one where the
///   ray stands, and its beginning is in `values`; `split-cubic` looks back over two points and reads one point
///   ahead of the ray, `split` under light keeps the gradient at the point before.
/// - `refine` with `mip` or `minip` looks around the place of the value when the ray is finished, as `first_hit`
///   looks between the point that was hit and the one before: what is there has to be at hand then.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RayState {
    /// Number of lattice points behind the ray, in the order in which the composite goes: it stands at the lattice
    /// point of this number, with `back_to_front` counted from the far end. A ray at its end stands behind the last one.
    pub walked: u32,
    /// Premultiplied, without what is behind the volume.
    pub color: [f32; 3],
    /// Opacity so far.
    pub alpha: f32,
    /// The value so far: largest, smallest, sum.
    pub value: f32,
    /// Lattice coordinate (in steps from the entry) at which that value, or the hit, lies.
    pub place: f32,
    /// What rounding has lost from a sum.
    pub lost: f32,
    /// Number of samples, or whether there was one: 1.
    pub number: f32,
    /// Towards the larger values, in the world, of length 1; 0 if there was none.
    pub last_normal: [f32; 3],
    /// Opacity in front of the last sample whose brick may show something.
    pub last_alpha: f32,
    /// Values at two lattice points behind the ray, the further one first, and at the one where it stands.
    pub values: [f32; 3],
    /// The gradient at the lattice point behind the ray, per voxel step in the world.
    pub gradient: [f32; 3],
    /// Bit i: `values[i]` is known; bit 3: `gradient` is.
    pub known: u32,
    /// The segment of the last lattice point by its number in the label volume, counted from 1; 0 if there was none.
    pub segment: u32,
    /// Its technique, counted from 1; 0 where it is hidden, 65535 where no more of its run is to be seen.
    pub technique: u32,
    /// What the runs of segments that have ended add up to, premultiplied …
    pub seen_color: [f32; 3],
    /// … and how opaque they are.
    pub seen_alpha: f32,
    /// What their rule remembers: the largest luminance, or the importance so far …
    pub seen_weight: f32,
    /// … and the number of those that are not transparent, or whether there was one: 1.
    pub seen_runs: u32,
    /// The importance of the places of the run that goes on.
    pub importance: f32,
    /// Lattice coordinate of the first hit among them …
    pub hit_place: f32,
    /// … if there was one: 1.
    pub has_hit: u32,
    /// Samples taken …
    pub samples: u32,
    /// … those that took part in the pixel …
    pub visible: u32,
    /// … and lattice points that bricks left out.
    pub skipped: u32,
}

/// The numbers of a [`RayState`].
pub const NUMBERS: usize = 34;

impl RayState {
    /// All numbers, each exact: counts are at most 2^24.
    pub(crate) fn numbers(&self) -> [f32; NUMBERS] {
        let [r, g, b] = self.color;
        let [nx, ny, nz] = self.last_normal;
        let [before, begin, end] = self.values;
        let [gx, gy, gz] = self.gradient;
        let [seen_r, seen_g, seen_b] = self.seen_color;
        [
            self.walked as f32,
            r,
            g,
            b,
            self.alpha,
            self.value,
            self.place,
            self.lost,
            self.number,
            nx,
            ny,
            nz,
            self.last_alpha,
            before,
            begin,
            end,
            gx,
            gy,
            gz,
            self.known as f32,
            self.segment as f32,
            self.technique as f32,
            seen_r,
            seen_g,
            seen_b,
            self.seen_alpha,
            self.seen_weight,
            self.seen_runs as f32,
            self.importance,
            self.hit_place,
            self.has_hit as f32,
            self.samples as f32,
            self.visible as f32,
            self.skipped as f32,
        ]
    }

    /// What has these numbers.
    pub(crate) fn from_numbers(numbers: [f32; NUMBERS]) -> RayState {
        let [
            walked,
            r,
            g,
            b,
            alpha,
            value,
            place,
            lost,
            number,
            nx,
            ny,
            nz,
            last_alpha,
            before,
            begin,
            end,
            gx,
            gy,
            gz,
            known,
            segment,
            technique,
            seen_r,
            seen_g,
            seen_b,
            seen_alpha,
            seen_weight,
            seen_runs,
            importance,
            hit_place,
            has_hit,
            samples,
            visible,
            skipped,
        ] = numbers;
        RayState {
            walked: walked as u32,
            color: [r, g, b],
            alpha,
            value,
            place,
            lost,
            number,
            last_normal: [nx, ny, nz],
            last_alpha,
            values: [before, begin, end],
            gradient: [gx, gy, gz],
            known: known as u32,
            segment: segment as u32,
            technique: technique as u32,
            seen_color: [seen_r, seen_g, seen_b],
            seen_alpha,
            seen_weight,
            seen_runs: seen_runs as u32,
            importance,
            hit_place,
            has_hit: has_hit as u32,
            samples: samples as u32,
            visible: visible as u32,
            skipped: skipped as u32,
        }
    }
}
