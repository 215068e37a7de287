// What one particle adds to the sums of its cell, in fixed point.
//!include moments
//!include places
//!include nearest

// What one fluid particle adds to the count, and what a ghost adds.
const ONE_PARTICLE: u32 = 1u;
const ONE_GHOST: u32 = 0x10001u;

fn fixed3(a: vec3<f32>) -> vec3<i32> {
    return bitcast<vec3<i32>>(nearest3(a));
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
    s.coarse += b.coarse;
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

// x from the cell's centre.
fn contribution(one: u32, x: vec3<f32>, v: vec3<f32>) -> Sums {
    let square = square_of(v);
    var s: Sums;
    s.count = one;
    s.v = fixed3(v * system.scale_velocity);
    s.energy = nearest(square * system.scale_energy);
    s.coarse = nearest_small(square, system.scale_coarse);
    if !PLACES {
        return s;
    }
    s.x = fixed3(x * system.scale_position);
    s.diagonal = fixed3(x * x * system.scale_second);
    s.mixed = fixed3(vec3<f32>(x.x * x.y, x.x * x.z, x.y * x.z) * system.scale_second);
    s.xv0 = fixed3(x.x * v * system.scale_mixed);
    s.xv1 = fixed3(x.y * v * system.scale_mixed);
    s.xv2 = fixed3(x.z * v * system.scale_mixed);
    return s;
}
