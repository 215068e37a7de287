// apply: every particle receives its cell's operator, v <- b + A v + W x x.
//!include dispatch
//!include cells
//!include particles-store
//!include operator-load

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read> operators: array<vec4<f32>>;

fn applied(i: u32, p: Particle) -> Particle {
    let place = locate(p.position, vec3<u32>(shift[0], shift[1], shift[2]));
    return Particle(p.position, collided(operator_at(place.cell), place.offset, p.velocity));
}

@compute @workgroup_size(WORKGROUP)
fn apply(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    store_particle(i, applied(i, particle_at(i)));
}
