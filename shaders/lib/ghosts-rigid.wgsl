// What the random velocities of a squirmer's ghosts have of a rigid motion, as sums. The including file binds what `ghosts-draw`
// asks for, and `ghost_sums` as atomics.
//!include ghosts-draw
//!include workgroup-sum
//!include contribution

// Words of a squirmer. Sums over its ghosts, wide: 0-2 s, 3-5 v, 6-8 s x v, 9-11 xx yy zz, 12-14 xy xz yz of s s^T. Then how many of its ghosts take part.
const SUM_WORDS: u32 = 31u;
const KEPT_WORD: u32 = 30u;
const SUM_SCALE: f32 = 262144.0;

// Adds a ghost to the sums of its workgroup, all of whose ghosts belong to one squirmer.
fn add_rigid(g: Drawn) {
    let v = g.random * system.inverse_impulse_unit;
    collect3(0u, fixed3(g.s * SUM_SCALE));
    collect3(3u, fixed3(v * SUM_SCALE));
    collect3(6u, fixed3(cross3(g.s, v) * SUM_SCALE));
    collect3(9u, fixed3(g.s * g.s * SUM_SCALE));
    collect3(12u, fixed3(vec3<f32>(g.s.x * g.s.y, g.s.x * g.s.z, g.s.y * g.s.z) * SUM_SCALE));
}

// Adds the sums of a workgroup to those of squirmer `i`.
fn hand_on_rigid(i: u32, lane: u32) {
    if lane < WORKGROUP_SUMS && i < system.squirmer_count {
        let share = collected(lane);
        let word = i * SUM_WORDS + 2u * lane;
        let old = atomicAdd(&ghost_sums[word], share.x);
        atomicAdd(&ghost_sums[word + 1u], share.y + select(0u, 1u, old + share.x < old));
    }
}
