// Ghost particles inside squirmers, drawn afresh wherever they are needed: a function of (seed, step, squirmer, index).
// The including file binds `system` and declares `now`.
//!include rng
//!include spheroid

struct Ghost {
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
    // Slip velocity of the surface point in its direction, lab frame.
    slip: vec3<f32>,
    // Random velocity of variance kT per component.
    random: vec3<f32>,
}

// Uniform in the spheroid; the surface point is the homothetic one.
fn ghost(squirmer: u32, index: u32, kind: SpeciesUniform, orientation: vec4<f32>) -> Ghost {
    let u = uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 0u);
    let z = fma(2.0, u.x, -1.0);
    let ring = sqrt(max(0.0, fma(-z, z, 1.0)));
    let direction = vec3<f32>(ring * cos(TAU * u.y), ring * sin(TAU * u.y), z) * semi_axes(kind);
    var g: Ghost;
    g.s = turn(orientation, direction * pow(u.z, 1.0 / 3.0));
    g.slip = turn(orientation, slip(kind, direction));
    g.random = system.thermal_speed * normals(uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 1u));
    return g;
}
