//! The Spec: what is built, immutable while it runs. Widths in bits, times in clocks of the pipeline.

mod checks;
mod extension_checks;
mod extensions;

pub use extensions::{Axis, Bend, Merge, PlacedVolume, Polygons, Shadow, Shape};

use crate::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything about the processor, its memory, the view and the look that a run depends on, beside the volume.
///
/// The default is the document's design: 64 rays sorted by their distance from the image plane, eight memory
/// modules, leaping and early ray termination on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Spec {
    /// Clock of pipeline and memory in MHz; only frame rates and transfer times depend on it.
    pub clock_mhz: f64,
    /// Word widths.
    pub widths: Widths,
    /// Clocks that each unit takes.
    pub latency: Latency,
    /// Rays, their order, and how tiles follow each other.
    pub queue: Queue,
    /// The volume memory.
    pub memory: Memory,
    /// What is left out.
    pub optimisation: Optimisation,
    /// Voxel → opacity → light.
    pub look: Look,
    /// From where the volume is seen, and how finely it is sampled.
    pub view: View,
    /// The bus to the host.
    pub host: Host,
    /// Several volumes, several boards.
    pub merge: Merge,
    /// Surfaces among the samples.
    pub polygons: Polygons,
    /// Whether rays are bent. Needs leaping off.
    pub bend: Bend,
    /// Whether there are shadows: twice the reads.
    pub shadow: Shadow,
}

impl Default for Spec {
    fn default() -> Spec {
        Spec {
            clock_mhz: 100.0,
            widths: Widths::default(),
            latency: Latency::default(),
            queue: Queue::default(),
            memory: Memory::default(),
            optimisation: Optimisation::default(),
            look: Look::default(),
            view: View::default(),
            host: Host::default(),
            merge: Merge::default(),
            polygons: Polygons::default(),
            bend: Bend::None,
            shadow: Shadow::None,
        }
    }
}

/// Widths of words in bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Widths {
    /// Integer bits of a position P, beside its sign: volumes up to 2^n voxels per axis.
    pub position_integer: u32,
    /// Fraction bits of a position P.
    pub position_fraction: u32,
    /// Integer bits of a step Δ, beside its sign.
    pub step_integer: u32,
    /// Fraction bits of a step Δ; at most those of P.
    pub step_fraction: u32,
    /// Bits of L, the steps that a ray has left. The document's 10 are too few for the diagonal of 1024³.
    pub length: u32,
    /// Bits of the sort key.
    pub key: u32,
    /// Bits of the fractions that reach the interpolator.
    pub fraction: u32,
    /// Bits of a voxel behind the pre-classification table, and of opacity.
    pub data: u32,
    /// Fraction bits that interpolation keeps below those of `data`.
    pub lerp_guard: u32,
    /// Bits of norm1 and norm2 of the shading unit.
    pub norm: u32,
    /// Bits of one coordinate inside a face of the reflectance map: the table has 6 · 4^n entries.
    pub reflectance_index: u32,
    /// Bits of a reflected intensity.
    pub intensity: u32,
    /// Bits of T, the light that still passes.
    pub transmittance: u32,
    /// Fraction bits of the accumulator C below those of `intensity`.
    pub accumulator_fraction: u32,
    /// Bits of a distance word.
    pub distance: u32,
    /// Bits of the light that arrives at a sample, in the buffer of the shadow pass.
    pub shadow: u32,
}

impl Default for Widths {
    fn default() -> Widths {
        Widths {
            position_integer: 10,
            position_fraction: 12,
            step_integer: 2,
            step_fraction: 12,
            length: 10,
            key: 10,
            fraction: 8,
            data: 8,
            lerp_guard: 0,
            norm: 8,
            reflectance_index: 3,
            intensity: 8,
            transmittance: 16,
            accumulator_fraction: 8,
            distance: 8,
            shadow: 8,
        }
    }
}

impl Widths {
    /// Wide enough that word widths can no longer be seen: 1024³ at any angle and twice the sampling.
    pub fn wide() -> Widths {
        Widths {
            position_integer: 11,
            position_fraction: 18,
            step_integer: 2,
            step_fraction: 18,
            length: 13,
            key: 13,
            fraction: 12,
            data: 12,
            lerp_guard: 5,
            norm: 12,
            reflectance_index: 6,
            intensity: 12,
            transmittance: 20,
            accumulator_fraction: 12,
            distance: 8,
            shadow: 16,
        }
    }
}

/// Clocks from the input of a unit to its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Latency {
    /// Parameter RAM: ray number → P.
    pub parameter: u32,
    /// Memory: READ → data.
    pub memory: u32,
    /// Δ · d.
    pub multiply: u32,
    /// P + Δ · d.
    pub add: u32,
    /// The register of the sort bus.
    pub sort: u32,
    /// One interpolation: subtract, multiply, add. Three follow each other.
    pub lerp: u32,
    /// The table behind interpolation.
    pub classify: u32,
    /// Absorption, up to the decision that a ray is dead.
    pub absorb: u32,
    /// From that decision to the set of dead rays at the queue.
    pub terminate: u32,
    /// Shading: sign, divide, arctan, table, interpolation.
    pub shade: u32,
    /// Compositing.
    pub composite: u32,
}

impl Default for Latency {
    fn default() -> Latency {
        Latency {
            parameter: 1,
            memory: 3,
            multiply: 1,
            add: 1,
            sort: 1,
            lerp: 3,
            classify: 1,
            absorb: 2,
            terminate: 1,
            shade: 8,
            composite: 2,
        }
    }
}

/// The ray manager.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Queue {
    /// Rays of a tile along x and y; as many stages as rays.
    pub bundle: [u32; 2],
    /// Which ray is next.
    pub order: Order,
    /// When the rays of the next tile come.
    pub handover: Handover,
    /// Whether a ray waits for its memory row or the pipeline does.
    pub scheduling: Scheduling,
    /// Pipelines that share the memory, each with a queue and tiles of its own.
    pub pipelines: u32,
}

impl Default for Queue {
    fn default() -> Queue {
        Queue {
            bundle: [8, 8],
            order: Order::PlaneDistance,
            handover: Handover::WhenEmpty,
            scheduling: Scheduling::Freeze,
            pipelines: 1,
        }
    }
}

/// The key of the sorting queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// Smallest distance from the image plane first.
    PlaneDistance,
    /// Longest remaining length first.
    RemainingLength,
    /// Not sorted: first in, first out.
    RoundRobin,
}

/// When the rays of the next tile enter the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Handover {
    /// As soon as no ray waits, from a preloaded second set of stages: what the document's frame rates count.
    WhenEmpty,
    /// When the tile is complete, pipeline included; preloaded.
    WhenDone,
    /// When the tile is complete, then one ray per clock.
    Serial,
    /// Whenever a stage is free, one ray per clock, behind all rays of the tile before: the queue never drains. Needs an
    /// input for new rays beside the sort bus.
    Refill,
}

/// Who waits for a memory row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduling {
    /// The first ray goes, and the memory controller freezes everything until its rows are open.
    Freeze,
    /// The first ray whose rows are open goes; rows of the first ray are opened meanwhile.
    ReadyRowFirst {
        /// How many rays from the front of the queue are looked at.
        window: u32,
    },
}

/// The volume memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Memory {
    /// How voxels lie in it.
    pub model: MemoryModel,
    /// Chips of one module.
    pub chips: u32,
    /// Banks of one chip.
    pub banks: u32,
    /// Rows of one bank.
    pub rows: u32,
    /// Words of one row, a power of two.
    pub columns: u32,
    /// Reads that it takes per clock, for several pipelines: its clock against theirs.
    pub ports: u32,
    /// Which rows an access needs, for time; both are always counted.
    pub row_rule: RowRule,
    /// Whether the distance store has rows to open.
    pub distance_store: DistanceMemory,
    /// Clocks of its commands.
    pub timing: Timing,
    /// A cache in front of every module.
    pub cache: Option<Cache>,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            model: MemoryModel::M8,
            chips: 2,
            banks: 4,
            rows: 4096,
            columns: 512,
            ports: 1,
            row_rule: RowRule::Exact,
            distance_store: DistanceMemory::Ideal,
            timing: Timing::default(),
            cache: None,
        }
    }
}

/// What the distances lie in, which are read in parallel with the voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DistanceMemory {
    /// Every distance is there when its voxels are, as in the document's figures.
    Ideal,
    /// One module like those of the voxels, cells interleaved as in `m1-interleaved`: its rows are opened while those of the
    /// voxels are, and hold the pipeline for what is longer. It is refreshed together with them.
    Sdram,
}

/// How voxels lie in the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MemoryModel {
    /// Eight modules by the lowest bits of x, y, z; a row of all of them is a block of 16³.
    M8,
    /// One module, the same interleaving of bits; eight reads per sample.
    M1Interleaved,
    /// One module, 9 bits of x, then 9 of y, then 9 of z; eight reads per sample.
    M1Linear,
}

/// Which rows an access needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RowRule {
    /// The row of the voxel S0, and all modules together: how the document's figures come about.
    Thesis,
    /// The rows of all eight neighbours, in every module and bank.
    Exact,
}

/// Clocks of memory commands. The default is the document's SDR SDRAM at 100 MHz; bounds that are 0 do not bind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// PRECHARGE to ACTIVE of a bank (tRP).
    pub precharge: u32,
    /// ACTIVE to READ of a bank (tRCD).
    pub activate: u32,
    /// ACTIVE to PRECHARGE of a bank (tRAS).
    pub row_active: u32,
    /// READ to PRECHARGE of a bank (tRTP).
    pub read_to_precharge: u32,
    /// READ to READ in another bank group (tCCD_S).
    pub read: u32,
    /// READ to READ in the same bank group (tCCD_L).
    pub read_same_group: u32,
    /// ACTIVE to ACTIVE of one chip (tRRD).
    pub activate_to_activate: u32,
    /// Any five ACTIVEs of one chip span at least this (tFAW).
    pub four_activates: u32,
    /// Bank groups of a chip.
    pub bank_groups: u32,
    /// Words of one READ, a power of two.
    pub burst: u32,
    /// Between two refreshes (tREFI); 0 for none, which is how the document counts.
    pub refresh_interval: u32,
    /// How long a refresh takes (tRFC).
    pub refresh: u32,
    /// Longest time that a row may be open; 0 for no bound.
    pub longest_open: u32,
}

impl Default for Timing {
    fn default() -> Timing {
        Timing {
            precharge: 3,
            activate: 6,
            row_active: 0,
            read_to_precharge: 0,
            read: 1,
            read_same_group: 1,
            activate_to_activate: 0,
            four_activates: 0,
            bank_groups: 1,
            burst: 1,
            refresh_interval: 0,
            refresh: 0,
            longest_open: 0,
        }
    }
}

/// A cache in front of every module: lines of one burst, least recently used goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cache {
    /// Sets, a power of two.
    pub sets: u32,
    /// Lines of a set.
    pub ways: u32,
    /// Words of a line, a power of two and at least a burst.
    pub line: u32,
}

/// What is left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Optimisation {
    /// A ray ends when less than this share of light passes; 0 for never.
    pub termination_threshold: f64,
    /// Whether rays leap over empty space, and by which rule.
    pub leaping: Leaping,
    /// The circuit that codes distances; none: software, which is exact. Its clocks are counted, once per classification.
    pub distance_engine: Option<Engine>,
    /// Edge in cells of what shares one distance word: 1, or 2 for a store of an eighth of the size.
    pub distance_block: u32,
    /// Also leap where all corners of the surrounding cells are equal (for gradient-weighted compositing, which gives
    /// such places no light). Changes the picture, as their absorption is lost too.
    pub leap_homogeneous: bool,
    /// Adaptive distance sampling: leap (at most 7 steps) where interpolating opacity between the ends of the leap is
    /// wrong by no more than this many opacity steps; 0 for off.
    pub adaptive_error: u32,
}

impl Default for Optimisation {
    fn default() -> Optimisation {
        Optimisation {
            termination_threshold: 0.05,
            leaping: Leaping::Safe,
            distance_engine: None,
            distance_block: 1,
            leap_homogeneous: false,
            adaptive_error: 0,
        }
    }
}

impl Optimisation {
    /// Brute force: every sample of every ray.
    pub fn none() -> Optimisation {
        Optimisation {
            termination_threshold: 0.0,
            leaping: Leaping::Off,
            ..Optimisation::default()
        }
    }
}

/// The distance coder: a shift register over one plane of a column of the volume. Columns overlap, and distances beyond
/// the margin are cut to margin + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Engine {
    /// Cells of a plane along x, margins included; 5 to 1024.
    pub columns: u32,
    /// Cells of a plane along y, margins included; 3 to 1024.
    pub rows: u32,
    /// Cells on every side that are fed but not written; 1 to 254, less than half of `columns` and `rows`.
    pub margin: u32,
    /// If coder and caster share one programmable chip: milliseconds to load either, up to 60,000. Coding then takes two
    /// loads more. 0 if both are there.
    #[serde(default)]
    pub load_ms: u32,
}

/// How far a ray leaps in empty space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Leaping {
    /// One step at a time.
    Off,
    /// ⌊(D − 1) / s⌋ + 1 steps, D the distance in cells to the next cell with a visible corner: never changes a picture.
    Safe,
    /// max(1, ⌊d / s⌋) steps, d the distance in voxels from S0 to the next visible voxel: the document's rule, which can
    /// leap over a sample that is not empty.
    Document,
}

/// Voxel → opacity → light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Look {
    /// Where voxels become opacities.
    pub classification: Classification,
    /// Opacity over values: points (value, opacity 0 to 1), values ascending; constant before the first and behind the
    /// last. Two points at one value make a step. None: from 0 at a quarter of the volume's range to 1 at its end.
    pub opacity: Vec<[f64; 2]>,
    /// The lights.
    pub lights: Vec<Light>,
    /// Ambient, diffuse and specular share.
    pub phong: [f64; 3],
    /// Exponent of the highlight.
    pub shininess: f64,
    /// Colour and reflection over values, for a picture in colour: values ascending, linear between, constant outside. None:
    /// grey, with the shares of `phong`. Needs classification `post`.
    pub materials: Vec<Material>,
    /// Whether samples are lit.
    pub shading: Shading,
    /// Whether the length of the gradient weighs what a sample adds to the picture.
    pub gradient_weighting: bool,
    /// Multiplies that length, a power of two.
    pub gradient_gain: u32,
    /// What is behind everything, 0 to 1.
    pub background: f64,
    /// How values between voxels are found.
    pub reconstruction: Reconstruction,
}

impl Default for Look {
    fn default() -> Look {
        Look {
            classification: Classification::Pre,
            opacity: Vec::new(),
            lights: vec![Light {
                direction: [-0.4, -1.0, 0.6],
                intensity: 1.0,
            }],
            phong: [0.15, 0.75, 0.25],
            shininess: 16.0,
            materials: Vec::new(),
            shading: Shading::ReflectanceMap,
            gradient_weighting: true,
            gradient_gain: 8,
            background: 0.0,
            reconstruction: Reconstruction::Trilinear,
        }
    }
}

impl Look {
    /// The look with the curve that counts for a volume of this range.
    pub fn settled(&self, [lo, hi]: [f64; 2]) -> Look {
        let mut look = self.clone();
        if look.opacity.is_empty() {
            look.opacity = vec![[lo + 0.25 * (hi - lo), 0.0], [hi.max(lo + 1e-9), 1.0]];
        }
        look
    }
}

/// Where voxels become opacities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Classification {
    /// Before interpolation, on every data bus: a table of 64K entries.
    Pre,
    /// Behind interpolation: a table of 2^data entries. Voxels are cut to `data` bits over the volume's range.
    Post,
    /// Behind interpolation, by a table over the values at both ends of a step. Needs leaping off.
    PreIntegrated,
}

/// What a value looks like: C = ambient + diffuse · Id · colour + specular · Is, Id and Is the light of the reflectance maps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// The value.
    pub value: f64,
    /// Red, green, blue, 0 to 1.
    pub color: [f64; 3],
    /// Share of ambient light, 0 to 1.
    pub ambient: f64,
    /// Share of diffuse light, 0 to 1.
    pub diffuse: f64,
    /// Share of the highlight, 0 to 1.
    pub specular: f64,
}

/// A parallel light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Towards the light, in the view: x to the right, y into the picture, z up. Any length but 0.
    pub direction: [f64; 3],
    /// Factor ≥ 0.
    pub intensity: f64,
}

/// Whether samples are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// By the reflectance map.
    ReflectanceMap,
    /// Full intensity everywhere.
    Unlit,
}

/// How values between voxels are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reconstruction {
    /// Interpolated.
    Trilinear,
    /// The nearest voxel.
    Nearest,
}

/// From where the volume is seen. Without rotation along +y, x to the right and z up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct View {
    /// Turn about the z axis in degrees; 90 looks along +x.
    pub rotate_z_deg: f64,
    /// Turn of the eye upwards in degrees.
    pub rotate_x_deg: f64,
    /// How rays spread.
    pub projection: Projection,
    /// Distance of samples along the view direction in voxels.
    pub step: f64,
    /// Distance of rays on the image plane in voxels, for parallel rays.
    pub pixel: f64,
    /// Turns step and pixel to twice their size while the picture moves: 1/8 of the samples.
    pub is_moving: bool,
    /// Slabs of equal depth between intermediate image planes, 1 to 64, each with rays that lie one voxel apart at its back;
    /// 1 for none. More than 1 needs perspective.
    pub slabs: u32,
}

impl Default for View {
    fn default() -> View {
        View {
            rotate_z_deg: 0.0,
            rotate_x_deg: 0.0,
            projection: Projection::Parallel,
            step: 1.0,
            pixel: 1.0,
            is_moving: false,
            slabs: 1,
        }
    }
}

/// How rays spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Not at all.
    Parallel,
    /// From an eye. Rays start 1 / (2 tan(β/2) + 1) voxels apart, which is 1 apart at the back of a cube.
    Perspective {
        /// The full angle β over the longer side of the picture, in degrees.
        angle_deg: f64,
    },
}

/// The bus to the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Host {
    /// Bytes per microsecond (MB/s). The document's table uses 533.
    pub bus_mb_per_s: f64,
    /// Whether tiles wait for their parameters; the document's frame rates ignore transfers.
    pub is_waited_for: bool,
    /// Clocks of the local bus for a single access of a script, or the first word of a burst; 1 to 1000.
    pub single_clocks: u32,
}

impl Default for Host {
    fn default() -> Host {
        Host {
            bus_mb_per_s: 533.0,
            is_waited_for: false,
            single_clocks: 4,
        }
    }
}

impl Spec {
    /// Reads a Spec from JSON with comments; unknown keys are errors.
    ///
    /// # Errors
    /// If the text is no Spec, or contradicts itself.
    pub fn parse(file: &str, json: &str) -> Result<Spec, Error> {
        let problem = |problem: String| Error::File {
            file: file.to_owned(),
            problem,
        };
        let mut text = json.to_owned();
        json_strip_comments::strip(&mut text).map_err(|error| problem(error.to_string()))?;
        let spec: Spec = serde_json::from_str(&text).map_err(|error| problem(error.to_string()))?;
        spec.check()?;
        Ok(spec)
    }

    /// The Spec with some fields changed: each change is `path=value`, such as `queue.bundle=[16,16]` or
    /// `queue.order=round-robin`.
    ///
    /// # Errors
    /// If a path or value is not there, or the result contradicts itself.
    pub fn with(&self, changes: &[String]) -> Result<Spec, Error> {
        let problem = |change: &str, problem: String| Error::File {
            file: format!("the change {change}"),
            problem,
        };
        let mut all = serde_json::to_value(self).map_err(|e| problem("", e.to_string()))?;
        for change in changes {
            let Some((path, text)) = change.split_once('=') else {
                let wanted = "it must be path=value, such as queue.bundle=[16,16]";
                return Err(problem(change, wanted.to_owned()));
            };
            let value = serde_json::from_str(text)
                .unwrap_or_else(|_| serde_json::Value::String(text.to_owned()));
            let mut at = &mut all;
            for key in path.split('.') {
                let known: Vec<String> = at
                    .as_object()
                    .map(|o| o.keys().cloned().collect())
                    .unwrap_or_default();
                at = match at.get_mut(key) {
                    Some(next) => next,
                    None => {
                        let message = format!("there is no {key}; there are {}", known.join(", "));
                        return Err(problem(change, message));
                    }
                };
            }
            *at = value;
            // After every change, so that the message names the one that does not fit.
            serde_json::from_value::<Spec>(all.clone())
                .map_err(|e| problem(change, e.to_string()))?;
        }
        let spec: Spec = serde_json::from_value(all).map_err(|e| problem("", e.to_string()))?;
        spec.check()?;
        Ok(spec)
    }

    /// The JSON schema of a Spec.
    pub fn schema() -> String {
        let schema = schemars::schema_for!(Spec);
        serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
    }

    /// The Spec as JSON with a comment above every field: what the schema says about it.
    pub fn to_commented_json(&self) -> String {
        let schema = schemars::schema_for!(Spec);
        let value = serde_json::to_value(self).unwrap_or_default();
        let mut text = String::new();
        comment(schema.as_value(), schema.as_value(), &value, 0, &mut text);
        text + "\n"
    }
}

/// Prints `value` with what `schema` says about its fields.
fn comment(
    root: &serde_json::Value,
    schema: &serde_json::Value,
    value: &serde_json::Value,
    depth: usize,
    text: &mut String,
) {
    let schema = match schema["$ref"].as_str() {
        Some(path) => root.pointer(path.trim_start_matches('#')).unwrap_or(schema),
        None => schema,
    };
    let properties = &schema["properties"];
    let Some(object) = value.as_object().filter(|_| properties.is_object()) else {
        text.push_str(&value.to_string());
        return;
    };
    let indent = "  ".repeat(depth + 1);
    text.push_str("{\n");
    for (i, (key, value)) in object.iter().enumerate() {
        let field = &properties[key];
        if let Some(description) = field["description"].as_str() {
            for line in description.lines().filter(|line| !line.is_empty()) {
                text.push_str(&format!("{indent}// {line}\n"));
            }
        }
        for choice in choices(root, field) {
            text.push_str(&format!("{indent}//   {choice}\n"));
        }
        text.push_str(&format!("{indent}\"{key}\": "));
        comment(root, field, value, depth + 1, text);
        text.push_str(if i + 1 < object.len() { ",\n" } else { "\n" });
    }
    text.push_str(&"  ".repeat(depth));
    text.push('}');
}

/// The values that a field may have, if they are a closed list.
fn choices(root: &serde_json::Value, field: &serde_json::Value) -> Vec<String> {
    let schema = match field["$ref"].as_str() {
        Some(path) => root.pointer(path.trim_start_matches('#')).unwrap_or(field),
        None => field,
    };
    let Some(list) = schema["oneOf"].as_array() else {
        return Vec::new();
    };
    list.iter()
        .filter_map(|choice| {
            let about = choice["description"]
                .as_str()
                .unwrap_or_default()
                .replace('\n', " ");
            if let Some(name) = choice["const"].as_str() {
                return Some(format!("\"{name}\": {about}"));
            }
            let (name, inner) = choice["properties"].as_object()?.iter().next()?;
            let fields = inner["properties"].as_object()?;
            let fields: Vec<String> = fields.keys().map(|k| format!("\"{k}\": …")).collect();
            Some(format!(
                "{{\"{name}\": {{{}}}}}: {about}",
                fields.join(", ")
            ))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_spec_is_the_spec() {
        for spec in [
            Spec::default(),
            Spec {
                widths: Widths::wide(),
                ..Spec::default()
            },
        ] {
            let text = spec.to_commented_json();
            assert_eq!(Spec::parse("spec", &text).unwrap(), spec, "{text}");
            assert!(text.contains("// Bits of the sort key."), "{text}");
            assert!(text.contains("\"round-robin\": Not sorted"), "{text}");
        }
    }

    #[test]
    fn changes_are_typed() {
        let changes = [
            "queue.bundle=[16,4]",
            "queue.order=round-robin",
            "memory.cache={\"sets\":4,\"ways\":2,\"line\":8}",
        ];
        let spec = Spec::default().with(&changes.map(str::to_owned)).unwrap();
        assert_eq!(spec.queue.bundle, [16, 4]);
        assert_eq!(spec.queue.order, Order::RoundRobin);
        assert_eq!(spec.memory.cache.unwrap().line, 8);
    }

    /// Every refusal names field, value and what would be right.
    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        let cases = [
            ("queue.bundle=[0,8]", "queue.bundle", "1 to 64"),
            ("widths.step_fraction=14", "widths.step_fraction", "14"),
            ("widths.fraction=13", "widths.fraction", "at most"),
            (
                "widths.position_fraction=24",
                "widths.position_fraction",
                "20",
            ),
            (
                "widths.reflectance_index=9",
                "widths.reflectance_index",
                "1 to 8",
            ),
            ("memory.columns=500", "memory.columns", "power of two"),
            (
                "memory.cache={\"sets\":3,\"ways\":2,\"line\":8}",
                "memory.cache.sets",
                "power of two",
            ),
            (
                "memory.timing.refresh_interval=5",
                "memory.timing.refresh_interval",
                "nothing but refresh",
            ),
            ("look.opacity=[[5,1],[3,0]]", "look.opacity", "ascend"),
            (
                "optimisation.distance_block=4",
                "optimisation.distance_block",
                "1 or 2",
            ),
            (
                "look.classification=pre-integrated",
                "look.classification",
                "leaping",
            ),
            ("queue.bundel=3", "bundel", "bundle"),
            ("queue.order=sorted", "queue.order=sorted", "round-robin"),
            ("clock_mhz=0", "clock_mhz", "greater than 0"),
            ("nonsense", "nonsense", "path=value"),
        ];
        for (change, field, bound) in cases {
            let message = Spec::default()
                .with(&[change.to_owned()])
                .unwrap_err()
                .to_string();
            assert!(
                message.contains(field) && message.contains(bound),
                "{change}: {message}"
            );
        }
    }
}
