// The 23 sums over a cell's particles, and a coarse copy of sum |v|^2 that shows when the fine one has wrapped.
// Words: 0 count, and from bit `coarse_bit` on the coarse copy | 1-3 v | 4 |v|^2 (unsigned) | 5 how many are ghosts | 6-8 x
// | 9-14 xx: xx yy zz xy xz yz | 15-23 x_i v_j, row by row.
//!include energies
const MOMENT_WORDS: u32 = 24u;

// The sums in fixed point.
struct Sums {
    // Particles and ghosts, and sum |v|^2 in coarse units above them.
    count: u32,
    v: vec3<i32>,
    energy: u32,
    ghosts: u32,
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

// How many there are, of the first word of the sums.
fn number_in(count: u32) -> u32 {
    return count & ((1u << system.coarse_bit) - 1u);
}

fn moments_of(s: Sums) -> Moments {
    var m: Moments;
    let count = number_in(s.count);
    m.count = f32(count);
    m.ghosts = s.ghosts > 0u;
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
    let coarse = f32(s.count >> system.coarse_bit) * system.inverse_coarse;
    if ENERGIES && abs(coarse - m.energy) > 0.51 * m.count * system.inverse_coarse + 1e-5 * m.energy {
        m.faults |= FAULT_ENERGY;
    }
    return m;
}
