// cell-reduce without atomic sums: particles are counted and listed by cell, and each cell sums over its list. The sums are those
// of shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include contribution

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> positions: array<u32>;
@group(0) @binding(2) var<storage, read> velocities: array<f32>;
@group(0) @binding(3) var<storage, read> shift: array<u32>;
@group(0) @binding(4) var<storage, read_write> cell_counts: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> ranks: array<u32>;
@group(0) @binding(6) var<storage, read_write> cell_starts: array<u32>;
@group(0) @binding(7) var<storage, read_write> block_sums: array<u32>;
@group(0) @binding(8) var<storage, read_write> order: array<u32>;
@group(0) @binding(9) var<storage, read_write> moments: array<u32>;
@group(0) @binding(10) var<storage, read_write> faults: array<atomic<u32>>;

// Cells of one workgroup of the scan, four for each invocation.
const BLOCK: u32 = 1024u;
const SCAN: u32 = 256u;

@compute @workgroup_size(WORKGROUP)
fn clear_counts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        atomicStore(&cell_counts[cell], 0u);
    }
}

fn cell_here(p: vec3<u32>) -> Place {
    return locate(p, vec3<u32>(shift[0], shift[1], shift[2]));
}

// The particle takes the next number in its cell.
fn tally_at(i: u32, position: vec3<u32>) {
    let cell = cell_here(position).cell;
    ranks[2u * i] = cell;
    ranks[2u * i + 1u] = atomicAdd(&cell_counts[cell], 1u);
}

fn tallied(i: u32, p: Particle) -> Particle {
    tally_at(i, p.position);
    return p;
}

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        tally_at(i, position_at(i));
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

// First places within a block of cells, and the block's particles.
@compute @workgroup_size(SCAN)
fn scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = group.y * groups.x + group.x;
    let first = block * BLOCK + 4u * lane;
    var counts = array<u32, 4>(0u, 0u, 0u, 0u);
    for (var k = 0u; k < 4u; k++) {
        if first + k < system.cell_count {
            counts[k] = atomicLoad(&cell_counts[first + k]);
        }
    }
    var place = sum_before(lane, counts[0] + counts[1] + counts[2] + counts[3]);
    for (var k = 0u; k < 4u; k++) {
        if first + k < system.cell_count {
            cell_starts[first + k] = place;
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

fn start_of(cell: u32) -> u32 {
    return block_sums[cell / BLOCK] + cell_starts[cell];
}

// Particles of one cell stand side by side in `order`.
@compute @workgroup_size(WORKGROUP)
fn list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        order[start_of(ranks[2u * i]) + ranks[2u * i + 1u]] = i;
    }
}

fn gathered(cell: u32) -> Sums {
    var s: Sums;
    let first = start_of(cell);
    var end = system.particle_count;
    if cell + 1u < system.cell_count {
        end = start_of(cell + 1u);
    }
    for (var k = first; k < end; k++) {
        let i = order[k];
        let v = velocity_at(i);
        let fault = fault_of(square_of(v));
        if fault != 0u {
            atomicOr(&faults[0], fault);
            continue;
        }
        let c = contribution(ONE_PARTICLE, cell_here(position_at(i)).offset, v);
        s.count += c.count;
        s.v += c.v;
        s.energy += c.energy;
        s.coarse += c.coarse;
        if !PLACES {
            continue;
        }
        s.x += c.x;
        s.diagonal += c.diagonal;
        s.mixed += c.mixed;
        s.xv0 += c.xv0;
        s.xv1 += c.xv1;
        s.xv2 += c.xv2;
    }
    return s;
}

fn store_signed(word: u32, a: vec3<i32>) {
    moments[word] = bitcast<u32>(a.x);
    moments[word + 1u] = bitcast<u32>(a.y);
    moments[word + 2u] = bitcast<u32>(a.z);
}

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell >= system.cell_count {
        return;
    }
    let s = gathered(cell);
    let w = cell * MOMENT_WORDS;
    moments[w] = s.count;
    store_signed(w + 1u, s.v);
    moments[w + 4u] = s.energy;
    moments[w + 5u] = s.coarse;
    store_signed(w + 6u, s.x);
    store_signed(w + 9u, s.diagonal);
    store_signed(w + 12u, s.mixed);
    store_signed(w + 15u, s.xv0);
    store_signed(w + 18u, s.xv1);
    store_signed(w + 21u, s.xv2);
}
