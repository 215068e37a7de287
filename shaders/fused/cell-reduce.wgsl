// cell-reduce without atomic sums: every cell lists its particles, then sums over them. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include contribution
//!include fault
//!include lanes

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> positions: array<u32>;
@group(0) @binding(2) var<storage, read> velocities: array<f32>;
@group(0) @binding(3) var<storage, read> shift: array<u32>;
@group(0) @binding(4) var<storage, read_write> cell_counts: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> cell_lists: array<u32>;
@group(0) @binding(6) var<storage, read_write> spills: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> moments: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

fn cell_here(p: vec3<u32>) -> Place {
    return locate(p, vec3<u32>(shift[0], shift[1], shift[2]));
}

// Words of `spills`: 0 number of entries | the last entry of each cell, counted from 1 | entries: particle, and the entry before.
fn spill_head(cell: u32) -> u32 {
    return 1u + cell;
}

fn spill_entry(number: u32) -> u32 {
    return system.cell_count + 2u * number - 1u;
}

// The particle takes the next place in its cell's list, or if that is full joins the cell's chain.
fn tally_at(i: u32, position: vec3<u32>) {
    let cell = cell_here(position).cell;
    let number = atomicAdd(&cell_counts[cell], 1u);
    if number < system.list_room {
        cell_lists[cell * system.list_room + number] = i;
        return;
    }
    let entry = 1u + atomicAdd(&spills[0], 1u);
    if entry > system.spill_room {
        report(FAULT_SPILL, cell, Witness(SITE_CELL_REDUCE, i, UNKNOWN));
        return;
    }
    atomicStore(&spills[spill_entry(entry)], i);
    atomicStore(&spills[spill_entry(entry) + 1u], atomicExchange(&spills[spill_head(cell)], entry));
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

fn with_particle(before: Sums, cell: u32, i: u32) -> Sums {
    let v = velocity_at(i);
    let fault = fault_of(square_of(v));
    if fault != 0u {
        report(fault, cell, Witness(SITE_CELL_REDUCE, i, now.step_low));
        return before;
    }
    return sum_of(before, contribution(ONE_PARTICLE, cell_here(position_at(i)).offset, v));
}

// The sums of a cell, of whose invocations this is number `part`. Leaves its list empty.
fn gathered(cell: u32, part: u32) -> Sums {
    var s: Sums;
    let count = atomicLoad(&cell_counts[cell]);
    for (var k = part; k < min(count, system.list_room); k += LANES) {
        s = with_particle(s, cell, cell_lists[cell * system.list_room + k]);
    }
    if count > system.list_room && part == 0u {
        var entry = atomicLoad(&spills[spill_head(cell)]);
        while entry != 0u {
            s = with_particle(s, cell, atomicLoad(&spills[spill_entry(entry)]));
            entry = atomicLoad(&spills[spill_entry(entry) + 1u]);
        }
        atomicStore(&spills[spill_head(cell)], 0u);
    }
    // Nobody empties the list before all have read its length.
    s = added_across_lanes(s);
    if part == 0u {
        atomicStore(&cell_counts[cell], 0u);
        if cell == 0u {
            atomicStore(&spills[0], 0u);
        }
    }
    return s;
}

// Each invocation of the cell stores its share of the six vectors.
fn store_sums(cell: u32, part: u32, s: Sums) {
    let k = 6u * cell;
    let v = bitcast<vec3<u32>>(s.v);
    let x = bitcast<vec3<u32>>(s.x);
    let xv0 = bitcast<vec3<u32>>(s.xv0);
    let xv1 = bitcast<vec3<u32>>(s.xv1);
    let xv2 = bitcast<vec3<u32>>(s.xv2);
    if part == 0u {
        moments[k] = vec4<u32>(s.count, v);
    }
    if part == 1u % LANES {
        moments[k + 1u] = vec4<u32>(s.energy, s.coarse, x.xy);
    }
    if !PLACES {
        return;
    }
    if part == 2u % LANES {
        moments[k + 2u] = vec4<u32>(x.z, bitcast<vec3<u32>>(s.diagonal));
    }
    if part == 3u % LANES {
        moments[k + 3u] = vec4<u32>(bitcast<vec3<u32>>(s.mixed), xv0.x);
    }
    if part == 0u {
        moments[k + 4u] = vec4<u32>(xv0.yz, xv1.xy);
    }
    if part == 1u % LANES {
        moments[k + 5u] = vec4<u32>(xv1.z, xv2);
    }
}

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    // The cells fill whole workgroups.
    if invocation(group, groups, 0u) < system.cell_count * LANES {
        let i = invocation(group, groups, lane);
        store_sums(i / LANES, i % LANES, gathered(i / LANES, i % LANES));
    }
}
