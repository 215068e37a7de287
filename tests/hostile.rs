//! Messages that somebody made up: whatever the numbers in header and column table are, reading ends with values or an error.

#[path = "rig/messages.rs"]
mod messages;

use iceoryx2::prelude::{NodeBuilder, PortFactory as _, SignalHandlingMode, ipc};
use messages::honest;
use proptest::prelude::*;
use squirm::analyze::{Limits, Live, Source};
use squirm::wire::domain::{self, Block};
use squirm::wire::{Column, Fields, Header, Kind, Particles, Scalars, Snapshot, Squirmers, Status};
use std::ops::ControlFlow;
use std::time::Duration;

const HEAD: usize = size_of::<Header>();
const ENTRY: usize = size_of::<Column>();

/// Makes the checksum right, so that the checks behind it are reached; says where the table lies, if inside the message.
fn seal(bytes: &mut [u8]) {
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..HEAD]);
    let start = header.table as usize;
    let table = start..start.saturating_add((header.columns as usize).saturating_mul(ENTRY));
    let table = bytes.get(table).unwrap_or(&[]).to_vec();
    let checksum = header.checksum_with(&table);
    bytes[HEAD - 4..HEAD].copy_from_slice(&checksum.to_le_bytes());
}

/// Asks a message for everything that readers ask for.
fn read(bytes: &[u8]) -> bool {
    let Ok(snapshot) = Snapshot::parse(bytes) else { return false };
    for column in snapshot.columns() {
        let (name, n) = (column.name(), column.components);
        let _ = (snapshot.flat::<u8>(name, n), snapshot.flat::<u32>(name, n));
        let _ = (snapshot.flat::<f32>(name, n), snapshot.flat::<f64>(name, n));
        let _ = (column.unit(), snapshot.texts::<32>(name));
    }
    let _ = (Squirmers::decode(&snapshot), Scalars::decode(&snapshot), Fields::decode(&snapshot));
    let _ = (Particles::decode(&snapshot).map(|p| p.complete()), Status::decode(&snapshot));
    true
}

/// Numbers at which arithmetic goes wrong, and some that are nearly right.
fn nasty() -> impl Strategy<Value = u64> {
    let edges =
        [0, 1, 2, 3, 7, 8, 16, 159, 160, 224, u64::MAX, u64::MAX / 2, u64::MAX / 64, 1 << 32, u64::from(u32::MAX)];
    prop_oneof![prop::sample::select(edges.to_vec()), 0..2048u64, any::<u64>()]
}

#[test]
fn honest_messages_are_read() {
    for kind in Kind::ALL {
        let mut bytes = honest(kind);
        assert!(read(&bytes));
        seal(&mut bytes);
        assert_eq!(bytes, honest(kind), "the seal of the test is the true one");
    }
}

/// Somebody who publishes what he likes where a run's scalars are expected.
#[test]
fn a_live_reader_skips_what_is_no_snapshot_of_its_topic_and_says_so() {
    let run = format!("rogue-{}", std::process::id());
    let config = domain::config().unwrap();
    let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    let node = builder.create::<ipc::Service>().unwrap();
    let name = domain::service(&run, "scalars").unwrap();
    let service = node.service_builder(&name).publish_subscribe::<[Block]>().user_header::<Header>();
    let service = service.history_size(1).subscriber_max_buffer_size(8).open_or_create().unwrap();
    let _events = node.service_builder(&name).event().open_or_create().unwrap();
    let publisher = service.publisher_builder().initial_max_slice_len(256).create().unwrap();
    let publish = |bytes: &[u8]| {
        let blocks = bytes.as_chunks::<16>().0;
        let sample = publisher.loan_slice_uninit(blocks.len()).unwrap();
        sample.write_from_fn(|i| Block(blocks[i])).send().unwrap()
    };
    let reader = std::thread::spawn(move || {
        let limits = Limits { snapshots: Some(2), duration: Some(Duration::from_secs(30)), ..Limits::default() };
        let mut seen = 0;
        let ending = Live::new(&run, limits).drive(&[Kind::Scalars], &mut |s| {
            assert_eq!(s.kind(), Kind::Scalars);
            seen += 1;
            Ok(ControlFlow::Continue(()))
        });
        (seen, ending.unwrap().warnings)
    });
    while service.dynamic_config().number_of_subscribers() == 0 {
        std::thread::sleep(Duration::from_millis(5));
    }
    publish(&honest(Kind::Scalars));
    publish(&[0xff; 320]);
    publish(&honest(Kind::Squirmers));
    publish(&[]);
    publish(&honest(Kind::Scalars));
    let (seen, warnings) = reader.join().unwrap();
    assert_eq!(seen, 2);
    let about = |w: &String| w.contains("3 messages on scalars were skipped: not a squirm snapshot");
    assert!(warnings.iter().any(about), "{warnings:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Fields of the header (at multiples of four behind the version) and of the column table get nasty numbers.
    #[test]
    fn no_number_in_a_message_makes_a_reader_panic(
        kind in prop::sample::select(Kind::ALL.to_vec()),
        edits in prop::collection::vec((any::<prop::sample::Index>(), nasty(), any::<bool>()), 1..4),
        longer in 0..3usize,
    ) {
        let mut bytes = honest(kind);
        let end = HEAD + u32::from_le_bytes(bytes[124..128].try_into().unwrap()) as usize * ENTRY;
        for (at, number, wide) in edits {
            let at = 12 + 4 * at.index((end - 20) / 4);
            let width = if wide { 8 } else { 4 };
            bytes[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
        }
        bytes.resize(bytes.len() + 16 * longer, 0xff);
        seal(&mut bytes);
        read(&bytes);
    }

    /// Bytes that are not even meant to be a message.
    #[test]
    fn no_bytes_make_a_reader_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..1024), head in any::<bool>()) {
        if head && bytes.len() >= HEAD {
            bytes[..12].copy_from_slice(&honest(Kind::Scalars)[..12]);
            seal(&mut bytes);
        }
        read(&bytes);
    }
}
