// Reads the sums of a cell. The including file binds `moments` as vectors of four words.
//!include sums-words

fn sums_at(cell: u32) -> Sums {
    let k = 6u * cell;
    var words: array<vec4<u32>, 6>;
    words[0] = moments[k];
    words[1] = moments[k + 1u];
    if PLACES {
        words[2] = moments[k + 2u];
        words[3] = moments[k + 3u];
        words[4] = moments[k + 4u];
        words[5] = moments[k + 5u];
    }
    return sums_of_words(words);
}
