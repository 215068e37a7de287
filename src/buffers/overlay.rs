//! Arrays that lie in the memory of others.

/// Buffers that lie in the memory of others, since never both hold something.
#[derive(Debug)]
pub struct Overlay {
    /// Whose memory it is.
    pub hosts: [&'static str; 3],
    /// What lies there, too.
    pub guests: [&'static str; 2],
    /// What lies there when neither they nor those do.
    pub later: &'static [&'static str],
}

/// While particles lie in bricks there is no row of them. They leave it for the second set of bricks, and come back to it from either: what they
/// come from is not free, the other set is. Where they lie in bricks sums over cells are in memory only for snapshots, when they lie in their row.
pub const OVERLAYS: [Overlay; 2] = [
    Overlay { hosts: ["bricks_xy", "bricks_zu", "bricks_vw"], guests: ["particles", "velocities_yz"], later: &[] },
    Overlay {
        hosts: ["bricks_xy_next", "bricks_zu_next", "bricks_vw_next"],
        guests: ["particles_next", "velocities_yz_next"],
        later: &["moments"],
    },
];

/// Whether a buffer lies in the memory of others in a run that has these.
pub fn lodges(name: &str, there: impl Fn(&str) -> bool) -> bool {
    let lies = |o: &&Overlay| o.guests.iter().chain(o.later).any(|guest| *guest == name);
    OVERLAYS.iter().filter(lies).any(|o| o.hosts.into_iter().all(&there))
}
