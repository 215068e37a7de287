// Reads a cell's moments. The including file binds `moments` for reading.
//!include moments

fn moments_at(cell: u32) -> Moments {
    var words: array<u32, 24>;
    for (var i = 0u; i < MOMENT_WORDS; i++) {
        words[i] = moments[cell * MOMENT_WORDS + i];
    }
    return moments_of(words);
}
