// The ballistic path of a particle between plane walls. Time may run backwards: both wall conditions are their own inverse.
// The including file binds `system`.
//!include walls
// What a run has none of, its kernels leave out.
override FORCE: bool = true;

struct Path {
    position: vec3<u32>,
    velocity: vec3<f32>,
    // Momentum handed to the low and to the high wall.
    low: vec3<f32>,
    high: vec3<f32>,
}

fn beyond_wall(y: u32) -> bool {
    return WALLS && system.walled == 1u && (y & 0x80000000u) != 0u;
}

// Share of the displacement after which the path from y meets the wall that it crosses; 2 if it crosses none.
fn wall_share(y: u32, displacement: f32) -> f32 {
    let step = to_units(vec3<f32>(0.0, displacement, 0.0)).y;
    if !beyond_wall(y + step) {
        return 2.0;
    }
    let goal = select(0u, 0x7fffffffu, displacement > 0.0);
    return clamp(f32(bitcast<i32>(goal - y)) * system.cell_per_unit.y / displacement, 0.0, 1.0);
}

// The velocity after meeting the wall on the side to which `displacement` points, and what the wall receives.
fn reflect_at_wall(path: Path, displacement: f32) -> Path {
    var p = path;
    let high = displacement > 0.0;
    let wall = select(system.wall_low, system.wall_high, high);
    let before = p.velocity;
    if system.slip == 1u {
        p.velocity.y = -before.y;
    } else {
        p.velocity = 2.0 * wall - before;
    }
    let given = before - p.velocity;
    if high {
        p.high += given;
    } else {
        p.low += given;
    }
    p.position.y = select(0u, 0x7fffffffu, high);
    return p;
}

// Free flight for `time` (negative: backwards), reflected at walls.
fn fly(start: Path, time: f32) -> Path {
    var p = start;
    if !WALLS {
        p.position += to_units(p.velocity * time);
        return p;
    }
    var rest = time;
    for (var bounce = 0; bounce < 8; bounce++) {
        let displacement = p.velocity * rest;
        let share = wall_share(p.position.y, displacement.y);
        if share > 1.0 {
            p.position += to_units(displacement);
            return p;
        }
        p.position += to_units(displacement * share);
        p = reflect_at_wall(p, displacement.y);
        rest = fma(-share, rest, rest);
    }
    return p;
}

// Half a step of the body force. It is often no more than a few units in the last place of a velocity, and rounding to the nearest
// would then change its size for whole classes of particles: the low bits of the position decide which way to round. A whole number
// of units is added, so that no order in which a compiler adds can lose them.
fn kicked(v: vec3<f32>, position: vec3<u32>) -> vec3<f32> {
    if !FORCE {
        return v;
    }
    let kick = system.acceleration * (0.5 * system.dt);
    let dice = vec3<f32>(position.yzx & vec3<u32>(0xffffu)) * 1.52587890625e-5 + 7.62939453125e-6;
    // Distance to the next larger magnitude, or, next to rest, a small part of the kick.
    let unit = max(abs(bitcast<vec3<f32>>(bitcast<vec3<u32>>(v) + 1u) - v), abs(kick) * 1.1920928955078125e-7);
    return select(fma(floor(kick / unit + dice), unit, v), v, kick == vec3<f32>(0.0));
}
