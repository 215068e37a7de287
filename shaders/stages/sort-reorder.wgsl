// sort-reorder: particles of one cell become neighbours in memory (counting sort). Nothing physical changes.
//!include dispatch
//!include cells
//!include particles

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> positions: array<u32>;
@group(0) @binding(2) var<storage, read_write> velocities: array<f32>;
@group(0) @binding(3) var<storage, read> shift: array<u32>;
@group(0) @binding(4) var<storage, read_write> cell_counts: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> block_sums: array<u32>;
@group(0) @binding(6) var<storage, read_write> positions_sorted: array<u32>;
@group(0) @binding(7) var<storage, read_write> velocities_sorted: array<f32>;

const BLOCK: u32 = 1024u;

@compute @workgroup_size(WORKGROUP)
fn clear_counts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        atomicStore(&cell_counts[cell], 0u);
    }
}

@compute @workgroup_size(WORKGROUP)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        atomicAdd(&cell_counts[locate(position_at(i), vec3<u32>(shift[0], shift[1], shift[2])).cell], 1u);
    }
}

// Counts become first places within their block.
@compute @workgroup_size(WORKGROUP)
fn scan_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = invocation(group, groups, lane);
    if block * BLOCK >= system.cell_count {
        return;
    }
    var sum = 0u;
    for (var cell = block * BLOCK; cell < min((block + 1u) * BLOCK, system.cell_count); cell++) {
        let n = atomicLoad(&cell_counts[cell]);
        atomicStore(&cell_counts[cell], sum);
        sum += n;
    }
    block_sums[block] = sum;
}

// Block sums become first places of the blocks.
@compute @workgroup_size(1)
fn scan_sums() {
    var sum = 0u;
    for (var block = 0u; block * BLOCK < system.cell_count; block++) {
        let n = block_sums[block];
        block_sums[block] = sum;
        sum += n;
    }
}

@compute @workgroup_size(WORKGROUP)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    let position = position_at(i);
    let velocity = velocity_at(i);
    let cell = locate(position, vec3<u32>(shift[0], shift[1], shift[2])).cell;
    let place = 3u * (block_sums[cell / BLOCK] + atomicAdd(&cell_counts[cell], 1u));
    for (var k = 0u; k < 3u; k++) {
        positions_sorted[place + k] = position[k];
        velocities_sorted[place + k] = velocity[k];
    }
}

@compute @workgroup_size(WORKGROUP)
fn copy_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    for (var k = 0u; k < 3u; k++) {
        positions[3u * i + k] = positions_sorted[3u * i + k];
        velocities[3u * i + k] = velocities_sorted[3u * i + k];
    }
}
