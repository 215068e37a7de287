// Adds particles to the moments of their cell. The including file binds `moments` and `faults` as atomics.
//!include contribution
//!include fault

fn deposit3(word: u32, a: vec3<i32>) {
    atomicAdd(&moments[word], bitcast<u32>(a.x));
    atomicAdd(&moments[word + 1u], bitcast<u32>(a.y));
    atomicAdd(&moments[word + 2u], bitcast<u32>(a.z));
}

fn deposit_sums(cell: u32, s: Sums) {
    let word = cell * MOMENT_WORDS;
    atomicAdd(&moments[word], s.count);
    deposit3(word + 1u, s.v);
    atomicAdd(&moments[word + 4u], s.energy);
    if s.ghosts > 0u {
        atomicAdd(&moments[word + 5u], s.ghosts);
    }
    if !PLACES {
        return;
    }
    deposit3(word + 6u, s.x);
    deposit3(word + 9u, s.diagonal);
    deposit3(word + 12u, s.mixed);
    deposit3(word + 15u, s.xv0);
    deposit3(word + 18u, s.xv1);
    deposit3(word + 21u, s.xv2);
}

// x from the cell's centre.
fn deposit(ghosts: u32, cell: u32, x: vec3<f32>, v: vec3<f32>, by: Witness) {
    let fault = fault_of(square_of(v));
    if fault != 0u {
        report(fault, cell, by);
        return;
    }
    deposit_sums(cell, contribution(ghosts, x, v));
}

// The sums with one more, x from the cell's centre.
fn with_one(before: Sums, ghosts: u32, cell: u32, x: vec3<f32>, v: vec3<f32>, by: Witness) -> Sums {
    let fault = fault_of(square_of(v));
    if fault != 0u {
        report(fault, cell, by);
        return before;
    }
    return sum_of(before, contribution(ghosts, x, v));
}

fn deposit4(word: u32, part: u32, parts: u32, a: vec4<u32>) {
    for (var k = part; k < 4u; k += parts) {
        atomicAdd(&moments[word + k], a[k]);
    }
}

// What one of a cell's invocations, number `part` of one or four, adds of sums that all of them have: neighbours take neighbouring words.
fn deposit_part(cell: u32, part: u32, parts: u32, s: Sums) {
    if s.count == 0u {
        return;
    }
    let word = cell * MOMENT_WORDS;
    let x = bitcast<vec3<u32>>(s.x);
    deposit4(word, part, parts, vec4<u32>(s.count, bitcast<vec3<u32>>(s.v)));
    deposit4(word + 4u, part, parts, vec4<u32>(s.energy, s.ghosts, x.xy));
    if !PLACES {
        return;
    }
    let mixed = bitcast<vec3<u32>>(s.mixed);
    let xv0 = bitcast<vec3<u32>>(s.xv0);
    let xv1 = bitcast<vec3<u32>>(s.xv1);
    deposit4(word + 8u, part, parts, vec4<u32>(x.z, bitcast<vec3<u32>>(s.diagonal)));
    deposit4(word + 12u, part, parts, vec4<u32>(mixed, xv0.x));
    deposit4(word + 16u, part, parts, vec4<u32>(xv0.yz, xv1.xy));
    deposit4(word + 20u, part, parts, vec4<u32>(xv1.z, bitcast<vec3<u32>>(s.xv2)));
}
