// Sums over one workgroup of 64 invocations, in halves of 16 bits so that 64 additions of any i32 cannot overflow.
//!include wide
const WORKGROUP_SUMS: u32 = 15u;
var<workgroup> partial: array<atomic<i32>, 30>;

fn clear_sums_of_workgroup(lane: u32) {
    if lane < 2u * WORKGROUP_SUMS {
        atomicStore(&partial[lane], 0);
    }
    workgroupBarrier();
}

// The workgroup's share of a wide sum as (low, high).
fn collected(sum: u32) -> vec2<u32> {
    return wide_of_halves(atomicLoad(&partial[2u * sum]), atomicLoad(&partial[2u * sum + 1u]));
}
