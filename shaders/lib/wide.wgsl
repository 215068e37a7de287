// 64-bit sums from pairs of 32-bit atomics: (low, high), exact and independent of the order of addition.
// Every addition to the low word knows from its old value whether it carried into the high word.
fn carry(old_low: u32, added: i32) -> u32 {
    let sum = old_low + bitcast<u32>(added);
    return bitcast<u32>(added >> 31u) + select(0u, 1u, sum < old_low);
}

// A wide sum as f32, correctly rounded to within an ulp for either sign.
fn wide_value(low: u32, high: u32) -> f32 {
    let negative = (high & 0x80000000u) != 0u;
    var l = low;
    var h = high;
    if negative {
        l = ~low + 1u;
        h = ~high + select(0u, 1u, l == 0u);
    }
    let magnitude = fma(f32(h), 4294967296.0, f32(l));
    return select(magnitude, -magnitude, negative);
}
