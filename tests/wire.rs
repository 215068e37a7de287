//! Snapshot messages: round trips, tolerance of any alignment, and refusal of whatever was damaged.

use proptest::prelude::*;
use squirm::wire::{
    Encoder, Fields, Header, Kind, Particles, Scalar, Scalars, Snapshot, SpeciesRow, Squirmers, Stamp, WireError,
};

fn stamp() -> Stamp {
    Stamp {
        run_id: *b"0123456789abcdef",
        step: 40,
        time: 2.0,
        seq: 2,
        every: 20,
        box_size: [48.0, 12.0, 24.0],
        walls: true,
    }
}

fn squirmers(n: u32) -> Squirmers {
    let v = |k: u32| (0..n).map(|i| [i as f32, k as f32, 0.5]).collect::<Vec<_>>();
    Squirmers {
        id: (0..n).collect(),
        species: (0..n).map(|i| i % 2).collect(),
        position: v(1),
        unwrapped: (0..n).map(|i| [f64::from(i) + 1e-9, -100.25, 3.0]).collect(),
        axis: v(2),
        orientation: (0..n).map(|i| [0.0, 0.0, i as f32, 1.0]).collect(),
        velocity: v(3),
        angular_velocity: v(4),
        force: v(5),
        torque: v(6),
        table: ["puller", "pusher"]
            .map(|name| SpeciesRow {
                name: name.into(),
                along: 4.0,
                across: 2.0,
                b1: 0.1,
                beta: 1.0,
                rotlet: 0.0,
                u0: 0.07,
            })
            .to_vec(),
    }
}

#[test]
fn header_fields_lie_where_the_format_says() {
    let bytes = squirmers(3).encode(&stamp());
    let u32_at = |o: usize| u32::from_le_bytes(bytes[o..o + 4].try_into().unwrap());
    let u64_at = |o: usize| u64::from_le_bytes(bytes[o..o + 8].try_into().unwrap());
    let f64_at = |o: usize| f64::from_le_bytes(bytes[o..o + 8].try_into().unwrap());
    assert_eq!(&bytes[..8], b"\x89SQRM\r\n\x1a");
    assert_eq!((u32_at(8), u32_at(12), &bytes[16..32]), (1, 1, &b"0123456789abcdef"[..]));
    assert_eq!((u64_at(32), f64_at(40), u64_at(48), u64_at(56)), (40, 2.0, 2, bytes.len() as u64));
    assert_eq!((u64_at(64), u64_at(72), f64_at(80), f64_at(88), f64_at(96)), (3, 3, 48.0, 12.0, 24.0));
    assert_eq!((f64_at(104), u64_at(112), u32_at(120), u32_at(124), u32_at(128)), (1.0, 20, 1, 16, 160));
    // The fourth column, by hand: unwrapped positions.
    let entry = 160 + 3 * 64;
    assert_eq!(&bytes[entry..entry + 10], b"unwrapped\0");
    assert_eq!(&bytes[entry + 24..entry + 26], b"a\0");
    assert_eq!((u32_at(entry + 40), u32_at(entry + 44), u64_at(entry + 56)), (4, 3, 3));
    assert_eq!(f64_at(u64_at(entry + 48) as usize + 8), -100.25);
    assert_eq!(bytes.len() % 16, 0);
}

#[test]
fn any_alignment_reads_the_same() {
    let (expected, bytes) = (squirmers(5), squirmers(5).encode(&stamp()));
    for shift in 0..8 {
        let mut moved = vec![0u8; shift];
        moved.extend_from_slice(&bytes);
        let snapshot = Snapshot::parse(&moved[shift..]).unwrap();
        assert_eq!((Squirmers::decode(&snapshot).unwrap(), snapshot.header.stamp()), (expected.clone(), stamp()));
    }
}

#[test]
fn a_message_may_stand_in_a_longer_buffer() {
    let mut bytes = squirmers(1).encode(&stamp());
    let length = bytes.len();
    bytes.resize(length + 100, 0xaa);
    assert_eq!(Snapshot::parse(&bytes).unwrap().bytes().len(), length);
}

#[test]
fn fields_keep_their_grid_and_particles_their_population() {
    let fields = Fields { block: 2, blocks: [2, 3, 1], density: vec![1.5; 6], velocity: vec![[0.1, 0.2, 0.3]; 6] };
    assert_eq!(Fields::decode(&Snapshot::parse(&fields.encode(&stamp())).unwrap()).unwrap(), fields);
    let wrong = Fields { blocks: [2, 3, 2], ..fields };
    assert!(matches!(Fields::decode(&Snapshot::parse(&wrong.encode(&stamp())).unwrap()), Err(WireError::Malformed(_))));

    let some = Particles {
        fraction: 0.5,
        population: 4,
        position: vec![[1.0; 3]; 2],
        velocity: vec![[2.0; 3]; 2],
        ..Particles::default()
    };
    let read = Particles::decode(&Snapshot::parse(&some.encode(&stamp())).unwrap()).unwrap();
    assert_eq!((read.complete(), read), (false, some.clone()));
    assert!(Particles { population: 2, ..some }.complete());
}

#[test]
fn lengths_are_known_beforehand() {
    for n in [0u32, 1, 2, 3, 7] {
        let (count, v) = (n as usize, vec![[0.0f32; 3]; n as usize]);
        assert_eq!(squirmers(n).encode(&stamp()).len(), Squirmers::message_bytes(count, 2));
        let scalars = Scalars { list: vec![Scalar::default(); count] };
        assert_eq!(scalars.encode(&stamp()).len(), Scalars::message_bytes(count));
        let fields = Fields { block: 1, blocks: [n, 1, 1], density: vec![0.0; count], velocity: v.clone() };
        assert_eq!(fields.encode(&stamp()).len(), Fields::message_bytes(count));
        let mut particles = Particles { position: v.clone(), velocity: v.clone(), ..Particles::default() };
        assert_eq!(particles.encode(&stamp()).len(), Particles::message_bytes(count, false));
        particles.rest = v;
        assert_eq!(particles.encode(&stamp()).len(), Particles::message_bytes(count, count > 0));
    }
}

#[test]
fn errors_name_what_was_wrong() {
    let bytes = squirmers(2).encode(&stamp());
    let snapshot = Snapshot::parse(&bytes).unwrap();
    let shown = |e: WireError| e.to_string();
    assert_eq!(shown(snapshot.values::<f32>("mass").unwrap_err()), "this squirmers snapshot has no column `mass`");
    assert_eq!(shown(snapshot.rows::<f64, 3>("axis").unwrap_err()), "column `axis` holds 3 x f32, not 3 x f64");
    assert_eq!(shown(Scalars::decode(&snapshot).unwrap_err()), "a squirmers snapshot where scalars was expected");
    assert!(matches!(Snapshot::parse(&bytes[..100]), Err(WireError::Truncated { have: 100, need: 160 })));
    assert!(matches!(Snapshot::parse(b"{\"json\": true}".repeat(20).as_slice()), Err(WireError::Magic(_))));
}

#[test]
fn a_newer_version_is_refused_by_number() {
    let mut bytes = squirmers(2).encode(&stamp());
    bytes[8] = 2;
    assert_eq!(Snapshot::parse(&bytes).unwrap_err(), WireError::Version(2));
}

#[test]
fn unknown_species_are_refused() {
    let mut bad = squirmers(2);
    bad.species[1] = 7;
    let bytes = bad.encode(&stamp());
    assert!(matches!(Squirmers::decode(&Snapshot::parse(&bytes).unwrap()), Err(WireError::Malformed(_))));
}

/// A table that lies about its columns, with a checksum that matches.
#[test]
fn columns_outside_the_message_are_refused() {
    let honest = squirmers(2).encode(&stamp());
    let offset_of_first_column = 160 + 48;
    for (position, value) in [(0, u64::MAX - 7), (0, 1 << 40), (8, u64::MAX / 2), (8, 1 << 20), (0, 164)] {
        let mut bytes = honest.clone();
        bytes[offset_of_first_column + position..][..8].copy_from_slice(&value.to_le_bytes());
        let header: Header = bytemuck::pod_read_unaligned(&bytes[..160]);
        let checksum = header.checksum_with(&bytes[160..160 + 16 * 64]);
        bytes[156..160].copy_from_slice(&checksum.to_le_bytes());
        assert!(matches!(Snapshot::parse(&bytes), Err(WireError::Malformed(_))), "{position} {value}");
    }
}

#[test]
fn every_flipped_bit_of_header_and_table_is_refused() {
    let bytes = squirmers(2).encode(&stamp());
    for bit in 0..(160 + 16 * 64) * 8 {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(Snapshot::parse(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn every_truncation_is_refused() {
    let bytes = squirmers(2).encode(&stamp());
    assert!((0..bytes.len()).all(|n| Snapshot::parse(&bytes[..n]).is_err()));
}

proptest! {
    #[test]
    fn scalars_round_trip(list in prop::collection::vec(("[a-z_]{1,32}", "[a-zA-Z/^0-9]{0,16}", any::<f64>()), 0..20),
                          step in any::<u64>(), time in -1e12f64..1e12, seq in any::<u64>(), every in any::<u64>()) {
        let list: Vec<Scalar> = list.into_iter().map(|(name, unit, value)| Scalar { name, unit, value }).collect();
        let stamp = Stamp { step, time, seq, every, ..stamp() };
        let bytes = Scalars { list: list.clone() }.encode(&stamp);
        let snapshot = Snapshot::parse(&bytes).unwrap();
        prop_assert_eq!(snapshot.header.stamp(), stamp);
        let read = Scalars::decode(&snapshot).unwrap().list;
        prop_assert_eq!(read.len(), list.len());
        for (a, b) in read.iter().zip(&list) {
            prop_assert_eq!((&a.name, &a.unit, a.value.to_bits()), (&b.name, &b.unit, b.value.to_bits()));
        }
    }

    #[test]
    fn columns_round_trip(a in prop::collection::vec(any::<[f32; 3]>(), 0..40), b in prop::collection::vec(any::<u32>(), 0..40),
                          c in prop::collection::vec(any::<[f64; 2]>(), 0..40), d in prop::collection::vec(any::<[u8; 5]>(), 0..40)) {
        let bytes = Encoder::new(Kind::Fields, &stamp())
            .column("a", "", &a).flat("b", "kT", 1, &b).column("c", "", &c).column("d", "", &d).finish();
        let snapshot = Snapshot::parse(&bytes).unwrap();
        let bits = |v: &[[f32; 3]]| v.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&snapshot.rows::<f32, 3>("a").unwrap()), bits(&a));
        prop_assert_eq!(snapshot.values::<u32>("b").unwrap(), b);
        let bits = |v: &[[f64; 2]]| v.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&snapshot.rows::<f64, 2>("c").unwrap()), bits(&c));
        prop_assert_eq!(snapshot.rows::<u8, 5>("d").unwrap(), d);
        prop_assert_eq!(snapshot.columns()[1].unit(), "kT");
    }

    /// Whatever the bytes are, reading them ends; what parses can be asked for anything.
    #[test]
    fn damaged_messages_never_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..30), cut in any::<prop::sample::Index>()) {
        let mut bytes = squirmers(3).encode(&stamp());
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(cut.index(bytes.len()) + 1);
        // A checksum that matches, so that the checks behind it are reached.
        if bytes.len() >= 160 {
            let header: Header = bytemuck::pod_read_unaligned(&bytes[..160]);
            let end = (160 + header.columns as usize * 64).min(bytes.len());
            let checksum = header.checksum_with(&bytes[160..end]);
            bytes[156..160].copy_from_slice(&checksum.to_le_bytes());
        }
        if let Ok(snapshot) = Snapshot::parse(&bytes) {
            let _ = (Squirmers::decode(&snapshot), Scalars::decode(&snapshot), Fields::decode(&snapshot), Particles::decode(&snapshot));
        }
    }
}

#[test]
fn positions_are_exact_where_all_are_sent_and_never_rounded_out_of_the_box() {
    // The last position that a box of 300 has, and one that an f32 cannot hold.
    let unit = 300.0 / 4_294_967_296.0;
    let position = [300.0 - unit, 123_456_789.0 * unit, 0.0];
    let mut all = Particles { population: 1, ..Particles::default() };
    all.push(position, [1.0; 3], [300.0; 3], true);
    let read = Particles::decode(&Snapshot::parse(&all.encode(&stamp())).unwrap()).unwrap();
    assert_eq!((read.place(0), &read), (position, &all));
    let mut share = Particles { population: 2, ..Particles::default() };
    share.push(position, [1.0; 3], [300.0; 3], false);
    assert!(share.rest.is_empty() && share.position[0][0] < 300.0);
    assert!(share.place(0)[1] != position[1] && (share.place(0)[1] - position[1]).abs() < 3e-5);
}
