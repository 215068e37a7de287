// Adds to the momentum that the walls have received. The including file binds `system`, and `wall_impulses` as atomics.
//!include wide
const WALL_SCALE: f32 = 1048576.0;

// Component `k` of a momentum, as a wide sum of fixed-point numbers. Spread over 64 partial sums: neighbours at a wall would otherwise all
// wait for one address.
fn add_wide_wall_impulse(spread: u32, wall: u32, k: u32, share: vec2<u32>) {
    let word = (spread & 63u) * 12u + wall * 6u + 2u * k;
    let old = atomicAdd(&wall_impulses[word], share.x);
    let high = share.y + select(0u, 1u, old + share.x < old);
    if high != 0u {
        atomicAdd(&wall_impulses[word + 1u], high);
    }
}

fn add_wall_impulse(spread: u32, wall: u32, momentum: vec3<f32>) {
    for (var k = 0u; k < 3u; k++) {
        let added = i32(round(momentum[k] * (WALL_SCALE * system.inverse_impulse_unit)));
        add_wide_wall_impulse(spread, wall, k, vec2<u32>(bitcast<u32>(added), bitcast<u32>(added >> 31u)));
    }
}
