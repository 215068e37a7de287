//! Messages of every kind as the program writes them, for tests and fuzz targets that change them.

use squirm::wire::{Fields, Kind, Particles, Scalars, SpeciesRow, Squirmers, Stamp, Status};

/// An honest message of each kind.
pub fn honest(kind: Kind) -> Vec<u8> {
    let stamp = Stamp { box_size: [8.0; 3], ..Stamp::default() };
    let vectors = || vec![[1.0f32; 3]; 2];
    match kind {
        Kind::Squirmers => Squirmers {
            id: vec![0, 1],
            species: vec![0, 0],
            position: vectors(),
            unwrapped: vec![[1.0; 3]; 2],
            axis: vectors(),
            orientation: vec![[0.0; 4]; 2],
            velocity: vectors(),
            angular_velocity: vectors(),
            force: vectors(),
            torque: vectors(),
            table: vec![SpeciesRow { name: "a".into(), ..SpeciesRow::default() }],
        }
        .encode(&stamp),
        Kind::Scalars => {
            let mut scalars = Scalars::default();
            scalars.push("temperature", "kT", 1.0);
            scalars.encode(&stamp)
        }
        Kind::Fields => {
            let fields = Fields { block: 2, blocks: [1, 1, 2], density: vec![5.0; 2], velocity: vectors() };
            fields.encode(&stamp)
        }
        Kind::Particles => {
            let particles = Particles { position: vectors(), velocity: vectors(), ..Particles::default() };
            particles.encode(&stamp)
        }
        Kind::Status => Status { stages: vec![("stream".into(), 1.0)], ..Status::default() }.encode(&stamp),
    }
}
