//! Arrays that lie in the memory of others.

use super::Sizes;

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

/// Which buffers lie in the memory of others in a run that has these: of each set as many as there is room for.
pub fn lodgers(there: impl Fn(&str) -> bool, sizes: &Sizes) -> Vec<&'static str> {
    let bytes = |name: &str| super::find(name).map_or(0, |buffer| sizes.bytes(buffer));
    let mut all = Vec::new();
    for overlay in OVERLAYS.iter().filter(|o| o.hosts.into_iter().all(&there)) {
        let room: u64 = overlay.hosts.into_iter().map(bytes).sum();
        for set in [&overlay.guests[..], overlay.later] {
            let mut left = room;
            for guest in set.iter().filter(|guest| there(guest)) {
                if let Some(less) = left.checked_sub(bytes(guest)) {
                    left = less;
                    all.push(*guest);
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lodging(room: u64, cells: u64, there: impl Fn(&str) -> bool) -> Vec<&'static str> {
        lodgers(there, &Sizes { particles: 1000, cells, room, ..Sizes::default() })
    }

    #[test]
    fn who_finds_room_in_bricks() {
        // Two bricks, so that there are `room` places of 24 bytes in each set; the sums of a cell take 96.
        assert_eq!(
            lodging(1000, 128, |_| true),
            ["particles", "velocities_yz", "particles_next", "velocities_yz_next", "moments"]
        );
        assert_eq!(lodging(1000, 128, |name| name != "bricks_zu"), ["particles_next", "velocities_yz_next", "moments"]);
        assert_eq!(lodging(1000, 128, |name| !name.ends_with("_next")), ["particles", "velocities_yz"]);
        // 12,288 bytes of sums in 12,264.
        assert_eq!(
            lodging(511, 128, |name| !name.contains("particles") && !name.contains("velocities")),
            Vec::<&str>::new()
        );
        assert_eq!(lodging(512, 128, |name| !name.contains("particles") && !name.contains("velocities")), ["moments"]);
    }
}
