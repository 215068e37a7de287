//! sort-reorder: the same particles in the order of their cells, and nothing else, ever.

use crate::bench::*;
use crate::collision::active_slit;
use crate::rig;
use squirm::params::Value;

#[test]
fn particles_are_sorted_and_otherwise_the_same() {
    // More cells than one block of the prefix sum, and a slit.
    for (size, walled) in [([5, 6, 7], true), ([16, 16, 16], false), ([13, 11, 17], true)] {
        let mut system = rig::system(size);
        system.domain.walls = walled.then(rig::walls);
        let start = state(gas(&system, 12, 20_000), Vec::new());
        let mut bench = Bench::new(&system, &start, &["shift-grid", "sort-reorder"], &[]);
        bench.run_all(&["shift-grid"]);
        let cells = |bench: &Bench| {
            let particles = bench.state().particles;
            particles.iter().map(|p| bench.scene.locate(&system, p.position).0).collect::<Vec<_>>()
        };
        assert!(!cells(&bench).is_sorted());
        let digest = bench.session.raw().expect("readable").digest();
        bench.run("sort-reorder");
        assert!(cells(&bench).is_sorted());
        assert_eq!(bench.session.raw().expect("readable").digest(), digest);
        let reference: Vec<usize> =
            bench.scene.state.particles.iter().map(|p| bench.scene.locate(&system, p.position).0).collect();
        assert_eq!(cells(&bench), reference);
    }
}

/// Every stage for 20 steps, sorted in each, at the first only, and never: the same bits.
#[test]
fn sorting_changes_no_bit_of_a_trajectory() {
    let (system, start) = active_slit();
    let unsorted: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| *k != "sort-reorder").collect();
    let runs = [(rig::EVERYTHING, 1), (rig::EVERYTHING, 50), (unsorted.as_slice(), 1)].map(|(kinds, every)| {
        let mut bench = Bench::new(&system, &start, kinds, &[("sort-reorder", "every", Value::Integer(every))]);
        bench.session.advance(20, false);
        let raw = bench.session.raw().expect("readable");
        assert_eq!(bench.faults(), 0);
        bench.adopt();
        (raw.digest(), raw.positions, bench.wall_impulses(), bench.words("fluid_force"))
    });
    let [every, once, never] = &runs;
    assert_eq!((&every.0, &every.2, &every.3), (&once.0, &once.2, &once.3));
    assert_eq!((&every.0, &every.2, &every.3), (&never.0, &never.2, &never.3));
    // They do differ in memory.
    assert!(every.1 != once.1 && once.1 != never.1);
}
