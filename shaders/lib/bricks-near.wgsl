// A brick and its neighbours, and how many of a workgroup's particles go to each. The including file binds `system` and `shift`.
//!include cells
//!include bricks

// Numbers below are a brick and its 26 neighbours, this one any other.
const FAR: u32 = 27u;

fn brick_place(brick: u32) -> vec3<u32> {
    let n = bricks_per_axis();
    return vec3<u32>(brick % n.x, brick / n.x % n.y, brick / (n.x * n.y));
}

fn brick_number(place: vec3<u32>) -> u32 {
    let n = bricks_per_axis();
    return (place.z * n.y + place.y) * n.x + place.x;
}

// Which of a brick and its neighbours around the periodic box another brick is, with both as places. What is below 0 is a large number.
fn neighbour_number(place: vec3<u32>, other: vec3<u32>) -> u32 {
    let n = bricks_per_axis();
    var d = other - (place - 1u);
    d = min(d, d + n);
    d = min(d, d - n);
    return select(d.z * 9u + d.y * 3u + d.x, FAR, any(d > vec3<u32>(2u)));
}

// The brick that is this neighbour.
fn neighbour(place: vec3<u32>, number: u32) -> u32 {
    let n = bricks_per_axis();
    var p = place + vec3<u32>(number % 3u, number / 3u % 3u, number / 9u) + n - 1u;
    p = select(p, p - n, p >= n);
    p = select(p, p - n, p >= n);
    return brick_number(p);
}

// The place of the brick that a position is in: that of its cell, without divisions.
fn brick_place_at(position: vec3<u32>) -> vec3<u32> {
    let p = position + vec3<u32>(shift[0], shift[1], shift[2]);
    let y = min(split(p.y, system.period.y).x, system.cells.y - 1u);
    return vec3<u32>(split(p.x, system.period.x).x, y, split(p.z, system.period.z).x) / 4u;
}

// How many of the workgroup's particles go to each neighbour, and the first place that they have there.
var<workgroup> going: array<atomic<u32>, 27>;
var<workgroup> places: array<u32, 27>;
