// Reads particles. The including file binds `positions` and `velocities`.
//!include particle

fn position_at(i: u32) -> vec3<u32> {
    return vec3<u32>(positions[3u * i], positions[3u * i + 1u], positions[3u * i + 2u]);
}

fn velocity_at(i: u32) -> vec3<f32> {
    return vec3<f32>(velocities[3u * i], velocities[3u * i + 1u], velocities[3u * i + 2u]);
}

fn particle_at(i: u32) -> Particle {
    return Particle(position_at(i), velocity_at(i));
}
