// Ghost particles inside squirmers. The including file binds `system`, `species`, `squirmers`, `ghosts`, `ghosts_yz` and `ghost_motion`.
//!include cells
//!include exact

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
