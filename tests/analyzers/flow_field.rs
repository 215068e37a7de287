//! Flow fields: rigid rotation about a squirmer, averages by mass, and pairs of fields and squirmers.

use super::{close, fields, make, squirmers, stamp, table, take, text};
use glam::DVec3;
use squirm::analyze::Report;
use squirm::params::Value;
use squirm::wire::{Fields, Squirmers};

const EDGE: [f64; 3] = [24.0; 3];
const DRIFT: DVec3 = DVec3::new(0.125, -0.25, 0.0625);

/// A rigid rotation about an axis through a place, with a drift, in a periodic box.
fn rotating(centre: DVec3, spin: DVec3) -> Fields {
    fields([24; 3], 1, 10.0, |r| {
        let r = DVec3::from_array(r) - centre;
        let r = r - 24.0 * (r / 24.0).round();
        (DRIFT + spin.cross(r)).to_array()
    })
}

fn body(centre: DVec3, axis: DVec3) -> Squirmers {
    let mut body = squirmers(&[centre.as_vec3().to_array()], &[axis.as_vec3().to_array()], 3.0, 2.0);
    body.velocity = vec![DRIFT.as_vec3().to_array()];
    body
}

fn analyzed(fluid: &Fields, body: &Squirmers, options: &[(&'static str, Value)]) -> Report {
    let mut analyzer = make("flow-field", options);
    for seq in 0..4 {
        take(analyzer.as_mut(), &fluid.encode(&stamp(seq, EDGE, false))).unwrap();
        take(analyzer.as_mut(), &body.encode(&stamp(seq, EDGE, false))).unwrap();
    }
    analyzer.finish().unwrap()
}

/// Near a corner of the box, so that most neighbours are images.
const CENTRE: DVec3 = DVec3::new(23.5, 1.0, 12.25);

#[test]
fn a_rigid_rotation_is_azimuthal_in_the_frame_of_the_body() {
    let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
    let spin = 0.0625;
    let fluid = rotating(CENTRE, spin * axis);
    let report = analyzed(&fluid, &body(CENTRE, axis), &[("velocity", text("relative")), ("reach", Value::Float(8.0))]);
    let rows = table(&report, "body.csv");
    assert!(rows.len() > 80, "{} of the 8 x 16 bins less the body", rows.len());
    for row in &rows {
        let (rho, z) = (row["rho [a]"], row["z [a]"]);
        // The middles of blocks lie anywhere in a bin; f32 in the snapshot.
        let (low, high) = (spin * (rho - 0.5) - 1e-6, spin * (rho + 0.5) + 1e-6);
        assert!((low..high).contains(&row["v_phi [sqrt(kT/m)]"]), "{row:?}");
        close(row["v_rho [sqrt(kT/m)]"], 0.0, 1e-6);
        close(row["v_z [sqrt(kT/m)]"], 0.0, 1e-6);
        close(row["v_phi [sqrt(kT/m)] error"], 0.0, 1e-12);
        assert!(((rho + 0.5) / 2.0).powi(2) + ((z.abs() + 0.5) / 3.0).powi(2) >= 1.0, "inside the body: {row:?}");
    }
    // Around the body lies what its cylinder holds, less the body: 10 per cell, within the grain of cells at its surfaces.
    let mass: f64 = rows.iter().map(|r| r["mass seen [m]"]).sum::<f64>() / 4.0;
    let volume = std::f64::consts::PI * (64.0 * 16.0 - 4.0 / 3.0 * 3.0 * 4.0);
    assert!((mass / (10.0 * volume) - 1.0).abs() < 0.03, "{mass} {volume}");
}

#[test]
fn without_relative_the_drift_along_the_axis_remains() {
    let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
    let report = analyzed(&rotating(CENTRE, DVec3::ZERO), &body(CENTRE, axis), &[]);
    for row in table(&report, "body.csv") {
        close(row["v_z [sqrt(kT/m)]"], DRIFT.dot(axis), 1e-6);
    }
    assert!(report.summary.contains(&format!("{:.5}", DRIFT.dot(axis))), "{}", report.summary);
}

/// Negative control: a body that lies across the rotation does not see it as its own.
#[test]
fn another_axis_sees_another_flow() {
    let (axis, across) = (DVec3::Z, DVec3::X);
    let report = analyzed(&rotating(CENTRE, 0.0625 * axis), &body(CENTRE, across), &[("velocity", text("relative"))]);
    let rows = table(&report, "body.csv");
    // About its own axis it would be 0.0625 rho; the blocks of a bin do not lie quite evenly about the axis.
    let outer: Vec<_> = rows.iter().filter(|r| r["rho [a]"] > 4.0).collect();
    assert!(outer.len() > 50 && outer.iter().all(|r| r["v_phi [sqrt(kT/m)]"].abs() < 0.25 * 0.0625 * r["rho [a]"]));
}

#[test]
fn only_fields_and_squirmers_of_one_step_make_a_pair() {
    let (fluid, body) = (rotating(CENTRE, DVec3::ZERO), body(CENTRE, DVec3::X));
    let mut analyzer = make("flow-field", &[]);
    for seq in 0..6 {
        take(analyzer.as_mut(), &fluid.encode(&stamp(seq, EDGE, false))).unwrap();
    }
    for seq in [1, 4, 9] {
        take(analyzer.as_mut(), &body.encode(&stamp(seq, EDGE, false))).unwrap();
    }
    let summary = analyzer.finish().unwrap().summary;
    assert!(summary.contains("6 snapshots of the fields, 2 of them with squirmers"), "{summary}");
    let mut alone = make("flow-field", &[]);
    take(alone.as_mut(), &fluid.encode(&stamp(0, EDGE, false))).unwrap();
    let report = alone.finish().unwrap();
    assert!(report.summary.contains("no body frame") && report.files.len() == 2);
}

#[test]
fn the_lab_frame_averages_particles_along_the_look() {
    let of = |velocity: [[f32; 3]; 2]| Fields {
        block: 2,
        blocks: [1, 2, 1],
        density: vec![1.0, 3.0],
        velocity: velocity.to_vec(),
    };
    let found = |options: &[(&'static str, Value)]| {
        let mut analyzer = make("flow-field", options);
        for (seq, speed) in [(0, 1.0), (1, 3.0)] {
            let fields = of([[speed, 0.0, 0.5], [0.0; 3]]);
            take(analyzer.as_mut(), &fields.encode(&stamp(seq, [2.0, 4.0, 2.0], true)))?;
        }
        analyzer.finish()
    };
    let row = |options: &[(&'static str, Value)]| table(&found(options).unwrap(), "lab.csv")[0].clone();
    let all = row(&[]);
    assert_eq!([all["v_x [sqrt(kT/m)]"], all["v_z [sqrt(kT/m)]"], all["density [m/a^3]"]], [0.5, 0.125, 2.0]);
    let low = row(&[("at", Value::Float(1.5))]);
    assert_eq!([low["v_x [sqrt(kT/m)]"], low["density [m/a^3]"]], [2.0, 1.0]);
    let side = table(&found(&[("look", text("z"))]).unwrap(), "lab.csv");
    assert_eq!(side.iter().map(|r| (r["y [a]"], r["v_x [sqrt(kT/m)]"])).collect::<Vec<_>>(), [(1.0, 2.0), (3.0, 0.0)]);
    let said = found(&[("at", Value::Float(4.0))]).unwrap_err().to_string();
    assert!(said.contains("outside the box, whose edge along y is 4 a"), "{said}");
}
