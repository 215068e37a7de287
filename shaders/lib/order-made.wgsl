// Cell by cell, the particles that come next in memory: each workgroup takes the next places for those of its cells. The order of
// the workgroups is left to chance; nothing but the places depends on it. The including file binds `order` and `order_end`.
//!include dispatch

// Cells of a workgroup.
const CELLS: u32 = WORKGROUP / LANES;
var<workgroup> ends: array<u32, CELLS>;
var<workgroup> begin: u32;

// The place of a cell's first particle. All invocations of a workgroup ask together.
fn first_place(cell: u32, part: u32, count: u32) -> u32 {
    let mine = cell % CELLS;
    if part == 0u {
        ends[mine] = count;
    }
    workgroupBarrier();
    if mine == 0u && part == 0u {
        var sum = 0u;
        for (var k = 0u; k < CELLS; k++) {
            sum += ends[k];
            ends[k] = sum;
        }
        begin = atomicAdd(&order_end[0], sum);
        // The last ones leave it as it was.
        if begin + sum == system.particle_count {
            atomicStore(&order_end[0], 0u);
        }
    }
    workgroupBarrier();
    return begin + ends[mine] - count;
}

fn put_in_order(place: u32, particle: u32) {
    order[place] = particle;
}
