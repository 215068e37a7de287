// The 23 sums over a cell's particles, and a coarse copy of sum |v|^2 that shows when the fine one has wrapped.
// Words: 0 count, and in the high half how many of them are ghosts | 1-3 v | 4 |v|^2 (unsigned) | 5 the same, coarse | 6-8 x | 9-14 xx: xx yy zz xy xz yz | 15-23 x_i v_j, row by row.
const MOMENT_WORDS: u32 = 24u;

struct Moments {
    count: f32,
    // Whether a wall or a squirmer cuts the cell.
    ghosts: bool,
    v: vec3<f32>,
    energy: f32,
    x: vec3<f32>,
    // xx, yy, zz and xy, xz, yz of sum x x^T.
    diagonal: vec3<f32>,
    mixed: vec3<f32>,
    // Rows of sum x v^T: sum x_i v.
    xv: array<vec3<f32>, 3>,
    // Faults that the sums betray; 0 if none.
    faults: u32,
}

fn moments_of(words: array<u32, 24>) -> Moments {
    var w = words;
    var m: Moments;
    let count = w[0] & 0xffffu;
    m.count = f32(count);
    m.ghosts = w[0] > 0xffffu;
    m.v = signed3(w[1], w[2], w[3]) * system.inverse_velocity;
    m.energy = f32(w[4]) * system.inverse_energy;
    m.x = signed3(w[6], w[7], w[8]) * system.inverse_position;
    m.diagonal = signed3(w[9], w[10], w[11]) * system.inverse_second;
    m.mixed = signed3(w[12], w[13], w[14]) * system.inverse_second;
    m.xv[0] = signed3(w[15], w[16], w[17]) * system.inverse_mixed;
    m.xv[1] = signed3(w[18], w[19], w[20]) * system.inverse_mixed;
    m.xv[2] = signed3(w[21], w[22], w[23]) * system.inverse_mixed;
    m.faults = 0u;
    if count > system.max_count {
        m.faults |= FAULT_COUNT;
    }
    // Each contribution rounds by at most half a unit in either sum.
    let coarse = f32(w[5]) * system.inverse_coarse;
    if abs(coarse - m.energy) > 0.51 * m.count * system.inverse_coarse + 1e-5 * m.energy {
        m.faults |= FAULT_ENERGY;
    }
    return m;
}

fn signed3(a: u32, b: u32, c: u32) -> vec3<f32> {
    return vec3<f32>(vec3<i32>(bitcast<i32>(a), bitcast<i32>(b), bitcast<i32>(c)));
}
