// What went wrong, and where first. The including file binds `faults` as atomics.
// Words: 0 flags | of the first fault that stops a run: 1 where in the step it was seen, 2 cell + 1, 3 particle or squirmer + 1, 4 number of the
// step, counted from 1, low word; 0 where unknown.
const UNKNOWN: u32 = 0xffffffffu;

// Who saw it: where in the step, with which particle or squirmer, in which step, counted from 0.
struct Witness {
    site: u32,
    owner: u32,
    step: u32,
}

fn report(fault: u32, cell: u32, by: Witness) {
    let before = atomicOr(&faults[0], fault);
    if fault != FAULT_STUCK && (before & ~FAULT_STUCK) == 0u {
        atomicStore(&faults[1], by.site);
        atomicStore(&faults[2], cell + 1u);
        atomicStore(&faults[3], by.owner + 1u);
        atomicStore(&faults[4], by.step + 1u);
    }
}
