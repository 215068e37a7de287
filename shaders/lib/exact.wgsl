// Arithmetic whose error does not lean to one side: one residual correction after the hardware's own result.
fn divide(a: f32, b: f32) -> f32 {
    let r = 1.0 / b;
    let q = a * r;
    return fma(fma(-q, b, a), r, q);
}

fn square_root(a: f32) -> f32 {
    let s = sqrt(a);
    return select(fma(fma(-s, s, a), 0.5 / s, s), 0.0, a < 1e-30);
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        fma(a.y, b.z, -(a.z * b.y)),
        fma(a.z, b.x, -(a.x * b.z)),
        fma(a.x, b.y, -(a.y * b.x)),
    );
}

fn excess_of(u: vec3<f32>) -> f32 {
    return 0.5 * fma(u.z, u.z, fma(u.y, u.y, fma(u.x, u.x, -1.0)));
}

// The component that is `one` takes up what is missing to the length 1. Written without branches, which neighbours would take apart.
fn corrected(u: vec3<f32>, one: vec3<bool>) -> vec3<f32> {
    let component = select(select(u.z, u.y, one.y), u.x, one.x);
    return u - select(vec3<f32>(0.0), vec3<f32>(excess_of(u) / component), one);
}

fn largest_corrected(u: vec3<f32>) -> vec3<f32> {
    let size = abs(u);
    let x = size.x >= size.y && size.x >= size.z;
    let y = !x && size.y >= size.z;
    return corrected(u, vec3<bool>(x, y, !x && !y));
}

// A vector almost as long as 1 made a unit vector: its largest component takes up what is missing, twice. To scale all of them by
// 1 + e would round to one side, since numbers are twice as dense below 1 as above, and cool the fluid; compilers make that of u + e u, too.
// What the largest component is too coarse for, such as the lean of fast sines, the smallest takes up.
fn unit_vector(a: vec3<f32>) -> vec3<f32> {
    let u = largest_corrected(largest_corrected(a));
    let size = abs(u);
    let x = size.x <= size.y && size.x <= size.z;
    let y = !x && size.y <= size.z;
    // Below this a correction would turn the vector by more than its sines are wrong.
    let worth = min(size.x, min(size.y, size.z)) > 0.03;
    return select(u, corrected(u, vec3<bool>(x, y, !x && !y)), worth);
}
