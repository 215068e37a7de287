// An impulse in fixed point, or a fault if that cannot hold it. The including file binds `faults` as atomics.
//!include fault
fn impulse_fixed(j: vec3<f32>, scale: f32, by: Witness) -> vec3<i32> {
    let f = j * scale;
    if !all(abs(f) < vec3<f32>(2147483000.0)) {
        report(FAULT_IMPULSE, UNKNOWN, by);
        return vec3<i32>(0);
    }
    return vec3<i32>(round(f));
}
