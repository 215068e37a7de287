// Adds one particle to the moments of its cell. The including file binds `moments` and `faults` as atomics.
//!include contribution

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
    atomicAdd(&moments[word + 5u], s.coarse);
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
fn deposit(one: u32, cell: u32, x: vec3<f32>, v: vec3<f32>) {
    let fault = fault_of(square_of(v));
    if fault != 0u {
        atomicOr(&faults[0], fault);
        return;
    }
    deposit_sums(cell, contribution(one, x, v));
}
