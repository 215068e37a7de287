// Threefry-4x32-20 (Salmon, Moraes, Dror, Shaw, SC11, 2011), the same bits as src/math/rng.rs.
// The including file binds `system` and declares `now`.
const TAU: f32 = 6.283185307179586;

fn rotate_left(x: u32, n: u32) -> u32 {
    return (x << n) | (x >> (32u - n));
}

fn mix_words(x: vec4<u32>, a: u32, b: u32, swap: bool) -> vec4<u32> {
    var y = x;
    if swap {
        y.x += y.w;
        y.w = rotate_left(y.w, a) ^ y.x;
        y.z += y.y;
        y.y = rotate_left(y.y, b) ^ y.z;
    } else {
        y.x += y.y;
        y.y = rotate_left(y.y, a) ^ y.x;
        y.z += y.w;
        y.w = rotate_left(y.w, b) ^ y.z;
    }
    return y;
}

fn threefry(counter: vec4<u32>, key: vec4<u32>) -> vec4<u32> {
    let k4 = 0x1BD11BDAu ^ key.x ^ key.y ^ key.z ^ key.w;
    var x = counter + key;
    x = mix_words(mix_words(mix_words(mix_words(x, 10u, 26u, false), 11u, 21u, true), 13u, 27u, false), 23u, 5u, true);
    x += vec4<u32>(key.y, key.z, key.w, k4 + 1u);
    x = mix_words(mix_words(mix_words(mix_words(x, 6u, 20u, false), 17u, 11u, true), 25u, 10u, false), 18u, 20u, true);
    x += vec4<u32>(key.z, key.w, k4, key.x + 2u);
    x = mix_words(mix_words(mix_words(mix_words(x, 10u, 26u, false), 11u, 21u, true), 13u, 27u, false), 23u, 5u, true);
    x += vec4<u32>(key.w, k4, key.x, key.y + 3u);
    x = mix_words(mix_words(mix_words(mix_words(x, 6u, 20u, false), 17u, 11u, true), 25u, 10u, false), 18u, 20u, true);
    x += vec4<u32>(k4, key.x, key.y, key.z + 4u);
    x = mix_words(mix_words(mix_words(mix_words(x, 10u, 26u, false), 11u, 21u, true), 13u, 27u, false), 23u, 5u, true);
    x += vec4<u32>(key.x, key.y, key.z, key.w + 5u);
    return x;
}

// Four numbers uniform in (0, 1): the centres of 2^23 equal intervals, all exact in f32.
fn uniforms(purpose: u32, owner: u32, index: u32, block: u32) -> vec4<f32> {
    return uniforms_at(vec2<u32>(now.step_low, now.step_high), purpose, owner, index, block);
}

// Those of another step, by its low word and its high one.
fn uniforms_at(step: vec2<u32>, purpose: u32, owner: u32, index: u32, block: u32) -> vec4<f32> {
    let key = vec4<u32>(system.seed_low, system.seed_high, purpose, step.y);
    let words = threefry(vec4<u32>(step.x, owner, index, block), key) >> vec4<u32>(9u);
    return (vec4<f32>(words) + 0.5) * 1.1920928955078125e-7;
}

// The distance from the centre of two standard normals. Next to 1 a logarithm may err by 2^-21, to either side.
fn deviation(u: f32) -> f32 {
    return sqrt(max(0.0, -2.0 * log(u)));
}

// Three independent standard normals (Box and Muller, Ann. Math. Stat. 29, 610, 1958).
fn normals(u: vec4<f32>) -> vec3<f32> {
    let r = deviation(u.x);
    return vec3<f32>(r * cos(TAU * u.y), r * sin(TAU * u.y), deviation(u.z) * cos(TAU * u.w));
}
