// Particles that have moved find their bricks. The including file binds `system`, `shift`, `bricks_xy_next`, `bricks_zu_next` and
// `bricks_vw_next` (read_write), `brick_counts_next` and `faults` as atomics.
//!include cells
//!include bricks
//!include fault

// Numbers below are a brick and its 26 neighbours, this one any other.
const FAR: u32 = 27u;

fn brick_place(brick: u32) -> vec3<u32> {
    let n = bricks_per_axis();
    return vec3<u32>(brick % n.x, brick / n.x % n.y, brick / (n.x * n.y));
}

// Which of a brick and its neighbours around the periodic box another brick is, with both as places.
fn neighbour_number(place: vec3<u32>, other: vec3<u32>) -> u32 {
    let n = bricks_per_axis();
    var d = select(other + 1u - place, other + 1u + n - place, other + 1u < place);
    d = select(d, d - n, d >= n);
    return select(d.z * 9u + d.y * 3u + d.x, FAR, any(d > vec3<u32>(2u)));
}

// The brick that is this neighbour.
fn neighbour(place: vec3<u32>, number: u32) -> u32 {
    let n = bricks_per_axis();
    var p = place + vec3<u32>(number % 3u, number / 3u % 3u, number / 9u) + n - 1u;
    p = select(p, p - n, p >= n);
    p = select(p, p - n, p >= n);
    return (p.z * n.y + p.y) * n.x + p.x;
}

fn enter_brick(brick: u32, place: u32, p: Particle, i: u32) {
    if place >= system.room {
        report(FAULT_ROOM, brick * BRICK_CELLS, Witness(SITE_CELL_REDUCE, i, now.step_low));
        return;
    }
    let slot = brick * system.room + place;
    bricks_xy_next[slot] = p.position.xy;
    bricks_zu_next[slot] = vec2<u32>(p.position.z, bitcast<u32>(p.velocity.x));
    bricks_vw_next[slot] = p.velocity.yz;
}

fn brick_at(position: vec3<u32>) -> u32 {
    return locate(position, vec3<u32>(shift[0], shift[1], shift[2])).cell / BRICK_CELLS;
}

// How many of the workgroup's particles go to each neighbour, and the first place that they have there.
var<workgroup> going: array<atomic<u32>, 27>;
var<workgroup> places: array<u32, 27>;

// Every invocation's particle, if it has one, into the brick where it is now; `place` is that of the brick where it was.
fn settle_in_brick(has_one: bool, p: Particle, i: u32, place: vec3<u32>, lane: u32) {
    var to = 0u;
    var number = FAR;
    var rank = 0u;
    if has_one {
        to = brick_at(p.position);
        number = neighbour_number(place, brick_place(to));
    }
    if has_one && number != FAR {
        rank = atomicAdd(&going[number], 1u);
    }
    workgroupBarrier();
    if lane < FAR {
        let count = atomicExchange(&going[lane], 0u);
        if count > 0u {
            places[lane] = atomicAdd(&brick_counts_next[neighbour(place, lane)], count);
        }
    }
    workgroupBarrier();
    if has_one {
        if number == FAR {
            rank = atomicAdd(&brick_counts_next[to], 1u);
        } else {
            rank += places[number];
        }
        enter_brick(to, rank, p, i);
    }
}
