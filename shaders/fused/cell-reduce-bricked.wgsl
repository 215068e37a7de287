// cell-reduce where particles lie brick by brick: a workgroup adds up the sums of its brick's cells. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include contribution
//!include fault
//!include bricks
//!include bricks-settle
//!include sums-load
//!include sums-store
//!include energies
//!include walls

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read_write> bricks_xy: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> bricks_zu: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> bricks_vw: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> brick_counts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> bricks_xy_next: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> bricks_zu_next: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read_write> bricks_vw_next: array<vec2<f32>>;
@group(0) @binding(11) var<storage, read_write> brick_counts_next: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read_write> brick_total: array<atomic<u32>>;
@group(0) @binding(13) var<storage, read_write> moments: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read_write> brick_ghosts: array<atomic<u32>>;
@group(0) @binding(15) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// From the row of all particles into the bricks.
fn tallied(i: u32, p: Particle) -> Particle {
    if i == 0u {
        atomicStore(&brick_total[0], 0u);
    }
    let brick = brick_number(brick_place_at(p.position));
    enter_brick(brick, atomicAdd(&brick_counts_next[brick], 1u), p, Witness(SITE_CELL_REDUCE, i, now.step_low));
    return p;
}

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        _ = tallied(i, particle_at(i));
    }
}

var<workgroup> row_first: u32;

// Where the particles of a brick begin in the row of all.
fn place_in_row(count: u32, lane: u32) -> u32 {
    if lane == 0u {
        row_first = atomicAdd(&brick_total[0], count);
    }
    return workgroupUniformLoad(&row_first);
}

// The sums of the brick's cells: the first word of all, then the second.
var<workgroup> brick_sums: array<atomic<u32>, MOMENT_WORDS * BRICK_CELLS>;

// To be followed by a barrier.
fn clear_sums(lane: u32) {
    for (var k = lane; k < MOMENT_WORDS * BRICK_CELLS; k += BRICK_LANES) {
        atomicStore(&brick_sums[k], 0u);
    }
}

fn add_word(k: u32, cell: u32, word: u32) {
    atomicAdd(&brick_sums[k * BRICK_CELLS + cell], word);
}

fn add_words(k: u32, cell: u32, words: vec3<i32>) {
    let w = bitcast<vec3<u32>>(words);
    add_word(k, cell, w.x);
    add_word(k + 1u, cell, w.y);
    add_word(k + 2u, cell, w.z);
}

fn add_to_cell(cell: u32, s: Sums) {
    add_word(0u, cell, s.count);
    add_words(1u, cell, s.v);
    if ENERGIES {
        add_word(4u, cell, s.energy);
        add_word(5u, cell, s.coarse);
    }
    if !PLACES {
        return;
    }
    add_words(6u, cell, s.x);
    add_words(9u, cell, s.diagonal);
    add_words(12u, cell, s.mixed);
    add_words(15u, cell, s.xv0);
    add_words(18u, cell, s.xv1);
    add_words(21u, cell, s.xv2);
}

// Whether a wall cuts the cells of this row along y: then there are wall ghosts in them.
fn at_wall(row: u32) -> bool {
    return WALLS && (row == 0u || row >= system.cells.y - 1u);
}

// Whether a brick has cells in the two rows beside a wall: then its particles are in the sums in memory, to which wall ghosts have added.
fn beside_wall(brick: u32) -> bool {
    let n = bricks_per_axis();
    let y = brick / n.x % n.y;
    return WALLS && (y == 0u || y >= (system.cells.y - 2u) / 4u);
}

fn row_of(cell: u32) -> u32 {
    let n = bricks_per_axis();
    return 4u * (cell / BRICK_CELLS / n.x % n.y) + cell / 4u % 4u;
}

// Adds a particle to the sums of its cell.
fn add_particle(p: Particle) {
    let place = locate(p.position, vec3<u32>(shift[0], shift[1], shift[2]));
    let fault = fault_of(square_of(p.velocity));
    if fault != 0u {
        report(fault, place.cell, Witness(SITE_CELL_REDUCE, UNKNOWN, now.step_low));
        return;
    }
    add_to_cell(place.cell % BRICK_CELLS, contribution(ONE_PARTICLE, place.offset, p.velocity));
}

// Adds up the sums of all cells of a brick, with the ghosts at the end of its room; beside walls the particles are in memory already.
fn gather_brick(brick: u32, lane: u32) {
    clear_sums(lane);
    let count = particles_of_brick(brick, lane);
    if !beside_wall(brick) {
        for (var k = lane; k < count; k += BRICK_LANES) {
            add_particle(particle_in_brick(brick * system.room + k));
        }
    }
    add_ghosts(brick, lane);
}

fn add_ghosts(brick: u32, lane: u32) {
    let ghosts = ghosts_of_brick(brick, lane);
    for (var k = lane; k < ghosts; k += BRICK_LANES) {
        let g = particle_in_brick((brick + 1u) * system.room - 1u - k);
        let place = locate(g.position, vec3<u32>(shift[0], shift[1], shift[2]));
        add_to_cell(place.cell % BRICK_CELLS, contribution(ONE_GHOST, place.offset, g.velocity));
    }
    if lane == 0u {
        atomicStore(&brick_ghosts[brick], 0u);
    }
    workgroupBarrier();
}

var<workgroup> ghost_count: u32;

fn ghosts_of_brick(brick: u32, lane: u32) -> u32 {
    if lane == 0u {
        ghost_count = min(atomicLoad(&brick_ghosts[brick]), system.room);
    }
    return workgroupUniformLoad(&ghost_count);
}

fn sum_word(k: u32, cell: u32) -> u32 {
    return atomicLoad(&brick_sums[k * BRICK_CELLS + cell]);
}

fn sum_words(k: u32, cell: u32) -> vec3<i32> {
    return bitcast<vec3<i32>>(vec3<u32>(sum_word(k, cell), sum_word(k + 1u, cell), sum_word(k + 2u, cell)));
}

// The sums of one cell, once they are there.
fn gathered(cell: u32) -> Sums {
    let s = sums_of_workgroup(cell % BRICK_CELLS);
    if beside_wall(cell / BRICK_CELLS) {
        return sum_of(s, sums_at(cell));
    }
    return s;
}

fn sums_of_workgroup(c: u32) -> Sums {
    var s: Sums;
    s.count = sum_word(0u, c);
    s.v = sum_words(1u, c);
    s.energy = sum_word(4u, c);
    s.coarse = sum_word(5u, c);
    if !PLACES {
        return s;
    }
    s.x = sum_words(6u, c);
    s.diagonal = sum_words(9u, c);
    s.mixed = sum_words(12u, c);
    s.xv0 = sum_words(15u, c);
    s.xv1 = sum_words(18u, c);
    s.xv2 = sum_words(21u, c);
    return s;
}

@compute @workgroup_size(BRICK_LANES)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let brick = brick_of(group, groups);
    if brick * BRICK_CELLS >= system.cell_count {
        return;
    }
    gather_brick(brick, lane);
    if lane < BRICK_CELLS {
        store_sums(brick * BRICK_CELLS + lane, gathered(brick * BRICK_CELLS + lane));
    }
}

// The same without ghosts for the bricks beside walls: what wall ghosts need to know, and nobody adds up again.
@compute @workgroup_size(BRICK_LANES)
fn gather_walls(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let n = bricks_per_axis();
    let k = brick_of(group, groups);
    let layer = k / (n.x * n.z);
    let others = vec2<u32>(system.cells.y - 2u, system.cells.y - 1u) / 4u;
    let y = select(select(others.y, others.x, layer == 1u), 0u, layer == 0u);
    // Some may be the same.
    let again = (layer == 1u && others.x == 0u) || (layer == 2u && (others.y == 0u || others.y == others.x));
    if layer > 2u || again {
        return;
    }
    let brick = (k / n.x % n.z * n.y + y) * n.x + k % n.x;
    clear_sums(lane);
    let count = particles_of_brick(brick, lane);
    for (var k = lane; k < count; k += BRICK_LANES) {
        add_particle(particle_in_brick(brick * system.room + k));
    }
    workgroupBarrier();
    if lane < BRICK_CELLS {
        store_sums(brick * BRICK_CELLS + lane, sums_of_workgroup(lane));
    }
}
