// stream: free flight for one time step, half a kick of the body force before and after, reflection at walls.
//!include dispatch
//!include cells
//!include particles-store
//!include path
//!include wall-impulse

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> wall_impulses: array<atomic<u32>>;

fn streamed(i: u32, before: Particle) -> Particle {
    let p = fly(Path(before.position, kicked(before.velocity, before.position), vec3<f32>(0.0), vec3<f32>(0.0)), system.dt);
    if any(p.low != vec3<f32>(0.0)) {
        add_wall_impulse(i / WORKGROUP, 0u, p.low);
    }
    if any(p.high != vec3<f32>(0.0)) {
        add_wall_impulse(i / WORKGROUP, 1u, p.high);
    }
    return Particle(p.position, kicked(p.velocity, p.position));
}

// Whether its flight ends behind a wall.
fn meets_wall(before: Particle) -> bool {
    return wall_share(before.position.y, kicked(before.velocity, before.position).y * system.dt) <= 1.0;
}

// The flight of one that meets none.
fn flown(i: u32, before: Particle) -> Particle {
    let v = kicked(before.velocity, before.position);
    let position = before.position + to_units(v * system.dt);
    return Particle(position, kicked(v, position));
}

@compute @workgroup_size(WORKGROUP)
fn stream(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        store_particle(i, streamed(i, particle_at(i)));
    }
}
