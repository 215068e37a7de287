// Symmetric 3x3 matrices: product, and solution by LDL^T with a small addition to the diagonal and one refinement without it.
//!include exact
struct Symmetric {
    // xx, yy, zz.
    diagonal: vec3<f32>,
    // xy, xz, yz.
    mixed: vec3<f32>,
}

struct Factors {
    // Reciprocals of D.
    d: vec3<f32>,
    // L: entries 10, 20, 21.
    l: vec3<f32>,
}

fn multiply(s: Symmetric, a: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        fma(s.diagonal.x, a.x, fma(s.mixed.x, a.y, s.mixed.y * a.z)),
        fma(s.mixed.x, a.x, fma(s.diagonal.y, a.y, s.mixed.z * a.z)),
        fma(s.mixed.y, a.x, fma(s.mixed.z, a.y, s.diagonal.z * a.z)),
    );
}

fn factorise(s: Symmetric, addition: f32) -> Factors {
    var f: Factors;
    f.d.x = 1.0 / (s.diagonal.x + addition);
    f.l.x = s.mixed.x * f.d.x;
    f.l.y = s.mixed.y * f.d.x;
    f.d.y = 1.0 / max(fma(-f.l.x, s.mixed.x, s.diagonal.y + addition), addition);
    let r = fma(-f.l.y, s.mixed.x, s.mixed.z);
    f.l.z = r * f.d.y;
    f.d.z = 1.0 / max(fma(-f.l.z, r, fma(-f.l.y, s.mixed.y, s.diagonal.z + addition)), addition);
    return f;
}

fn solve(f: Factors, a: vec3<f32>) -> vec3<f32> {
    let y = fma(-f.l.x, a.x, a.y);
    let z = fma(-f.l.z, y, fma(-f.l.y, a.x, a.z));
    let sz = z * f.d.z;
    let sy = fma(-f.l.z, sz, y * f.d.y);
    let sx = fma(-f.l.x, sy, fma(-f.l.y, sz, a.x * f.d.x));
    return vec3<f32>(sx, sy, sz);
}

fn solve_refined(f: Factors, s: Symmetric, a: vec3<f32>) -> vec3<f32> {
    let first = solve(f, a);
    return first + solve(f, a - multiply(s, first));
}
