//! Where the arrays of a run lie: in memory of their own, or in that of others that hold nothing as long as they do.

use super::adapter::AdapterSummary;
use crate::buffers::{Buffer, OVERLAYS, Sizes, lodgers};
use std::collections::HashMap;

/// Bytes that begin so far behind the start of a block of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub block: usize,
    pub offset: u64,
    pub bytes: u64,
}

/// Blocks of memory, and the places of arrays in them.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// Each with the first array that lies in it, and its bytes.
    pub blocks: Vec<(&'static str, u64)>,
    /// The parts of each array.
    pub arrays: HashMap<&'static str, Vec<Place>>,
}

impl Layout {
    /// Of these buffers, with `room` bytes more at the end of each, which nobody else may have either: then none lies in another's memory. Places
    /// begin at multiples of `align`.
    pub fn new(
        wanted: &[&'static Buffer],
        (sizes, room): (&Sizes, u64),
        (summary, align): (&AdapterSummary, u64),
    ) -> Self {
        let mut layout = Self::default();
        let lengths = |name: &str| {
            let found = wanted.iter().find(|b| b.name == name);
            found.map_or(Vec::new(), |b| lengths(summary, (sizes.bytes(b) + room).next_multiple_of(16)))
        };
        let there = |name: &str| room == 0 && wanted.iter().any(|b| b.name == name);
        let lodging = lodgers(there, sizes);
        for overlay in OVERLAYS.iter().filter(|o| o.guests.iter().any(|guest| lodging.contains(guest))) {
            let mut free: Vec<Place> = Vec::new();
            for host in overlay.hosts {
                let places = lengths(host).into_iter().map(|bytes| {
                    // As many side by side as fit: a guest need not end where a host does.
                    let begin = free.last().map_or(0, |last| last.bytes.next_multiple_of(align));
                    match free.last_mut().filter(|_| begin + bytes <= summary.largest_buffer) {
                        Some(last) => {
                            last.bytes = begin + bytes;
                            layout.blocks[last.block].1 = last.bytes;
                            Place { block: last.block, offset: begin, bytes }
                        }
                        None => {
                            free.push(layout.block(host, bytes));
                            free[free.len() - 1]
                        }
                    }
                });
                let places = places.collect();
                layout.arrays.insert(host, places);
            }
            for guests in [&overlay.guests[..], overlay.later] {
                let mut free = free.clone();
                for guest in guests.iter().filter(|guest| lodging.contains(guest)) {
                    let places = lengths(guest).into_iter().map(|bytes| layout.lodge(guest, bytes, (&mut free, align)));
                    let places = places.collect();
                    layout.arrays.insert(guest, places);
                }
            }
        }
        for buffer in wanted {
            if !layout.arrays.contains_key(buffer.name) {
                let places = lengths(buffer.name).into_iter().map(|bytes| layout.block(buffer.name, bytes)).collect();
                layout.arrays.insert(buffer.name, places);
            }
        }
        layout
    }

    /// Bytes of all blocks.
    pub fn bytes(&self) -> u64 {
        self.blocks.iter().map(|(_, bytes)| bytes).sum()
    }

    /// A place for a guest in the first space that is large enough, or else in a block of its own.
    fn lodge(&mut self, guest: &'static str, bytes: u64, (free, align): (&mut [Place], u64)) -> Place {
        let Some(space) = free.iter_mut().find(|f| f.bytes >= bytes) else {
            return self.block(guest, bytes);
        };
        let place = Place { bytes, ..*space };
        let taken = bytes.next_multiple_of(align).min(space.bytes);
        *space = Place { offset: space.offset + taken, bytes: space.bytes - taken, ..*space };
        place
    }

    /// A new block.
    fn block(&mut self, name: &'static str, bytes: u64) -> Place {
        self.blocks.push((name, bytes));
        Place { block: self.blocks.len() - 1, offset: 0, bytes }
    }
}

/// Bytes of each part of an array of so many.
fn lengths(summary: &AdapterSummary, bytes: u64) -> Vec<u64> {
    let parts = summary.parts(bytes);
    let most = if parts > 1 { summary.part() } else { bytes };
    (0..parts).map(|k| most.min(bytes - k * most)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buffers::CATALOGUE;

    /// 1,000 particles, and bricks with room for 1,280: arrays of 16,000 and 8,000, and of 10,240 bytes.
    fn layout(names: &[&str], room: u64, limits: (u64, u64)) -> Layout {
        let sizes = Sizes { particles: 1000, cells: 128, room: 1280, ..Sizes::default() };
        laid_out(names, (&sizes, room), limits)
    }

    fn laid_out(names: &[&str], how: (&Sizes, u64), (binding, buffer): (u64, u64)) -> Layout {
        let wanted: Vec<&Buffer> = CATALOGUE.iter().filter(|b| names.contains(&b.name)).collect();
        let summary = AdapterSummary {
            index: 0,
            name: String::new(),
            kind: "",
            driver: String::new(),
            backend: String::new(),
            largest_binding: binding,
            largest_buffer: buffer,
            most_bindings: 32,
            usable: true,
        };
        Layout::new(&wanted, how, (&summary, 256))
    }

    const HOME: [&str; 5] = ["particles", "velocities_yz", "bricks_xy", "bricks_zu", "bricks_vw"];

    fn places(layout: &Layout, name: &str) -> Vec<(usize, u64, u64)> {
        layout.arrays[name].iter().map(|p| (p.block, p.offset, p.bytes)).collect()
    }

    #[test]
    fn a_row_lies_in_its_bricks() {
        let all = layout(&HOME, 0, (1 << 20, 1 << 20));
        assert_eq!(all.blocks, [("bricks_xy", 30_720)]);
        assert_eq!(places(&all, "bricks_zu"), [(0, 10_240, 10_240)]);
        assert_eq!(places(&all, "bricks_vw"), [(0, 20_480, 10_240)]);
        assert_eq!(places(&all, "particles"), [(0, 0, 16_000)]);
        // At the next multiple of 256.
        assert_eq!(places(&all, "velocities_yz"), [(0, 16_128, 8_000)]);
        assert_eq!(all.bytes(), 30_720);
    }

    #[test]
    fn what_comes_later_shares_with_the_guests() {
        let names =
            ["particles_next", "velocities_yz_next", "moments", "bricks_xy_next", "bricks_zu_next", "bricks_vw_next"];
        let all = layout(&names, 0, (1 << 20, 1 << 20));
        assert_eq!(places(&all, "particles_next"), [(0, 0, 16_000)]);
        assert_eq!(places(&all, "moments"), [(0, 0, 128 * 96)]);
        assert_eq!(all.bytes(), 30_720);
        // A loose run has them in memory of their own.
        assert_eq!(layout(&names[..3], 0, (1 << 20, 1 << 20)).bytes(), 24_000 + 128 * 96);
    }

    #[test]
    fn what_is_alone_has_memory_of_its_own() {
        let apart = layout(&HOME, 64, (1 << 20, 1 << 20));
        assert_eq!(apart.blocks.len(), 5);
        assert_eq!(apart.bytes(), 24_000 + 3 * 10_240 + 5 * 64);
        // Without bricks, or with the other set only.
        let row = layout(
            &["particles", "velocities_yz", "bricks_xy_next", "bricks_zu_next", "bricks_vw_next"],
            0,
            (1 << 20, 1 << 20),
        );
        assert_eq!((row.blocks.len(), row.bytes()), (5, 24_000 + 3 * 10_240));
        assert!(row.arrays.values().flatten().all(|p| p.offset == 0));
    }

    #[test]
    fn parts_find_places_one_by_one() {
        // Parts of 4,096 bytes, two of them in a buffer.
        let parts = layout(&HOME, 0, (4096, 9000));
        assert_eq!(places(&parts, "bricks_xy"), [(0, 0, 4096), (0, 4096, 4096), (1, 0, 2048)]);
        // The last of xy and the first of zu share a buffer, of which 2,048 remain when a third of the row's is there.
        assert_eq!(places(&parts, "bricks_zu"), [(1, 2048, 4096), (2, 0, 4096), (2, 4096, 2048)]);
        assert_eq!(places(&parts, "particles"), [(0, 0, 4096), (0, 4096, 4096), (1, 0, 4096), (2, 0, 3712)]);
        for (name, places) in &parts.arrays {
            for place in places {
                let (_, bytes) = parts.blocks[place.block];
                assert!(place.offset % 256 == 0 && place.offset + place.bytes <= bytes.min(9000), "{name} {place:?}");
            }
        }
        assert_eq!(parts.bytes(), 30_720);
    }

    #[test]
    fn who_finds_no_place_has_a_block_of_its_own() {
        // Hosts that cannot lie side by side, none of which holds the whole of the row's first array.
        let apart = layout(&HOME, 0, (16_000, 16_000));
        assert_eq!(apart.blocks.iter().map(|b| b.1).collect::<Vec<_>>(), [10_240, 10_240, 10_240, 16_000]);
        assert_eq!(places(&apart, "particles"), [(3, 0, 16_000)]);
        assert_eq!(places(&apart, "velocities_yz"), [(0, 0, 8_000)]);
    }

    #[test]
    fn guests_of_one_set_never_share_a_byte() {
        for binding in [1024, 2048, 4096, 8192, 10_240, 20_000] {
            for buffer in [20_480, 24_000, 31_000] {
                let all = layout(&HOME, 0, (binding, buffer));
                let mut taken: Vec<(usize, u64, u64)> =
                    ["particles", "velocities_yz"].iter().flat_map(|name| places(&all, name)).collect();
                taken.sort_unstable();
                assert_eq!(taken.iter().map(|p| p.2).sum::<u64>(), 24_000);
                assert!(taken.windows(2).all(|w| w[0].0 < w[1].0 || w[0].1 + w[0].2 <= w[1].1), "{taken:?}");
                assert_eq!(all.bytes(), 30_720, "{binding} {buffer}");
            }
        }
    }

    /// Boxes of 10 particles per cell on an H100, whose bindings end at 2 GiB and whose buffers at 4: everybody finds a place.
    #[test]
    fn large_boxes_need_no_more_than_their_bricks() {
        for edge in [100u64, 200, 230, 238, 256, 300, 368, 400, 464] {
            let sizes = Sizes { particles: 10 * edge.pow(3), cells: edge.pow(3), room: 1584, ..Sizes::default() };
            let all = laid_out(&HOME, (&sizes, 0), (2_147_483_644, 4_292_870_144));
            // Two arrays of a set may begin 128 bytes behind the end of the one before.
            let spare = all.bytes() - 24 * sizes.count(crate::buffers::Extent::Rooms);
            assert!(spare == 0 || spare == 256, "{edge}: {spare}");
            assert!(all.blocks.iter().all(|(_, bytes)| *bytes <= 4_292_870_144), "{edge}");
        }
    }
}
