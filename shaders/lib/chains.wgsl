// A chain of what lies in each cell: everyone leaves its number as the cell's last, and keeps the number that was there. That is one atomic
// operation, and a store beside those of its neighbours. The including file binds `chains` as atomics and `links` (read_write).

fn join_chain(cell: u32, i: u32) {
    links[i] = atomicExchange(&chains[cell], i + 1u);
}

// The last of a cell's chain, counted from 1; 0 if there is none.
fn end_of_chain(cell: u32) -> u32 {
    return atomicLoad(&chains[cell]);
}

// Leaves the chain empty. Last of all: done before the chain is walked it costs a third of the sums over a cell on an H100, where more
// invocations then fit in at a time than the cache has room for what they fetch.
fn empty_chain(cell: u32) {
    atomicStore(&chains[cell], 0u);
}
