// The momentum that ghosts gain in the collision is their squirmer's. The including file binds what `ghosts`, `operator-load` and `impulse` ask for.
//!include ghosts
//!include operator-load
//!include impulse
//!include workgroup-sum

// Adds what a ghost of squirmer `i` has gained to the sums of its workgroup, all of whose ghosts belong to that.
fn add_gain(i: u32, g: Ghost, place: Place, step: u32) {
    let v = moving_ghost(i, g);
    let gain = collided(operator_at(place.cell), place.offset, v) - v;
    let by = Witness(SITE_SQUIRMER_FILL, i, step);
    collect3(0u, impulse_fixed(gain, FORCE_SCALE, by));
    collect3(3u, impulse_fixed(cross3(g.s, gain), TORQUE_SCALE, by));
}

// Adds the sums of a workgroup to those of squirmer `i`.
fn hand_on_gains(i: u32, lane: u32) {
    if lane < 6u && i < system.squirmer_count {
        let share = collected(lane);
        let word = i * IMPULSE_WORDS + 2u * lane;
        let old = atomicAdd(&impulses[word], share.x);
        atomicAdd(&impulses[word + 1u], share.y + select(0u, 1u, old + share.x < old));
    }
}
