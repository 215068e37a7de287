// Spheroids in body coordinates (axis e = z): slip velocity of the squirmer surface. Quaternions are (x, y, z, w).
//!include exact

// Ghosts deeper than this meet no fluid: a cell's diagonal.
const DEEPEST: f32 = 1.7320508;

fn turn(q: vec4<f32>, a: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross3(q.xyz, a);
    return a + q.w * t + cross3(q.xyz, t);
}

fn turn_back(q: vec4<f32>, a: vec3<f32>) -> vec3<f32> {
    return turn(vec4<f32>(-q.xyz, q.w), a);
}

// Semi-axes of the surface that the fluid meets.
fn hull(s: SpeciesUniform) -> vec3<f32> {
    return vec3<f32>(s.hull_across, s.hull_across, s.hull_along);
}

// The slip at a point of the hull's surface, mode by mode.
struct Slip {
    // -B1 [e - (n.e) n] and -B2 (p_z/b_z) [e - (n.e) n] (Theers et al., Soft Matter 12, 7372, 2016, in a form without angles).
    first: vec3<f32>,
    second: vec3<f32>,
    // The rotlet dipole C2 (p_z/b_z) (e x p)/b_x, odd along the axis.
    rotlet: vec3<f32>,
}

// At the point of the surface that is q times the semi-axes, |q| = 1; `by_width` is 1 over the square root of width_at(b, q.z).
fn slip_modes(s: SpeciesUniform, b: vec3<f32>, q: vec3<f32>, by_width: f32) -> Slip {
    // The normal is along q over the semi-axes.
    let n = q * b.zzx * by_width;
    let tangent = vec3<f32>(-n.z * n.x, -n.z * n.y, fma(-n.z, n.z, 1.0));
    return Slip(-s.b1 * tangent, -s.b2 * q.z * tangent, vec3<f32>(-q.y, q.x, 0.0) * (s.rotlet * q.z));
}

// b_x^2 zeta^2 + b_z^2 (1 - zeta^2): of a point of the surface at the height zeta in units of b_z, (b_x b_z)^2 times the square of q over the semi-axes.
fn width_at(b: vec3<f32>, zeta: f32) -> f32 {
    return fma(b.x * b.x, zeta * zeta, b.z * b.z * fma(-zeta, zeta, 1.0));
}

// At the point of the hull's surface that is q times the semi-axes, |q| = 1.
fn slip(s: SpeciesUniform, q: vec3<f32>) -> vec3<f32> {
    let b = hull(s);
    let modes = slip_modes(s, b, q, inverseSqrt(width_at(b, q.z)));
    return modes.first + modes.second + modes.rotlet;
}

// The squirmer's own flow continued from the surface to the point that is `share` e times the semi-axes, |e| = 1, to first order in the depth: its
// gradients along the normal are known from Stokes flow (math/surface.rs has the formulas). The foot of the normal is found to first order as well.
fn slip_inside(s: SpeciesUniform, e: vec3<f32>, share: f32) -> vec3<f32> {
    let b = hull(s);
    let by_b = 1.0 / b;
    let along_normal = e * by_b;
    let normal = along_normal * inverseSqrt(dot(along_normal, along_normal));
    let depth = min((1.0 - share) * dot(e * b, normal), DEEPEST);
    let foot = fma(vec3<f32>(depth), normal * by_b, share * e);
    let q = foot * inverseSqrt(max(dot(foot, foot), 1e-12));
    let by_width = inverseSqrt(width_at(b, q.z));
    let meridian = b.x * b.z * by_width * by_width * by_width;
    let around = b.z * by_b.x * by_width;
    let modes = slip_modes(s, b, q, by_width);
    return fma(meridian, depth, 1.0) * modes.first + fma(fma(-s.vorticity, by_width, meridian), depth, 1.0) * modes.second
        + fma(3.0 * around, depth, 1.0) * modes.rotlet;
}

// Angular velocity from the angular momentum, both in the lab frame.
fn angular_velocity(s: SpeciesUniform, q: vec4<f32>, l: vec3<f32>) -> vec3<f32> {
    let body = turn_back(q, l);
    return turn(q, body / vec3<f32>(s.inertia_across, s.inertia_across, s.inertia_along));
}
