// Reads a cell's moments. The including file binds `moments` for reading.
//!include moments

fn signed_at(word: u32) -> vec3<i32> {
    return vec3<i32>(bitcast<i32>(moments[word]), bitcast<i32>(moments[word + 1u]), bitcast<i32>(moments[word + 2u]));
}

fn moments_at(cell: u32) -> Moments {
    let w = cell * MOMENT_WORDS;
    var s: Sums;
    s.count = moments[w];
    s.v = signed_at(w + 1u);
    s.energy = moments[w + 4u];
    s.coarse = moments[w + 5u];
    s.x = signed_at(w + 6u);
    s.diagonal = signed_at(w + 9u);
    s.mixed = signed_at(w + 12u);
    s.xv0 = signed_at(w + 15u);
    s.xv1 = signed_at(w + 18u);
    s.xv2 = signed_at(w + 21u);
    return moments_of(s);
}
