//! Any bytes as a snapshot, or as changes to one, with and without a right checksum: parsing and decoding end with values or an error.
#![no_main]

#[path = "../../tests/rig/messages.rs"]
mod messages;

use libfuzzer_sys::fuzz_target;
use messages::honest;
use squirm::wire::{Column, Fields, Header, Kind, MAGIC, Particles, Scalars, Snapshot, Squirmers, Status, VERSION};

const HEAD: usize = size_of::<Header>();

fn read(bytes: &[u8]) {
    let Ok(snapshot) = Snapshot::parse(bytes) else { return };
    for column in snapshot.columns() {
        let (name, n) = (column.name(), column.components);
        let _ = (snapshot.flat::<u8>(name, n), snapshot.flat::<u32>(name, n));
        let _ = (snapshot.flat::<f32>(name, n), snapshot.flat::<f64>(name, n));
    }
    let _ = (Squirmers::decode(&snapshot), Scalars::decode(&snapshot), Fields::decode(&snapshot));
    let _ = (Particles::decode(&snapshot), Status::decode(&snapshot));
}

/// Makes magic, version and checksum right: what is behind them would hardly ever be reached.
fn sealed(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut header: Header = bytemuck::pod_read_unaligned(bytes.get(..HEAD)?);
    (header.magic, header.version) = (MAGIC, VERSION);
    let start = header.table as usize;
    let end = start.saturating_add((header.columns as usize).saturating_mul(size_of::<Column>()));
    // A table inside the header is refused.
    header.checksum = header.checksum_with(bytes.get(start.max(HEAD)..end).unwrap_or(&[]));
    let mut sealed = bytes.to_vec();
    sealed[..HEAD].copy_from_slice(bytemuck::bytes_of(&header));
    Some(sealed)
}

fuzz_target!(|bytes: &[u8]| {
    let message = match bytes.split_first() {
        Some((first, changes)) if usize::from(*first) < Kind::ALL.len() => {
            let mut message = honest(Kind::ALL[usize::from(*first)]);
            for change in changes.chunks_exact(3) {
                let at = usize::from(u16::from_le_bytes([change[0], change[1]])) % message.len();
                message[at] = change[2];
            }
            message
        }
        _ => bytes.to_vec(),
    };
    read(&message);
    sealed(&message).iter().for_each(|message| read(message));
});
