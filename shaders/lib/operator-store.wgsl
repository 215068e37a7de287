// Writes a cell's operator. The including file binds `operators`.
//!include operator

fn store_operator(cell: u32, o: Operator) {
    var op = o;
    let k = cell * OPERATOR_WORDS;
    for (var i = 0u; i < 3u; i++) {
        operators[k + 3u * i] = op.a[i].x;
        operators[k + 3u * i + 1u] = op.a[i].y;
        operators[k + 3u * i + 2u] = op.a[i].z;
        operators[k + 9u + i] = op.w[i];
        operators[k + 12u + i] = op.b[i];
    }
    operators[k + 15u] = 0.0;
}
