// Lists particles that wait. The including file binds `held` and `held_groups` (as atomics).
//!include held
const HELD_GROUPS_AT_MOST: u32 = 65535u;

fn hold(i: u32) {
    let list = held_list();
    let k = atomicAdd(&held_groups[list + 3u], 1u);
    held[k] = i;
    if k % WORKGROUP == 0u && k / WORKGROUP < HELD_GROUPS_AT_MOST {
        atomicAdd(&held_groups[list], 1u);
    }
}

// Empties the list of the next step.
fn empty_other_list() {
    let other = HELD_WORDS - held_list();
    atomicStore(&held_groups[other], 0u);
    atomicStore(&held_groups[other + 3u], 0u);
}
