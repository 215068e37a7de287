// Ghost particles inside squirmers, drawn afresh wherever they are needed: a function of (seed, step, squirmer, index).
// The including file binds `system` and declares `now`.
//!include rng
//!include spheroid

struct Ghost {
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
    // Slip velocity of the surface point at its foot, lab frame.
    slip: vec3<f32>,
    // Random velocity of variance kT per component.
    random: vec3<f32>,
}

// The surface point whose normal leads to p, inside, along the hyperbola that crosses all confocal spheroids at right angles: close to
// the surface it is the nearest point. Eccentric angle from the distances to the foci, in a plane through the axis.
fn foot(kind: SpeciesUniform, p: vec3<f32>) -> vec3<f32> {
    let rho = length(p.xy);
    let square = kind.along * kind.along - kind.across * kind.across;
    let focus = sqrt(abs(square)) * select(vec2<f32>(1.0, 0.0), vec2<f32>(0.0, 1.0), square >= 0.0);
    let far = 0.5 * (length(vec2<f32>(rho, p.z) - focus) + length(vec2<f32>(rho, p.z) + focus));
    // Sine and cosine of the angle from the pole; one of them is known well, the other follows.
    let known = min(select(rho, abs(p.z), square >= 0.0) / max(far, 1e-20), 1.0);
    let other = sqrt((1.0 - known) * (1.0 + known));
    let sine = select(known, other, square >= 0.0);
    let cosine = select(other, known, square >= 0.0);
    let height = kind.along * cosine;
    return vec3<f32>(p.xy * (kind.across * sine / max(rho, 1e-20)), select(height, -height, p.z < 0.0));
}

// Uniform in the spheroid; the slip is that of the surface point at the foot.
fn ghost(squirmer: u32, index: u32, kind: SpeciesUniform, orientation: vec4<f32>) -> Ghost {
    let u = uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 0u);
    let z = fma(2.0, u.x, -1.0);
    let ring = sqrt(max(0.0, fma(-z, z, 1.0)));
    let direction = vec3<f32>(ring * cos(TAU * u.y), ring * sin(TAU * u.y), z) * semi_axes(kind);
    let place = direction * pow(u.z, 1.0 / 3.0);
    var g: Ghost;
    g.s = turn(orientation, place);
    g.slip = turn(orientation, slip(kind, foot(kind, place)));
    g.random = system.thermal_speed * normals(uniforms(PURPOSE_SQUIRMER_GHOST, squirmer, index, 1u));
    return g;
}
