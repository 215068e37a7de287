//! No kernel touches what lies beyond the end of its buffers as the catalogue has them: writes there are dropped without a word.

use crate::bench::Change;
use crate::collision::{active_slit, continued};
use crate::rig;
use squirm::buffers::Gathering;
use squirm::gpu::{Form, Gpu, Session};

const ROOM: u64 = 4096;
const POISON: u8 = 0xb7;

/// Where every buffer ends by the catalogue, and all that lies beyond.
fn tails(session: &Session) -> Vec<(&'static str, usize, Vec<u8>)> {
    let tail = |(name, bytes): (&'static str, u64)| {
        let end = usize::try_from(bytes).expect("small");
        let content = session.read::<u8>(name).expect("a readable buffer");
        (name, end, content[end..].to_vec())
    };
    session.buffers().map(tail).collect()
}

#[test]
fn no_stage_writes_or_reads_beyond_its_buffers() {
    stays_within(rig::gpu(), &[], Form::Loose);
    stays_within(rig::gpu(), &continued(), Form::Loose);
    for gathering in [Gathering::Chains, Gathering::Bricks] {
        let mut gpu = rig::gpu().clone();
        gpu.gathering = Some(gathering);
        stays_within(&gpu, &continued(), Form::Fused);
    }
}

fn stays_within(gpu: &Gpu, changes: &[Change], form: Form) {
    let (system, state) = active_slit();
    let plan = rig::plan(&system, rig::EVERYTHING, changes);
    let mut watched = Session::with_room(gpu, &plan, &state, (form, ROOM)).expect("a session");
    let mut seen = 0;
    for (name, bytes) in watched.buffers() {
        let mut content = watched.read::<u8>(name).expect("a readable buffer");
        content[usize::try_from(bytes).expect("small")..].fill(POISON);
        assert!(content.len() as u64 >= bytes + ROOM);
        watched.write(name, &content);
        seen += 1;
    }
    assert!(seen > 15, "{seen}");
    watched.advance(5, false);
    for (name, end, tail) in tails(&watched) {
        let touched = tail.iter().position(|b| *b != POISON);
        assert_eq!(touched, None, "`{name}` has {end} bytes, and something wrote beyond them");
    }
    // Had something read there, the poison would have changed the run.
    let mut plain = Session::formed(gpu, &plan, &state, form).expect("a session");
    plain.advance(5, false);
    assert_eq!(watched.raw().expect("readable").digest(), plain.raw().expect("readable").digest());
    // What lies in the memory of others has gone by now.
    let lodging = squirm::buffers::lodgers(|name| plain.buffers().any(|(other, _)| other == name), plain.sizes());
    for (name, bytes) in plain.buffers() {
        let (with, without) = (watched.read::<u8>(name).expect("bytes"), plain.read::<u8>(name).expect("bytes"));
        let end = usize::try_from(bytes).expect("small");
        // Order in memory and lists filled by atomic counters may differ.
        let ordered =
            ["squirmers", "fluid_force", "steric", "ghost_sums", "ghost_motion", "moments", "operators", "wall_shear"];
        assert!(
            lodging.contains(&name) || !ordered.contains(&name) || with[..end] == without[..end],
            "`{name}` differs"
        );
    }
}
