// Momentum and angular momentum handed to squirmers, as wide sums. The including file binds `impulses` and `faults` as atomics.
// Words of a squirmer: six (low, high) pairs: force x time x, y, z; torque x time x, y, z.
//!include wide
//!include impulse-fixed
const IMPULSE_WORDS: u32 = 12u;
const FORCE_SCALE: f32 = 16777216.0;
const TORQUE_SCALE: f32 = 1048576.0;

fn add_wide_impulse(word: u32, low: i32) {
    let high = carry(atomicAdd(&impulses[word], bitcast<u32>(low)), low);
    if high != 0u {
        atomicAdd(&impulses[word + 1u], high);
    }
}

fn add_impulse(squirmer: u32, force: vec3<f32>, torque: vec3<f32>, by: Witness) {
    let f = impulse_fixed(force, FORCE_SCALE, by);
    let t = impulse_fixed(torque, TORQUE_SCALE, by);
    for (var k = 0u; k < 3u; k++) {
        add_wide_impulse(squirmer * IMPULSE_WORDS + 2u * k, f[k]);
        add_wide_impulse(squirmer * IMPULSE_WORDS + 6u + 2u * k, t[k]);
    }
}
