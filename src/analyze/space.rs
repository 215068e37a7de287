//! The box as analyzers see it: its edges, and which of its sides are joined.

use crate::wire::{FLAG_WALLS_Y, Header};
use glam::DVec3;

/// A box that is periodic, but for y between walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    /// Edges in a.
    pub edge: DVec3,
    /// Whether there are walls at y = 0 and at the other end.
    pub walls: bool,
}

impl Space {
    /// The box of a snapshot.
    #[must_use]
    pub fn of(header: &Header) -> Self {
        Self { edge: DVec3::from_array(header.box_size), walls: header.flags & FLAG_WALLS_Y != 0 }
    }

    /// Whether the sides across this axis (0 x, 1 y, 2 z) are joined.
    #[must_use]
    pub fn periodic(&self, axis: usize) -> bool {
        !(self.walls && axis == 1)
    }

    /// From one place to the nearest image of another.
    #[must_use]
    pub fn nearest(&self, from: DVec3, to: DVec3) -> DVec3 {
        let straight = to - from;
        let wrapped = straight - self.edge * (straight / self.edge).round();
        if self.walls { DVec3::new(wrapped.x, straight.y, wrapped.z) } else { wrapped }
    }

    /// Half the shortest periodic edge: within it there is one nearest image.
    #[must_use]
    pub fn reach(&self) -> f64 {
        (0..3).filter(|k| self.periodic(*k)).map(|k| self.edge[k] / 2.0).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_image_crosses_periodic_sides_only() {
        let slit = Space { edge: DVec3::new(50.0, 7.0, 40.0), walls: true };
        let r = slit.nearest(DVec3::new(1.0, 6.5, 39.0), DVec3::new(149.0, 0.5, 2.0));
        assert!((r - DVec3::new(-2.0, -6.0, 3.0)).length() < 1e-12, "{r}");
        assert_eq!((slit.reach(), Space { walls: false, ..slit }.reach()), (20.0, 3.5));
    }
}
