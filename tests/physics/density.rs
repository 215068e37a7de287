//! The fluid beside walls and beside squirmers: as dense and as hot as everywhere else.

use crate::{SQUIRMERS, advance, alone, listed, rig, scaled_radius, size, sound, temperature};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::state::start::{nearest_image, start};
use squirm::state::{Particle, State, System};

const SLIT: &[&str] =
    &["stream", "shift-grid", "sort-reorder", "cell-reduce", "wall-ghosts", "rotate", "restore-thermostat", "apply"];

/// Every bin must hold what a uniform fluid would put there, within `allowance` and five of its errors, and the errors must be
/// small enough for the comparison to mean something.
fn assert_uniform(bins: &[Vec<f64>], expected: &[f64], allowance: f64, largest_error: f64) {
    for (k, (series, expected)) in bins.iter().zip(expected).enumerate() {
        let found: Estimate = blocked(series);
        let (ratio, error) = (found.mean / expected, found.error / expected);
        println!("bin {k}: {ratio:.4} +- {error:.4}");
        assert!(error < largest_error, "bin {k}: error {error}");
        assert!((ratio - 1.0).abs() < allowance + 5.0 * error, "bin {k}: {ratio} +- {error}");
    }
}

/// Bins of 0.1 a from both walls inwards, and the rest of the half slit in bins of 0.5 a. A bin of 0.1 a holds 128 particles
/// on both sides together: 9 % Poisson noise per frame, under 0.7 % from the 300 frames of a quick run.
#[test]
fn density_is_uniform_across_a_slit() {
    let _turn = alone();
    let edge = size(8, 32);
    let mut system = rig::system([edge, 8, edge]);
    system.domain.walls = Some(rig::walls());
    let state = rig::fluid(&system, 80 * (edge as usize).pow(2));
    let edges: Vec<f64> = (0..=10).map(|k| f64::from(k) * 0.1).chain((3..=8).map(|k| f64::from(k) * 0.5)).collect();
    let mut session = rig::fused(&rig::plan(&system, SLIT, &[]), &state);
    let mut bins = vec![Vec::new(); edges.len() - 1];
    for _ in 0..300 {
        advance(&mut session, 8);
        let mut counts = vec![0.0; bins.len()];
        for particle in session.state().expect("a state").particles {
            let depth = particle.position.y.min(8.0 - particle.position.y);
            assert!(depth >= 0.0, "{depth}");
            counts[edges.partition_point(|e| *e <= depth) - 1] += 1.0;
        }
        bins.iter_mut().zip(counts).for_each(|(bin, n)| bin.push(n));
    }
    sound(&session);
    let whole = state.particles.len() as f64;
    let expected: Vec<f64> = edges.windows(2).map(|e| whole * (e[1] - e[0]) / 4.0).collect();
    assert_uniform(&bins, &expected, 0.0, size(0.012, 0.003));
}

/// Scaled radius |S r'| of a particle from the one squirmer: 1 on the surface.
fn scaled(system: &System, state: &State, particle: &Particle) -> f64 {
    let body = &state.squirmers[0];
    let arm = nearest_image(&system.domain, particle.position - body.position);
    scaled_radius(system, body.species, body.orientation, arm)
}

/// Shells between scaled radii 1 and 1.5 around a swimming spheroid. The first, 1 to 1.05, holds 106 particles: 10 % Poisson
/// noise per frame. The published rule, which puts particles found inside onto the surface, would make the first half of it
/// 2.4 % too dense. Ghosts without slip velocity would heat the first shell by 1 %; the flow itself, slip 0.1, adds at most
/// 0.1^2/3 = 0.3 %, and its pressure takes u^2/(2 kT) = 0.5 % of the density at most (Bernoulli). The squirmer starts in the far
/// corner of the box, where its neighbourhood crosses three sides.
#[test]
fn beside_a_squirmer_the_fluid_is_as_dense_and_as_hot_as_elsewhere() {
    let _turn = alone();
    let mut system = rig::system([12, 12, 12]);
    system.species = vec![listed(rig::species(4.0, 2.0, 0.1, 0.0), vec![[10.0, 9.0, 11.0, 0.2, 0.3, 1.0]])];
    let state = start(&system).expect("there is room");
    let edges: Vec<f64> = (0..=10).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
    let mut session = rig::fused(&rig::plan(&system, SQUIRMERS, &[]), &state);
    let mut bins = vec![Vec::new(); edges.len() - 1];
    let mut heat = Vec::new();
    advance(&mut session, 50);
    for _ in 0..size(300, 6000) {
        advance(&mut session, 5);
        let now = session.state().expect("a state");
        let radii: Vec<f64> = now.particles.iter().map(|p| scaled(&system, &now, p)).collect();
        for (k, bin) in bins.iter_mut().enumerate() {
            bin.push(radii.iter().filter(|s| edges[k] <= **s && **s < edges[k + 1]).count() as f64);
        }
        heat.push(temperature(now.particles.iter().zip(&radii).filter(|(_, s)| **s < 1.15).map(|(p, _)| p)));
    }
    sound(&session);
    let volume = system.species[0].spheroid().volume();
    let density = state.particles.len() as f64 / system.fluid_volume();
    let expected: Vec<f64> = edges.windows(2).map(|e| density * volume * (e[1].powi(3) - e[0].powi(3))).collect();
    assert_uniform(&bins, &expected, 0.005, size(0.012, 0.003));
    let t = blocked(&heat);
    println!("temperature of the first shell {:.4} +- {:.4}", t.mean, t.error);
    assert!(t.error < size(0.005, 0.0015), "{}", t.error);
    assert!((t.mean - 1.0).abs() < 0.003 + 3.0 * t.error, "{} +- {}", t.mean, t.error);
}
