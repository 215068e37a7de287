// cell-reduce where only velocities are summed: every particle adds to its cell's sums, two of them with each atomic addition. The sums are
// those of shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include contribution
//!include fault
//!include sums-store
//!include energies

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> shift: array<u32>;
@group(0) @binding(4) var<storage, read_write> pairs: array<atomic<u64>>;
@group(0) @binding(5) var<storage, read_write> moments: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// Of each cell: count and v_x | v_y and v_z | if asked for, coarse and fine |v|^2 | not used, so that they fill 32 bytes, which memory moves
// at a time. The former of two is in the low half.
const PAIRS: u32 = 4u;

// A number with another in its high half, which lends to the low one if that is negative.
fn paired(low: i32, high: u32) -> u64 {
    return bitcast<u64>(i64(low)) + (u64(high) << 32u);
}

fn tallied(i: u32, p: Particle) -> Particle {
    let cell = locate(p.position, vec3<u32>(shift[0], shift[1], shift[2])).cell;
    let fault = fault_of(square_of(p.velocity));
    if fault != 0u {
        report(fault, cell, Witness(SITE_CELL_REDUCE, i, now.step_low));
        return p;
    }
    let s = contribution(ONE_PARTICLE, vec3<f32>(0.0), p.velocity);
    atomicAdd(&pairs[PAIRS * cell], paired(i32(s.count), bitcast<u32>(s.v.x)));
    atomicAdd(&pairs[PAIRS * cell + 1u], paired(s.v.y, bitcast<u32>(s.v.z)));
    if ENERGIES {
        atomicAdd(&pairs[PAIRS * cell + 2u], paired(i32(s.coarse), s.energy));
    }
    return p;
}

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        _ = tallied(i, particle_at(i));
    }
}

// One of a cell's pairs, which is left at zero.
fn taken(cell: u32, k: u32) -> vec2<u32> {
    let pair = atomicLoad(&pairs[PAIRS * cell + k]);
    atomicStore(&pairs[PAIRS * cell + k], 0lu);
    return vec2<u32>(u32(pair & 0xfffffffflu), u32(pair >> 32u));
}

// The sums of a cell.
fn gathered(cell: u32) -> Sums {
    let first = taken(cell, 0u);
    let second = taken(cell, 1u);
    var s: Sums;
    s.count = first.x;
    // What the low half borrowed where it is negative goes back.
    s.v = bitcast<vec3<i32>>(vec3<u32>(first.y, second.x, second.y + (second.x >> 31u)));
    if ENERGIES {
        let third = taken(cell, 2u);
        s.coarse = third.x;
        s.energy = third.y;
    }
    return s;
}

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        store_sums(cell, gathered(cell));
    }
}
