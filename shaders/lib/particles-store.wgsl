// Writes particles. The including file binds `positions` and `velocities` (read_write).
//!include particles

fn store_particle(i: u32, p: Particle) {
    for (var k = 0u; k < 3u; k++) {
        positions[3u * i + k] = p.position[k];
        velocities[3u * i + k] = p.velocity[k];
    }
}
