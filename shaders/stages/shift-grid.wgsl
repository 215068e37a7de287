// shift-grid: a new random position of the collision grid in every step (Ihle and Kroll 2001).
//!include rng

@group(0) @binding(0) var<uniform> system: SystemUniform;
var<immediate> now: Now;
@group(0) @binding(1) var<storage, read_write> shift: array<u32>;

@compute @workgroup_size(1)
fn shift_grid() {
    let u = uniforms(PURPOSE_SHIFT, 0u, 0u, 0u);
    shift[0] = u32(u.x * system.units.x);
    shift[1] = u32(u.y * system.units.y);
    shift[2] = u32(u.z * system.units.z);
    shift[3] = 0u;
}
