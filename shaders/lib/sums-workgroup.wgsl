// The sums of 64 cells in workgroup memory, raw: the first word of all, then the second. The including file binds `system`.
//!include contribution
const SUMMED_CELLS: u32 = 64u;

var<workgroup> cell_sums: array<atomic<u32>, MOMENT_WORDS * SUMMED_CELLS>;

// To be followed by a barrier.
fn clear_sums(lane: u32, lanes: u32) {
    for (var k = lane; k < MOMENT_WORDS * SUMMED_CELLS; k += lanes) {
        atomicStore(&cell_sums[k], 0u);
    }
}

fn add_word(k: u32, cell: u32, word: u32) {
    atomicAdd(&cell_sums[k * SUMMED_CELLS + cell], word);
}

fn add_words(k: u32, cell: u32, words: vec3<i32>) {
    let w = bitcast<vec3<u32>>(words);
    add_word(k, cell, w.x);
    add_word(k + 1u, cell, w.y);
    add_word(k + 2u, cell, w.z);
}

// Adds a raw contribution.
fn add_to_cell(cell: u32, s: Sums) {
    add_word(0u, cell, s.count);
    add_words(1u, cell, s.v);
    if ENERGIES {
        add_word(4u, cell, s.energy);
    }
    if s.ghosts > 0u {
        add_word(5u, cell, s.ghosts);
    }
    if !PLACES {
        return;
    }
    add_words(6u, cell, s.x);
    add_words(9u, cell, s.diagonal);
    add_words(12u, cell, s.mixed);
    add_words(15u, cell, s.xv0);
    add_words(18u, cell, s.xv1);
    add_words(21u, cell, s.xv2);
}

fn sum_word(k: u32, cell: u32) -> u32 {
    return atomicLoad(&cell_sums[k * SUMMED_CELLS + cell]);
}

fn sum_words(k: u32, cell: u32) -> vec3<i32> {
    return bitcast<vec3<i32>>(vec3<u32>(sum_word(k, cell), sum_word(k + 1u, cell), sum_word(k + 2u, cell)));
}

fn sums_of_workgroup(c: u32) -> Sums {
    var s: Sums;
    s.count = sum_word(0u, c);
    s.v = sum_words(1u, c);
    s.energy = sum_word(4u, c);
    s.ghosts = sum_word(5u, c);
    if !PLACES {
        return settled(s, number_in(s.count));
    }
    s.x = sum_words(6u, c);
    s.diagonal = sum_words(9u, c);
    s.mixed = sum_words(12u, c);
    s.xv0 = sum_words(15u, c);
    s.xv1 = sum_words(18u, c);
    s.xv2 = sum_words(21u, c);
    return settled(s, number_in(s.count));
}
