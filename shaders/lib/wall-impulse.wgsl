// Adds to the momentum that the walls have received. The including file binds `wall_impulses` as atomics.
//!include wide
const WALL_SCALE: f32 = 1048576.0;

// Spread over 64 partial sums: neighbours at a wall would otherwise all wait for one address.
fn add_wall_impulse(spread: u32, wall: u32, momentum: vec3<f32>) {
    for (var k = 0u; k < 3u; k++) {
        let added = i32(round(momentum[k] * WALL_SCALE));
        let word = (spread & 63u) * 12u + wall * 6u + 2u * k;
        let high = carry(atomicAdd(&wall_impulses[word], bitcast<u32>(added)), added);
        if high != 0u {
            atomicAdd(&wall_impulses[word + 1u], high);
        }
    }
}
