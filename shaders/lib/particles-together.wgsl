// Writes the particles of a subgroup, whose invocations are neighbours, side by side. Each invocation would else write three words with
// gaps that its neighbours fill later, and memory takes a third as many writes of whole blocks. The including file binds `positions` and
// `velocities` (read_write).
//!include particle

// The word of three that this invocation writes, out of the vectors of the whole subgroup.
fn taken(a: vec3<u32>, word: u32) -> u32 {
    let x = subgroupShuffle(a.x, word / 3u);
    let y = subgroupShuffle(a.y, word / 3u);
    let z = subgroupShuffle(a.z, word / 3u);
    return select(select(z, y, word % 3u == 1u), x, word % 3u == 0u);
}

// `i` is the particle, `lane` the number of the invocation in its subgroup of `size`. All of them take part, also those without a particle.
fn store_together(i: u32, lane: u32, size: u32, p: Particle) {
    let first = 3u * (i - lane);
    let end = 3u * system.particle_count;
    for (var k = 0u; k < 3u; k++) {
        let word = k * size + lane;
        let position = taken(p.position, word);
        let velocity = taken(bitcast<vec3<u32>>(p.velocity), word);
        if first + word < end {
            positions[first + word] = position;
            velocities[first + word] = bitcast<f32>(velocity);
        }
    }
}
