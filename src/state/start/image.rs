//! Periodic images on the host.

use crate::state::Domain;
use glam::DVec3;

/// Which axes are periodic.
#[must_use]
pub fn periodic(domain: &Domain) -> [bool; 3] {
    [true, domain.walls.is_none(), true]
}

/// Box lengths.
#[must_use]
pub fn lengths(domain: &Domain) -> DVec3 {
    DVec3::from_array(domain.size.map(f64::from))
}

/// The shortest of a difference of positions and its periodic images.
#[must_use]
pub fn nearest_image(domain: &Domain, difference: DVec3) -> DVec3 {
    let (l, periodic) = (lengths(domain), periodic(domain));
    DVec3::from_array([0, 1, 2].map(|i| {
        let d = difference[i];
        if periodic[i] { d - l[i] * (d / l[i]).round() } else { d }
    }))
}

/// The image of a position that lies in the box; across a slit, the position as it is.
#[must_use]
pub fn wrap(domain: &Domain, position: DVec3) -> DVec3 {
    let (l, periodic) = (lengths(domain), periodic(domain));
    DVec3::from_array([0, 1, 2].map(|i| {
        let wrapped = position[i].rem_euclid(l[i]);
        // A tiny negative number plus L rounds to L itself.
        match periodic[i] {
            true if wrapped < l[i] => wrapped,
            true => 0.0,
            false => position[i],
        }
    }))
}
