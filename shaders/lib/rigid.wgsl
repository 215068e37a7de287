// rigid: rotation of a rigid symmetric top; every product that is added is an explicit fma, so that all kernels round alike.
//!include exact

// Third column of the rotation matrix of q = (x, y, z, w): the body's axis e in the lab.
fn body_axis(q: vec4<f32>) -> vec3<f32> {
    return vec3<f32>(
        2.0 * fma(q.x, q.z, q.w * q.y),
        2.0 * fma(q.y, q.z, -(q.w * q.x)),
        fma(-2.0, fma(q.x, q.x, q.y * q.y), 1.0),
    );
}

// Hamilton's product p q: first the rotation q, then p.
fn hamilton(p: vec4<f32>, q: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(
        fma(p.w, q.x, fma(q.w, p.x, fma(p.y, q.z, -(p.z * q.y)))),
        fma(p.w, q.y, fma(q.w, p.y, fma(p.z, q.x, -(p.x * q.z)))),
        fma(p.w, q.z, fma(q.w, p.z, fma(p.x, q.y, -(p.y * q.x)))),
        fma(p.w, q.w, -dot3(p.xyz, q.xyz)),
    );
}

// The quaternion of the rotation vector v. Hardware sines are good to 2^-11 only, so up to half angles of 1.5 Taylor's series
// is used (error below 3e-8).
fn rotation(v: vec3<f32>) -> vec4<f32> {
    let half = 0.5 * v;
    let s = dot3(half, half);
    if s > 2.25 {
        let angle = sqrt(s);
        return vec4<f32>(half * (sin(angle) / angle), cos(angle));
    }
    var sinc = fma(s, 1.6059044e-10, -2.5052108e-8);
    sinc = fma(s, sinc, 2.7557319e-6);
    sinc = fma(s, sinc, -1.9841270e-4);
    sinc = fma(s, sinc, 8.3333333e-3);
    sinc = fma(s, sinc, -0.16666667);
    sinc = fma(s, sinc, 1.0);
    var cosine = fma(s, 2.0876757e-9, -2.7557319e-7);
    cosine = fma(s, cosine, 2.4801587e-5);
    cosine = fma(s, cosine, -1.3888889e-3);
    cosine = fma(s, cosine, 4.1666667e-2);
    cosine = fma(s, cosine, -0.5);
    cosine = fma(s, cosine, 1.0);
    return vec4<f32>(half * sinc, cosine);
}

// Orientation after the time t without torque, exact for a symmetric top with angular momentum l (Landau and Lifshitz,
// Mechanics, section 33): precession about l at |l|/across, and what is left of the spin about e.
fn turned(q: vec4<f32>, l: vec3<f32>, t: f32, along: f32, across: f32) -> vec4<f32> {
    let spin = dot3(l, body_axis(q)) * (1.0 / along - 1.0 / across) * t;
    let p = hamilton(rotation(l * (t / across)), hamilton(q, rotation(vec3<f32>(0.0, 0.0, spin))));
    return p * (1.0 / sqrt(fma(p.w, p.w, dot3(p.xyz, p.xyz))));
}

// Angular velocity in the lab of a body with the axis e and angular momentum l.
fn top_velocity(e: vec3<f32>, l: vec3<f32>, along: f32, across: f32) -> vec3<f32> {
    let excess = dot3(l, e) * (1.0 / along - 1.0 / across);
    return fma(e, vec3<f32>(excess), l * (1.0 / across));
}
