// shift-grid for the steps to come: nobody waits for it in each of them. Beside a shift is the low word of its step.
//!include dispatch
//!include rng

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> shifts: array<vec4<u32>>;
var<immediate> now: Now;

// Steps whose shifts are there at a time, this one and those after it, beside that of the step before. Vectors from one to the next: a uniform
// begins at a multiple of 256 bytes.
const AHEAD: u32 = 63u;
const STRIDE: u32 = 16u;

@compute @workgroup_size(WORKGROUP)
fn shift_ahead(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = invocation(group, groups, lane);
    if k >= AHEAD {
        return;
    }
    let low = now.step_low + k;
    let step = vec2<u32>(low, now.step_high + select(0u, 1u, low < k));
    let u = units(words_at(step, PURPOSE_SHIFT, 0u, 0u, 0u));
    shifts[low % (AHEAD + 1u) * STRIDE] = vec4<u32>(vec3<u32>(u.xyz * system.units), low);
}
