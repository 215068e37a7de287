// Ghost particles inside squirmers. The including file binds `system`, `species`, `squirmers`, `ghosts`, `ghosts_yz` and `ghost_motion`.
//!include cells
//!include exact
//!include spheroid

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

// Where `ghost_motion` has the number of a squirmer's ghosts that take part, if only these are kept.
const KEPT: u32 = 3u;

// As `whose_ghost`, where only ghosts that take part are kept, in the first places of their squirmer.
fn whose_kept_ghost(first: u32, lane: u32) -> Whose {
    let i = first / system.ghost_stride;
    let index = first % system.ghost_stride + lane;
    return Whose(i, index, i < system.squirmer_count && index < u32(ghost_motion[8u * i + KEPT]));
}

struct Ghost {
    // From the squirmer's centre, lab frame, in cells.
    s: vec3<f32>,
    // Its velocity relative to the rigid motion of all ghosts of its squirmer: random, and the slip that it carries.
    v: vec3<f32>,
}

fn ghost_at(k: u32) -> Ghost {
    let g = ghosts[k];
    return Ghost(g.xyz, vec3<f32>(g.w, ghosts_yz[k]));
}

fn moving_ghost(i: u32, g: Ghost) -> vec3<f32> {
    let linear = vec3<f32>(ghost_motion[8u * i], ghost_motion[8u * i + 1u], ghost_motion[8u * i + 2u]);
    let angular = vec3<f32>(ghost_motion[8u * i + 4u], ghost_motion[8u * i + 5u], ghost_motion[8u * i + 6u]);
    return linear + cross3(angular, g.s) + g.v;
}

// On the grid moved so far.
fn ghost_place(i: u32, s: vec3<f32>, moved: vec3<u32>) -> Place {
    return locate(squirmers[i].position + to_units(s), moved);
}

// How far a ghost's cell reaches from its squirmer's centre, squared and in units of the hull: below 1 all of it lies inside. `s` as above, `offset` from
// the cell's centre. With c the centre in units of the semi-axes b and h half a diagonal, |c + h|^2 <= |c|^2 + 2 c.h + 3/(4 b_min^2); 2 c.h is
// largest for the corner on c's side.
fn reach_of_cell(i: u32, s: vec3<f32>, offset: vec3<f32>) -> f32 {
    let by_b = 1.0 / hull(species[squirmers[i].species]);
    let q = squirmers[i].orientation;
    let c = turn_back(q, s - offset) * by_b;
    let slope = abs(turn(q, c * by_b));
    let most = max(by_b.x, by_b.z);
    return dot3(c, c) + slope.x + slope.y + slope.z + 0.75 * most * most;
}

// Whether anything but its own squirmer's ghosts can be in a ghost's cell. If not, collisions there change neither momentum nor angular momentum, so
// that such ghosts need not take part.
fn may_meet(i: u32, s: vec3<f32>, offset: vec3<f32>) -> bool {
    return reach_of_cell(i, s, offset) > 1.0;
}

// Whoever took part is among them, however a compiler rounds; others gain nothing in a cell where nobody collides.
fn may_have_met(i: u32, s: vec3<f32>, offset: vec3<f32>) -> bool {
    return reach_of_cell(i, s, offset) > 0.9999;
}
