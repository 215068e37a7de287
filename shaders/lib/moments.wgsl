// The 23 sums over a cell's particles, and a coarse copy of sum |v|^2 that shows when the fine one has wrapped.
// Words: 0 count, and in the high half how many of them are ghosts | 1-3 v | 4 |v|^2 (unsigned) | 5 the same, coarse | 6-8 x
// | 9-14 xx: xx yy zz xy xz yz | 15-23 x_i v_j, row by row.
const MOMENT_WORDS: u32 = 24u;

// The sums in fixed point.
struct Sums {
    count: u32,
    v: vec3<i32>,
    energy: u32,
    coarse: u32,
    x: vec3<i32>,
    // xx, yy, zz and xy, xz, yz of sum x x^T.
    diagonal: vec3<i32>,
    mixed: vec3<i32>,
    // Rows of sum x v^T: sum x_i v.
    xv0: vec3<i32>,
    xv1: vec3<i32>,
    xv2: vec3<i32>,
}

struct Moments {
    count: f32,
    // Whether a wall or a squirmer cuts the cell.
    ghosts: bool,
    v: vec3<f32>,
    energy: f32,
    x: vec3<f32>,
    diagonal: vec3<f32>,
    mixed: vec3<f32>,
    xv: array<vec3<f32>, 3>,
    // Faults that the sums betray; 0 if none.
    faults: u32,
}

fn moments_of(s: Sums) -> Moments {
    var m: Moments;
    let count = s.count & 0xffffu;
    m.count = f32(count);
    m.ghosts = s.count > 0xffffu;
    m.v = vec3<f32>(s.v) * system.inverse_velocity;
    m.energy = f32(s.energy) * system.inverse_energy;
    m.x = vec3<f32>(s.x) * system.inverse_position;
    m.diagonal = vec3<f32>(s.diagonal) * system.inverse_second;
    m.mixed = vec3<f32>(s.mixed) * system.inverse_second;
    m.xv[0] = vec3<f32>(s.xv0) * system.inverse_mixed;
    m.xv[1] = vec3<f32>(s.xv1) * system.inverse_mixed;
    m.xv[2] = vec3<f32>(s.xv2) * system.inverse_mixed;
    m.faults = 0u;
    if count > system.max_count {
        m.faults |= FAULT_COUNT;
    }
    // Each contribution rounds by at most half a unit in either sum.
    let coarse = f32(s.coarse) * system.inverse_coarse;
    if abs(coarse - m.energy) > 0.51 * m.count * system.inverse_coarse + 1e-5 * m.energy {
        m.faults |= FAULT_ENERGY;
    }
    return m;
}
