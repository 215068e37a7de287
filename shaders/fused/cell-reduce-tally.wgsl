// cell-reduce without atomic sums: every cell chains its particles, then sums over them. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order. This is the first half: particles join the chains.
//!include dispatch
//!include cells
//!include particles
//!include chains

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read_write> chains: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> links: array<u32>;

fn chain_at(p: vec3<u32>) -> u32 {
    return chain_of(locate(p, vec3<u32>(shift[0], shift[1], shift[2])).cell, shift[3]);
}

fn tallied(i: u32, p: Particle) -> Particle {
    join_chain(chain_at(p.position), i);
    return p;
}

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        join_chain(chain_at(position_at(i)), i);
    }
}
