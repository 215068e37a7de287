// squirmer-fill where particles lie brick by brick: ghosts lie at the end of their brick's room until its sums have been made.
//!include dispatch
//!include ghosts
//!include bricks
//!include contribution
//!include fault

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: SquirmerFillSettings;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read> ghost_motion: array<f32>;
@group(0) @binding(5) var<uniform> shift: vec4<u32>;
@group(0) @binding(6) var<storage, read_write> bricks_xy: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> bricks_zu: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read_write> bricks_vw: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read_write> brick_counts: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> brick_ghosts: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

@compute @workgroup_size(WORKGROUP)
fn enter(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    if !whose.there {
        return;
    }
    let i = whose.squirmer;
    let kind = species[squirmers[i].species];
    let g = ghost(i, whose.index, kind, squirmers[i].orientation, settings.continued == 1u);
    let position = squirmers[i].position + to_units(g.s);
    let v = moving_ghost(i, g);
    let cell = ghost_place(i, g.s).cell;
    let by = Witness(SITE_SQUIRMER_FILL, i, now.step_low);
    let fault = fault_of(square_of(v));
    if fault != 0u {
        report(fault, cell, by);
        return;
    }
    let brick = cell / BRICK_CELLS;
    let place = atomicAdd(&brick_ghosts[brick], 1u);
    if place + atomicLoad(&brick_counts[brick]) >= system.room {
        report(FAULT_ROOM, cell, by);
        return;
    }
    store_in_brick((brick + 1u) * system.room - 1u - place, Particle(position, v));
}
