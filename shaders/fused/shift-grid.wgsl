// shift-grid where the collision of the step before is applied only after it: that shift is kept.
@group(0) @binding(0) var<storage, read> shift: array<u32>;
@group(0) @binding(1) var<storage, read_write> shift_before: array<u32>;

@compute @workgroup_size(1)
fn keep_shift() {
    for (var k = 0u; k < 3u; k++) {
        shift_before[k] = shift[k];
    }
}
