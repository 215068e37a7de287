// A copy from one buffer to another, 16 bytes per invocation: what memory gives at best, against which kernels are held.

const GROUP: u32 = 256u;

@group(0) @binding(0) var<storage, read_write> from_here: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> to_there: array<vec4<f32>>;

fn index(group: vec3<u32>, groups: vec3<u32>, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * GROUP + lane;
}

// Values that differ, so that no memory compresses them.
@compute @workgroup_size(GROUP)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = index(group, groups, lane);
    if i < arrayLength(&from_here) {
        let mixed = vec4<u32>(i, i + 1u, i + 2u, i + 3u) * 2654435769u;
        from_here[i] = vec4<f32>(mixed ^ (mixed >> vec4<u32>(15u)));
    }
}

@compute @workgroup_size(GROUP)
fn copy(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = index(group, groups, lane);
    if i < arrayLength(&from_here) {
        to_there[i] = from_here[i];
    }
}
