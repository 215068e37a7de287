// Writes the sums of a cell. The including file binds `moments` as vectors.
//!include sums-words

fn store_sums(cell: u32, s: Sums) {
    let k = 6u * cell;
    let words = words_of(s);
    moments[k] = words[0];
    moments[k + 1u] = words[1];
    if !PLACES {
        return;
    }
    moments[k + 2u] = words[2];
    moments[k + 3u] = words[3];
    moments[k + 4u] = words[4];
    moments[k + 5u] = words[5];
}
