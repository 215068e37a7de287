// A fluid particle.
struct Particle {
    // In coordinate units.
    position: vec3<u32>,
    velocity: vec3<f32>,
}
