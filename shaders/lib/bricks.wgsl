// Particles brick by brick: two bricks of 4 x 4 x 4 cells have room for system.room of them together, side by side, and one workgroup does all
// its work for those of a brick. The including file binds `system`, `bricks_xy`, `bricks_zu`, `bricks_vw` (read_write), `brick_counts` and
// `faults` (as atomics), and has `now`.
//!include particle
//!include fault
override BRICK_LANES: u32;
const BRICK_CELLS: u32 = 64u;
// The driver need not clear workgroup memory: who adds to it clears it first.
const CLEARS_WORKGROUP_MEMORY: bool = true;

fn bricks_per_axis() -> vec3<u32> {
    return (system.cells + 3u) / 4u;
}

fn brick_of(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// The place of a brick's k-th particle, k < system.room. Two bricks share a room: one fills it from its beginning, the other from its end.
fn slot_of(brick: u32, k: u32) -> u32 {
    let begin = brick / 2u * system.room;
    return begin + select(k, system.room - 1u - k, brick % 2u == 1u);
}

// The brick with which this one shares its room.
fn partner_of(brick: u32) -> u32 {
    return brick ^ 1u;
}

// How many of those who came to a brick have places there. Whoever works on it asks this first, with the number of its partner: where the two have
// met, some are lost, and the run stops. The partner may be done by then, and have made its number smaller; but it asked before that, and this
// brick's number becomes smaller only after this. So whoever asks first of the two sees both numbers as they were.
fn placed(brick: u32, count: u32, others: u32) -> u32 {
    if count + others > system.room {
        report(FAULT_ROOM, brick * BRICK_CELLS, Witness(SITE_CELL_REDUCE, UNKNOWN, now.step_low));
    }
    return min(count, system.room);
}

var<workgroup> brick_count: u32;

// How many particles the brick has, the same for all of its workgroup.
fn particles_of_brick(brick: u32, lane: u32) -> u32 {
    if lane == 0u {
        brick_count = placed(brick, atomicLoad(&brick_counts[brick]), atomicLoad(&brick_counts[partner_of(brick)]));
    }
    return workgroupUniformLoad(&brick_count);
}

fn particle_in_brick(slot: u32) -> Particle {
    let zu = bricks_zu[slot];
    return Particle(vec3<u32>(bricks_xy[slot], zu.x), vec3<f32>(bitcast<f32>(zu.y), bricks_vw[slot]));
}

// The particle in the k-th place of a brick that has so many.
fn fetched(brick: u32, k: u32, count: u32) -> Particle {
    if k < count {
        return particle_in_brick(slot_of(brick, k));
    }
    return Particle();
}

fn store_in_brick(slot: u32, p: Particle) {
    bricks_xy[slot] = p.position.xy;
    bricks_zu[slot] = vec2<u32>(p.position.z, bitcast<u32>(p.velocity.x));
    bricks_vw[slot] = p.velocity.yz;
}

// How many particles of a brick have been held back, in its first places, for a kernel of their own.
var<workgroup> held_back: atomic<u32>;
