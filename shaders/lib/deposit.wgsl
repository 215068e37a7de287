// Adds one particle to the moments of its cell. The including file binds `moments` and `faults` as atomics.
//!include moments

fn fixed3(a: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(round(a));
}

fn deposit3(word: u32, a: vec3<i32>) {
    atomicAdd(&moments[word], bitcast<u32>(a.x));
    atomicAdd(&moments[word + 1u], bitcast<u32>(a.y));
    atomicAdd(&moments[word + 2u], bitcast<u32>(a.z));
}

// What one fluid particle adds to the count of its cell, and what a ghost adds.
const ONE_PARTICLE: u32 = 1u;
const ONE_GHOST: u32 = 0x10001u;

// x from the cell's centre.
fn deposit(one: u32, cell: u32, x: vec3<f32>, v: vec3<f32>) {
    let square = fma(v.x, v.x, fma(v.y, v.y, v.z * v.z));
    // The comparison is false for a velocity that is not a number, too. Comparing such a number with itself says nothing in WGSL:
    // its bits do.
    if !(square <= system.max_speed * system.max_speed) {
        atomicOr(&faults[0], select(FAULT_SPEED, FAULT_NAN, (bitcast<u32>(square) & 0x7fffffffu) > 0x7f800000u));
        return;
    }
    let word = cell * MOMENT_WORDS;
    atomicAdd(&moments[word], one);
    deposit3(word + 1u, fixed3(v * system.scale_velocity));
    atomicAdd(&moments[word + 4u], u32(round(square * system.scale_energy)));
    atomicAdd(&moments[word + 5u], u32(round(square * system.scale_coarse)));
    deposit3(word + 6u, fixed3(x * system.scale_position));
    deposit3(word + 9u, fixed3(x * x * system.scale_second));
    deposit3(word + 12u, fixed3(vec3<f32>(x.x * x.y, x.x * x.z, x.y * x.z) * system.scale_second));
    deposit3(word + 15u, fixed3(x.x * v * system.scale_mixed));
    deposit3(word + 18u, fixed3(x.y * v * system.scale_mixed));
    deposit3(word + 21u, fixed3(x.z * v * system.scale_mixed));
}
