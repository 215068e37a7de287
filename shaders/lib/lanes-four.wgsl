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

fn added_across_lanes(mine: Sums) -> Sums {
    var s = mine;
    s.count = across(s.count);
    s.v = across3(s.v);
    s.energy = across(s.energy);
    s.ghosts = across(s.ghosts);
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
