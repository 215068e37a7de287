//! Which squirmers touch, and the clusters that they form.

use crate::analyze::space::Space;
use crate::math::spheroid::Spheroid;
use crate::math::steric::{Body, closer_than};
use crate::wire::Squirmers;
use glam::DVec3;

/// Shapes, axes and centres of the squirmers of a snapshot.
#[must_use]
pub fn bodies(squirmers: &Squirmers) -> Vec<(Body, DVec3)> {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let body = |i: usize| {
        let species = &squirmers.table[squirmers.species[i] as usize];
        let shape = Spheroid { along: species.along, across: species.across };
        (Body { shape, axis: vector(squirmers.axis[i]).normalize_or_zero() }, vector(squirmers.position[i]))
    };
    (0..squirmers.id.len()).map(body).collect()
}

/// Sizes of the clusters, largest first: squirmers belong to one cluster if a chain of surfaces closer than `gap` (in
/// a) joins them, by the directional distance of Paramonov and Yaliraki 2005. Union-find with path halving (Tarjan
/// 1975).
#[must_use]
pub fn sizes(space: &Space, all: &[(Body, DVec3)], gap: f64) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..all.len()).collect();
    for (i, (a, here)) in all.iter().enumerate() {
        for (j, (b, there)) in all[..i].iter().enumerate() {
            if closer_than(a, b, space.nearest(*here, *there), gap) {
                let (one, other) = (root(&mut parent, i), root(&mut parent, j));
                parent[one] = other;
            }
        }
    }
    let mut sizes = vec![0; all.len()];
    for i in 0..all.len() {
        sizes[root(&mut parent, i)] += 1;
    }
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes.retain(|n| *n > 0);
    sizes
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLIT: Space = Space { edge: DVec3::new(50.0, 7.0, 40.0), walls: true };

    /// Prolate, its axis along x.
    fn at(x: f64, z: f64) -> (Body, DVec3) {
        (Body { shape: Spheroid { along: 6.0, across: 3.0 }, axis: DVec3::X }, DVec3::new(x, 3.5, z))
    }

    #[test]
    fn chains_form_clusters_through_the_sides() {
        // A row of three whose surfaces are 0.5 apart, one of them beyond the side of the box; a pair; one alone.
        let row = [at(10.0, 38.0), at(10.0, 4.5), at(10.0, 11.0)];
        let others = [at(30.0, 20.0), at(42.5, 20.0), at(30.0, 30.0)];
        let all = [others[0], row[1], others[2], row[2], others[1], row[0]];
        assert_eq!(sizes(&SLIT, &all, 0.6), [3, 2, 1]);
        assert_eq!(sizes(&SLIT, &all, 0.4), [1; 6]);
        assert_eq!(sizes(&SLIT, &[], 1.0), Vec::<usize>::new());
        // The two ends of a ring around the box are joined from both sides, and counted once.
        let ring: Vec<_> = (0..4).map(|i| at(12.5 * f64::from(i), 5.0)).collect();
        assert_eq!(sizes(&SLIT, &ring, 0.6), [4]);
    }
}
