// sort-reorder: particles of one cell become neighbours in memory (counting sort). Nothing physical changes.
//!include dispatch
//!include cells
//!include particles

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read_write> places: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> block_sums: array<u32>;
@group(0) @binding(6) var<storage, read_write> particles_sorted: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> velocities_yz_sorted: array<vec2<f32>>;

// Cells of one workgroup of the scan, four for each invocation.
const BLOCK: u32 = 1024u;
const SCAN: u32 = 256u;

@compute @workgroup_size(WORKGROUP)
fn clear_places(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        atomicStore(&places[cell], 0u);
    }
}

@compute @workgroup_size(WORKGROUP)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        atomicAdd(&places[locate(position_at(i), vec3<u32>(shift[0], shift[1], shift[2])).cell], 1u);
    }
}

var<workgroup> partial: array<u32, 256>;

// The sum of `mine` over all earlier lanes of the workgroup; the last lane's `partial` is the sum of all.
fn sum_before(lane: u32, mine: u32) -> u32 {
    partial[lane] = mine;
    workgroupBarrier();
    for (var reach = 1u; reach < SCAN; reach *= 2u) {
        var added = 0u;
        if lane >= reach {
            added = partial[lane - reach];
        }
        workgroupBarrier();
        partial[lane] += added;
        workgroupBarrier();
    }
    return partial[lane] - mine;
}

// Counts become first places within their block.
@compute @workgroup_size(SCAN)
fn scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = group.y * groups.x + group.x;
    let first = block * BLOCK + 4u * lane;
    var counts = array<u32, 4>(0u, 0u, 0u, 0u);
    for (var k = 0u; k < 4u; k++) {
        if first + k < system.cell_count {
            counts[k] = atomicLoad(&places[first + k]);
        }
    }
    var place = sum_before(lane, counts[0] + counts[1] + counts[2] + counts[3]);
    for (var k = 0u; k < 4u; k++) {
        if first + k < system.cell_count {
            atomicStore(&places[first + k], place);
        }
        place += counts[k];
    }
    if lane == SCAN - 1u && block * BLOCK < system.cell_count {
        block_sums[block] = place;
    }
}

// Block sums become first places of the blocks.
@compute @workgroup_size(SCAN)
fn scan_blocks(@builtin(local_invocation_index) lane: u32) {
    let blocks = (system.cell_count + BLOCK - 1u) / BLOCK;
    var before = 0u;
    for (var first = 0u; first < blocks; first += SCAN) {
        var mine = 0u;
        if first + lane < blocks {
            mine = block_sums[first + lane];
        }
        let place = before + sum_before(lane, mine);
        if first + lane < blocks {
            block_sums[first + lane] = place;
        }
        before += partial[SCAN - 1u];
        workgroupBarrier();
    }
}

@compute @workgroup_size(WORKGROUP)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    let cell = locate(position_at(i), vec3<u32>(shift[0], shift[1], shift[2])).cell;
    let place = block_sums[cell / BLOCK] + atomicAdd(&places[cell], 1u);
    particles_sorted[place] = particles[i];
    velocities_yz_sorted[place] = velocities_yz[i];
}

@compute @workgroup_size(WORKGROUP)
fn copy_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        particles[i] = particles_sorted[i];
        velocities_yz[i] = velocities_yz_sorted[i];
    }
}
