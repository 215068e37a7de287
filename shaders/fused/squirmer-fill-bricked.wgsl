// squirmer-fill where particles lie brick by brick: ghosts lie in the other set of bricks, which is free, until the sums have been made.
//!include dispatch
//!include ghosts
//!include bricks
//!include bricks-settle
//!include contribution

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read> ghost_motion: array<f32>;
@group(0) @binding(5) var<uniform> shift: vec4<u32>;
@group(0) @binding(6) var<storage, read_write> bricks_xy: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> bricks_zu: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read_write> bricks_vw: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read_write> brick_counts: array<atomic<u32>>;
@group(0) @binding(14) var<storage, read_write> bricks_xy_next: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> bricks_zu_next: array<vec2<u32>>;
@group(0) @binding(16) var<storage, read_write> bricks_vw_next: array<vec2<f32>>;
@group(0) @binding(17) var<storage, read_write> brick_counts_next: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> brick_ghosts: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read> ghosts: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> ghosts_yz: array<vec2<f32>>;
var<immediate> now: Now;

// The brick of a squirmer's ghost is one of 27 around its centre's, or FAR from it; whoever is not far asks for places together with others.
fn ask_for_ghost_places(home: vec3<u32>, lane: u32) {
    workgroupBarrier();
    if lane < FAR {
        let count = atomicLoad(&going[lane]);
        if count > 0u {
            places[lane] = atomicAdd(&brick_ghosts[neighbour(home, lane)], count);
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(WORKGROUP)
fn enter(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if lane < FAR {
        atomicStore(&going[lane], 0u);
    }
    let whose = whose_kept_ghost(invocation(group, groups, 0u), lane);
    let i = min(whose.squirmer, system.squirmer_count - 1u);
    let home = brick_place_at(squirmers[i].position);
    workgroupBarrier();
    let by = Witness(SITE_SQUIRMER_FILL, i, now.step_low);
    var p: Particle;
    var brick = 0u;
    var number = NOBODY;
    var place = 0u;
    if whose.there {
        let g = ghost_at(invocation(group, groups, lane));
        p = Particle(squirmers[i].position + to_units(g.s), moving_ghost(i, g));
        let at = brick_place_at(p.position);
        brick = brick_number(at);
        let fault = fault_of(square_of(p.velocity));
        if fault != 0u {
            report(fault, ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2])).cell, by);
        } else {
            number = neighbour_number(home, at);
            if number == FAR {
                place = atomicAdd(&brick_ghosts[brick], 1u);
            } else {
                place = atomicAdd(&going[number], 1u);
            }
        }
    }
    ask_for_ghost_places(home, lane);
    if number == NOBODY {
        return;
    }
    if number < FAR {
        place += places[number];
    }
    enter_brick(brick, place, p, by);
}
