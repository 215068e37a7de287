// wall-ghosts: the parts of wall-cut cells that lie behind the wall are filled with ghosts at the wall's velocity, or at the
// fluid's continued behind it: a Poisson process of the fluid's density, of which only sums are stored (Lamura et al. 2001, with positions).
//!include dispatch
//!include deposit
//!include lanes
//!include wall-ghosts
//!include operator-load
//!include impulse-fixed
//!include wall-impulse
//!include workgroup-sum

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: WallGhostsSettings;
@group(0) @binding(2) var<uniform> shift: vec4<u32>;
@group(0) @binding(3) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> operators: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> wall_impulses: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> wall_seen: array<vec4<i32>>;
@group(0) @binding(7) var<storage, read_write> wall_sums: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> wall_shear: array<f32>;
@group(0) @binding(9) var<storage, read_write> wall_ghosts: array<vec4<u32>>;
@group(0) @binding(10) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

fn signed_moment(word: u32) -> i32 {
    return bitcast<i32>(atomicLoad(&moments[word]));
}

// What of a cell's sums the shear beside the wall needs.
fn sums_for_shear(cell: u32) -> Sums {
    let word = MOMENT_WORDS * cell;
    var s: Sums;
    s.count = atomicLoad(&moments[word]);
    s.v = vec3<i32>(signed_moment(word + 1u), 0, signed_moment(word + 3u));
    s.x.y = signed_moment(word + 7u);
    s.diagonal.y = signed_moment(word + 10u);
    s.xv1 = vec3<i32>(signed_moment(word + 18u), 0, signed_moment(word + 20u));
    return s;
}

// The fluid in the two cells next to the wall; no ghosts are in them yet.
@compute @workgroup_size(WORKGROUP)
fn observe(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    let c = wall_cell(i);
    if settings.continued == 0u || !c.there {
        return;
    }
    for (var j = 0u; j < 2u; j++) {
        wall_seen[2u * i + j] = vec4<i32>(seen_from_wall(c.wall, j, sums_for_shear(cell_from_wall(c, j)), shift[1]), 0);
    }
}

@compute @workgroup_size(WORKGROUP)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let first = invocation(group, groups, 0u) / LANES;
    sum_ghosts(first, lane, shift[1], settings);
    let i = first + lane;
    let c = wall_cell(i);
    if lane < DRAWN_CELLS && c.there {
        let s = sums_of_workgroup(lane);
        store_wall_ghosts(i, s);
        deposit_sums(cell_from_wall(c, 0u), s);
    }
}

fn add_wall_sum(home: u32, k: u32, share: vec2<u32>) {
    let word = wall_sum_word(home, now.step_low) + 2u * k;
    let old = atomicAdd(&wall_sums[word], share.x);
    let carried = share.y + select(0u, 1u, old + share.x < old);
    if carried != 0u {
        atomicAdd(&wall_sums[word + 1u], carried);
    }
}

// What the ghosts of a cell gain in the collision: this is affine, so that sums over them tell it. sum v' - v = n b + A sum v + W x sum x - sum v.
fn gained(s: Sums, o: Operator) -> vec3<i32> {
    let n = f32(number_in(s.count));
    let v = vec3<f32>(s.v) * system.inverse_velocity;
    let x = vec3<f32>(s.x) * system.inverse_position;
    let gain = fma(vec3<f32>(n - 1.0), o.b, collided(o, x, v)) - v;
    return impulse_fixed(gain, WALL_SCALE, Witness(SITE_WALL_GHOSTS, UNKNOWN, now.step_low));
}

// The walls take what their ghosts gain, and the patches what has been seen beside them.
@compute @workgroup_size(WORKGROUP)
fn receive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    clear_sums_of_workgroup(lane);
    let i = invocation(group, groups, lane);
    let first = wall_cell(i - lane);
    let c = wall_cell(i);
    var seen = vec3<i32>(0);
    if c.there {
        let s = wall_ghosts_at(i);
        if s.count > 0u {
            let gain = gained(s, operator_at(cell_from_wall(c, 0u)));
            for (var k = 0u; k < 3u; k++) {
                collect(k, gain[k]);
            }
        }
        if settings.continued == 1u {
            seen = wall_seen[2u * i].xyz + wall_seen[2u * i + 1u].xyz;
        }
    }
    // Patches are rectangles: the tile is in one if its corners are.
    let home = wall_patch(first.wall, first.column, settings);
    let mixed = home != wall_patch(first.wall, min(first.column + TILE - 1u, system.cells.xz - 1u), settings);
    if settings.continued == 1u && c.there {
        for (var k = 0u; k < 3u; k++) {
            if mixed {
                add_wall_sum(wall_patch(c.wall, c.column, settings), k, vec2<u32>(bitcast<u32>(seen[k]), bitcast<u32>(seen[k] >> 31u)));
            } else {
                collect(3u + k, seen[k]);
            }
        }
    }
    workgroupBarrier();
    // Workgroups in rows of 65,535 may be more than there are tiles.
    if first.wall > 1u {
        return;
    }
    if lane < 3u {
        add_wide_wall_impulse(i / WORKGROUP, first.wall, lane, collected(lane));
    } else if lane < 6u && !mixed && settings.continued == 1u {
        add_wall_sum(home, lane - 3u, collected(lane));
    }
}
