// Sums over one workgroup of 64 invocations, in halves of 16 bits so that 64 additions of any i32 cannot overflow.
const WORKGROUP_SUMS: u32 = 15u;
var<workgroup> partial: array<atomic<i32>, 30>;

fn clear_sums_of_workgroup(lane: u32) {
    if lane < 2u * WORKGROUP_SUMS {
        atomicStore(&partial[lane], 0);
    }
    workgroupBarrier();
}

fn collect(sum: u32, value: i32) {
    atomicAdd(&partial[2u * sum], value & 0xffff);
    atomicAdd(&partial[2u * sum + 1u], value >> 16u);
}

fn collect3(sum: u32, values: vec3<i32>) {
    collect(sum, values.x);
    collect(sum + 1u, values.y);
    collect(sum + 2u, values.z);
}

// The workgroup's share of a wide sum as (low, high).
fn collected(sum: u32) -> vec2<u32> {
    let rest = atomicLoad(&partial[2u * sum + 1u]);
    let low = bitcast<u32>(rest) << 16u;
    let total = low + bitcast<u32>(atomicLoad(&partial[2u * sum]));
    return vec2<u32>(total, bitcast<u32>(rest >> 16u) + select(0u, 1u, total < low));
}

// For values of which 64 together stay below 2^31: one word each.
fn collect_small(sum: u32, value: i32) {
    atomicAdd(&partial[sum], value);
}

fn collect_small3(sum: u32, values: vec3<i32>) {
    collect_small(sum, values.x);
    collect_small(sum + 1u, values.y);
    collect_small(sum + 2u, values.z);
}

// The workgroup's share of a wide sum as (low, high), if it has collected so much too much.
fn collected_small(sum: u32, excess: u32) -> vec2<u32> {
    let total = atomicLoad(&partial[sum]) - bitcast<i32>(excess);
    return vec2<u32>(bitcast<u32>(total), bitcast<u32>(total >> 31u));
}
