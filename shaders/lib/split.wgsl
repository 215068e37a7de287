// x * period / 2^32: whole cells, and the rest in units of 2^-32 cell; the period is below 2^16.
fn split(x: u32, period: u32) -> vec2<u32> {
    let low = (x & 0xffffu) * period;
    let high = (x >> 16u) * period + (low >> 16u);
    return vec2<u32>(high >> 16u, (high << 16u) | (low & 0xffffu));
}
