// A chain of what lies in each cell: everyone leaves its number as the cell's last, and keeps the number that was there. That is one atomic
// operation, and a store beside those of its neighbours. The including file binds `chains` as atomics and `links` (read_write).
// A cell has two, in turns from step to step, so that a kernel may walk one while those of the next step join the other: `step` is the low
// word of the step, the fourth of its shift.

fn chain_of(cell: u32, step: u32) -> u32 {
    return 2u * cell + (step & 1u);
}

fn join_chain(chain: u32, i: u32) {
    links[i] = atomicExchange(&chains[chain], i + 1u);
}

// The last of a chain, counted from 1; 0 if there is none.
fn end_of_chain(chain: u32) -> u32 {
    return atomicLoad(&chains[chain]);
}

// Leaves the chain empty. Last of all: done before the chain is walked it costs a third of the sums over a cell on an H100, where more
// invocations then fit in at a time than the cache has room for what they fetch.
fn empty_chain(chain: u32) {
    atomicStore(&chains[chain], 0u);
}
