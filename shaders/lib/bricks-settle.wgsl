// Particles that have moved find their bricks. The including file binds `system`, `shift`, `bricks_xy_next`, `bricks_zu_next` and
// `bricks_vw_next` (read_write), `brick_counts_next` and `faults` as atomics.
//!include cells
//!include bricks
//!include fault

// Numbers below are a brick and its 26 neighbours, this one any other.
const FAR: u32 = 27u;
// What becomes of an invocation's particle: there is none; it is held back, in this place; or it goes to a neighbour, as so many-th of all.
const NOBODY: u32 = 0xffffffffu;
const HELD: u32 = 0x80000000u;

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

fn enter_brick(brick: u32, place: u32, p: Particle, by: Witness) {
    if place >= system.room {
        report(FAULT_ROOM, brick * BRICK_CELLS, by);
        return;
    }
    let slot = brick * system.room + place;
    bricks_xy_next[slot] = p.position.xy;
    bricks_zu_next[slot] = vec2<u32>(p.position.z, bitcast<u32>(p.velocity.x));
    bricks_vw_next[slot] = p.velocity.yz;
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

// Nobody is on the way yet. To be followed by a barrier.
fn clear_going(lane: u32) {
    if lane < FAR {
        atomicStore(&going[lane], 0u);
    }
    if lane == 0u {
        atomicStore(&held_back, 0u);
    }
}

// A particle makes ready to go to the brick where it is now; `place` is that of the brick where it was.
fn leave(p: Particle, place: vec3<u32>) -> u32 {
    let number = neighbour_number(place, brick_place_at(p.position));
    if number == FAR {
        return FAR;
    }
    return atomicAdd(&going[number], 1u) * 32u + number;
}

fn hold() -> u32 {
    return HELD | atomicAdd(&held_back, 1u);
}

// Between leaving and arriving.
fn ask_for_places(place: vec3<u32>, lane: u32) {
    workgroupBarrier();
    if lane < FAR {
        let count = atomicExchange(&going[lane], 0u);
        if count > 0u {
            places[lane] = atomicAdd(&brick_counts_next[neighbour(place, lane)], count);
        }
    }
    workgroupBarrier();
}

// The particle takes the place that it has been given; `step` is the one for whose collision it comes there.
fn arrive(what: u32, p: Particle, place: vec3<u32>, i: u32, step: u32) {
    if what == NOBODY {
        return;
    }
    if what >= HELD {
        store_in_brick(brick_number(place) * system.room + (what & ~HELD), p);
        return;
    }
    let number = what % 32u;
    var brick: u32;
    var rank: u32;
    if number == FAR {
        brick = brick_number(brick_place_at(p.position));
        rank = atomicAdd(&brick_counts_next[brick], 1u);
    } else {
        brick = neighbour(place, number);
        rank = places[number] + what / 32u;
    }
    enter_brick(brick, rank, p, Witness(SITE_CELL_REDUCE, i, step));
}
