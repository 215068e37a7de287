// cell-reduce: the sums over each cell's particles, in fixed point so that their order cannot matter.
//!include dispatch
//!include cells
//!include deposit
//!include particles

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// A workgroup clears the words of its 64 cells side by side.
@compute @workgroup_size(WORKGROUP)
fn clear(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let first = invocation(group, groups, 0u) * MOMENT_WORDS;
    let end = system.cell_count * MOMENT_WORDS;
    for (var k = lane; k < WORKGROUP * MOMENT_WORDS; k += WORKGROUP) {
        if first + k < end {
            atomicStore(&moments[first + k], 0u);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn reduce(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    let p = particle_at(i);
    let place = locate(p.position, vec3<u32>(shift[0], shift[1], shift[2]));
    deposit(FLUID, place.cell, place.offset, p.velocity, Witness(SITE_CELL_REDUCE, i, now.step_low));
}
