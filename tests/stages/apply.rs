//! apply: every particle by the map of its cell.

use crate::bench::*;
use crate::rig;
use glam::DMat3;

#[test]
fn particles_receive_the_map_of_their_cell() {
    let mut system = rig::system([5, 6, 7]);
    system.domain.walls = Some(rig::walls());
    let start = state(gas(&system, 8, 2100), Vec::new());
    let kinds = ["shift-grid", "cell-reduce", "rotate", "restore-thermostat", "apply"];
    let mut bench = Bench::new(&system, &start, &kinds, &[]);
    bench.run_all(&kinds[..4]);
    let before = bench.scene.state.particles.clone();
    bench.run("apply");
    let mut changed = 0;
    for ((found, wanted), old) in bench.state().particles.iter().zip(&bench.scene.state.particles).zip(&before) {
        assert_eq!(found.position, wanted.position);
        let (cell, offset) = bench.scene.locate(&system, old.position);
        let o = &bench.scene.operators[cell];
        let size = |m: DMat3| DMat3::from_cols_array(&m.to_cols_array().map(f64::abs));
        // Seven products and sums, each rounded once.
        let terms = size(o.a) * old.velocity.abs() + o.w.abs().cross(offset.abs()).abs() + o.b.abs();
        let scale = terms.max_element() + o.w.length() * offset.length();
        assert!((found.velocity - wanted.velocity).abs().max_element() <= 8.0 * ROUNDING * scale);
        changed += usize::from(found.velocity != old.velocity);
    }
    assert!(changed > 2000, "{changed}");
}
