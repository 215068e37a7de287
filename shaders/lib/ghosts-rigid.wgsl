// What the random velocities of a squirmer's ghosts have of a rigid motion, as sums. The including file binds what `ghosts-draw`
// asks for, and `ghost_sums` as atomics.
//!include ghosts
//!include ghosts-draw
//!include workgroup-sum
//!include contribution

// Words of a squirmer. Sums over its ghosts, wide: 0-2 s, 3-5 v, 6-8 s x v, 9-11 xx yy zz, 12-14 xy xz yz of s s^T, lengths in units of the
// hull's larger semi-axis. Then how many of its ghosts take part.
const SUM_WORDS: u32 = 31u;
const KEPT_WORD: u32 = 30u;
// |s| <= 1 and |v| < 12: what 64 ghosts have together stays below 2^31.
const SUM_SCALE: f32 = 2097152.0;

fn reach_of(kind: SpeciesUniform) -> f32 {
    let b = hull(kind);
    return max(b.x, b.z);
}

// Adds a ghost to the raw sums of its workgroup, all of whose ghosts belong to one squirmer of this kind.
fn add_rigid(g: Drawn, kind: SpeciesUniform) {
    let s = g.s * divide(1.0, reach_of(kind));
    let v = g.random * system.inverse_impulse_unit;
    let scaled = s * SUM_SCALE;
    collect_small3(0u, raw_fixed3(scaled));
    collect_small3(3u, raw_fixed3(v * SUM_SCALE));
    collect_small3(6u, raw_fixed3(cross3(scaled, v)));
    collect_small3(9u, raw_fixed3(scaled * s));
    collect_small3(12u, raw_fixed3(vec3<f32>(scaled.x * s.y, scaled.x * s.z, scaled.y * s.z)));
}

// Adds the sums of a workgroup to those of its squirmer.
fn hand_on_rigid(whose: Whose, lane: u32) {
    let i = whose.squirmer;
    if lane < WORKGROUP_SUMS && i < system.squirmer_count {
        let ghosts = species[squirmers[i].species].ghosts;
        let first = whose.index - lane;
        let share = collected_small(lane, RAW * min(ghosts - min(first, ghosts), WORKGROUP));
        let word = i * SUM_WORDS + 2u * lane;
        let old = atomicAdd(&ghost_sums[word], share.x);
        atomicAdd(&ghost_sums[word + 1u], share.y + select(0u, 1u, old + share.x < old));
    }
}
