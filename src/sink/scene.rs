//! What a viewer draws: Foxglove's messages made from snapshots.

use crate::wire::{Header, Particles, Squirmers};
use foxglove::messages::{
    ArrowPrimitive, Color, FrameTransform, LinePrimitive, PackedElementField, Point3, PointCloud, Pose, PosesInFrame,
    Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, Timestamp, Vector3, line_primitive, packed_element_field,
};
use glam::{DQuat, DVec3};

/// Points of the fluid beyond which viewers become slow.
pub(super) const MAX_POINTS: usize = 200_000;
/// Everything is in this frame.
const FRAME: &str = "box";
/// Colours that remain apart for the colour-blind (Okabe and Ito 2008), one per species in turn.
const PALETTE: [[f64; 3]; 6] = [
    [0.902, 0.624, 0.0],
    [0.337, 0.706, 0.914],
    [0.0, 0.620, 0.451],
    [0.941, 0.894, 0.259],
    [0.835, 0.369, 0.0],
    [0.8, 0.475, 0.655],
];

/// Simulated time in ns, 1 tau counted as 1 s; times before the start count as the start.
pub(super) fn nanoseconds(time: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let ns = (time * 1e9).round() as u64;
    ns
}

fn timestamp(header: &Header) -> Option<Timestamp> {
    let ns = nanoseconds(header.time);
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    #[allow(clippy::cast_possible_truncation)]
    Some(Timestamp::new(seconds, (ns % 1_000_000_000) as u32))
}

fn vector(v: DVec3) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

fn pose(position: DVec3, orientation: DQuat) -> Pose {
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

/// Spheroids, headings, and the box.
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
    let entity = |id: &str| SceneEntity {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        id: id.into(),
        ..SceneEntity::default()
    };
    let bodies = SceneEntity { spheres, arrows, ..entity("squirmers") };
    let edges = SceneEntity { lines: vec![edges(header)], ..entity("box") };
    SceneUpdate { deletions: Vec::new(), entities: vec![bodies, edges] }
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

fn cloud(header: &Header, names: &[(&str, packed_element_field::NumericType)], data: Vec<u8>) -> PointCloud {
    let field = |(i, (name, kind)): (usize, &(&str, packed_element_field::NumericType))| {
        #[allow(clippy::cast_possible_truncation)]
        let offset = 4 * i as u32;
        PackedElementField { name: (*name).into(), offset, r#type: *kind as i32 }
    };
    #[allow(clippy::cast_possible_truncation)]
    let point_stride = 4 * names.len() as u32;
    PointCloud {
        timestamp: timestamp(header),
        frame_id: FRAME.into(),
        pose: Some(pose(DVec3::ZERO, DQuat::IDENTITY)),
        point_stride,
        fields: names.iter().enumerate().map(field).collect(),
        data: data.into(),
    }
}

/// Squirmers as points with what one may want to colour them by.
pub(super) fn squirmer_points(header: &Header, squirmers: &Squirmers) -> PointCloud {
    use packed_element_field::NumericType::{Float32, Uint32};
    let mut data = Vec::with_capacity(32 * squirmers.id.len());
    for i in 0..squirmers.id.len() {
        data.extend_from_slice(bytemuck::bytes_of(&squirmers.position[i]));
        data.extend_from_slice(bytemuck::bytes_of(&squirmers.axis[i]));
        data.extend_from_slice(&squirmers.id[i].to_le_bytes());
        data.extend_from_slice(&squirmers.species[i].to_le_bytes());
    }
    let floats = ["x", "y", "z", "ux", "uy", "uz"].map(|n| (n, Float32));
    cloud(header, &[&floats[..], &[("id", Uint32), ("species", Uint32)]].concat(), data)
}

/// Every n-th particle, so that at most [`MAX_POINTS`] remain.
pub(super) fn fluid_points(header: &Header, particles: &Particles) -> PointCloud {
    use packed_element_field::NumericType::Float32;
    let n = particles.position.len();
    let step = n.div_ceil(MAX_POINTS).max(1);
    let mut data = Vec::with_capacity(24 * n.div_ceil(step));
    for i in (0..n).step_by(step) {
        data.extend_from_slice(bytemuck::bytes_of(&particles.position[i]));
        data.extend_from_slice(bytemuck::bytes_of(&particles.velocity[i]));
    }
    cloud(header, &["x", "y", "z", "vx", "vy", "vz"].map(|n| (n, Float32)), data)
}
