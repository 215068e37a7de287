// A cell is one invocation's work.
//!include moments
const LANES: u32 = 1u;

fn added_across_lanes(s: Sums) -> Sums {
    return s;
}

fn across3(a: vec3<i32>) -> vec3<i32> {
    return a;
}

// `before` and what the invocations up to number `part` have, and the same for all of them.
fn added_in_order(before: f32, mine: f32, part: u32) -> vec2<f32> {
    return vec2<f32>(before + mine);
}
