// What one particle adds to the sums of its cell, in fixed point.
//!include moments
//!include places
//!include nearest

// How many ghosts a fluid particle is, and a ghost.
const FLUID: u32 = 0u;
const GHOST: u32 = 1u;

fn fixed3(a: vec3<f32>) -> vec3<i32> {
    return bitcast<vec3<i32>>(nearest3(a));
}

fn raw_fixed3(a: vec3<f32>) -> vec3<i32> {
    return bitcast<vec3<i32>>(raw3(a));
}

fn square_of(v: vec3<f32>) -> f32 {
    return fma(v.x, v.x, fma(v.y, v.y, v.z * v.z));
}

// 0, or the fault of a velocity that the sums cannot take. The comparison is false for a velocity that is not a number, too. Comparing such
// a number with itself says nothing in WGSL: its bits do.
fn fault_of(square: f32) -> u32 {
    if square <= system.max_speed * system.max_speed {
        return 0u;
    }
    return select(FAULT_SPEED, FAULT_NAN, (bitcast<u32>(square) & 0x7fffffffu) > 0x7f800000u);
}

fn sum_of(a: Sums, b: Sums) -> Sums {
    var s = a;
    s.count += b.count;
    s.v += b.v;
    s.energy += b.energy;
    s.ghosts += b.ghosts;
    if PLACES {
        s.x += b.x;
        s.diagonal += b.diagonal;
        s.mixed += b.mixed;
        s.xv0 += b.xv0;
        s.xv1 += b.xv1;
        s.xv2 += b.xv2;
    }
    return s;
}

// What a particle or ghost adds, all but the numbers of these larger by RAW; x from the cell's centre. Scales are powers of two, so that it does not
// matter which factor takes them.
fn raw_contribution(ghosts: u32, x: vec3<f32>, v: vec3<f32>) -> Sums {
    let square = square_of(v);
    var s: Sums;
    // From bit 10 on nothing of RAW is left.
    s.count = (raw_small(square, system.scale_coarse) << system.coarse_bit) + 1u;
    s.ghosts = ghosts;
    s.v = raw_fixed3(v * system.scale_velocity);
    s.energy = raw(square * system.scale_energy);
    if !PLACES {
        return s;
    }
    s.x = raw_fixed3(x * system.scale_position);
    let second = x * system.scale_second;
    s.diagonal = raw_fixed3(second * x);
    s.mixed = raw_fixed3(vec3<f32>(second.x * x.y, second.x * x.z, second.y * x.z));
    let mixed = x * system.scale_mixed;
    s.xv0 = raw_fixed3(mixed.x * v);
    s.xv1 = raw_fixed3(mixed.y * v);
    s.xv2 = raw_fixed3(mixed.z * v);
    return s;
}

// The sums over so many contributions.
fn settled(sums: Sums, number: u32) -> Sums {
    let excess = number * RAW;
    let excess3 = vec3<i32>(bitcast<i32>(excess));
    var s = sums;
    s.v -= excess3;
    s.energy -= excess;
    if PLACES {
        s.x -= excess3;
        s.diagonal -= excess3;
        s.mixed -= excess3;
        s.xv0 -= excess3;
        s.xv1 -= excess3;
        s.xv2 -= excess3;
    }
    return s;
}

fn contribution(ghosts: u32, x: vec3<f32>, v: vec3<f32>) -> Sums {
    return settled(raw_contribution(ghosts, x, v), 1u);
}
