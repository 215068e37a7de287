// Rounding to whole numbers, halves to even, as bits that may be taken as signed or unsigned: |y| < 2^31 or 0 <= y < 2^32. The same as
// converting round(y), in plain additions: conversions take four times as long on a GPU. The including file binds `system`.

// Added to a number below 2^22, it leaves the whole part of that in the lowest bits.
const WHOLE: f32 = 12582912.0;
// The bits of WHOLE itself, by which a number is too large that is left as it comes: a sum of n of them by n times as much.
const RAW: u32 = 0x4b400000u;

fn raw(y: f32) -> u32 {
    // system.whole is WHOLE: but no compiler knows, which would else take WHOLE away from a sum with WHOLE.
    let high = fma(y, 0.000244140625, system.whole);
    // Exact: what is left of y is below 2^12 and on y's own grid.
    let low = fma(high - WHOLE, -4096.0, y) + WHOLE;
    // RAW times 4096 is a multiple of 2^32.
    return bitcast<u32>(high) * 4096u + bitcast<u32>(low);
}

// The same of a product for -2^22 <= a scale < 2^22, in one operation.
fn raw_small(a: f32, scale: f32) -> u32 {
    return bitcast<u32>(fma(a, scale, WHOLE));
}

fn raw3(y: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(raw(y.x), raw(y.y), raw(y.z));
}

fn nearest(y: f32) -> u32 {
    return raw(y) - RAW;
}

fn nearest3(y: vec3<f32>) -> vec3<u32> {
    return raw3(y) - RAW;
}
