// Particles brick by brick: 4 x 4 x 4 cells have room for system.room of them, side by side, and one workgroup does all its work for them.
// The including file binds `system`, `bricks_xy`, `bricks_zu`, `bricks_vw` (read_write) and `brick_counts` (as atomics).
//!include particle
const BRICK_LANES: u32 = 192u;
// Of a kernel for a few of them.
const HELD_LANES: u32 = 32u;
const BRICK_CELLS: u32 = 64u;
// The driver need not clear workgroup memory: who adds to it clears it first.
const CLEARS_WORKGROUP_MEMORY: bool = true;

fn bricks_per_axis() -> vec3<u32> {
    return (system.cells + 3u) / 4u;
}

fn brick_of(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

var<workgroup> brick_count: u32;

// How many particles the brick has, the same for all of its workgroup.
fn particles_of_brick(brick: u32, lane: u32) -> u32 {
    if lane == 0u {
        // Whoever found no room is lost, and the run stops.
        brick_count = min(atomicLoad(&brick_counts[brick]), system.room);
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
        return particle_in_brick(brick * system.room + k);
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
