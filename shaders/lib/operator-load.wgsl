// Reads a cell's operator. The including file binds `operators`.
//!include operator

fn operator_at(cell: u32) -> Operator {
    let k = 4u * cell;
    let x = operators[k];
    let y = operators[k + 1u];
    let z = operators[k + 2u];
    var o: Operator;
    o.a[0] = x.xyz;
    o.a[1] = y.xyz;
    o.a[2] = z.xyz;
    o.w = vec3<f32>(x.w, y.w, z.w);
    o.b = operators[k + 3u].xyz;
    return o;
}
