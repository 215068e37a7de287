// restore-thermostat: gives the cell its angular momentum back (Noguchi and Gompper 2008), and its energy exactly, or an energy
// drawn from its canonical law (Huang et al. 2010), by scaling only what neither momentum nor angular momentum fixes.
//!include dispatch
//!include rng
//!include moments-load
//!include operator-load
//!include operator-store
//!include symmetric
//!include energies

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: RestoreThermostatSettings;
@group(0) @binding(2) var<storage, read> moments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> operators: array<vec4<f32>>;
var<immediate> now: Now;

// By which the moments of inertia may be wrong, in cells^2, several times over: sums of squares and what rounding leaves of their differences.
// A residual energy is known no better than to this times the square of the angular velocity that was taken from it.
const BLUR: f32 = 1e-6;
// How far above the blur an energy must lie that others are scaled to: what it is wrong by is a random walk of the total energy, and rare
// cells near the limit make nearly all of it. Such cells, one in a million at ten particles per cell, do not collide.
const CLEAR: f32 = 30.0;
const ENERGY: u32 = 0u;
const THERMOSTAT: u32 = 1u;

// Second moments about the cell's own means.
struct Centred {
    count: f32,
    vc: vec3<f32>,
    xc: vec3<f32>,
    // sum |w|^2.
    energy: f32,
    // Rows of sum x w^T.
    m: array<vec3<f32>, 3>,
    // sum x x^T.
    c: Symmetric,
}

fn restored(cell: u32, sums: Moments, turned: Operator) -> Operator {
    // A rotation alone keeps the energy.
    if sums.count < 2.0 || !ENERGIES {
        return turned;
    }
    let k = centre(sums);
    var o: Operator;
    if k.energy <= 1e-6 * sums.energy {
        // Equal velocities up to the resolution of the sums: nothing to turn or to scale.
        o = no_collision();
    } else if settings.angular_momentum == 0u {
        o = scaled(turned, factor(cell, 1.5 * (k.count - 1.0), k.energy, k.energy), vec3<f32>(0.0));
    } else {
        o = with_spin(cell, k, turned);
    }
    o.b = centred(o, k.vc, k.xc);
    return o;
}

@compute @workgroup_size(WORKGROUP)
fn restore(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        store_operator(cell, restored(cell, moments_at(cell), operator_at(cell)));
    }
}

// a - x b.
fn less_product(a: vec3<f32>, x: f32, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(fma(-x, b.x, a.x), fma(-x, b.y, a.y), fma(-x, b.z, a.z));
}

fn turned_row(turned: Operator, m: vec3<f32>) -> vec3<f32> {
    var o = turned;
    return vec3<f32>(dot3(o.a[0], m), dot3(o.a[1], m), dot3(o.a[2], m));
}

fn centre(s: Moments) -> Centred {
    var m = s;
    var k: Centred;
    k.count = m.count;
    k.vc = vec3<f32>(divide(m.v.x, m.count), divide(m.v.y, m.count), divide(m.v.z, m.count));
    k.xc = vec3<f32>(divide(m.x.x, m.count), divide(m.x.y, m.count), divide(m.x.z, m.count));
    k.energy = max(0.0, m.energy - dot3(m.v, k.vc));
    k.m[0] = less_product(m.xv[0], m.x.x, k.vc);
    k.m[1] = less_product(m.xv[1], m.x.y, k.vc);
    k.m[2] = less_product(m.xv[2], m.x.z, k.vc);
    k.c.diagonal = vec3<f32>(fma(-m.x.x, k.xc.x, m.diagonal.x), fma(-m.x.y, k.xc.y, m.diagonal.y), fma(-m.x.z, k.xc.z, m.diagonal.z));
    k.c.mixed = vec3<f32>(fma(-m.x.x, k.xc.y, m.mixed.x), fma(-m.x.x, k.xc.z, m.mixed.y), fma(-m.x.y, k.xc.z, m.mixed.z));
    return k;
}

// More than two particles in general position: angular momentum as before, the energy of what is neither momentum nor spin scaled.
fn with_spin(cell: u32, centred_sums: Centred, rotation: Operator) -> Operator {
    var k = centred_sums;
    var turned = rotation;
    let spread = k.c.diagonal.x + k.c.diagonal.y + k.c.diagonal.z;
    // Nearly one point: its moment of inertia is below the resolution of the sums.
    if spread < 1e-3 {
        return no_collision();
    }
    // p_jk = sum x_j (R w)_k.
    var p: array<vec3<f32>, 3>;
    p[0] = turned_row(turned, k.m[0]);
    p[1] = turned_row(turned, k.m[1]);
    p[2] = turned_row(turned, k.m[2]);
    let l = vec3<f32>(k.m[1].z - k.m[2].y, k.m[2].x - k.m[0].z, k.m[0].y - k.m[1].x);
    let l_turned = vec3<f32>(p[1].z - p[2].y, p[2].x - p[0].z, p[0].y - p[1].x);
    if k.count == 2.0 {
        return pair(cell, k, turned, l, l_turned, spread, p[0].x + p[1].y + p[2].z);
    }
    var inertia: Symmetric;
    inertia.diagonal = vec3<f32>(spread) - k.c.diagonal;
    inertia.mixed = -k.c.mixed;
    let solver = factorise(inertia, fma(2e-6, spread, 2e-7 * k.count));
    let wo = solve_refined(solver, inertia, l);
    let wt = solve_refined(solver, inertia, l_turned);
    if settings.mode > THERMOSTAT {
        return scaled(turned, 1.0, wo - wt);
    }
    // The energies must not rest on the quality of the solution: its residuals enter.
    let ro = l - multiply(inertia, wo);
    let rt = l_turned - multiply(inertia, wt);
    let e_turned = k.energy - dot3(wt, l_turned) - dot3(wt, rt);
    if e_turned <= fma(CLEAR * BLUR, dot3(wt, wt), 1e-4 * k.energy) {
        return no_collision();
    }
    var f: f32;
    if settings.mode == ENERGY {
        let e_kept = max(0.0, k.energy - dot3(wo, l) + dot3(wo, ro));
        // The positive root of f^2 e_turned + 2 f wo.rt = e_kept: exact for any wo and wt, however the cell is conditioned.
        let t = divide(dot3(wo, rt), e_turned);
        f = square_root(fma(t, t, divide(e_kept, e_turned))) - t;
    } else {
        f = factor(cell, fma(1.5, k.count, -3.0), k.energy, e_turned);
    }
    return scaled(turned, f, wo - f * wt);
}

// Two particles: the residual lies along the line between them and can only keep, lose or change its sign.
fn pair(cell: u32, k: Centred, turned: Operator, l: vec3<f32>, l_turned: vec3<f32>, spread: f32, along: f32) -> Operator {
    var sums = k;
    let omega = l / spread;
    if settings.mode > THERMOSTAT {
        return scaled(turned, 1.0, omega - l_turned / spread);
    }
    let before = sums.m[0].x + sums.m[1].y + sums.m[2].z;
    var g = select(-1.0, 1.0, along * before >= 0.0);
    if settings.mode == THERMOSTAT {
        let residual = sums.energy - dot3(omega, l);
        if residual < fma(BLUR, dot3(omega, omega), 1e-6 * sums.energy) {
            return no_collision();
        }
        g *= factor(cell, 0.5, 0.0, residual);
    }
    var o = no_collision();
    o.a[0].x = g;
    o.a[1].y = g;
    o.a[2].z = g;
    o.w = (1.0 - g) * omega;
    return o;
}

fn scaled(turned: Operator, f: f32, w: vec3<f32>) -> Operator {
    var o = turned;
    o.a[0] = f * o.a[0];
    o.a[1] = f * o.a[1];
    o.a[2] = f * o.a[2];
    o.w = w;
    return o;
}

// What scales velocities of energy sum |y|^2 to the energy `kept`, or with the thermostat to twice a Gamma variate.
fn factor(cell: u32, shape: f32, kept: f32, turned: f32) -> f32 {
    if turned <= 0.0 {
        return 1.0;
    }
    if settings.mode != THERMOSTAT {
        return square_root(divide(kept, turned));
    }
    return square_root(divide(2.0 * system.temperature * gamma(cell, shape), turned));
}

// What an attempt at a gamma variate takes: the first one what the rotation axis has left of the cell's random words.
fn attempted(cell: u32, attempt: u32) -> vec3<f32> {
    if attempt == 0u {
        let drawn = words(PURPOSE_COLLISION, cell, 0u, 0u);
        return vec3<f32>(unit(drawn.z), unit(drawn.w), fifth(drawn));
    }
    return uniforms(PURPOSE_THERMOSTAT, cell, attempt, 0u).xyz;
}

// Gamma variate of shape >= 1, or exactly 1/2 (Marsaglia and Tsang, ACM Trans. Math. Softw. 26, 363, 2000).
fn gamma(cell: u32, shape: f32) -> f32 {
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / sqrt(9.0 * d);
    var result = d;
    for (var attempt = 0u; attempt < 64u; attempt++) {
        let u = attempted(cell, attempt);
        let x = deviation(u.x) * cos(TAU * u.y);
        if shape < 1.0 {
            return 0.5 * x * x;
        }
        let t = fma(c, x, 1.0);
        let v = t * t * t;
        if t > 0.0 && log(u.z) < fma(0.5 * x, x, d - d * v + d * log(v)) {
            result = d * v;
            break;
        }
    }
    return result;
}
