// Ghosts in the parts of cells that lie behind a wall, and the shear of the fluid beside it that they continue. The including file binds
// `system`, `wall_shear` and `wall_ghosts` (read_write) and `wall_sums` (as atomics), and includes `lanes`. Cells that a wall cuts are numbered
// in tiles of 8 x 8 columns, which lie in a row along x, then z, first those of the low wall; tiles at the end may have columns beyond the box.
// Within a tile they go quarter by quarter.
//!include rng
//!include cells
//!include exact
//!include contribution
//!include sums-words
//!include sums-workgroup
//!include wide
//!include fault

// Words of a patch: wide sums of y (v - u_w) along x and z and of y^2, y being the distance from the wall, of even steps, then of odd ones.
const WALL_SUM_WORDS: u32 = 12u;
// Words of a patch: averages of the same over the steps before, for even steps, then for odd ones.
const WALL_SHEAR_WORDS: u32 = 6u;
// By how much these sums' scales are smaller than those of xv and xx in the moments: y reaches four times as far as x, from two
// cells, and u_w may be as fast as any particle.
const MOMENT_MARGIN: f32 = 64.0;
const WEIGHT_MARGIN: f32 = 32.0;

const TILE: u32 = 8u;
const QUARTER: u32 = TILE / 2u;

fn tiles() -> vec2<u32> {
    return (system.cells.xz + TILE - 1u) / TILE;
}

// A cell cut by a wall: that of a column of cells, by its numbers along x and z, or none.
struct WallCell {
    wall: u32,
    column: vec2<u32>,
    there: bool,
}

fn wall_cell(i: u32) -> WallCell {
    let n = tiles();
    let tile = i / (TILE * TILE);
    let quarter = i / (QUARTER * QUARTER);
    let column = TILE * vec2<u32>(tile % n.x, tile / n.x % n.y) + QUARTER * (vec2<u32>(quarter, quarter / 2u) % 2u)
        + vec2<u32>(i, i / QUARTER) % QUARTER;
    let wall = tile / (n.x * n.y);
    return WallCell(wall, column, wall < 2u && all(column < system.cells.xz));
}

// Its number.
fn wall_cell_number(wall: u32, column: vec2<u32>) -> u32 {
    let n = tiles();
    let tile = column / TILE;
    let quarter = column / QUARTER % 2u;
    let within = column % QUARTER;
    let quarters = 4u * ((wall * n.y + tile.y) * n.x + tile.x) + 2u * quarter.y + quarter.x;
    return (quarters * QUARTER + within.y) * QUARTER + within.x;
}

// The row of cells that is the j-th from a wall.
fn row_from_wall(wall: u32, j: u32) -> u32 {
    return select(j, system.cells.y - 1u - j, wall == 1u);
}

fn cell_from_wall(c: WallCell, j: u32) -> u32 {
    return cell_index(vec3<u32>(c.column.x, row_from_wall(c.wall, j), c.column.y));
}

fn wall_velocity(wall: u32) -> vec3<f32> {
    return select(system.wall_low, system.wall_high, wall == 1u);
}

// The patch of a column.
fn wall_patch(wall: u32, column: vec2<u32>, s: WallGhostsSettings) -> u32 {
    return (wall * s.patches_z + column.y / s.edge) * s.patches_x + column.x / s.edge;
}

// The first word of a step's sums.
fn wall_sum_word(home: u32, step: u32) -> u32 {
    return home * WALL_SUM_WORDS + (step & 1u) * (WALL_SUM_WORDS / 2u);
}

fn wall_shear_word(home: u32, step: u32) -> u32 {
    return home * WALL_SHEAR_WORDS + (step & 1u) * (WALL_SHEAR_WORDS / 2u);
}

// Averages up to the step before this one.
fn past_averages(home: u32, s: WallGhostsSettings) -> vec3<f32> {
    let moment_unit = system.inverse_mixed * MOMENT_MARGIN;
    let units = vec3<f32>(moment_unit, moment_unit, system.inverse_second * WEIGHT_MARGIN);
    let sum = wall_sum_word(home, now.step_low + 1u);
    let word = wall_shear_word(home, now.step_low + 1u);
    var averages: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        let seen = wide_value(atomicLoad(&wall_sums[sum + 2u * k]), atomicLoad(&wall_sums[sum + 2u * k + 1u])) * units[k];
        let old = wall_shear[word + k];
        averages[k] = fma(s.fresh, seen - old, old);
    }
    return averages;
}

// Columns of cells in the patch of a column: those at the end may be cut.
fn columns_around(column: vec2<u32>, s: WallGhostsSettings) -> f32 {
    let first = column / s.edge * s.edge;
    let size = min(vec2<u32>(s.edge), system.cells.xz - first);
    return f32(size.x * size.y);
}

// The shear along x and z that the fluid beside a wall cell has had. The first of a patch keeps the averages, and empties the sums of this step.
fn past_shear(c: WallCell, s: WallGhostsSettings) -> vec2<f32> {
    let home = wall_patch(c.wall, c.column, s);
    let averages = past_averages(home, s);
    if all(c.column % s.edge == vec2<u32>(0u)) {
        let sum = wall_sum_word(home, now.step_low);
        for (var k = 0u; k < WALL_SUM_WORDS / 2u; k++) {
            atomicStore(&wall_sums[sum + k], 0u);
        }
        let word = wall_shear_word(home, now.step_low);
        for (var k = 0u; k < 3u; k++) {
            wall_shear[word + k] = averages[k];
        }
    }
    // A patch that holds little fluid, as beneath a body or in the first steps, would tell more noise than shear.
    let weight = max(averages.z, s.least * columns_around(c.column, s));
    if weight > 0.0 {
        return vec2<f32>(divide(averages.x, weight), divide(averages.y, weight));
    }
    return vec2<f32>(0.0);
}

// The part of a cell behind the wall, as an interval of the offset from its centre.
struct Cut {
    low: f32,
    high: f32,
}

// The lowest cells reach behind the low wall by the share of a cell by which the grid has been moved, the highest ones as far into the box.
fn cut(wall: u32, shift_y: u32) -> Cut {
    let plane = fma(f32(shift_y), system.cell_per_unit.y, -0.5);
    return Cut(select(-0.5, plane, wall == 1u), select(plane, 0.5, wall == 1u));
}

const LOG2_E: f32 = 1.4426950408889634;

// Distances from one point of a Poisson process to the next, four of them. They are in units of ln 2, as adapters compute logarithms: a factor
// might be contracted with the sum over them in one kernel and not in the next.
fn distances(cell: u32, block: u32) -> vec4<f32> {
    return max(vec4<f32>(0.0), -log2(uniforms(PURPOSE_WALL_GHOST, cell, block, 1u)));
}

// Where the process has got to, and how many of its points lie within the expected number of ghosts.
struct Arrivals {
    time: f32,
    count: u32,
}

fn arrived(before: Arrivals, distances: vec4<f32>, expected: f32) -> Arrivals {
    var a = before;
    for (var k = 0u; k < 4u; k++) {
        a.time += distances[k];
        a.count += select(0u, 1u, a.time < expected);
    }
    return a;
}

struct WallGhost {
    x: vec3<f32>,
    v: vec3<f32>,
}

fn wall_ghost(c: Cut, wall: u32, cell: u32, shear: vec2<f32>, index: u32) -> WallGhost {
    let drawn = seven(words(PURPOSE_WALL_GHOST, cell, index, 0u));
    let u = drawn.place;
    var g: WallGhost;
    g.x = vec3<f32>(u.x - 0.5, fma(u.z, c.high - c.low, c.low), u.y - 0.5);
    let random = normals(drawn.motion);
    let depth = select(c.high - g.x.y, g.x.y - c.low, wall == 1u);
    g.v = fma(vec3<f32>(shear.x, 0.0, shear.y), vec3<f32>(-depth), fma(vec3<f32>(system.thermal_speed), random, wall_velocity(wall)));
    return g;
}

// Cells whose ghosts one workgroup draws.
const DRAWN_CELLS: u32 = 64u / LANES;
var<workgroup> first_distances: array<vec4<f32>, 64>;
// Of each of them: the number of ghosts in it and in all before it, and their shear along x and z.
var<workgroup> ghosts_up_to: array<u32, DRAWN_CELLS>;
var<workgroup> shears: array<vec2<f32>, DRAWN_CELLS>;

// How many ghosts a cell has. Each of the cell's invocations has looked at one block.
fn ghosts_behind(c: Cut, cell: u32, lane: u32) -> u32 {
    let expected = system.density * (c.high - c.low) * LOG2_E;
    var a = Arrivals(0.0, 0u);
    for (var block = 0u; block < LANES; block++) {
        a = arrived(a, first_distances[lane + block], expected);
    }
    for (var block = LANES; a.time < expected && a.count < system.max_count; block++) {
        a = arrived(a, distances(cell, block), expected);
    }
    return a.count;
}

// The first of the cells that has the k-th ghost or a later one.
fn cell_with(k: u32) -> u32 {
    var first = 0u;
    for (var half = DRAWN_CELLS / 2u; half > 0u; half /= 2u) {
        if ghosts_up_to[first + half - 1u] <= k {
            first += half;
        }
    }
    return first;
}

// Counts the ghosts of the cells from number `first` on.
fn count_ghosts(first: u32, lane: u32, c: Cut, s: WallGhostsSettings) {
    let own = wall_cell(first + lane / LANES);
    let cell = cell_from_wall(own, 0u);
    if own.there {
        first_distances[lane] = distances(cell, lane % LANES);
    }
    workgroupBarrier();
    if lane % LANES == 0u {
        var n = 0u;
        var shear = vec2<f32>(0.0);
        if own.there {
            n = ghosts_behind(c, cell, lane);
            if s.continued == 1u {
                shear = past_shear(own, s);
            }
        }
        ghosts_up_to[lane / LANES] = n;
        shears[lane / LANES] = shear;
    }
    for (var step = 1u; step < DRAWN_CELLS; step *= 2u) {
        workgroupBarrier();
        var before = 0u;
        if lane >= step && lane < DRAWN_CELLS {
            before = ghosts_up_to[lane - step];
        }
        workgroupBarrier();
        if lane < DRAWN_CELLS {
            ghosts_up_to[lane] += before;
        }
    }
    workgroupBarrier();
}

// Makes sums over the ghosts of the cells from number `first` on: the workgroup shares them evenly, however many a cell has. Ends with a barrier.
fn sum_ghosts(first: u32, lane: u32, shift_y: u32, s: WallGhostsSettings) {
    clear_sums(lane, WORKGROUP);
    let wall = wall_cell(first).wall;
    let c = cut(wall, shift_y);
    count_ghosts(first, lane, c, s);
    let all = ghosts_up_to[DRAWN_CELLS - 1u];
    // Neighbours draw for different cells, so that their additions do not meet.
    let each = (all + WORKGROUP - 1u) / WORKGROUP;
    for (var k = lane * each; k < min((lane + 1u) * each, all); k++) {
        let number = cell_with(k);
        let cell = cell_from_wall(wall_cell(first + number), 0u);
        var index = k;
        if number > 0u {
            index -= ghosts_up_to[number - 1u];
        }
        let g = wall_ghost(c, wall, cell, shears[number], index);
        let fault = fault_of(square_of(g.v));
        if fault != 0u {
            report(fault, cell, Witness(SITE_WALL_GHOSTS, UNKNOWN, now.step_low));
        } else {
            add_to_cell(number, raw_contribution(GHOST, g.x, g.v));
        }
    }
    workgroupBarrier();
}

// The sums over the ghosts of a wall cell.
fn store_wall_ghosts(i: u32, s: Sums) {
    let k = 6u * i;
    let words = words_of(s);
    wall_ghosts[k] = words[0];
    wall_ghosts[k + 1u] = words[1];
    if !PLACES {
        return;
    }
    wall_ghosts[k + 2u] = words[2];
    wall_ghosts[k + 3u] = words[3];
    wall_ghosts[k + 4u] = words[4];
    wall_ghosts[k + 5u] = words[5];
}

fn wall_ghosts_at(i: u32) -> Sums {
    let k = 6u * i;
    var words: array<vec4<u32>, 6>;
    words[0] = wall_ghosts[k];
    words[1] = wall_ghosts[k + 1u];
    if PLACES {
        words[2] = wall_ghosts[k + 2u];
        words[3] = wall_ghosts[k + 3u];
        words[4] = wall_ghosts[k + 4u];
        words[5] = wall_ghosts[k + 5u];
    }
    return sums_of_words(words);
}

// What the cell in row `j` from the wall, without ghosts, adds to sum y (v - u_w) along x and z and to sum y^2, in fixed point: of its sums
// it needs the number, those over v and y, and y y and y v.
fn seen_from_wall(wall: u32, j: u32, s: Sums, shift_y: u32) -> vec3<i32> {
    let inward = select(1.0, -1.0, wall == 1u);
    let u = wall_velocity(wall).xz;
    // Distance of the cell's centre from the wall.
    let centre = f32(j) + inward * (0.5 - f32(shift_y) * system.cell_per_unit.y);
    let n = f32(number_in(s.count));
    let v = vec2<f32>(s.v.xz) * system.inverse_velocity;
    let x = inward * f32(s.x.y) * system.inverse_position;
    let xx = f32(s.diagonal.y) * system.inverse_second;
    let xv = inward * vec2<f32>(s.xv1.xz) * system.inverse_mixed;
    let about_centre = fma(vec2<f32>(-x), u, xv);
    let of_centre = fma(vec2<f32>(-n), u, v);
    let moment = fma(vec2<f32>(centre), of_centre, about_centre);
    let weight = fma(centre, fma(centre, n, 2.0 * x), xx);
    let moment_scale = system.scale_mixed * (1.0 / MOMENT_MARGIN);
    let weight_scale = system.scale_second * (1.0 / WEIGHT_MARGIN);
    return vec3<i32>(round(vec3<f32>(moment, weight) * vec3<f32>(moment_scale, moment_scale, weight_scale)));
}
