//! Where the squirmers start: listed, on a lattice, or random without overlap.

use super::StartError;
use super::crowd::{Crowd, Placed};
use super::image::{lengths, periodic, wrap};
use super::stream::{Stream, Use};
use crate::math::steric::{Body, Repulsion, SAFETY, SIGMA};
use crate::state::{Species, System};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Random places tried for one squirmer before the crowd has to make room for it.
const ATTEMPTS: usize = 100;

/// Gap between the bodies with their steric margin from which on the default repulsion is zero.
fn wanted_gap() -> f64 {
    1.0001 * Repulsion { sigma: SIGMA, epsilon: 0.0, max_force: 0.0 }.cutoff()
}

/// Squirmers in the order in which they are placed; `crowd` has the first of them.
struct Queue<'a> {
    crowd: Crowd<'a>,
    order: Vec<usize>,
    /// Species of every squirmer.
    species: Vec<usize>,
}

/// Centre and orientation of every squirmer, species by species.
///
/// # Errors
/// If a body does not fit into the box, listed ones overlap, or the box is too crowded.
pub fn poses(system: &System) -> Result<Vec<(DVec3, DQuat)>, StartError> {
    let Queue { mut crowd, order, species } = given(system)?;
    let mut tight = false;
    for i in &order[crowd.placed.len()..] {
        crowd.add(insert(system, &crowd, &system.species[species[*i]], *i, wanted_gap(), &mut tight));
    }
    if tight && !crowd.relax() {
        let share = 1.0 - system.fluid_volume() / system.domain.volume();
        return Err(StartError::Crowded { count: species.len(), share });
    }
    let mut poses = vec![(DVec3::ZERO, DQuat::IDENTITY); species.len()];
    for (i, placed) in order.iter().zip(&crowd.placed) {
        poses[*i] = (placed.position, placed.orientation);
    }
    Ok(poses)
}

/// Whether every squirmer fits into the box and those that the user placed, in lists or on lattices, have room; random ones are not placed.
///
/// # Errors
/// If not.
pub fn check(system: &System) -> Result<(), StartError> {
    given(system).map(drop)
}

/// Crowding up to which random places are found. Of 21 systems tried, with spheres, spheroids twice to four times as long as thick and flat ones in boxes and
/// slits of 1 to 2000 squirmers, three seeds each, the first failed at 0.58.
pub const SURE: f64 = 0.55;

/// The share that the bodies with the gap around them that a random start wants have of the room that layers of them can use: the
/// box, or of a slit the height that whole layers take.
#[must_use]
pub fn crowding(system: &System) -> f64 {
    let grown = |species: &Species| species.spheroid().grown(SAFETY + 0.5 * wanted_gap());
    let bodies: f64 = system.species.iter().map(|s| f64::from(s.count) * grown(s).volume()).sum();
    let thinnest = system.species.iter().map(|s| grown(s).along.min(grown(s).across)).fold(f64::MAX, f64::min);
    let height = lengths(&system.domain).y;
    let layers = if system.domain.walls.is_some() { (height / (2.0 * thinnest)).floor() } else { f64::MAX };
    bodies / system.domain.volume() * (height / (2.0 * thinnest * layers)).max(1.0)
}

/// Places what the user placed.
fn given(system: &System) -> Result<Queue<'_>, StartError> {
    let wanted = wanted_gap();
    for species in &system.species {
        fits(system, species, wanted)?;
    }
    let radius = system.species.iter().map(|s| s.spheroid().radius() + SAFETY).fold(0.0, f64::max);
    let species: Vec<usize> = system.squirmer_species().collect();
    // What the user placed comes first; random squirmers then find room among it.
    let mut order: Vec<usize> = (0..species.len()).collect();
    order.sort_by_key(|i| match system.species[species[*i]].start.as_str() {
        "listed" => 0,
        "lattice" => 1,
        _ => 2,
    });
    let mut crowd = Crowd::new(&system.domain, radius, wanted);
    let mut given = Vec::new();
    for s in &system.species {
        given.extend(match s.start.as_str() {
            "listed" => listed(s)?.into_iter().map(Some).collect(),
            "lattice" => lattice(system, s, wanted)?.into_iter().map(Some).collect(),
            _ => vec![None; s.count as usize],
        });
    }
    for i in &order {
        let Some((position, orientation)) = given[*i] else { break };
        let pose = (wrap(&system.domain, position), orientation);
        let placed = fixed(system, &crowd, &order, &system.species[species[*i]], *i, pose)?;
        crowd.add(placed);
    }
    Ok(Queue { crowd, order, species })
}

/// The bare body must not meet its own image, nor both walls whatever its orientation; at random its margin must fit as well.
fn fits(system: &System, species: &Species, wanted: f64) -> Result<(), StartError> {
    let shape = species.spheroid();
    let periodic = periodic(&system.domain);
    let margin = if species.start == "random" { SAFETY + wanted } else { 0.0 };
    for axis in 0..3 {
        let length = f64::from(system.domain.size[axis]);
        let needed = 2.0 * if periodic[axis] { shape.radius() } else { shape.along.min(shape.across) + margin };
        if needed >= length {
            return Err(StartError::Narrow {
                species: species.name.clone(),
                axis: ["x", "y", "z"][axis],
                needed,
                length,
            });
        }
    }
    Ok(())
}

fn bare(species: &Species, orientation: DQuat) -> Body {
    Body { shape: species.hull(), axis: orientation * DVec3::Z }
}

fn with_margin(species: &Species, e: DVec3) -> Body {
    Body { shape: species.spheroid().grown(SAFETY), axis: e }
}

/// A squirmer where the user put it: refused if the bare bodies overlap, while steric margins may.
fn fixed(
    system: &System,
    crowd: &Crowd,
    order: &[usize],
    species: &Species,
    squirmer: usize,
    (position, orientation): (DVec3, DQuat),
) -> Result<Placed, StartError> {
    let body = bare(species, orientation);
    let half = body.shape.half_height(body.axis.y);
    let height = f64::from(system.domain.size[1]);
    if system.domain.walls.is_some() && (position.y < half || position.y > height - half) {
        return Err(StartError::InWall { squirmer, species: species.name.clone(), y: position.y });
    }
    if let Some(other) = crowd.overlapping(&body, position, SAFETY) {
        return Err(StartError::Overlap { first: order[other], second: squirmer });
    }
    Ok(Placed { body: with_margin(species, body.axis), position, orientation, movable: false })
}

/// Random sequential insertion (Widom, J. Chem. Phys. 44, 3888, 1966); where no attempt fits, the one that overlaps least.
fn insert(system: &System, crowd: &Crowd, species: &Species, index: usize, wanted: f64, tight: &mut bool) -> Placed {
    #[allow(clippy::cast_possible_truncation)]
    let mut stream = Stream::new(system.run.seed, Use::Pose, index as u32);
    let mut best = (f64::MIN, DVec3::ZERO, DVec3::Z);
    for _ in 0..ATTEMPTS {
        let (position, e) = candidate(system, species, wanted, &mut stream);
        let gap = crowd.gap(&with_margin(species, e), position, best.0);
        if gap > best.0 {
            best = (gap, position, e);
        }
        if gap >= wanted {
            break;
        }
    }
    *tight |= best.0 < wanted;
    let (_, position, e) = best;
    Placed { body: with_margin(species, e), position, orientation: stream.orientation(e), movable: true }
}

/// A pose uniform in the box; in a slit, among those that keep off the walls.
fn candidate(system: &System, species: &Species, wanted: f64, stream: &mut Stream) -> (DVec3, DVec3) {
    let l = lengths(&system.domain);
    let shape = species.spheroid().grown(SAFETY);
    // Half heights between `least` and `most` fit; e_y^2 is linear in their square.
    let least = shape.along.min(shape.across);
    let most = (l.y / 2.0 - wanted).clamp(least, shape.radius());
    let cosine = |half: f64| {
        let difference = shape.along.powi(2) - shape.across.powi(2);
        let square = if difference == 0.0 { 1.0 } else { (half * half - shape.across.powi(2)) / difference };
        square.clamp(0.0, 1.0).sqrt()
    };
    let range = match system.domain.walls {
        None => [0.0, 1.0],
        Some(_) if shape.along == shape.across => [0.0, 1.0],
        Some(_) if shape.along > shape.across => [0.0, cosine(most)],
        Some(_) => [cosine(most), 1.0],
    };
    loop {
        let (u, v) = (stream.uniforms(), stream.uniforms());
        let cos = range[0] + (range[1] - range[0]) * v[0];
        let (e_y, angle, sin) = (if v[1] < 0.5 { cos } else { -cos }, TAU * v[2], (1.0 - cos * cos).sqrt());
        let e = DVec3::new(sin * angle.cos(), e_y, sin * angle.sin());
        let mut position = l * DVec3::new(u[0], u[1], u[2]);
        if system.domain.walls.is_some() {
            let (half, room) = (shape.half_height(e_y) + wanted, l.y - 2.0 * (least + wanted));
            position.y = l.y / 2.0 + room * (u[1] - 0.5);
            if position.y < half || l.y - position.y < half {
                continue;
            }
        }
        return (position, e);
    }
}

/// The poses that the user listed.
fn listed(species: &Species) -> Result<Vec<(DVec3, DQuat)>, StartError> {
    let rows = species.poses.as_deref().unwrap_or_default();
    if rows.len() != species.count as usize {
        let (species, found, wanted) = (species.name.clone(), rows.len(), species.count);
        return Err(StartError::Poses { species, found, wanted });
    }
    let pose = |(row, [x, y, z, ex, ey, ez]): (usize, &[f64; 6])| {
        let e = DVec3::new(*ex, *ey, *ez).try_normalize();
        let e = e.ok_or_else(|| StartError::NoDirection { species: species.name.clone(), row: row + 1 })?;
        Ok((DVec3::new(*x, *y, *z), DQuat::from_rotation_arc(DVec3::Z, e)))
    };
    rows.iter().enumerate().map(pose).collect()
}

/// Sites on the lattice with the most room around each body, axes along x; squirmers are spread evenly over the sites.
fn lattice(system: &System, species: &Species, wanted: f64) -> Result<Vec<(DVec3, DQuat)>, StartError> {
    let shape = species.spheroid().grown(SAFETY);
    let size = 2.0 * DVec3::new(shape.along, shape.across, shape.across) + DVec3::splat(wanted);
    let (l, count) = (lengths(&system.domain), species.count as usize);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let most = [0, 1, 2].map(|k| ((l[k] / size[k]) as usize).min(count));
    let mut best: Option<(f64, [usize; 3])> = None;
    for nx in 1..=most[0] {
        for ny in 1..=most[1] {
            let n = [nx, ny, count.div_ceil(nx * ny)];
            if n[2] > most[2] {
                continue;
            }
            let room = [0, 1, 2].map(|k| l[k] / n[k] as f64 - size[k]).into_iter().fold(f64::MAX, f64::min);
            if best.is_none_or(|b| room > b.0) {
                best = Some((room, n));
            }
        }
    }
    let [nx, ny, nz] = best.ok_or_else(|| StartError::Lattice { species: species.name.clone(), count })?.1;
    let sites = nx * ny * nz;
    let pose = |k: usize| {
        let site = k * sites / count;
        let cell = DVec3::new((site % nx) as f64, (site / nx % ny) as f64, (site / (nx * ny)) as f64);
        let position = (cell + DVec3::splat(0.5)) * l / DVec3::new(nx as f64, ny as f64, nz as f64);
        (position, DQuat::from_rotation_arc(DVec3::Z, DVec3::X))
    };
    Ok((0..count).map(pose).collect())
}
