// wall-ghosts: the parts of wall-cut cells that lie behind the wall are filled with ghosts at the wall's velocity, or at the
// fluid's continued behind it: a Poisson process of the fluid's density, drawn in registers and never stored (Lamura et al.
// 2001, with positions).
//!include dispatch
//!include rng
//!include cells
//!include exact
//!include deposit
//!include lanes
//!include operator-load
//!include impulse-fixed
//!include wall-impulse
//!include workgroup-sum

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: WallGhostsSettings;
@group(0) @binding(2) var<uniform> shift: vec4<u32>;
@group(0) @binding(3) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> operators: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> wall_impulses: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> wall_sums: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> wall_shear: array<f32>;
@group(0) @binding(8) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// Words of a patch: wide sums of y (v - u_w) along x and z and of y^2 in this step, y being the distance from the wall.
const WALL_SUM_WORDS: u32 = 6u;
// Words of a patch: averages over the past of the same, then the shear along x and z.
const WALL_SHEAR_WORDS: u32 = 5u;
// By how much these sums' scales are smaller than those of xv and xx in the moments: y reaches four times as far as x, from two
// cells, and u_w may be as fast as any particle.
const MOMENT_MARGIN: f32 = 64.0;
const WEIGHT_MARGIN: f32 = 32.0;

// A cell cut by a wall, and the part of it behind the wall, as an interval of the offset from its centre.
struct Cut {
    cell: u32,
    wall: u32,
    low: f32,
    high: f32,
    // The mean number of ghosts in it, in the unit of `arrival`.
    expected: f32,
    // By which the ghosts' velocity falls with the distance behind the wall.
    shear: vec3<f32>,
}

struct WallGhost {
    x: vec3<f32>,
    v: vec3<f32>,
}

fn wall_cells() -> u32 {
    return 2u * system.cells.x * system.cells.z;
}

fn wall_velocity(wall: u32) -> vec3<f32> {
    return select(system.wall_low, system.wall_high, wall == 1u);
}

// The patch of a wall cell.
fn wall_patch(i: u32) -> u32 {
    let layer = system.cells.x * system.cells.z;
    let k = i % layer;
    let row = i / layer * settings.patches_z + k / system.cells.x / settings.edge;
    return row * settings.patches_x + k % system.cells.x / settings.edge;
}

// Columns of cells in a patch: those at the end may be cut.
fn patch_columns(i: u32) -> f32 {
    let x = i % settings.patches_x;
    let z = i / settings.patches_x % settings.patches_z;
    let edge = vec2<u32>(settings.edge);
    let size = min(edge, system.cells.xz - vec2<u32>(x, z) * edge);
    return f32(size.x * size.y);
}

// Invocations 0, 1, ... are the cells of the low layer, then those of the high one.
fn cut(i: u32) -> Cut {
    let layer = system.cells.x * system.cells.z;
    let wall = i / layer;
    let k = i % layer;
    // Layer 0 begins below the low wall by the share of a cell by which the grid is shifted.
    let plane = fma(f32(shift[1]), system.cell_per_unit.y, -0.5);
    var c: Cut;
    c.wall = wall;
    c.cell = cell_index(vec3<u32>(k % system.cells.x, wall * (system.cells.y - 1u), k / system.cells.x));
    c.low = select(-0.5, plane, wall == 1u);
    c.high = select(plane, 0.5, wall == 1u);
    c.expected = system.density * (c.high - c.low) * LOG2_E;
    if settings.continued == 1u {
        let word = wall_patch(i) * WALL_SHEAR_WORDS + 3u;
        c.shear = vec3<f32>(wall_shear[word], 0.0, wall_shear[word + 1u]);
    }
    return c;
}

const LOG2_E: f32 = 1.4426950408889634;

// By how much a ghost arrives after the one before; the process ends when the arrivals exceed the expected number. In units of ln 2, as
// adapters compute logarithms: a factor might be contracted with the sum over arrivals in one kernel and not in the next.
fn arrival(u: vec4<f32>) -> f32 {
    return max(0.0, -log2(u.x));
}

fn wall_ghost(c: Cut, index: u32, u: vec4<f32>) -> WallGhost {
    var g: WallGhost;
    g.x = vec3<f32>(u.y - 0.5, fma(u.w, c.high - c.low, c.low), u.z - 0.5);
    let random = normals(uniforms(PURPOSE_WALL_GHOST, c.cell, index, 1u));
    g.v = fma(vec3<f32>(system.thermal_speed), random, wall_velocity(c.wall));
    if settings.continued == 1u {
        let depth = select(c.high - g.x.y, g.x.y - c.low, c.wall == 1u);
        g.v = fma(c.shear, vec3<f32>(-depth), g.v);
    }
    return g;
}

fn signed_moment(word: u32) -> f32 {
    return f32(bitcast<i32>(atomicLoad(&moments[word])));
}

// Sums of y (v - u_w) along x and z and of y^2 over the two cells next to the wall of one column; no ghosts are in them yet.
fn observed(i: u32) -> vec3<f32> {
    let layer = system.cells.x * system.cells.z;
    let wall = i / layer;
    let k = i % layer;
    let behind = f32(shift[1]) * system.cell_per_unit.y;
    let inward = select(1.0, -1.0, wall == 1u);
    let u = wall_velocity(wall).xz;
    var sum = vec3<f32>(0.0);
    for (var j = 0u; j < 2u; j++) {
        let row = select(j, system.cells.y - 1u - j, wall == 1u);
        let word = MOMENT_WORDS * cell_index(vec3<u32>(k % system.cells.x, row, k / system.cells.x));
        // Distance of the cell's centre from the wall.
        let centre = f32(j) + inward * (0.5 - behind);
        let n = f32(atomicLoad(&moments[word]));
        let v = vec2<f32>(signed_moment(word + 1u), signed_moment(word + 3u)) * system.inverse_velocity;
        let x = inward * signed_moment(word + 7u) * system.inverse_position;
        let xx = signed_moment(word + 10u) * system.inverse_second;
        let xv = inward * vec2<f32>(signed_moment(word + 18u), signed_moment(word + 20u)) * system.inverse_mixed;
        let about_centre = fma(vec2<f32>(-x), u, xv);
        let of_centre = fma(vec2<f32>(-n), u, v);
        let moment = fma(vec2<f32>(centre), of_centre, about_centre);
        sum += vec3<f32>(moment, fma(centre, fma(centre, n, 2.0 * x), xx));
    }
    return sum;
}

fn add_wall_sum(word: u32, low: u32, high: u32) {
    let old = atomicAdd(&wall_sums[word], low);
    let carried = high + select(0u, 1u, old + low < old);
    if carried != 0u {
        atomicAdd(&wall_sums[word + 1u], carried);
    }
}

// 1 if the wall cells of the workgroup belong to more than one patch.
var<workgroup> mixed: atomic<u32>;

@compute @workgroup_size(WORKGROUP)
fn observe(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if settings.continued == 0u {
        return;
    }
    clear_sums_of_workgroup(lane);
    let first = invocation(group, groups, 0u);
    let i = first + lane;
    let home = wall_patch(min(first, wall_cells() - 1u));
    var own = home;
    var share = vec3<i32>(0);
    if i < wall_cells() {
        own = wall_patch(i);
        let moment_scale = system.scale_mixed * (1.0 / MOMENT_MARGIN);
        let weight_scale = system.scale_second * (1.0 / WEIGHT_MARGIN);
        share = vec3<i32>(round(observed(i) * vec3<f32>(moment_scale, moment_scale, weight_scale)));
    }
    if own != home {
        atomicStore(&mixed, 1u);
    }
    for (var k = 0u; k < 3u; k++) {
        collect(k, share[k]);
    }
    workgroupBarrier();
    // All columns of a large patch would otherwise wait for the same words.
    if atomicLoad(&mixed) == 0u {
        if lane < 3u {
            let all = collected(lane);
            add_wall_sum(home * WALL_SUM_WORDS + 2u * lane, all.x, all.y);
        }
    } else {
        for (var k = 0u; k < 3u; k++) {
            add_wall_sum(own * WALL_SUM_WORDS + 2u * k, bitcast<u32>(share[k]), bitcast<u32>(share[k] >> 31u));
        }
    }
}

// The sums of this step enter the averages and begin anew; the shear follows from the averages.
@compute @workgroup_size(WORKGROUP)
fn average(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if settings.continued == 0u || i >= 2u * settings.patches_x * settings.patches_z {
        return;
    }
    let moment_unit = system.inverse_mixed * MOMENT_MARGIN;
    let units = vec3<f32>(moment_unit, moment_unit, system.inverse_second * WEIGHT_MARGIN);
    var averages: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        let word = i * WALL_SUM_WORDS + 2u * k;
        let seen = wide_value(atomicLoad(&wall_sums[word]), atomicLoad(&wall_sums[word + 1u])) * units[k];
        atomicStore(&wall_sums[word], 0u);
        atomicStore(&wall_sums[word + 1u], 0u);
        let old = wall_shear[i * WALL_SHEAR_WORDS + k];
        averages[k] = fma(settings.fresh, seen - old, old);
        wall_shear[i * WALL_SHEAR_WORDS + k] = averages[k];
    }
    // A patch that holds little fluid, as beneath a body or in the first steps, would tell more noise than shear.
    let weight = max(averages.z, settings.least * patch_columns(i));
    for (var k = 0u; k < 2u; k++) {
        var shear = 0.0;
        if weight > 0.0 {
            shear = divide(averages[k], weight);
        }
        wall_shear[i * WALL_SHEAR_WORDS + 3u + k] = shear;
    }
}

// Of a cell's invocations each takes every LANES-th ghost; `max_count` is a multiple of their number.
@compute @workgroup_size(WORKGROUP)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane) / LANES;
    let part = lane % LANES;
    if i >= wall_cells() {
        return;
    }
    let c = cut(i);
    var time = 0.0;
    var sums: Sums;
    for (var index = part; index < system.max_count && time < c.expected; index += LANES) {
        let u = uniforms(PURPOSE_WALL_GHOST, c.cell, index, 0u);
        let arrived = added_in_order(time, arrival(u), part);
        time = arrived.y;
        if arrived.x < c.expected {
            let g = wall_ghost(c, index, u);
            sums = with_one(sums, ONE_GHOST, c.cell, g.x, g.v, Witness(SITE_WALL_GHOSTS, UNKNOWN, now.step_low));
        }
    }
    deposit_part(c.cell, part, LANES, added_across_lanes(sums));
}

// What the ghosts gain in the collision is the wall's. Gains are summed in fixed point, in halves of 16 bits so that no sum of i32 over
// `max_count` ghosts can overflow; one that is no i32 is a fault.
@compute @workgroup_size(WORKGROUP)
fn receive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane) / LANES;
    let part = lane % LANES;
    if i >= wall_cells() {
        return;
    }
    let c = cut(i);
    let o = operator_at(c.cell);
    var time = 0.0;
    var low = vec3<i32>(0);
    var high = vec3<i32>(0);
    for (var index = part; index < system.max_count && time < c.expected; index += LANES) {
        let u = uniforms(PURPOSE_WALL_GHOST, c.cell, index, 0u);
        let arrived = added_in_order(time, arrival(u), part);
        time = arrived.y;
        if arrived.x < c.expected {
            let g = wall_ghost(c, index, u);
            let gain = impulse_fixed(collided(o, g.x, g.v) - g.v, WALL_SCALE, Witness(SITE_WALL_GHOSTS, UNKNOWN, now.step_low));
            low += gain & vec3<i32>(0xffff);
            high += gain >> vec3<u32>(16u);
        }
    }
    low = across3(low);
    high = across3(high);
    for (var k = part; k < 3u; k += LANES) {
        add_wide_wall_impulse(i / WORKGROUP, c.wall, k, wide_of_halves(low[k], high[k]));
    }
}
