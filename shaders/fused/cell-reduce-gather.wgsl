// cell-reduce without atomic sums: every cell chains its particles, then sums over them. The sums are those of
// shaders/stages/cell-reduce.wgsl, bit by bit, since integers may be added in any order. This is the second half: cells walk their chains.
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

// What the sums need of a particle: a CPU driver fetches every word by itself.
fn seen(i: u32) -> Particle {
    if PLACES {
        return particle_at(i);
    }
    return Particle(vec3<u32>(), velocity_at(i));
}

// The sums of a cell. Leaves its chain empty.
fn gathered(cell: u32) -> Sums {
    var s: Sums;
    let chain = chain_of(cell, shift[3]);
    var link = end_of_chain(chain);
    // Reported once the chain has been walked: a CPU driver goes through what nobody needs, too.
    var fault = 0u;
    var witness = 0u;
    while link != 0u {
        let i = link - 1u;
        let p = seen(i);
        link = links[i];
        let own = fault_of(square_of(p.velocity));
        if own != 0u {
            fault |= own;
            witness = i;
        } else {
            s = sum_of(s, contribution(FLUID, locate(p.position, vec3<u32>(shift[0], shift[1], shift[2])).offset, p.velocity));
        }
    }
    if fault != 0u {
        report(fault, cell, Witness(SITE_CELL_REDUCE, witness, now.step_low));
    }
    empty_chain(chain);
    return s;
}

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        store_sums(cell, gathered(cell));
    }
}
