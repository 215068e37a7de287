// Reads a cell's operator. The including file binds `operators`.
//!include operator

fn operator_at(cell: u32) -> Operator {
    let k = cell * OPERATOR_WORDS;
    var o: Operator;
    o.a[0] = vec3<f32>(operators[k], operators[k + 1u], operators[k + 2u]);
    o.a[1] = vec3<f32>(operators[k + 3u], operators[k + 4u], operators[k + 5u]);
    o.a[2] = vec3<f32>(operators[k + 6u], operators[k + 7u], operators[k + 8u]);
    o.w = vec3<f32>(operators[k + 9u], operators[k + 10u], operators[k + 11u]);
    o.b = vec3<f32>(operators[k + 12u], operators[k + 13u], operators[k + 14u]);
    return o;
}
