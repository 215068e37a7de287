// cell-reduce where particles lie brick by brick: a workgroup adds up the sums of its brick's cells. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include sums-workgroup
//!include fault
//!include bricks
//!include bricks-settle
//!include sums-store
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

// Whether a wall cuts the cells of this row along y: then there are wall ghosts in them.
fn at_wall(row: u32) -> bool {
    return WALLS && (row == 0u || row >= system.cells.y - 1u);
}

fn row_of(cell: u32) -> u32 {
    let n = bricks_per_axis();
    return 4u * (cell / BRICK_CELLS / n.x % n.y) + cell / 4u % 4u;
}

// Adds a particle to the sums of its cell.
fn add_particle(p: Particle) {
    let moved = vec3<u32>(shift[0], shift[1], shift[2]);
    let place = locate_in_brick(p.position, moved);
    let fault = fault_of(square_of(p.velocity));
    if fault != 0u {
        report(fault, locate(p.position, moved).cell, Witness(SITE_CELL_REDUCE, UNKNOWN, now.step_low));
        return;
    }
    add_to_cell(place.cell, raw_contribution(FLUID, place.offset, p.velocity));
}

// How many ghosts of squirmers the brick has.
var<workgroup> ghost_count: u32;

// Adds up the sums of all cells of a brick over its particles; ghosts follow.
fn gather_brick(brick: u32, lane: u32) {
    clear_sums(lane, BRICK_LANES);
    if lane == 0u {
        ghost_count = placed(brick, atomicLoad(&brick_ghosts[brick]), atomicLoad(&brick_ghosts[partner_of(brick)]));
    }
    let count = particles_of_brick(brick, lane);
    for (var k = lane; k < count; k += BRICK_LANES) {
        add_particle(particle_in_brick(slot_of(brick, k)));
    }
}

// A ghost in the other set of bricks, which is free from when all have moved until they move again.
fn ghost_in_brick(slot: u32) -> Particle {
    let zu = bricks_zu_next[slot];
    return Particle(vec3<u32>(bricks_xy_next[slot], zu.x), vec3<f32>(bitcast<f32>(zu.y), bricks_vw_next[slot]));
}

fn add_ghosts(brick: u32, lane: u32) {
    let ghosts = workgroupUniformLoad(&ghost_count);
    for (var k = lane; k < ghosts; k += BRICK_LANES) {
        let g = ghost_in_brick(slot_of(brick, k));
        let place = locate_in_brick(g.position, vec3<u32>(shift[0], shift[1], shift[2]));
        add_to_cell(place.cell, raw_contribution(GHOST, place.offset, g.velocity));
    }
    if lane == 0u {
        atomicStore(&brick_ghosts[brick], 0u);
    }
    workgroupBarrier();
}

// The sums of one cell, once they are there.
fn gathered(cell: u32) -> Sums {
    return sums_of_workgroup(cell % BRICK_CELLS);
}

@compute @workgroup_size(BRICK_LANES)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let brick = brick_of(group, groups);
    if brick * BRICK_CELLS >= system.cell_count {
        return;
    }
    gather_brick(brick, lane);
    add_ghosts(brick, lane);
    if lane < BRICK_CELLS {
        store_sums(brick * BRICK_CELLS + lane, gathered(brick * BRICK_CELLS + lane));
    }
}
