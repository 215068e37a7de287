// Writes a cell's operator. The including file binds `operators`.
//!include operator

fn store_operator(cell: u32, o: Operator) {
    var op = o;
    let k = 4u * cell;
    operators[k] = vec4<f32>(op.a[0], op.w.x);
    operators[k + 1u] = vec4<f32>(op.a[1], op.w.y);
    operators[k + 2u] = vec4<f32>(op.a[2], op.w.z);
    operators[k + 3u] = vec4<f32>(op.b, 0.0);
}
