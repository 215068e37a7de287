// squirmer-fill where particles lie brick by brick: of the ghosts that are drawn only those are kept that may meet anything, so that they fill
// their workgroups when they enter bricks and receive.
//!include dispatch
//!include ghosts
//!include ghosts-rigid
//!include ghosts-gain

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: SquirmerFillSettings;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read_write> ghost_sums: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> ghost_motion: array<f32>;
@group(0) @binding(6) var<uniform> shift: vec4<u32>;
@group(0) @binding(8) var<storage, read> operators: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> impulses: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read_write> ghosts: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> ghosts_yz: array<vec2<f32>>;
var<immediate> now: Now;

const DROPPED: u32 = 0xffffffffu;
// How many of the workgroup's ghosts are kept, and where.
var<workgroup> kept: atomic<u32>;
var<workgroup> kept_first: u32;

@compute @workgroup_size(WORKGROUP)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        atomicStore(&kept, 0u);
    }
    clear_sums_of_workgroup(lane);
    let whose = whose_ghost(invocation(group, groups, 0u), lane);
    let i = whose.squirmer;
    var g: Drawn;
    var place = DROPPED;
    if whose.there {
        let kind = species[squirmers[i].species];
        g = drawn_ghost(i, whose.index, kind, squirmers[i].orientation, settings.continued == 1u);
        if settings.equipartition == 1u {
            add_rigid(g, kind);
        }
        if may_meet(i, g.s, ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2])).offset) {
            place = atomicAdd(&kept, 1u);
        }
    }
    workgroupBarrier();
    if settings.equipartition == 1u {
        hand_on_rigid(whose, lane);
    }
    if lane == WORKGROUP - 1u && i < system.squirmer_count {
        kept_first = i * system.ghost_stride + atomicAdd(&ghost_sums[i * SUM_WORDS + KEPT_WORD], atomicLoad(&kept));
    }
    workgroupBarrier();
    if place != DROPPED {
        let k = kept_first + place;
        let all = g.slip + g.random;
        ghosts[k] = vec4<f32>(g.s, all.x);
        ghosts_yz[k] = all.yz;
    }
}

@compute @workgroup_size(WORKGROUP)
fn receive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    clear_sums_of_workgroup(lane);
    let whose = whose_kept_ghost(invocation(group, groups, 0u), lane);
    let i = whose.squirmer;
    if whose.there {
        let g = ghost_at(invocation(group, groups, lane));
        add_gain(i, g, ghost_place(i, g.s, vec3<u32>(shift[0], shift[1], shift[2])), now.step_low);
    }
    workgroupBarrier();
    hand_on_gains(i, lane);
}
