// What the loop over one object in segments calls: samples of one segment in a row are a run, which its
// technique makes into one sample; runs add up front to back, those of a group among themselves first.

@group(0) @binding(14) var labels: texture_3d<u32>;
/// Rows of `TABLE_ROW` entries, `SEGMENT_ENTRIES` for each segment.
@group(0) @binding(15) var segments: texture_2d<u32>;

const SEGMENT_ENTRIES: u32 = 7u;
const HIDDEN: u32 = 0u;
const NO_SEGMENT: u32 = 0xFFFFFFFFu;
/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

var<private> entry_in_voxel: vec3f;
var<private> step_in_voxel: vec3f;
/// Of the run: `HIDDEN` as well where nothing of it is left to be added.
var<private> technique_of_run: u32 = HIDDEN;

var<private> segment_of_run: u32 = NO_SEGMENT;
/// Opacity of all that lies before the run.
var<private> alpha_before: f32 = 0.0;

fn covered() -> f32 {
    return alpha_before;
}

fn technique() -> u32 {
    return technique_of_run;
}

fn object() -> u32 {
    return 0u;
}

fn table_first() -> u32 {
    return u32(technique_numbers(0u).x);
}

fn bricks_first() -> vec3u {
    return vec3u(0u);
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entry_in_voxel + lattice_point * step_in_voxel;
}

// Where a place lies among the voxels of the label volume around it.
struct LabelCell {
    first: vec3i,
    // From the first voxel to the next along each axis, 0 to 1.
    share: vec3f,
    is_outside: bool,
}

// The first texels of the tables say where the label volume lies.
fn label_cell(position: vec3f) -> LabelCell {
    let p = vec4f(position, 1.0);
    let place = vec3f(dot(table_entry(0u), p), dot(table_entry(1u), p), dot(table_entry(2u), p));
    let end = vec3f(textureDimensions(labels)) - 0.5;
    let is_outside = any(place < vec3f(-0.5 - ROUNDING)) || any(place > end + ROUNDING);
    let inside = clamp(place, vec3f(0.0), end - 0.5);
    let first = floor(inside);
    return LabelCell(vec3i(first), inside - first, is_outside);
}

fn label_corner(cell: LabelCell, corner: i32) -> u32 {
    let voxel = cell.first + vec3i(corner & 1, corner >> 1u & 1, corner >> 2u & 1);
    return textureLoad(labels, min(voxel, vec3i(textureDimensions(labels)) - 1), 0).r;
}

fn label_weight(cell: LabelCell, corner: i32) -> f32 {
    let side = vec3<bool>((corner & 1) == 1, (corner >> 1u & 1) == 1, (corner >> 2u & 1) == 1);
    let share = select(1.0 - cell.share, cell.share, side);
    return share.x * share.y * share.z;
}

// That whose voxels around the position have the largest weight as trilinear interpolation counts.
fn segment_at(position: vec3f) -> u32 {
    let cell = label_cell(position);
    if cell.is_outside {
        return u32(table_entry(3u).x);
    }
    var numbers: array<u32, 8>;
    var are_equal = true;
    for (var i = 0; i < 8; i++) {
        numbers[i] = label_corner(cell, i);
        are_equal = are_equal && numbers[i] == numbers[0];
    }
    if are_equal {
        return numbers[0];
    }
    var heaviest = NO_SEGMENT;
    var largest = 0.0;
    for (var i = 0; i < 8; i++) {
        var weight = 0.0;
        for (var j = 0; j < 8; j++) {
            weight += select(0.0, label_weight(cell, j), numbers[j] == numbers[i]);
        }
        if weight > largest || (weight == largest && numbers[i] < heaviest) {
            largest = weight;
            heaviest = numbers[i];
        }
    }
    return heaviest;
}

// The weight that the segment of the run has at a position, 0 to 1.
fn membership(position: vec3f) -> f32 {
    let cell = label_cell(position);
    if cell.is_outside {
        return select(0.0, 1.0, u32(table_entry(3u).x) == segment_of_run);
    }
    var weight = 0.0;
    var number = 0;
    for (var i = 0; i < 8; i++) {
        if label_corner(cell, i) == segment_of_run {
            weight += label_weight(cell, i);
            number += 1;
        }
    }
    // Weights add up to 1 but for rounding.
    return select(weight, 1.0, number == 8);
}

fn segment_entry(segment: u32, number: u32) -> u32 {
    let index = segment * SEGMENT_ENTRIES + number;
    return textureLoad(segments, vec2u(index % TABLE_ROW, index / TABLE_ROW), 0).r;
}

fn technique_of_segment(segment: u32) -> u32 {
    return segment_entry(segment, 0u);
}

/// What runs add up to, and what their rule remembers of them.
struct Sum {
    color: vec4f,
    weight: f32,
    number: f32,
}

/// What the runs of a ray have become so far.
struct Runs {
    /// Those without a group, and groups.
    all: Sum,
    /// Those of the group in which the ray is, counted from 1; 0 if it is in none.
    of_group: Sum,
    group: u32,
    /// The importance of the places of the group's runs.
    group_by_place: f32,
}

const NOTHING: Sum = Sum(vec4f(0.0), 0.0, 0.0);

// How runs become a pixel: the numbers of `table_entry(3u).z`.
const BRIGHTEST: u32 = 1u;
const AVERAGE: u32 = 2u;
const FIRST: u32 = 3u;
const IMPORTANCE_AWARE: u32 = 4u;

fn global_rule() -> u32 {
    return u32(table_entry(3u).z);
}

// Of a group, counted from 1, its rule, opacity and importance.
fn group_numbers(group: u32) -> vec4f {
    return table_entry(4u + group);
}

// The rule by which runs of a group add up, or by which runs without a group do.
fn rule_of(group: u32) -> u32 {
    if group == 0u {
        return global_rule();
    }
    return u32(group_numbers(group).x);
}

fn no_runs() -> Runs {
    return Runs(NOTHING, NOTHING, 0u, 0.0);
}

// With a run of `segment`, which has a tint and an opacity; `by_place` is the importance of its places.
fn with_run(runs: Runs, untinted: vec4f, segment: u32, by_place: f32) -> Runs {
    let factors = bitcast<vec4f>(vec4u(
        segment_entry(segment, 1u),
        segment_entry(segment, 2u),
        segment_entry(segment, 3u),
        segment_entry(segment, 4u),
    ));
    let run = untinted * factors;
    let importance = bitcast<f32>(segment_entry(segment, 5u)) + by_place;
    var next = runs;
    if runs.group == 0u {
        next.all = added(runs.all, run, importance, global_rule());
    } else {
        next.of_group = added(runs.of_group, run, importance, rule_of(runs.group));
        next.group_by_place = max(runs.group_by_place, by_place);
    }
    return next;
}

// Where the ray is in `segment`: the group that it has left makes one sample.
fn entered(runs: Runs, segment: u32) -> Runs {
    return in_group(runs, segment_entry(segment, 6u));
}

fn in_group(runs: Runs, group: u32) -> Runs {
    if group == runs.group {
        return runs;
    }
    var all = runs.all;
    if runs.group != 0u {
        let numbers = group_numbers(runs.group);
        let sample = mixed(runs.of_group, rule_of(runs.group)) * numbers.y;
        all = added(all, sample, numbers.z + runs.group_by_place, global_rule());
    }
    return Runs(all, NOTHING, group, 0.0);
}

// With one more run, by a rule.
fn added(sum: Sum, run: vec4f, importance: f32, rule: u32) -> Sum {
    if run.a <= 0.0 {
        return sum;
    }
    switch rule {
        case BRIGHTEST: {
            let luminance = dot(run.rgb, vec3f(0.2126, 0.7152, 0.0722));
            if luminance > sum.weight {
                return Sum(run, luminance, 1.0);
            }
            return sum;
        }
        case AVERAGE: {
            return Sum(sum.color + run, 0.0, sum.number + 1.0);
        }
        case FIRST: {
            if sum.number > 0.0 {
                return sum;
            }
            return Sum(run, 0.0, 1.0);
        }
        case IMPORTANCE_AWARE: {
            return with_important(sum, run, importance);
        }
        default: {
            return Sum(sum.color + (1.0 - sum.color.a) * run, 0.0, 1.0);
        }
    }
}

// As the composite `importance_aware` adds a sample.
fn with_important(sum: Sum, run: vec4f, importance: f32) -> Sum {
    let rise = importance - sum.weight;
    let before = sum.color.a;
    var kept = 1.0;
    if rise > 0.0 && 1.0 - before < 1.0 - exp(-rise) {
        kept = exp(-rise) / before;
    }
    let passing = 1.0 - run.a;
    let alpha = before * passing + run.a;
    let modulated = kept * before * passing + run.a;
    let color = kept * sum.color.rgb + (1.0 - kept * before) * run.rgb;
    let accumulated = importance + log(run.a + passing * exp(min(-rise, 0.0)));
    let weight = select(sum.weight, max(sum.weight, accumulated), rise > 0.0);
    return Sum(vec4f(color * (alpha / modulated), alpha), weight, 1.0);
}

// The hit of the ray is that of its first run with one.
fn keep_first_hit(before_mm: f32) {
    hit_mm = select(hit_mm, before_mm, before_mm < NOWHERE_MM);
}

// Whether nothing behind can be seen.
fn is_complete(runs: Runs) -> bool {
    let passing = 1.0 - runs.all.color.a;
    switch global_rule() {
        case BRIGHTEST, AVERAGE: {
            return false;
        }
        case FIRST: {
            return runs.all.number > 0.0;
        }
        case IMPORTANCE_AWARE: {
            return passing < 0.00390625 && runs.all.weight >= table_entry(3u).w;
        }
        default: {
            return passing < table_entry(3u).y || passing <= 0.0;
        }
    }
}

fn mixed(sum: Sum, rule: u32) -> vec4f {
    if rule == AVERAGE {
        return sum.color / max(sum.number, 1.0);
    }
    return sum.color;
}

fn pixel_of(runs: Runs) -> vec4f {
    return mixed(in_group(runs, 0u).all, global_rule());
}

fn opacity_before(runs: Runs) -> f32 {
    let passing = 1.0 - min(mixed(runs.all, global_rule()).a, 1.0);
    return 1.0 - passing * (1.0 - min(mixed(runs.of_group, rule_of(runs.group)).a, 1.0));
}
