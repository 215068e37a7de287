// The same as `split`, where an adapter has whole numbers of 64 bits: one operation in place of seven.
fn split(x: u32, period: u32) -> vec2<u32> {
    let product = u64(x) * u64(period);
    return vec2<u32>(u32(product >> 32u), u32(product));
}
