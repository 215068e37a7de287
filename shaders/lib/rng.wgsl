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

// Four random words: those of another step by its low word and its high one.
fn words_at(step: vec2<u32>, purpose: u32, owner: u32, index: u32, block: u32) -> vec4<u32> {
    let key = vec4<u32>(system.seed_low, system.seed_high, purpose, step.y);
    return threefry(vec4<u32>(step.x, owner, index, block), key);
}

fn words(purpose: u32, owner: u32, index: u32, block: u32) -> vec4<u32> {
    return words_at(vec2<u32>(now.step_low, now.step_high), purpose, owner, index, block);
}

// A number uniform in (0, 1) from its upper 23 bits: the centres of 2^23 equal intervals, all exact in f32.
fn unit(word: u32) -> f32 {
    return (f32(word >> 9u) + 0.5) * 1.1920928955078125e-7;
}

fn units(words: vec4<u32>) -> vec4<f32> {
    return (vec4<f32>(words >> vec4<u32>(9u)) + 0.5) * 1.1920928955078125e-7;
}

fn uniforms(purpose: u32, owner: u32, index: u32, block: u32) -> vec4<f32> {
    return units(words(purpose, owner, index, block));
}

// A fifth number from what is left of the four words.
fn fifth(w: vec4<u32>) -> f32 {
    return unit((w.x << 23u) | ((w.y & 0x1ffu) << 14u) | ((w.z & 0x1fu) << 9u));
}

// What one ghost needs, from one block: where it is and how it moves.
struct Seven {
    // For its place: 16, 16 and 18 bits.
    place: vec3<f32>,
    // For `normals`: 23 bits for the logarithms, 16 for the angles.
    motion: vec4<f32>,
}

fn seven(w: vec4<u32>) -> Seven {
    let angles = (vec2<f32>(w.zw >> vec2<u32>(16u)) + 0.5) * 1.52587890625e-5;
    let halves = (vec2<f32>(w.zw & vec2<u32>(0xffffu)) + 0.5) * 1.52587890625e-5;
    let rest = (f32(((w.x & 0x1ffu) << 9u) | (w.y & 0x1ffu)) + 0.5) * 3.814697265625e-6;
    return Seven(vec3<f32>(halves, rest), vec4<f32>(unit(w.x), angles.x, unit(w.y), angles.y));
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
