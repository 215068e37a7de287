// wall-ghosts: the parts of wall-cut cells that lie behind the wall are filled with ghosts at the wall's velocity, a Poisson
// process of the fluid's density, drawn in registers and never stored (Lamura et al. 2001, with positions).
//!include dispatch
//!include rng
//!include cells
//!include deposit
//!include operator-load
//!include wall-impulse

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read> shift: array<u32>;
@group(0) @binding(2) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read> operators: array<f32>;
@group(0) @binding(4) var<storage, read_write> wall_impulses: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> faults: array<atomic<u32>>;
var<immediate> now: Now;

// A cell cut by a wall, and the part of it behind the wall, as an interval of the offset from its centre.
struct Cut {
    cell: u32,
    wall: u32,
    low: f32,
    high: f32,
}

struct WallGhost {
    x: vec3<f32>,
    v: vec3<f32>,
}

// Invocations 0, 1, ... are the cells of the low layer, then those of the high one.
fn cut(i: u32) -> Cut {
    let layer = system.cells.x * system.cells.z;
    let wall = i / layer;
    let k = i % layer;
    // Share of a cell by which the grid is shifted: layer 0 begins that much below the low wall.
    let behind = f32(shift[1]) * system.cell_per_unit.y;
    var c: Cut;
    c.wall = wall;
    c.cell = cell_index(vec3<u32>(k % system.cells.x, wall * (system.cells.y - 1u), k / system.cells.x));
    c.low = select(-0.5, behind - 0.5, wall == 1u);
    c.high = select(behind - 0.5, 0.5, wall == 1u);
    return c;
}

// Ghost `index` arrives `gap` after the one before; the process ends when the arrivals exceed the expected number.
fn arrival(u: vec4<f32>) -> f32 {
    return -log(u.x);
}

fn wall_ghost(c: Cut, index: u32, u: vec4<f32>) -> WallGhost {
    var g: WallGhost;
    g.x = vec3<f32>(u.y - 0.5, fma(u.w, c.high - c.low, c.low), u.z - 0.5);
    let wall = select(system.wall_low, system.wall_high, c.wall == 1u);
    g.v = wall + system.thermal_speed * normals(uniforms(PURPOSE_WALL_GHOST, c.cell, index, 1u));
    return g;
}

@compute @workgroup_size(WORKGROUP)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= 2u * system.cells.x * system.cells.z {
        return;
    }
    let c = cut(i);
    let expected = system.density * (c.high - c.low);
    var time = 0.0;
    for (var index = 0u; index < system.max_count; index++) {
        let u = uniforms(PURPOSE_WALL_GHOST, c.cell, index, 0u);
        time += arrival(u);
        if time >= expected {
            break;
        }
        let g = wall_ghost(c, index, u);
        deposit(c.cell, g.x, g.v);
    }
}

// What the ghosts gain in the collision is the wall's.
@compute @workgroup_size(WORKGROUP)
fn receive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= 2u * system.cells.x * system.cells.z {
        return;
    }
    let c = cut(i);
    let expected = system.density * (c.high - c.low);
    let o = operator_at(c.cell);
    var time = 0.0;
    var gain = vec3<f32>(0.0);
    for (var index = 0u; index < system.max_count; index++) {
        let u = uniforms(PURPOSE_WALL_GHOST, c.cell, index, 0u);
        time += arrival(u);
        if time >= expected {
            break;
        }
        let g = wall_ghost(c, index, u);
        gain += collided(o, g.x, g.v) - g.v;
    }
    add_wall_impulse(i / WORKGROUP, c.wall, gain);
}
