// rotate: velocities relative to the cell's mean turn about a random axis (Malevanets and Kapral 1999): A = R, W = 0. Where a cell
// holds ghosts they turn further.
//!include dispatch
//!include rng
//!include moments-load
//!include operator-store
//!include fault

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: RotateSettings;
@group(0) @binding(2) var<storage, read> moments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> operators: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// The map that the stage makes anew, whatever there was before.
fn rotated(cell: u32, m: Moments, before: Operator) -> Operator {
    // Here and not where they are needed: a compiler that knows them does not draw them again for the thermostat.
    let drawn = words(PURPOSE_COLLISION, cell, 0u, 0u);
    if m.faults != 0u {
        report(m.faults, cell, Witness(SITE_ROTATE, UNKNOWN, now.step_low));
    }
    var o = no_collision();
    if m.count >= 2.0 {
        let cos = select(settings.cos, settings.ghost_cos, m.ghosts);
        let sin = select(settings.sin, settings.ghost_sin, m.ghosts);
        let one_minus_cos = select(settings.one_minus_cos, settings.ghost_one_minus_cos, m.ghosts);
        o = rotation(random_axis(drawn), cos, sin, one_minus_cos);
        let vc = vec3<f32>(divide(m.v.x, m.count), divide(m.v.y, m.count), divide(m.v.z, m.count));
        o.b = centred(o, vc, vec3<f32>(0.0));
    }
    return o;
}

@compute @workgroup_size(WORKGROUP)
fn rotate(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        store_operator(cell, rotated(cell, moments_at(cell), no_collision()));
    }
}

// Uniform on the unit sphere, from the first two of a cell's random words.
fn random_axis(drawn: vec4<u32>) -> vec3<f32> {
    let u = vec2<f32>(unit(drawn.x), unit(drawn.y));
    let z = fma(2.0, u.x, -1.0);
    let r = sqrt(max(0.0, fma(-z, z, 1.0)));
    return unit_vector(vec3<f32>(r * cos(TAU * u.y), r * sin(TAU * u.y), z));
}

// Rodrigues: R = c 1 + s [e]x + (1 - c) e e^T.
fn rotation(e: vec3<f32>, c: f32, sin: f32, one_minus_cos: f32) -> Operator {
    let f = e * one_minus_cos;
    let g = e * sin;
    var o = no_collision();
    o.a[0] = vec3<f32>(fma(f.x, e.x, c), fma(f.x, e.y, -g.z), fma(f.x, e.z, g.y));
    o.a[1] = vec3<f32>(fma(f.y, e.x, g.z), fma(f.y, e.y, c), fma(f.y, e.z, -g.x));
    o.a[2] = vec3<f32>(fma(f.z, e.x, -g.y), fma(f.z, e.y, g.x), fma(f.z, e.z, c));
    return o;
}
