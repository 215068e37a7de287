// Writes particles. The including file binds `particles` and `velocities_yz` (read_write).
//!include particles

fn store_particle(i: u32, p: Particle) {
    particles[i] = vec4<u32>(p.position, bitcast<u32>(p.velocity.x));
    velocities_yz[i] = p.velocity.yz;
}
