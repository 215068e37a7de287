//! Squirmers being placed: their neighbours, the gaps between them, and pushing them apart.

use super::image::{lengths, nearest_image, periodic, wrap};
use crate::math::steric::{Body, Contact, closer_than, contact, wall_contact};
use crate::state::Domain;
use glam::{DQuat, DVec3};

/// A body with a place.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Semi-axes with the steric margin, and axis.
    pub body: Body,
    /// Centre.
    pub position: DVec3,
    /// Orientation; its z axis is the body's axis.
    pub orientation: DQuat,
    /// Whether it may be pushed aside.
    pub movable: bool,
}

impl Placed {
    fn push(&mut self, domain: &Domain, shift: DVec3, turn: DVec3) {
        // Steps are limited since the gaps of deep overlaps are only rough.
        self.position = wrap(domain, self.position + shift.clamp_length_max(0.5));
        self.orientation = (DQuat::from_scaled_axis(turn.clamp_length_max(0.2)) * self.orientation).normalize();
        self.body.axis = self.orientation * DVec3::Z;
    }

    /// Inverse weights of shifts and turns in a push; a turn counts by the way that the body's mass goes.
    fn mobility(&self) -> (f64, f64) {
        let gyration = 0.2 * (self.body.shape.along.powi(2) + self.body.shape.across.powi(2));
        if self.movable { (1.0, 1.0 / gyration) } else { (0.0, 0.0) }
    }
}

/// Bodies in a box, found by bins at least as wide as the farthest reach.
#[derive(Debug)]
pub struct Crowd<'a> {
    domain: &'a Domain,
    /// The gap wanted between all bodies, and to the walls.
    wanted: f64,
    /// All bodies, in the order in which they were added.
    pub placed: Vec<Placed>,
    counts: [usize; 3],
    bins: Vec<Vec<usize>>,
}

/// Gaps are opened by this more than wanted, so that finitely many pushes suffice.
const OVERSHOOT: f64 = 0.01;
/// Pairs up to this much beyond the wanted gap are looked at in a sweep.
const SKIN: f64 = 0.3;
/// Sweeps after which a crowd counts as too dense.
const SWEEPS: usize = 2000;

impl<'a> Crowd<'a> {
    /// An empty box for bodies of at most this radius.
    #[must_use]
    pub fn new(domain: &'a Domain, radius: f64, wanted: f64) -> Self {
        let reach = 2.0 * radius + wanted + SKIN;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let counts = lengths(domain).to_array().map(|l| ((l / reach) as usize).clamp(1, 128));
        Self { domain, wanted, placed: Vec::new(), counts, bins: vec![Vec::new(); counts.iter().product()] }
    }

    /// Adds a body.
    pub fn add(&mut self, placed: Placed) {
        let bin = self.index(self.bin(placed.position));
        self.bins[bin].push(self.placed.len());
        self.placed.push(placed);
    }

    /// The smallest gap between `body` and everything else, walls included; the search ends at the first below `enough`.
    #[must_use]
    pub fn gap(&self, body: &Body, position: DVec3, enough: f64) -> f64 {
        let mut smallest = self.wall_contacts(body, position).map(|c| c.gap).fold(f64::MAX, f64::min);
        for j in self.near(position) {
            if smallest < enough {
                break;
            }
            let other = &self.placed[j];
            let r = nearest_image(self.domain, other.position - position);
            let outer = r.length() - body.shape.radius() - other.body.shape.radius();
            if outer < smallest {
                smallest = smallest.min(contact(body, &other.body, r).map_or(f64::MIN, |c| c.gap));
            }
        }
        smallest
    }

    /// A body that overlaps `body` once the margin of those already here is taken off again.
    #[must_use]
    pub fn overlapping(&self, body: &Body, position: DVec3, margin: f64) -> Option<usize> {
        self.near(position).find(|j| {
            let other = Body { shape: self.placed[*j].body.shape.grown(-margin), ..self.placed[*j].body };
            closer_than(body, &other, nearest_image(self.domain, self.placed[*j].position - position), 0.0)
        })
    }

    /// Pushes bodies apart, pair by pair, until all gaps are as wanted; false if that fails. A pair closer than wanted is put at
    /// the wanted gap by the smallest shifts and turns that do it to first order (the projection of Jakobsen, Advanced Character
    /// Physics, GDC 2001).
    pub fn relax(&mut self) -> bool {
        for _ in 0..SWEEPS {
            self.sort();
            let mut settled = true;
            for i in 0..self.placed.len() {
                for c in self.wall_contacts(&self.placed[i].body, self.placed[i].position) {
                    if c.gap < self.wanted {
                        settled = false;
                        self.resolve(&c, None, i);
                    }
                }
                for j in self.near(self.placed[i].position).filter(|j| *j > i).collect::<Vec<_>>() {
                    let (a, b) = (&self.placed[i], &self.placed[j]);
                    let r = nearest_image(self.domain, b.position - a.position);
                    if r.length() > a.body.shape.radius() + b.body.shape.radius() + self.wanted {
                        continue;
                    }
                    match contact(&a.body, &b.body, r) {
                        Some(c) if c.gap >= self.wanted => {}
                        Some(c) => {
                            settled = false;
                            self.resolve(&c, Some(i), j);
                        }
                        None => {
                            settled = false;
                            self.placed[j].push(self.domain, DVec3::X * 0.1, DVec3::ZERO);
                        }
                    }
                }
            }
            if settled {
                return true;
            }
        }
        false
    }

    /// Opens the gap between `a` (a wall if none) and `b`.
    fn resolve(&mut self, c: &Contact, a: Option<usize>, b: usize) {
        let (shift_a, turn_a) = a.map_or((0.0, 0.0), |a| self.placed[a].mobility());
        let (shift_b, turn_b) = self.placed[b].mobility();
        let stiffness = (shift_a + shift_b) * c.by_shift.length_squared()
            + turn_a * c.by_turn_a.length_squared()
            + turn_b * c.by_turn_b.length_squared();
        if stiffness == 0.0 {
            return;
        }
        let push = (self.wanted + OVERSHOOT - c.gap) / stiffness;
        if let Some(a) = a {
            self.placed[a].push(self.domain, -push * shift_a * c.by_shift, push * turn_a * c.by_turn_a);
        }
        self.placed[b].push(self.domain, push * shift_b * c.by_shift, push * turn_b * c.by_turn_b);
    }

    fn wall_contacts(&self, body: &Body, position: DVec3) -> impl Iterator<Item = Contact> + use<> {
        let walls = self.domain.walls.as_ref().map(|_| {
            let height = f64::from(self.domain.size[1]) - position.y;
            [wall_contact(body, position.y, DVec3::Y), wall_contact(body, height, DVec3::NEG_Y)]
        });
        walls.into_iter().flatten()
    }

    fn sort(&mut self) {
        self.bins.iter_mut().for_each(Vec::clear);
        for i in 0..self.placed.len() {
            let bin = self.index(self.bin(self.placed[i].position));
            self.bins[bin].push(i);
        }
    }

    fn bin(&self, position: DVec3) -> [usize; 3] {
        let l = lengths(self.domain);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        [0, 1, 2].map(|k| ((position[k] / l[k] * self.counts[k] as f64) as usize).min(self.counts[k] - 1))
    }

    fn index(&self, bin: [usize; 3]) -> usize {
        (bin[2] * self.counts[1] + bin[1]) * self.counts[0] + bin[0]
    }

    /// Everything in the bins around a position, each bin once.
    fn near(&self, position: DVec3) -> impl Iterator<Item = usize> + '_ {
        let home = self.bin(position);
        let periodic = periodic(self.domain);
        let range = [0, 1, 2].map(|k| {
            let (n, h) = (self.counts[k], home[k]);
            match (periodic[k], n) {
                (_, ..3) => (0..n).collect(),
                (true, _) => vec![(h + n - 1) % n, h, (h + 1) % n],
                (false, _) => (h.saturating_sub(1)..=(h + 1).min(n - 1)).collect::<Vec<_>>(),
            }
        });
        let [xs, ys, zs] = range;
        let bins = zs.into_iter().flat_map(move |z| {
            let xs = xs.clone();
            ys.clone().into_iter().flat_map(move |y| xs.clone().into_iter().map(move |x| [x, y, z]))
        });
        bins.flat_map(|bin| self.bins[self.index(bin)].iter().copied())
    }
}
