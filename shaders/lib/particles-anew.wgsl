// Writes particles to new places. The including file binds `positions_sorted` and `velocities_sorted` (read_write).
//!include particle

fn store_particle_anew(i: u32, p: Particle) {
    positions_sorted[3u * i] = p.position.x;
    positions_sorted[3u * i + 1u] = p.position.y;
    positions_sorted[3u * i + 2u] = p.position.z;
    velocities_sorted[3u * i] = p.velocity.x;
    velocities_sorted[3u * i + 1u] = p.velocity.y;
    velocities_sorted[3u * i + 2u] = p.velocity.z;
}
