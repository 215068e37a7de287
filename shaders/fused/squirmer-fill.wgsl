// squirmer-fill with few atomic sums: every cell chains its ghosts, then sums over them in registers. The sums are those of
// shaders/stages/squirmer-fill.wgsl, bit by bit, since integers may be added in any order. The chains are those of cell-reduce, empty again.
//!include dispatch
//!include ghosts
//!include deposit
//!include chains
//!include lanes

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read> ghost_motion: array<f32>;
@group(0) @binding(5) var<uniform> shift: vec4<u32>;
@group(0) @binding(6) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> chains: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> links: array<u32>;
@group(0) @binding(9) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read> ghosts: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read> ghosts_yz: array<vec2<f32>>;
var<immediate> now: Now;

@compute @workgroup_size(WORKGROUP)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    if !whose.there {
        return;
    }
    let k = invocation(group, groups, lane);
    let s = ghost_at(k).s;
    let place = ghost_place(whose.squirmer, s, vec3<u32>(shift[0], shift[1], shift[2]));
    if may_meet(whose.squirmer, s, place.offset) {
        join_chain(chain_of(place.cell, shift[3]), k);
    }
}

// The sums over the ghosts in a cell's chain, which is left empty.
@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane) / LANES;
    let part = lane % LANES;
    if cell >= system.cell_count {
        return;
    }
    var s: Sums;
    let chain = chain_of(cell, shift[3]);
    var link = end_of_chain(chain);
    while link != 0u {
        // Of the next few each invocation of the cell takes one.
        var mine = 0u;
        for (var k = 0u; k < LANES && link != 0u; k++) {
            if k == part {
                mine = link;
            }
            link = links[link - 1u];
        }
        if mine != 0u {
            let i = (mine - 1u) / system.ghost_stride;
            let g = ghost_at(mine - 1u);
            let place = ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2]));
            s = with_one(s, GHOST, cell, place.offset, moving_ghost(i, g), Witness(SITE_SQUIRMER_FILL, i, now.step_low));
        }
    }
    // Nobody empties the chain before all have read its end.
    s = added_across_lanes(s);
    if part == 0u {
        empty_chain(chain);
    }
    deposit_part(cell, part, LANES, s);
}
