// Brings particles back into their row. The including file binds `particles_next` and `velocities_yz_next` (read_write).
//!include particle

fn leave_for_row(i: u32, p: Particle) {
    particles_next[i] = vec4<u32>(p.position, bitcast<u32>(p.velocity.x));
    velocities_yz_next[i] = p.velocity.yz;
}
