// Four neighbouring invocations of a subgroup share the work for a cell.
//!include moments
//!include places
const LANES: u32 = 4u;

fn across(a: u32) -> u32 {
    let b = a + subgroupShuffleXor(a, 1u);
    return b + subgroupShuffleXor(b, 2u);
}

fn across3(a: vec3<i32>) -> vec3<i32> {
    let b = a + subgroupShuffleXor(a, 1u);
    return b + subgroupShuffleXor(b, 2u);
}

// `before` and what the invocations up to number `part` have, and the same for all four, by the additions that one invocation would make.
fn added_in_order(before: f32, mine: f32, part: u32) -> vec2<f32> {
    let beside = subgroupShuffleXor(mine, 1u);
    let pair = select(vec2<f32>(mine, beside), vec2<f32>(beside, mine), (part & 1u) != 0u);
    let other = subgroupShuffleXor(pair, 2u);
    let shares = select(vec4<f32>(pair, other), vec4<f32>(other, pair), (part & 2u) != 0u);
    var sums: vec4<f32>;
    sums.x = before + shares.x;
    sums.y = sums.x + shares.y;
    sums.z = sums.y + shares.z;
    sums.w = sums.z + shares.w;
    return vec2<f32>(sums[part], sums.w);
}

fn added_across_lanes(mine: Sums) -> Sums {
    var s = mine;
    s.count = across(s.count);
    s.v = across3(s.v);
    s.energy = across(s.energy);
    s.coarse = across(s.coarse);
    if PLACES {
        s.x = across3(s.x);
        s.diagonal = across3(s.diagonal);
        s.mixed = across3(s.mixed);
        s.xv0 = across3(s.xv0);
        s.xv1 = across3(s.xv1);
        s.xv2 = across3(s.xv2);
    }
    return s;
}
