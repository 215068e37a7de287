// Ghost particles inside squirmers, drawn afresh wherever they are needed: a function of (seed, step, squirmer, index).
// The including file binds `system`, `species`, `squirmers`, `ghost_motion` and `shift`, and declares `now`.
//!include rng
//!include spheroid
//!include cells

// Whose ghost an invocation has, its number there, and whether there is such a ghost.
struct Whose {
    squirmer: u32,
    index: u32,
    there: bool,
}

// The ghosts of one workgroup, whose first invocation is `first`, belong to one squirmer: ghost_stride is a multiple of its size.
fn whose_ghost(first: u32, lane: u32) -> Whose {
    let i = first / system.ghost_stride;
    let index = first % system.ghost_stride + lane;
    return Whose(i, index, i < system.squirmer_count && index < species[squirmers[i].species].ghosts);
}

// Where a ghost is.
struct Site {
    // On the unit sphere, and from the squirmer's centre in cells; in the body's axes.
    direction: vec3<f32>,
    body: vec3<f32>,
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
}

struct Ghost {
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
    // Slip velocity that it carries, lab frame.
    slip: vec3<f32>,
    // Random velocity of variance kT per component.
    random: vec3<f32>,
}

// Uniform in the hull.
fn ghost_site(squirmer: u32, index: u32, kind: SpeciesUniform, orientation: vec4<f32>) -> Site {
    let u = uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 0u);
    let z = fma(2.0, u.x, -1.0);
    let ring = sqrt(max(0.0, fma(-z, z, 1.0)));
    var site: Site;
    site.direction = vec3<f32>(ring * cos(TAU * u.y), ring * sin(TAU * u.y), z);
    site.body = site.direction * hull(kind) * pow(u.z, 1.0 / 3.0);
    site.s = turn(orientation, site.body);
    return site;
}

// The slip is continued into the body as the flow outside would go on, or that of the surface point in the same direction.
fn ghost(squirmer: u32, index: u32, kind: SpeciesUniform, orientation: vec4<f32>, continued: bool) -> Ghost {
    let site = ghost_site(squirmer, index, kind, orientation);
    var g: Ghost;
    g.s = site.s;
    if continued {
        g.slip = turn(orientation, slip_inside(kind, site.body));
    } else {
        g.slip = turn(orientation, slip(kind, site.direction * hull(kind)));
    }
    g.random = system.thermal_speed * normals(uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 1u));
    return g;
}

fn moving_ghost(i: u32, g: Ghost) -> vec3<f32> {
    let linear = vec3<f32>(ghost_motion[8u * i], ghost_motion[8u * i + 1u], ghost_motion[8u * i + 2u]);
    let angular = vec3<f32>(ghost_motion[8u * i + 4u], ghost_motion[8u * i + 5u], ghost_motion[8u * i + 6u]);
    return linear + cross3(angular, g.s) + g.slip + g.random;
}

fn ghost_place(i: u32, s: vec3<f32>) -> Place {
    return locate(squirmers[i].position + to_units(s), vec3<u32>(shift[0], shift[1], shift[2]));
}
