//! The fluid in the middle plane of the box, as viewers draw it: coloured by its speed, with the numbers beside the colour.

use super::scene::{FRAME, RGBA, packed_fields, pose, timestamp, vector};
use crate::wire::{Fields, Header};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{Grid, PackedElementField, Vector2, VoxelGrid};
use glam::{DQuat, DVec3};

/// How thick a slab is drawn, in a: thin, so that it hides no squirmer.
const THICKNESS: f64 = 0.1;
/// Colour of a block at rest, and of one at [`FAST`] or above.
const COLOURS: [[f32; 3]; 2] = [[247.0, 251.0, 255.0], [8.0, 48.0, 107.0]];
/// Where the colours end, in root mean squares of the speed in the plane: a single fast block must not make the rest pale.
const FAST: f32 = 2.0;
/// Bytes of a block: five numbers and a colour.
const STRIDE: u32 = 24;

/// The slice as a plane at half the height of the box; its rows run along z, and their cells along x.
pub(super) fn grid(header: &Header, fields: &Fields) -> Grid {
    let edge = f64::from(fields.block);
    // The plane of a grid is its own x-y plane: a quarter turn about x takes y to z.
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    Grid {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        pose: Some(pose(DVec3::new(0.0, header.box_size[1] / 2.0, 0.0), upright)),
        column_count: fields.blocks[0],
        cell_size: Some(Vector2 { x: edge, y: edge }),
        row_stride: STRIDE * fields.blocks[0],
        cell_stride: STRIDE,
        fields: contents(),
        data: blocks(header, fields).into(),
    }
}

/// The slice as one layer of voxels, for viewers that know no grids.
pub(super) fn slab(header: &Header, fields: &Fields) -> VoxelGrid {
    let edge = f64::from(fields.block);
    VoxelGrid {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        pose: Some(pose(DVec3::new(0.0, (header.box_size[1] - THICKNESS) / 2.0, 0.0), DQuat::IDENTITY)),
        row_count: 1,
        column_count: fields.blocks[0],
        cell_size: Some(vector(DVec3::new(edge, THICKNESS, edge))),
        slice_stride: STRIDE * fields.blocks[0],
        row_stride: STRIDE * fields.blocks[0],
        cell_stride: STRIDE,
        fields: contents(),
        data: blocks(header, fields).into(),
    }
}

/// The numbers and the colour of a block; viewers that colour by a number begin with the first.
fn contents() -> Vec<PackedElementField> {
    let numbers = ["speed", "density", "vx", "vy", "vz"].map(|name| (name, NumericType::Float32));
    packed_fields(&[&numbers[..], &RGBA].concat())
}

/// The blocks that the middle plane runs through, x fastest, then z. Empty ones are transparent.
fn blocks(header: &Header, fields: &Fields) -> Vec<u8> {
    let [nx, ny, nz] = fields.blocks.map(|n| n as usize);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let middle = (header.box_size[1] / 2.0 / f64::from(fields.block)) as usize;
    let middle = middle.min(ny.saturating_sub(1));
    let plane: Vec<usize> = (0..nz)
        .flat_map(|z| (0..nx).map(move |x| (z * ny + middle) * nx + x))
        .filter(|i| *i < fields.density.len())
        .collect();
    let speed = |i: usize| glam::Vec3::from_array(fields.velocity[i]).length();
    let (mass, energy) = plane.iter().fold((0.0, 0.0), |(mass, energy), i| {
        (mass + fields.density[*i], energy + fields.density[*i] * speed(*i).powi(2))
    });
    let fast = FAST * (energy / mass).sqrt();
    let mut data = Vec::with_capacity(STRIDE as usize * plane.len());
    for i in plane {
        let [vx, vy, vz] = fields.velocity[i];
        data.extend_from_slice(bytemuck::cast_slice(&[speed(i), fields.density[i], vx, vy, vz]));
        // Without motion, or without fluid, there is no scale.
        let share = if fast > 0.0 { (speed(i) / fast).min(1.0) } else { 0.0 };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        data.extend((0..3).map(|k| (COLOURS[0][k] + share * (COLOURS[1][k] - COLOURS[0][k])).round() as u8));
        data.push(if fields.density[i] > 0.0 { 255 } else { 0 });
    }
    data
}
