// Particles, or bricks with some, that wait for a kernel of their own, which has as many workgroups as they need. The including file binds `held`,
// their numbers, and `held_groups`; there are two lists, one for even steps and one for odd ones.
//!include dispatch

// Words of a list in `held_groups`: workgroups along x, y and z, as an indirect dispatch wants them, then how many wait.
const HELD_WORDS: u32 = 4u;

fn held_list(step: u32) -> u32 {
    return HELD_WORDS * (step & 1u);
}
