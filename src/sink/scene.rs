//! What a viewer draws: Foxglove's messages made from snapshots.

use crate::wire::{Header, Particles, Squirmers};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, FrameTransform, LinePrimitive, PackedElementField, Point3, PointCloud, Pose,
    PosesInFrame, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, Timestamp, Vector3, line_primitive,
};
use glam::{DQuat, DVec3};

/// Points of the fluid beyond which viewers become slow.
pub(super) const MAX_POINTS: usize = 200_000;
/// Everything is in this frame.
pub(super) const FRAME: &str = "box";
/// How thick walls are drawn, in a.
const WALL: f64 = 0.2;
/// Colours that remain apart for the colour-blind (Okabe and Ito 2008), one per species in turn.
const PALETTE: [[f64; 3]; 6] = [
    [0.902, 0.624, 0.0],
    [0.337, 0.706, 0.914],
    [0.0, 0.620, 0.451],
    [0.941, 0.894, 0.259],
    [0.835, 0.369, 0.0],
    [0.8, 0.475, 0.655],
];

/// Names under which viewers find the colour of a point or a block.
pub(super) const RGBA: [(&str, NumericType); 4] = [
    ("red", NumericType::Uint8),
    ("green", NumericType::Uint8),
    ("blue", NumericType::Uint8),
    ("alpha", NumericType::Uint8),
];

/// Simulated time in ns, 1 tau counted as 1 s; times before the start count as the start.
pub(super) fn nanoseconds(time: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let ns = (time * 1e9).round() as u64;
    ns
}

pub(super) fn timestamp(header: &Header) -> Option<Timestamp> {
    let ns = nanoseconds(header.time);
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    #[allow(clippy::cast_possible_truncation)]
    Some(Timestamp::new(seconds, (ns % 1_000_000_000) as u32))
}

pub(super) fn vector(v: DVec3) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

pub(super) fn pose(position: DVec3, orientation: DQuat) -> Pose {
    let [x, y, z, w] = orientation.to_array();
    Pose { position: Some(vector(position)), orientation: Some(Quaternion { x, y, z, w }) }
}

/// Centre and orientation of squirmer `i`, widened.
fn placed(squirmers: &Squirmers, i: usize) -> (DVec3, DQuat) {
    let orientation = DQuat::from_array(squirmers.orientation[i].map(f64::from));
    (DVec3::from_array(squirmers.position[i].map(f64::from)), orientation)
}

/// Viewers draw arrows along x; the swimming axis is the body's z.
fn x_along_axis(orientation: DQuat) -> DQuat {
    orientation * DQuat::from_rotation_y(-std::f64::consts::FRAC_PI_2)
}

/// The frame of the box in the world, for viewers that want a root.
pub(super) fn transform(header: &Header) -> FrameTransform {
    FrameTransform {
        timestamp: timestamp(header),
        parent_frame_id: "world".into(),
        child_frame_id: FRAME.into(),
        translation: Some(vector(DVec3::ZERO)),
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}

/// Poses whose x axes are the swimming axes.
pub(super) fn poses(header: &Header, squirmers: &Squirmers) -> PosesInFrame {
    let one = |i| {
        let (position, orientation) = placed(squirmers, i);
        pose(position, x_along_axis(orientation))
    };
    PosesInFrame {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        poses: (0..squirmers.id.len()).map(one).collect(),
    }
}

/// Spheroids as spheres with a diameter along each axis of the body, and headings.
pub(super) fn scene(header: &Header, squirmers: &Squirmers) -> SceneUpdate {
    let (mut spheres, mut arrows) = (Vec::new(), Vec::new());
    for i in 0..squirmers.id.len() {
        let index = squirmers.species[i] as usize;
        let (position, orientation) = placed(squirmers, i);
        let species = &squirmers.table[index];
        let [r, g, b] = PALETTE[index % PALETTE.len()];
        let size = DVec3::new(species.across, species.across, species.along) * 2.0;
        spheres.push(SpherePrimitive {
            pose: Some(pose(position, orientation)),
            size: Some(vector(size)),
            color: Some(Color { r, g, b, a: 0.8 }),
        });
        arrows.push(ArrowPrimitive {
            pose: Some(pose(position, x_along_axis(orientation))),
            shaft_length: 1.2 * species.along,
            shaft_diameter: 0.15 * species.across,
            head_length: 0.3 * species.along,
            head_diameter: 0.35 * species.across,
            color: Some(Color { r: 0.1, g: 0.1, b: 0.1, a: 1.0 }),
        });
    }
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![SceneEntity { spheres, arrows, ..entity(header, "squirmers") }],
    }
}

/// The box's edges, and its walls as slabs that begin where the fluid ends.
pub(super) fn surroundings(header: &Header) -> SceneUpdate {
    let [x, y, z] = header.box_size;
    let wall = |place: f64| CubePrimitive {
        pose: Some(pose(DVec3::new(x / 2.0, place, z / 2.0), DQuat::IDENTITY)),
        size: Some(vector(DVec3::new(x, WALL, z))),
        color: Some(Color { r: 0.5, g: 0.5, b: 0.5, a: 0.3 }),
    };
    let walls = if header.stamp().walls { vec![wall(-WALL / 2.0), wall(y + WALL / 2.0)] } else { Vec::new() };
    let edges = SceneEntity { lines: vec![edges(header)], ..entity(header, "edges") };
    let walls = SceneEntity { cubes: walls, ..entity(header, "walls") };
    SceneUpdate { deletions: Vec::new(), entities: vec![edges, walls] }
}

fn entity(header: &Header, id: &str) -> SceneEntity {
    SceneEntity { timestamp: timestamp(header), frame_id: FRAME.into(), id: id.into(), ..SceneEntity::default() }
}

/// The twelve edges of the box.
fn edges(header: &Header) -> LinePrimitive {
    let size = header.box_size;
    let corner = |bits: usize| {
        let at = |axis: usize| if bits >> axis & 1 == 1 { size[axis] } else { 0.0 };
        Point3 { x: at(0), y: at(1), z: at(2) }
    };
    let edge = |(from, axis): (usize, usize)| [corner(from), corner(from | 1 << axis)];
    let all = (0..8).flat_map(|from| (0..3).map(move |axis| (from, axis))).filter(|(from, axis)| from >> axis & 1 == 0);
    LinePrimitive {
        r#type: line_primitive::Type::LineList as i32,
        pose: Some(pose(DVec3::ZERO, DQuat::IDENTITY)),
        thickness: 1.0,
        scale_invariant: true,
        points: all.flat_map(edge).collect(),
        color: Some(Color { r: 0.5, g: 0.5, b: 0.5, a: 1.0 }),
        ..LinePrimitive::default()
    }
}

fn cloud(header: &Header, names: &[(&str, NumericType)], data: Vec<u8>) -> PointCloud {
    PointCloud {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        pose: Some(pose(DVec3::ZERO, DQuat::IDENTITY)),
        point_stride: names.iter().map(|(_, kind)| bytes(*kind)).sum(),
        fields: packed_fields(names),
        data: data.into(),
    }
}

/// Names and types of values that follow each other without gaps.
pub(super) fn packed_fields(names: &[(&str, NumericType)]) -> Vec<PackedElementField> {
    let mut offset = 0;
    let place = |(name, kind): &(&str, NumericType)| {
        offset += bytes(*kind);
        PackedElementField { name: (*name).into(), offset: offset - bytes(*kind), r#type: *kind as i32 }
    };
    names.iter().map(place).collect()
}

fn bytes(kind: NumericType) -> u32 {
    if kind == NumericType::Uint8 { 1 } else { 4 }
}

/// Squirmers as points in the colours of their species, with what one may want to colour them by instead.
pub(super) fn squirmer_points(header: &Header, squirmers: &Squirmers) -> PointCloud {
    let mut data = Vec::with_capacity(36 * squirmers.id.len());
    for i in 0..squirmers.id.len() {
        data.extend_from_slice(bytemuck::bytes_of(&squirmers.position[i]));
        data.extend_from_slice(bytemuck::bytes_of(&squirmers.axis[i]));
        data.extend_from_slice(&squirmers.id[i].to_le_bytes());
        data.extend_from_slice(&squirmers.species[i].to_le_bytes());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        data.extend(PALETTE[squirmers.species[i] as usize % PALETTE.len()].map(|c| (255.0 * c).round() as u8));
        data.push(255);
    }
    let floats = ["x", "y", "z", "ux", "uy", "uz"].map(|n| (n, NumericType::Float32));
    let numbers = [("id", NumericType::Uint32), ("species", NumericType::Uint32)];
    cloud(header, &[&floats[..], &numbers, &RGBA].concat(), data)
}

/// Every n-th particle, so that at most [`MAX_POINTS`] remain.
pub(super) fn fluid_points(header: &Header, particles: &Particles) -> PointCloud {
    let n = particles.position.len();
    let step = n.div_ceil(MAX_POINTS).max(1);
    let mut data = Vec::with_capacity(24 * n.div_ceil(step));
    for i in (0..n).step_by(step) {
        data.extend_from_slice(bytemuck::bytes_of(&particles.position[i]));
        data.extend_from_slice(bytemuck::bytes_of(&particles.velocity[i]));
    }
    cloud(header, &["x", "y", "z", "vx", "vy", "vz"].map(|n| (n, NumericType::Float32)), data)
}
