// Lists who waits in the first places of a brick. The including file binds what `held-store` asks for.
//!include held-store
//!include held-handfuls

var<workgroup> handfuls_first: u32;
var<workgroup> handfuls_left: u32;

// Lists the handful that is so many-th of its brick, if there is one.
fn enlist_handful(brick: u32, nth: u32, left: u32) {
    let k = HANDFUL * nth;
    if k < left {
        held[handfuls_first + nth] = handful_up_to(brick, min(k + HANDFUL, left) - 1u);
    }
}

// All of the workgroup list those whom it has held back, once all are. HANDFUL is such that three entries for each invocation are enough, unless a cell
// has more than some 380 particles. A loop would take more registers than all before.
fn enlist_handfuls(brick: u32, lane: u32, step: u32) {
    if lane == 0u {
        let left = atomicLoad(&held_back);
        handfuls_left = left;
        if left > 3u * BRICK_LANES * HANDFUL {
            report(FAULT_ROOM, brick * BRICK_CELLS, Witness(SITE_CELL_REDUCE, UNKNOWN, step));
        }
        if left > 0u {
            handfuls_first = room_in_list((left + HANDFUL - 1u) / HANDFUL, handfuls_of_workgroup(), step);
        }
    }
    let left = workgroupUniformLoad(&handfuls_left);
    enlist_handful(brick, lane, left);
    enlist_handful(brick, lane + BRICK_LANES, left);
    enlist_handful(brick, lane + 2u * BRICK_LANES, left);
}
