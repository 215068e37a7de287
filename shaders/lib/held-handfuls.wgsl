// Those who wait in the first places of their brick, by handfuls: an entry of the list is twice the place of the last of HANDFUL, or of as many as are
// left, and 1 for a brick that fills its room from the end. A room is whole handfuls from either end, so that one of them lies in one of these.
//!include held
//!include bricks

override HANDFUL: u32;

// Entries for which a workgroup has invocations.
fn handfuls_of_workgroup() -> u32 {
    return WORKGROUP / HANDFUL;
}

// The entry of the handful of which the last is in the k-th place of the brick.
fn handful_up_to(brick: u32, k: u32) -> u32 {
    return 2u * slot_of(brick, k) + brick % 2u;
}

// A place, and whether one who waits is there.
struct Waiting {
    slot: u32,
    there: bool,
}

// The place of which an invocation takes care.
fn waiting_in(handful: u32, lane: u32) -> Waiting {
    let last = handful / 2u;
    let slot = last / HANDFUL * HANDFUL + lane % HANDFUL;
    return Waiting(slot, select(slot <= last, slot >= last, handful % 2u == 1u));
}
