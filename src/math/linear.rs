//! Symmetric 3x3 matrices: eigenvalues, eigenvectors, pseudo-inverse.

use glam::{DMat3, DVec3};

/// Eigenvalues and orthonormal eigenvectors (columns) of a symmetric matrix, by Jacobi's rotations
/// (Jacobi, J. reine angew. Math. 30, 51, 1846).
#[must_use]
pub fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = matrix;
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..30 {
        let mixed = a.y_axis.x.abs() + a.z_axis.x.abs() + a.z_axis.y.abs();
        if mixed <= 1e-17 * (a.x_axis.x.abs() + a.y_axis.y.abs() + a.z_axis.z.abs()) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a.col(q)[p] == 0.0 {
                continue;
            }
            let turn = 0.5 * (2.0 * a.col(q)[p]).atan2(a.col(q)[q] - a.col(p)[p]);
            let (sin, cos) = turn.sin_cos();
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = cos;
            rotation.col_mut(q)[q] = cos;
            rotation.col_mut(q)[p] = sin;
            rotation.col_mut(p)[q] = -sin;
            a = rotation.transpose() * a * rotation;
            vectors *= rotation;
        }
    }
    (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z), vectors)
}

/// The pseudo-inverse of a symmetric matrix with no negative eigenvalue (Penrose, Proc. Camb. Phil. Soc. 51, 406, 1955);
/// eigenvalues below 1e-12 of the largest count as zero.
#[must_use]
pub fn pseudo_inverse(matrix: DMat3) -> DMat3 {
    let (values, vectors) = eigen(matrix);
    let least = 1e-12 * values.max_element();
    let inverse = values.to_array().map(|value| if value > least { value.recip() } else { 0.0 });
    vectors * DMat3::from_diagonal(DVec3::from_array(inverse)) * vectors.transpose()
}

/// a b^T: entry (row i, column j) is a_i b_j.
#[must_use]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::draws::normals;
    use crate::math::rng::{Draw, Purpose};

    fn largest(m: DMat3) -> f64 {
        m.to_cols_array().into_iter().fold(0.0, |most, x| x.abs().max(most))
    }

    /// sum of `rank` products a a^T with random a.
    fn sample(i: u32, rank: u32) -> DMat3 {
        let draw = Draw::new(2, Purpose::Start, 0);
        (0..rank).map(|k| normals(draw.uniforms(i, k, 0))).fold(DMat3::ZERO, |sum, a| sum + outer(a, a))
    }

    #[test]
    fn known_eigenvalues() {
        let matrix = DMat3::from_cols_array(&[2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 5.0]);
        let mut values = eigen(matrix).0.to_array();
        values.sort_by(f64::total_cmp);
        for (value, expected) in values.into_iter().zip([1.0, 3.0, 5.0]) {
            assert!((value - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn eigenvectors_are_orthonormal_and_rebuild_the_matrix() {
        for i in 0..500 {
            let matrix = sample(i, 4) - 0.7 * sample(i + 1000, 2);
            let (values, vectors) = eigen(matrix);
            assert!(largest(vectors.transpose() * vectors - DMat3::IDENTITY) < 1e-13);
            let rebuilt = vectors * DMat3::from_diagonal(values) * vectors.transpose();
            assert!(largest(rebuilt - matrix) < 1e-13 * largest(matrix));
        }
    }

    #[test]
    fn pseudo_inverse_meets_penroses_equations_at_every_rank() {
        for (i, rank) in (0..500).flat_map(|i| (0..4).map(move |rank| (i, rank))) {
            let a = sample(i, rank);
            let b = pseudo_inverse(a);
            let size = 1.0 + largest(a) * largest(b);
            assert!(largest(a * b * a - a) < 1e-12 * size * (1.0 + largest(a)), "rank {rank}");
            assert!(largest(b * a * b - b) < 1e-12 * size * (1.0 + largest(b)), "rank {rank}");
            assert!(largest(a * b - (a * b).transpose()) < 1e-12 * size, "rank {rank}");
            let projected = (a * b).x_axis.x + (a * b).y_axis.y + (a * b).z_axis.z;
            assert!((projected - f64::from(rank)).abs() < 1e-9 * size, "rank {rank}");
        }
    }
}
