// Writes the sums of a cell. The including file binds `moments` as vectors.
//!include moments
//!include places

fn store_sums(cell: u32, s: Sums) {
    let k = 6u * cell;
    let x = bitcast<vec3<u32>>(s.x);
    moments[k] = vec4<u32>(s.count, bitcast<vec3<u32>>(s.v));
    moments[k + 1u] = vec4<u32>(s.energy, s.coarse, x.xy);
    if !PLACES {
        return;
    }
    let xv0 = bitcast<vec3<u32>>(s.xv0);
    let xv1 = bitcast<vec3<u32>>(s.xv1);
    moments[k + 2u] = vec4<u32>(x.z, bitcast<vec3<u32>>(s.diagonal));
    moments[k + 3u] = vec4<u32>(bitcast<vec3<u32>>(s.mixed), xv0.x);
    moments[k + 4u] = vec4<u32>(xv0.yz, xv1.xy);
    moments[k + 5u] = vec4<u32>(xv1.z, bitcast<vec3<u32>>(s.xv2));
}
