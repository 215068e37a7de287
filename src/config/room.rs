//! Whether squirmers find room: the poses that are listed, the share of the box, and places without overlap.

use super::late::no_start;
use super::node::Node;
use crate::diag::{Diagnostic, Span};
use crate::state::{Species, System, start};

/// Largest volume fraction of bodies that a start without overlap can reach.
const MAX_FRACTION: f64 = 0.6;

/// Squirmers that are placed to see whether it succeeds where that is not sure; this takes seconds at most.
const TRIED: u32 = 100;

/// Largest rows of poses reported one by one.
const SHOWN: usize = 5;

/// One `[[squirmers]]` of the file.
pub struct Place<'a> {
    /// The file.
    pub root: &'a Node,
    /// Its position.
    pub index: String,
}

impl Place<'_> {
    /// The place of one of its values.
    pub fn of(&self, rest: &[&str]) -> Span {
        let path: Vec<&str> = ["squirmers", &self.index].into_iter().chain(rest.iter().copied()).collect();
        self.root.place(&path)
    }
}

/// Checks the poses that a species lists, one by one.
pub fn poses(species: &Species, system: &System, at: &Place<'_>, found: &mut Vec<Diagnostic>) {
    let listed = species.start == "listed";
    let Some(poses) = &species.poses else {
        if listed {
            found.push(
                Diagnostic::error(format!("\"{}\" starts from listed poses, but there is no `poses`", species.name))
                    .at(at.of(&["start"]), "needs `poses`")
                    .help("add poses = [[x, y, z, ex, ey, ez], ...]"),
            );
        }
        return;
    };
    if !listed {
        found.push(
            Diagnostic::error(format!("`poses` is given, but \"{}\" starts from \"{}\"", species.name, species.start))
                .at(at.of(&["poses"]), "would be ignored")
                .help("write start = \"listed\", or remove poses"),
        );
    }
    if poses.len() != species.count as usize {
        found.push(
            Diagnostic::error(format!("`poses` has {} rows, but count is {}", poses.len(), species.count))
                .at(at.of(&["poses"]), "rows")
                .at(at.of(&["count"]), "count")
                .help(format!("write count = {}, or give a row for each squirmer", poses.len())),
        );
    }
    let problems = poses.iter().enumerate().filter_map(|(row, pose)| Some((row, pose_problem(species, system, pose)?)));
    for (row, (message, help)) in problems.take(SHOWN) {
        let place = at.of(&["poses", &row.to_string()]);
        found.push(Diagnostic::error(message).at(place, "this pose").help(help));
    }
}

/// What is wrong with one pose x, y, z, ex, ey, ez, and what to do.
fn pose_problem(species: &Species, system: &System, pose: &[f64; 6]) -> Option<(String, String)> {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let edge = system.domain.size[axis];
        if !(0.0..f64::from(edge)).contains(&pose[axis]) {
            let message = format!("{name} = {} lies outside the box", pose[axis]);
            return Some((message, format!("give a position with 0 <= {name} < {edge}")));
        }
    }
    let length2: f64 = pose[3..].iter().map(|e| e * e).sum();
    if length2 < 1e-12 {
        return Some(("the axis is zero and gives no direction".into(), "give ex, ey, ez of any other length".into()));
    }
    if system.domain.walls.is_some() {
        let half = species.hull().half_height(pose[4] / length2.sqrt());
        let top = f64::from(system.domain.size[1]);
        if 2.0 * half > top {
            let message =
                format!("with this axis the body is {:.2} high and reaches through both walls of the slit", 2.0 * half);
            let help = format!("turn the axis towards the walls' plane, or make the slit wider than {:.2}", 2.0 * half);
            return Some((message, help));
        }
        if pose[1] < half || pose[1] > top - half {
            // Rounded to where the body fits.
            let (low, high) = ((100.0 * half).ceil() / 100.0, (100.0 * (top - half)).floor() / 100.0);
            let message = format!("the body reaches through a wall: y = {}, half height {half:.2}", pose[1]);
            let help = if low > high {
                format!("give the position y = {}", 0.5 * top)
            } else {
                format!("give a position with {low:.2} <= y <= {high:.2}")
            };
            return Some((message, help));
        }
    }
    None
}

/// Checks the share of the box that bodies fill.
pub fn fraction(system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    let fraction = 1.0 - system.fluid_volume() / system.domain.volume();
    if fraction > MAX_FRACTION {
        found.push(
            Diagnostic::error(format!(
                "the squirmers fill {:.0} % of the box, so they cannot be placed",
                100.0 * fraction
            ))
            .at(root.place(&["squirmers", "0", "count"]), "too many")
            .at(root.place(&["box", "size"]), "for this box")
            .help(format!(
                "stay below {:.0} %, and lower for random places, which need a gap around each body",
                100.0 * MAX_FRACTION
            )),
        );
    }
}

/// Whether the squirmers find places. What has been found wrong is not said again in other words.
pub fn places(system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    if found.iter().any(Diagnostic::is_error) {
        return;
    }
    let random = system.species.iter().position(|s| s.start == "random");
    let crowding = start::crowding(system);
    let doubtful = random.filter(|_| crowding > start::SURE);
    // A run of this seed finds the very same.
    let tried = doubtful.is_some() && system.squirmer_count() <= TRIED;
    if let Err(error) = if tried { start::poses(system).map(drop) } else { start::check(system) } {
        found.push(no_start(&error, system, root));
    } else if let Some(index) = doubtful.filter(|_| !tried) {
        let at = Place { root, index: index.to_string() };
        let bare = 1.0 - system.fluid_volume() / system.domain.volume();
        found.push(
            Diagnostic::warning(format!(
                "the squirmers fill {:.1} % of the box, and with the gaps of a random start {:.0} % of the room for them: \
                 the run may find no places and not begin",
                100.0 * bare,
                100.0 * crowding
            ))
            .at(at.of(&["count"]), "many")
            .help(format!("stay below {:.0} % with the gaps, or take start = \"lattice\"", 100.0 * start::SURE)),
        );
    }
}
