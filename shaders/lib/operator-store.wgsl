// Writes a cell's operator. The including file binds `operators`.
//!include operator

// Each of a cell's invocations, of which this is number `part` of `parts`, stores its share of the four vectors.
fn store_operator_part(cell: u32, part: u32, parts: u32, o: Operator) {
    if parts == 1u {
        store_operator(cell, o);
        return;
    }
    var op = o;
    for (var k = part; k < 4u; k += parts) {
        var row = vec4<f32>(op.a[0], op.w.x);
        row = select(row, vec4<f32>(op.a[1], op.w.y), k == 1u);
        row = select(row, vec4<f32>(op.a[2], op.w.z), k == 2u);
        row = select(row, vec4<f32>(op.b, 0.0), k == 3u);
        operators[4u * cell + k] = row;
    }
}

fn store_operator(cell: u32, o: Operator) {
    var op = o;
    let k = 4u * cell;
    operators[k] = vec4<f32>(op.a[0], op.w.x);
    operators[k + 1u] = vec4<f32>(op.a[1], op.w.y);
    operators[k + 2u] = vec4<f32>(op.a[2], op.w.z);
    operators[k + 3u] = vec4<f32>(op.b, 0.0);
}
