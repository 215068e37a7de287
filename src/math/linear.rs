//! Symmetric 3x3 matrices: eigenvalues, eigenvectors, pseudo-inverse.

use glam::{DMat3, DVec3};

/// Eigenvalues and orthonormal eigenvectors (columns) of a symmetric matrix, by Jacobi's rotations
/// (Jacobi, J. reine angew. Math. 30, 51, 1846).
#[must_use]
pub fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = matrix;
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..30 {
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
