// cell-reduce without atomic sums: every cell chains its particles, then sums over them. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include cells
//!include particles
//!include contribution
//!include fault
//!include chains
//!include sums-store

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(3) var<uniform> shift: vec4<u32>;
@group(0) @binding(4) var<storage, read_write> chains: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> links: array<u32>;
@group(0) @binding(6) var<storage, read_write> moments: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

fn cell_here(p: vec3<u32>) -> Place {
    return locate(p, vec3<u32>(shift[0], shift[1], shift[2]));
}

fn tallied(i: u32, p: Particle) -> Particle {
    join_chain(cell_here(p.position).cell, i);
    return p;
}

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        join_chain(cell_here(position_at(i)).cell, i);
    }
}

// The sums of a cell. Leaves its chain empty.
fn gathered(cell: u32) -> Sums {
    var s: Sums;
    var link = end_of_chain(cell);
    while link != 0u {
        let i = link - 1u;
        let p = particle_at(i);
        link = links[i];
        let fault = fault_of(square_of(p.velocity));
        if fault != 0u {
            report(fault, cell, Witness(SITE_CELL_REDUCE, i, now.step_low));
        } else {
            s = sum_of(s, contribution(ONE_PARTICLE, cell_here(p.position).offset, p.velocity));
        }
    }
    empty_chain(cell);
    return s;
}

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        store_sums(cell, gathered(cell));
    }
}
