// Writes particles. The including file binds `positions` and `velocities` (read_write).
//!include particles

fn store_particle(i: u32, p: Particle) {
    positions[3u * i] = p.position.x;
    positions[3u * i + 1u] = p.position.y;
    positions[3u * i + 2u] = p.position.z;
    velocities[3u * i] = p.velocity.x;
    velocities[3u * i + 1u] = p.velocity.y;
    velocities[3u * i + 2u] = p.velocity.z;
}
