// Reads particles. The including file binds `particles` and `velocities_yz`: the six words of a particle are a vector of four and one of
// two, since what a GPU can do in a time is to fetch so many vectors, however long they are, and to store whole rows of them.
//!include particle

fn position_at(i: u32) -> vec3<u32> {
    return particles[i].xyz;
}

fn velocity_at(i: u32) -> vec3<f32> {
    return vec3<f32>(bitcast<f32>(particles[i].w), velocities_yz[i]);
}

fn particle_at(i: u32) -> Particle {
    let p = particles[i];
    return Particle(p.xyz, vec3<f32>(bitcast<f32>(p.w), velocities_yz[i]));
}
