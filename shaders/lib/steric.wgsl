// steric: contact distance of two spheroids (Paramonov and Yaliraki 2005) and the repulsion that depends on it.
//!include exact

// A spheroid with its steric margin, and its axis in the lab.
struct Spheroid {
    axis: vec3<f32>,
    across: f32,
    along: f32,
}

// Distance (0 at contact, negative in overlap) and its derivatives with respect to B's shift and the turns of A and B.
struct Contact {
    gap: f32,
    by_shift: vec3<f32>,
    by_turn_a: vec3<f32>,
    by_turn_b: vec3<f32>,
}

// across^2 v + (along^2 - across^2) (e.v) e.
fn shape_times(body: Spheroid, v: vec3<f32>) -> vec3<f32> {
    let x2 = body.across * body.across;
    let excess = fma(body.along, body.along, -x2);
    return fma(body.axis, vec3<f32>(excess * dot3(body.axis, v)), x2 * v);
}

fn half_height(body: Spheroid, cosine: f32) -> f32 {
    let x2 = body.across * body.across;
    let excess = fma(body.along, body.along, -x2);
    return sqrt(fma(excess, cosine * cosine, x2));
}

// Y = [(1 - t) A + t B]^-1 R, with (e_a.Y, e_b.Y) from a 2 x 2 system: the matrix is a multiple of 1 plus two dyads.
struct Solved {
    y: vec3<f32>,
    p: f32,
    q: f32,
}

fn solve_mixed(a: Spheroid, b: Spheroid, r: vec3<f32>, t: f32) -> Solved {
    let a2 = a.across * a.across;
    let b2 = b.across * b.across;
    let alpha = fma(1.0 - t, a2, t * b2);
    let u = (1.0 - t) * fma(a.along, a.along, -a2);
    let v = t * fma(b.along, b.along, -b2);
    let k = dot3(a.axis, b.axis);
    let ra = dot3(a.axis, r);
    let rb = dot3(b.axis, r);
    let determinant = fma(alpha + u, alpha + v, -(u * v * k * k));
    var solved: Solved;
    solved.p = fma(ra, alpha + v, -(v * k * rb)) / determinant;
    solved.q = fma(rb, alpha + u, -(u * k * ra)) / determinant;
    solved.y = fma(a.axis, vec3<f32>(-u * solved.p), fma(b.axis, vec3<f32>(-v * solved.q), r)) * (1.0 / alpha);
    return solved;
}

// Maximum over t of t (1 - t) R.Y: where (1 - t) sqrt(Y.A Y) = t sqrt(Y.B Y), or p/(p + q) - t vanishes with these roots p and q, which
// falls through zero once and for two spheres is a straight line. Regula falsi with halved weights of an end that stays (Illinois;
// Dowell and Jarratt, BIT 11, 168, 1971): five or six rounds to f32's resolution, as exact after 16 as 24 bisections up to ratios of 20.
fn contact_parameter(a: Spheroid, b: Spheroid, r: vec3<f32>) -> f32 {
    let a2 = a.across * a.across;
    let b2 = b.across * b.across;
    let a_excess = fma(a.along, a.along, -a2);
    let b_excess = fma(b.along, b.along, -b2);
    // Where it is positive and where negative: t and its value; the first are no more than a guess.
    var low = vec2<f32>(0.0, 0.5);
    var high = vec2<f32>(1.0, -0.5);
    var moved = 0;
    var t = 0.5;
    for (var i = 0u; i < 16u; i = i + 1u) {
        let s = solve_mixed(a, b, r, t);
        let square = dot3(s.y, s.y);
        let p = sqrt(max(fma(a_excess, s.p * s.p, a2 * square), 0.0));
        let q = sqrt(max(fma(b_excess, s.q * s.q, b2 * square), 0.0));
        let value = fma(-t, p + q, p) / (p + q);
        if abs(value) <= 1.1920929e-7 {
            break;
        }
        if value > 0.0 {
            high.y = select(high.y, 0.5 * high.y, moved == 1);
            low = vec2<f32>(t, value);
            moved = 1;
        } else {
            low.y = select(low.y, 0.5 * low.y, moved == -1);
            high = vec2<f32>(t, value);
            moved = -1;
        }
        var next = fma(high.x - low.x, low.y / (low.y - high.y), low.x);
        if !(next > low.x && next < high.x) {
            next = 0.5 * (low.x + high.x);
        }
        let done = abs(next - t) <= 5.9604645e-8;
        t = next;
        if done {
            break;
        }
    }
    return t;
}

// R points from A to B and must not be zero.
fn contact(a: Spheroid, b: Spheroid, r: vec3<f32>) -> Contact {
    let t = contact_parameter(a, b, r);
    let x = solve_mixed(a, b, r, t).y * (t * (1.0 - t));
    let f = dot3(r, x);
    let inverse_root = 1.0 / sqrt(f);
    let distance = sqrt(dot3(r, r));
    let k = distance * inverse_root / f;
    var c: Contact;
    c.gap = fma(-distance, inverse_root, distance);
    c.by_shift = fma(x, vec3<f32>(k), r * ((1.0 - inverse_root) / distance));
    c.by_turn_a = cross3(shape_times(a, x), x) * (-k / t);
    c.by_turn_b = cross3(shape_times(b, x), x) * (-k / (1.0 - t));
    return c;
}

// Distance from a plane whose unit normal into the fluid is +y or -y (`inward`), the centre being `height` above it.
fn wall_contact(body: Spheroid, height: f32, inward: f32) -> Contact {
    let n = vec3<f32>(0.0, inward, 0.0);
    let half = half_height(body, body.axis.y);
    var c: Contact;
    c.gap = height - half;
    c.by_shift = n;
    c.by_turn_b = cross3(shape_times(body, n) * (-1.0 / half), n);
    return c;
}

// -U'(d) of U = 4 epsilon [(sigma/(d + sigma))^12 - (sigma/(d + sigma))^6] + epsilon, cut where it vanishes, reduced so that the
// force stays below max_force. Deep in an overlap d + sigma is held at sigma/10, where the bare force is far above any cap.
fn repulsion(c: Contact, sigma: f32, epsilon: f32, max_force: f32) -> f32 {
    let x = sigma / max(c.gap + sigma, 0.1 * sigma);
    let x3 = x * x * x;
    let x6 = x3 * x3;
    let bare = 24.0 * epsilon / sigma * x * fma(2.0 * x6, x6, -x6);
    return clamp(bare, 0.0, max_force / max(1.0, sqrt(dot3(c.by_shift, c.by_shift))));
}
