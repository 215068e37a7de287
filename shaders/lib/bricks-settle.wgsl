// Particles that have moved find their bricks. The including file binds `system`, `shift`, `bricks_xy_next`, `bricks_zu_next` and
// `bricks_vw_next` (read_write), `brick_counts_next` and `faults` as atomics.
//!include cells
//!include bricks
//!include bricks-near
//!include fault

// What becomes of an invocation's particle: there is none; it is held back, in this place; or it goes to a neighbour, as so many-th of all.
const NOBODY: u32 = 0xffffffffu;
const HELD: u32 = 0x80000000u;

// In the room of the two of them; whether they meet there is seen by who works on either of them next.
fn enter_brick(brick: u32, place: u32, p: Particle, by: Witness) {
    if place >= system.room {
        report(FAULT_ROOM, brick * BRICK_CELLS, by);
        return;
    }
    let slot = slot_of(brick, place);
    bricks_xy_next[slot] = p.position.xy;
    bricks_zu_next[slot] = vec2<u32>(p.position.z, bitcast<u32>(p.velocity.x));
    bricks_vw_next[slot] = p.velocity.yz;
}

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
        store_in_brick(slot_of(brick_number(place), what & ~HELD), p);
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
