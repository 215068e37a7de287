// Reads a cell's moments. The including file binds `moments` for reading, as vectors of four words.
//!include sums-load

fn moments_at(cell: u32) -> Moments {
    return moments_of(sums_at(cell));
}
