// Lists who waits. The including file binds `held` and `held_groups` (as atomics).
//!include held
const HELD_GROUPS_AT_MOST: u32 = 65535u;

// Workgroups for so many entries: one for so many each, or for more if there cannot be as many workgroups as that.
fn groups_for(entries: u32, each: u32) -> u32 {
    return min((entries + each - 1u) / each, HELD_GROUPS_AT_MOST);
}

// Room in the list for so many entries: where the first of them goes.
fn room_in_list(entries: u32, each: u32, step: u32) -> u32 {
    let list = held_list(step);
    let first = atomicAdd(&held_groups[list + 3u], entries);
    let more = groups_for(first + entries, each) - groups_for(first, each);
    if more > 0u {
        atomicAdd(&held_groups[list], more);
    }
    return first;
}

fn enlist(i: u32, each: u32, step: u32) {
    held[room_in_list(1u, each, step)] = i;
}

// Empties the list of the next step.
fn empty_other_list(step: u32) {
    let other = HELD_WORDS - held_list(step);
    atomicStore(&held_groups[other], 0u);
    atomicStore(&held_groups[other + 3u], 0u);
}
