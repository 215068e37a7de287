// Lists who waits. The including file binds `held` and `held_groups` (as atomics).
//!include held
const HELD_GROUPS_AT_MOST: u32 = 65535u;

// A workgroup of their kernel takes so many, or more if it cannot have as many workgroups as that.
fn enlist(i: u32, each: u32, step: u32) {
    let list = held_list(step);
    let k = atomicAdd(&held_groups[list + 3u], 1u);
    held[k] = i;
    if k % each == 0u && k / each < HELD_GROUPS_AT_MOST {
        atomicAdd(&held_groups[list], 1u);
    }
}

// Empties the list of the next step.
fn empty_other_list(step: u32) {
    let other = HELD_WORDS - held_list(step);
    atomicStore(&held_groups[other], 0u);
    atomicStore(&held_groups[other + 3u], 0u);
}
