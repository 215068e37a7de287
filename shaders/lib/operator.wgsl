// The collision of one cell as an affine map, v' = b + A v + W x x with x from the cell's centre.
// In memory: three rows of A with the components of W behind them, then b; 16 words as four vectors.
//!include exact
//!include places
const OPERATOR_WORDS: u32 = 16u;

struct Operator {
    // Rows of A.
    a: array<vec3<f32>, 3>,
    w: vec3<f32>,
    b: vec3<f32>,
}

fn collided(o: Operator, x: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    var op = o;
    var spin = vec3<f32>(0.0);
    if PLACES {
        spin = cross3(op.w, x);
    }
    return vec3<f32>(
        fma(op.a[0].x, v.x, fma(op.a[0].y, v.y, fma(op.a[0].z, v.z, spin.x))),
        fma(op.a[1].x, v.x, fma(op.a[1].y, v.y, fma(op.a[1].z, v.z, spin.y))),
        fma(op.a[2].x, v.x, fma(op.a[2].y, v.y, fma(op.a[2].z, v.z, spin.z))),
    ) + op.b;
}

fn no_collision() -> Operator {
    var o: Operator;
    o.a[0] = vec3<f32>(1.0, 0.0, 0.0);
    o.a[1] = vec3<f32>(0.0, 1.0, 0.0);
    o.a[2] = vec3<f32>(0.0, 0.0, 1.0);
    o.w = vec3<f32>(0.0);
    o.b = vec3<f32>(0.0);
    return o;
}

// b such that a particle with the mean velocity at the mean position keeps it: b = vc - A vc - W x xc.
fn centred(o: Operator, vc: vec3<f32>, xc: vec3<f32>) -> vec3<f32> {
    var op = o;
    op.b = vec3<f32>(0.0);
    return vc - collided(op, xc, vc);
}
