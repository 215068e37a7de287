// squirmer-fill: ghost particles inside the squirmers take part in the collision, so that the fluid meets a full cell moving with
// the surface (Theers et al. 2016). Ghosts are drawn afresh in each step.
//!include dispatch
//!include ghosts
//!include ghosts-rigid
//!include ghosts-gain
//!include deposit
//!include absorb
//!include symmetric

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: SquirmerFillSettings;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read_write> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read_write> ghost_sums: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> ghost_motion: array<f32>;
@group(0) @binding(6) var<uniform> shift: vec4<u32>;
@group(0) @binding(7) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read> operators: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> impulses: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> fluid_force: array<f32>;
@group(0) @binding(11) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read_write> ghosts: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> ghosts_yz: array<vec2<f32>>;
var<immediate> now: Now;

@compute @workgroup_size(WORKGROUP)
fn clear_sums(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.squirmer_count {
        return;
    }
    for (var k = 0u; k < SUM_WORDS; k++) {
        atomicStore(&ghost_sums[i * SUM_WORDS + k], 0u);
    }
}

// Draws the ghosts, and for equipartition adds up what their random velocities have of a rigid motion.
@compute @workgroup_size(WORKGROUP)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    clear_sums_of_workgroup(lane);
    let k = invocation(group, groups, lane);
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    let i = whose.squirmer;
    if whose.there {
        let kind = species[squirmers[i].species];
        let g = drawn_ghost(i, whose.index, kind, squirmers[i].orientation, settings.continued == 1u);
        let all = g.slip + g.random;
        ghosts[k] = vec4<f32>(g.s, all.x);
        ghosts_yz[k] = all.yz;
        if settings.equipartition == 1u {
            add_rigid(g, kind);
        }
    }
    workgroupBarrier();
    if settings.equipartition == 1u {
        hand_on_rigid(whose, lane);
    }
}

fn ghost_sum(i: u32, sum: u32) -> f32 {
    let word = i * SUM_WORDS + 2u * sum;
    return wide_value(atomicLoad(&ghost_sums[word]), atomicLoad(&ghost_sums[word + 1u])) * (1.0 / SUM_SCALE);
}

fn ghost_sum3(i: u32, sum: u32) -> vec3<f32> {
    return vec3<f32>(ghost_sum(i, sum), ghost_sum(i, sum + 1u), ghost_sum(i, sum + 2u));
}

// The rigid motion added to the ghosts: that of the squirmer, less, for equipartition, the rigid part of their random velocities.
@compute @workgroup_size(WORKGROUP)
fn prepare(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.squirmer_count {
        return;
    }
    let kind = species[squirmers[i].species];
    var linear = squirmers[i].velocity;
    var angular = angular_velocity(kind, squirmers[i].orientation, squirmers[i].angular_momentum);
    if settings.equipartition == 1u {
        let n = f32(kind.ghosts);
        let reach = reach_of(kind);
        let s = reach * ghost_sum3(i, 0u) / n;
        let v = system.impulse_unit * ghost_sum3(i, 3u) / n;
        let l = reach * system.impulse_unit * ghost_sum3(i, 6u) - n * cross3(s, v);
        var c: Symmetric;
        c.diagonal = reach * reach * ghost_sum3(i, 9u) - n * s * s;
        c.mixed = reach * reach * ghost_sum3(i, 12u) - n * vec3<f32>(s.x * s.y, s.x * s.z, s.y * s.z);
        var inertia: Symmetric;
        inertia.diagonal = vec3<f32>(c.diagonal.x + c.diagonal.y + c.diagonal.z) - c.diagonal;
        inertia.mixed = -c.mixed;
        let spin = solve_refined(factorise(inertia, 1e-6 * n), inertia, l);
        linear -= v - cross3(spin, s);
        angular -= spin;
    }
    for (var k = 0u; k < 3u; k++) {
        ghost_motion[8u * i + k] = linear[k];
        ghost_motion[8u * i + 4u + k] = angular[k];
    }
    ghost_motion[8u * i + KEPT] = f32(atomicLoad(&ghost_sums[i * SUM_WORDS + KEPT_WORD]));
}

@compute @workgroup_size(WORKGROUP)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    if !whose.there {
        return;
    }
    let i = whose.squirmer;
    let g = ghost_at(invocation(group, groups, lane));
    let place = ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2]));
    if may_meet(i, g.s, place.offset) {
        deposit(GHOST, place.cell, place.offset, moving_ghost(i, g), Witness(SITE_SQUIRMER_FILL, i, now.step_low));
    }
}

// The momentum that the ghosts gain in the collision is the squirmer's.
@compute @workgroup_size(WORKGROUP)
fn receive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    clear_sums_of_workgroup(lane);
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    let i = whose.squirmer;
    if whose.there {
        let g = ghost_at(invocation(group, groups, lane));
        let place = ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2]));
        if may_have_met(i, g.s, place.offset) {
            add_gain(i, g, place, now.step_low);
        }
    }
    workgroupBarrier();
    hand_on_gains(i, lane);
}

@compute @workgroup_size(WORKGROUP)
fn absorb(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.squirmer_count {
        absorb_impulse(i, false);
    }
}
