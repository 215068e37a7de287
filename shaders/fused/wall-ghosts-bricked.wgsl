// wall-ghosts where particles lie brick by brick: the ghosts are drawn beforehand, and the workgroup that adds up a brick's sums looks at the fluid
// beside the wall, then adds theirs. The sums are those of shaders/stages/wall-ghosts.wgsl, bit by bit, since integers may be added in any order.
//!include dispatch
//!include bricks-near
//!include lanes
//!include wall-ghosts
//!include walls

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: WallGhostsSettings;
@group(0) @binding(2) var<uniform> shift: vec4<u32>;
@group(0) @binding(3) var<storage, read_write> wall_shear: array<f32>;
@group(0) @binding(4) var<storage, read_write> wall_seen: array<vec4<i32>>;
@group(0) @binding(5) var<storage, read_write> wall_ghosts: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> wall_sums: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> bricks_xy: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read_write> bricks_zu: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> bricks_vw: array<vec2<f32>>;
@group(0) @binding(10) var<storage, read_write> brick_counts: array<atomic<u32>>;
var<immediate> now: Now;

// What lies behind the walls depends on no particle.
@compute @workgroup_size(WORKGROUP)
fn draw_behind(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let first = invocation(group, groups, 0u) / LANES;
    sum_ghosts(first, lane, shift[1], settings);
    if lane < DRAWN_CELLS && wall_cell(first + lane).there {
        store_wall_ghosts(first + lane, sums_of_workgroup(lane));
    }
}

// A cell of a brick, by its numbers in the box.
fn place_of(cell: u32) -> vec3<u32> {
    return 4u * brick_place(cell / BRICK_CELLS) + vec3<u32>(cell, cell / 4u, cell / 16u) % 4u;
}

fn in_box(column: vec2<u32>) -> bool {
    return all(column < system.cells.xz);
}

// The fluid beside the wall, between the sums over the brick's particles and the ghosts: a barrier comes before those.
fn observe_brick(brick: u32, lane: u32) {
    let y = brick_place(brick).y;
    if !WALLS || settings.continued == 0u || (y > 0u && y < (system.cells.y - 2u) / 4u) {
        return;
    }
    workgroupBarrier();
    let place = place_of(brick * BRICK_CELLS + lane % BRICK_CELLS);
    if lane >= BRICK_CELLS || !in_box(place.xz) {
        return;
    }
    let s = sums_of_workgroup(lane);
    for (var wall = 0u; wall < 2u; wall++) {
        let j = select(place.y, system.cells.y - 1u - place.y, wall == 1u);
        if j < 2u {
            wall_seen[2u * wall_cell_number(wall, place.xz) + j] = vec4<i32>(seen_from_wall(wall, j, s, shift[1]), 0);
        }
    }
}

@compute @workgroup_size(BRICK_LANES)
fn observe_bricks(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    observe_brick(brick_of(group, groups), lane);
}

// The sums of a cell with those of the ghosts behind its wall.
fn filled(cell: u32, s: Sums) -> Sums {
    let place = place_of(cell);
    let wall = select(0u, 1u, place.y > 0u);
    if !WALLS || place.y != row_from_wall(wall, 0u) || !in_box(place.xz) {
        return s;
    }
    return sum_of(s, wall_ghosts_at(wall_cell_number(wall, place.xz)));
}

@compute @workgroup_size(WORKGROUP)
fn fill_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    _ = filled(invocation(group, groups, lane), Sums());
}
