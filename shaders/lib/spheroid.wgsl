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

fn slip_modes(s: SpeciesUniform, p: vec3<f32>) -> Slip {
    let b = hull(s);
    let n = normalize(p / (b * b));
    let tangent = vec3<f32>(-n.z * n.x, -n.z * n.y, fma(-n.z, n.z, 1.0));
    let zeta = p.z / b.z;
    return Slip(-s.b1 * tangent, -s.b2 * zeta * tangent, vec3<f32>(-p.y, p.x, 0.0) * (s.rotlet * zeta / b.x));
}

fn slip(s: SpeciesUniform, p: vec3<f32>) -> vec3<f32> {
    let modes = slip_modes(s, p);
    return modes.first + modes.second + modes.rotlet;
}

// The squirmer's own flow continued from the surface to a point inside, to first order in the depth: its gradients along the normal are
// known from Stokes flow (math/surface.rs has the formulas). The foot of the normal is found to first order as well.
fn slip_inside(s: SpeciesUniform, point: vec3<f32>) -> vec3<f32> {
    let b = hull(s);
    let scaled = max(length(point / b), 1e-6);
    let homothetic = point / scaled;
    let normal = normalize(homothetic / (b * b));
    let depth = min((1.0 - scaled) * dot(homothetic, normal), DEEPEST);
    let foot = point + depth * normal;
    let p = foot / max(length(foot / b), 1e-6);
    let zeta = p.z / b.z;
    let width = fma(b.x * b.x, zeta * zeta, b.z * b.z * fma(-zeta, zeta, 1.0));
    let meridian = b.x * b.z / (width * sqrt(width));
    let around = 1.0 / (b.x * b.x * length(p / (b * b)));
    let modes = slip_modes(s, p);
    return fma(meridian, depth, 1.0) * modes.first + fma(meridian - s.vorticity / sqrt(width), depth, 1.0) * modes.second
        + fma(3.0 * around, depth, 1.0) * modes.rotlet;
}

// Angular velocity from the angular momentum, both in the lab frame.
fn angular_velocity(s: SpeciesUniform, q: vec4<f32>, l: vec3<f32>) -> vec3<f32> {
    let body = turn_back(q, l);
    return turn(q, body / vec3<f32>(s.inertia_across, s.inertia_across, s.inertia_along));
}
