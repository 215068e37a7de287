// Sums over a workgroup, one invocation adding for all of its subgroup that are here.
//!include workgroup-partial

fn collect(lane: u32, sum: u32, value: i32) {
    let low = subgroupAdd(value & 0xffff);
    let high = subgroupAdd(value >> 16u);
    if lane == subgroupBroadcastFirst(lane) {
        atomicAdd(&partial[2u * sum], low);
        atomicAdd(&partial[2u * sum + 1u], high);
    }
}
