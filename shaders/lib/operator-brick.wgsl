// Operators of a brick's cells where one workgroup makes them and applies them. The including file has the words `cell_sums`: a cell's operator
// takes the place of its sums, which its own invocation has read by then. The less memory, the more workgroups are at work at a time.
//!include operator

fn keep_words(k: u32, c: u32, words: vec3<f32>) {
    atomicStore(&cell_sums[k * BRICK_CELLS + c], bitcast<u32>(words.x));
    atomicStore(&cell_sums[(k + 1u) * BRICK_CELLS + c], bitcast<u32>(words.y));
    atomicStore(&cell_sums[(k + 2u) * BRICK_CELLS + c], bitcast<u32>(words.z));
}

// `c` is the cell's number in its brick.
fn keep_operator(c: u32, o: Operator) {
    var op = o;
    keep_words(0u, c, op.a[0]);
    keep_words(3u, c, op.a[1]);
    keep_words(6u, c, op.a[2]);
    keep_words(9u, c, op.b);
    if PLACES {
        keep_words(12u, c, op.w);
    }
}

fn kept_words(k: u32, c: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(
        atomicLoad(&cell_sums[k * BRICK_CELLS + c]),
        atomicLoad(&cell_sums[(k + 1u) * BRICK_CELLS + c]),
        atomicLoad(&cell_sums[(k + 2u) * BRICK_CELLS + c]),
    ));
}

fn operator_at(cell: u32) -> Operator {
    let c = cell % BRICK_CELLS;
    var o: Operator;
    o.a[0] = kept_words(0u, c);
    o.a[1] = kept_words(3u, c);
    o.a[2] = kept_words(6u, c);
    o.b = kept_words(9u, c);
    if PLACES {
        o.w = kept_words(12u, c);
    }
    return o;
}
