// Draws ghosts inside squirmers: functions of (seed, step, squirmer, index). The including file binds `system` and declares `now`.
//!include rng
//!include spheroid

struct Drawn {
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
    // Slip velocity that it carries, lab frame.
    slip: vec3<f32>,
    // Random velocity of variance kT per component.
    random: vec3<f32>,
}

// Uniform in the hull. The slip is continued into the body as the flow outside would go on, or that of the surface point in the same direction.
fn drawn_ghost(squirmer: u32, index: u32, kind: SpeciesUniform, orientation: vec4<f32>, continued: bool) -> Drawn {
    let drawn = seven(words(PURPOSE_SQUIRMER_GHOST, squirmer, index, 0u));
    let u = drawn.place;
    let z = fma(2.0, u.x, -1.0);
    let ring = sqrt(max(0.0, fma(-z, z, 1.0)));
    let direction = vec3<f32>(ring * cos(TAU * u.y), ring * sin(TAU * u.y), z);
    let share = pow(u.z, 1.0 / 3.0);
    var g: Drawn;
    g.s = turn(orientation, direction * hull(kind) * share);
    if continued {
        g.slip = turn(orientation, slip_inside(kind, direction, share));
    } else {
        g.slip = turn(orientation, slip(kind, direction));
    }
    g.random = system.thermal_speed * normals(drawn.motion);
    return g;
}
