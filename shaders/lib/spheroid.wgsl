// Spheroids in body coordinates (axis e = z): slip velocity of the squirmer surface. Quaternions are (x, y, z, w).
//!include exact

fn turn(q: vec4<f32>, a: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross3(q.xyz, a);
    return a + q.w * t + cross3(q.xyz, t);
}

fn turn_back(q: vec4<f32>, a: vec3<f32>) -> vec3<f32> {
    return turn(vec4<f32>(-q.xyz, q.w), a);
}

fn semi_axes(s: SpeciesUniform) -> vec3<f32> {
    return vec3<f32>(s.across, s.across, s.along);
}

// Slip velocity at the surface point p (Theers et al., Soft Matter 12, 7372, 2016, in a form without angles):
// -(B1 + B2 p_z/b_z) [e - (n.e) n], and the rotlet dipole C2 (p_z/b_z) (e x p)/b_x, odd along the axis.
fn slip(s: SpeciesUniform, p: vec3<f32>) -> vec3<f32> {
    let b = semi_axes(s);
    let n = normalize(p / (b * b));
    let zeta = p.z / s.along;
    let tangent = vec3<f32>(-n.z * n.x, -n.z * n.y, fma(-n.z, n.z, 1.0));
    let around = vec3<f32>(-p.y, p.x, 0.0) * (s.rotlet * zeta / s.across);
    return around - fma(s.b2, zeta, s.b1) * tangent;
}

// Angular velocity from the angular momentum, both in the lab frame.
fn angular_velocity(s: SpeciesUniform, q: vec4<f32>, l: vec3<f32>) -> vec3<f32> {
    let body = turn_back(q, l);
    return turn(q, body / vec3<f32>(s.inertia_across, s.inertia_across, s.inertia_along));
}
