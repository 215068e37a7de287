// Rounding to whole numbers, halves to even, as bits that may be taken as signed or unsigned: |y| < 2^31 or 0 <= y < 2^32. The same as
// converting round(y), in plain additions: conversions take four times as long on a GPU.

// Added to a number below 2^22, it leaves the whole part of that in the lowest bits.
const WHOLE: f32 = 12582912.0;

fn nearest(y: f32) -> u32 {
    let high = bitcast<u32>(fma(y, 0.000244140625, WHOLE));
    // These bits are set already; but no compiler knows, which would else take WHOLE away from a sum with WHOLE.
    let high_part = bitcast<f32>(high | 0x4b000000u) - WHOLE;
    // Exact: what is left of y is below 2^12 and on y's own grid.
    let low = bitcast<u32>(fma(high_part, -4096.0, y) + WHOLE);
    return high * 4096u + low - 0x4b400000u;
}

// The same of a product for -2^22 <= a scale < 2^22, in two operations.
fn nearest_small(a: f32, scale: f32) -> u32 {
    return bitcast<u32>(fma(a, scale, WHOLE)) - 0x4b400000u;
}

fn nearest3(y: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(nearest(y.x), nearest(y.y), nearest(y.z));
}
