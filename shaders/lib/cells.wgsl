// Positions as u32 fractions of a turn, and the cells they lie in: exact, with wrap-around and minimum image for free.
// The including file binds `system`.
//!include nearest
//!include split
struct Place {
    cell: u32,
    // From the cell's centre, in cells: -0.5 <= offset < 0.5.
    offset: vec3<f32>,
}

fn from_centre(fraction: u32) -> f32 {
    return f32(bitcast<i32>(fraction ^ 0x80000000u)) * 2.3283064365386963e-10;
}

// Cells are numbered brick by brick, 4 x 4 x 4 cells each: neighbours in space are mostly neighbours in memory.
fn cell_index(c: vec3<u32>) -> u32 {
    let bricks = (system.cells + 3u) / 4u;
    let b = c / 4u;
    let w = c % 4u;
    return ((b.z * bricks.y + b.y) * bricks.x + b.x) * 64u + w.z * 16u + w.y * 4u + w.x;
}

// Of a position on the grid moved by `shift`: its cell along each axis, and how far it is from the centre of that.
struct Spot {
    cell: vec3<u32>,
    offset: vec3<f32>,
}

fn spot(position: vec3<u32>, shift: vec3<u32>) -> Spot {
    let p = position + shift;
    let x = split(p.x, system.period.x);
    let y = split(p.y, system.period.y);
    let z = split(p.z, system.period.z);
    return Spot(vec3<u32>(x.x, y.x, z.x), vec3<f32>(from_centre(x.y), from_centre(y.y), from_centre(z.y)));
}

// Its place there.
fn locate(position: vec3<u32>, shift: vec3<u32>) -> Place {
    let s = spot(position, shift);
    // Across a slit the coordinate can leave the grid only if a particle left the box: keep the index in bounds.
    return Place(cell_index(vec3<u32>(s.cell.x, min(s.cell.y, system.cells.y - 1u), s.cell.z)), s.offset);
}

// The same with the cell's number in its brick.
fn locate_in_brick(position: vec3<u32>, shift: vec3<u32>) -> Place {
    let s = spot(position, shift);
    let w = s.cell & vec3<u32>(3u);
    return Place(w.z * 16u + w.y * 4u + w.x, s.offset);
}

// A displacement in cells as coordinate units, rounded to the nearest.
fn to_units(displacement: vec3<f32>) -> vec3<u32> {
    return nearest3(displacement * system.units);
}

// The shortest vector from b to a, in cells.
fn separation(a: vec3<u32>, b: vec3<u32>) -> vec3<f32> {
    return vec3<f32>(bitcast<vec3<i32>>(a - b)) * system.cell_per_unit;
}
