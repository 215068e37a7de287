// Sums over a workgroup, each invocation adding its own share.
//!include workgroup-partial

fn collect(lane: u32, sum: u32, value: i32) {
    atomicAdd(&partial[2u * sum], value & 0xffff);
    atomicAdd(&partial[2u * sum + 1u], value >> 16u);
}
