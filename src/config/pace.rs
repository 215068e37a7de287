//! How long a step takes on a data-centre GPU, estimated from what there is in it.

use crate::buffers::{Extent, Sizes};

/// What a step costs on one H100 80GB, in nanoseconds per element (docs/performance.md); within 30 % of what was measured.
const PACE: [(Extent, f64); 4] =
    [(Extent::One, 9_000.0), (Extent::Particles, 0.0215), (Extent::WallCells, 0.7), (Extent::SquirmerGhosts, 0.13)];

/// What a particle takes besides where the collision uses the sums over positions, in nanoseconds.
const PLACES: f64 = 0.0116;

/// What the kernels of squirmers take besides, however few there are, in nanoseconds: in all, and per particle.
const SQUIRMERS: [f64; 2] = [60_000.0, 0.0105];

/// What a particle takes besides where there are more than these, whose arrays lie in several buffers.
const PARTS: (u64, f64) = (134_000_000, 0.014);

/// Seconds per step; `places`: the collision uses the sums over positions.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn step(sizes: &Sizes, places: bool) -> f64 {
    let elements: f64 = PACE.iter().map(|(extent, pace)| sizes.count(*extent) as f64 * pace).sum();
    let squirmers = SQUIRMERS[0] + SQUIRMERS[1] * sizes.particles as f64;
    let particle = [(places, PLACES), (sizes.particles > PARTS.0, PARTS.1)];
    let besides: f64 = particle.iter().filter(|(there, _)| *there).map(|(_, pace)| pace * sizes.particles as f64).sum();
    1e-9 * (elements + besides + if sizes.squirmers > 0 { squirmers } else { 0.0 })
}

/// Seconds in words.
#[must_use]
pub fn words(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "less than a second".into(),
        s if s < 100.0 => format!("about {s:.0} s"),
        s if s < 6000.0 => format!("about {:.0} minutes", s / 60.0),
        s if s < 2e5 => format!("about {:.1} hours", s / 3600.0),
        s => format!("about {:.0} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_were_measured_are_met_within_30_per_cent() {
        let fluid = |particles, wall_cells| Sizes { particles, wall_cells, ..Sizes::default() };
        let with = |sizes, squirmers| Sizes { squirmers, ghost_stride: 2496, ..sizes };
        // One H100 80GB, microseconds per step: srd-a, energy, slit, slit-800, channel-100, small, crowd-3700, crowd-1 of `squirm
        // bench`, srd-a of 1,000 million, and thermostat of 10 thousand to a million.
        for (sizes, places, measured) in [
            (fluid(10_000_000, 0), false, 215.0),
            (fluid(10_000_000, 0), true, 324.0),
            (fluid(54_000_000, 185_000), true, 2161.0),
            (with(fluid(4_300_000, 185_000), 800), true, 585.0),
            (with(fluid(10_550_000, 38_900), 100), true, 622.0),
            (Sizes { ghost_stride: 832, ..with(fluid(101_000, 2000), 10) }, true, 75.1),
            (Sizes { ghost_stride: 768, ..with(fluid(22_300_000, 0), 3700) }, true, 1454.0),
            (Sizes { ghost_stride: 768, ..with(fluid(25_150_000, 0), 1) }, true, 1162.0),
            (fluid(998_970_000, 0), false, 39_190.0),
            (fluid(10_000, 0), true, 10.0),
            (fluid(106_480, 0), true, 11.2),
            (fluid(297_910, 0), true, 16.5),
            (fluid(973_360, 0), true, 40.1),
        ] {
            let ratio = 1e6 * step(&sizes, places) / measured;
            assert!(ratio > 0.77 && ratio < 1.3, "{measured} us: {ratio}");
        }
    }

    #[test]
    fn times_are_told_in_the_unit_that_suits() {
        assert_eq!(words(0.3), "less than a second");
        assert_eq!(
            [12.0, 600.0, 7200.0, 864_000.0].map(words),
            ["about 12 s", "about 10 minutes", "about 2.0 hours", "about 10 days"]
        );
    }
}
