// An impulse in fixed point, or a fault if that cannot hold it; `scale` is for thermal speeds of 1. The including file binds `system`, and `faults`
// as atomics.
//!include fault
fn impulse_fixed(j: vec3<f32>, scale: f32, by: Witness) -> vec3<i32> {
    let f = j * (scale * system.inverse_impulse_unit);
    if !all(abs(f) < vec3<f32>(2147483000.0)) {
        report(FAULT_IMPULSE, UNKNOWN, by);
        return vec3<i32>(0);
    }
    return vec3<i32>(round(f));
}
