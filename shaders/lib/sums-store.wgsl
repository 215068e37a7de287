// Writes the sums of a cell. The including file binds `moments` as vectors and includes `lanes`.
//!include moments
//!include places

// Each invocation of the cell stores its share of the six vectors.
fn store_sums(cell: u32, part: u32, s: Sums) {
    let k = 6u * cell;
    let v = bitcast<vec3<u32>>(s.v);
    let x = bitcast<vec3<u32>>(s.x);
    let xv0 = bitcast<vec3<u32>>(s.xv0);
    let xv1 = bitcast<vec3<u32>>(s.xv1);
    let xv2 = bitcast<vec3<u32>>(s.xv2);
    if part == 0u {
        moments[k] = vec4<u32>(s.count, v);
    }
    if part == 1u % LANES {
        moments[k + 1u] = vec4<u32>(s.energy, s.coarse, x.xy);
    }
    if !PLACES {
        return;
    }
    if part == 2u % LANES {
        moments[k + 2u] = vec4<u32>(x.z, bitcast<vec3<u32>>(s.diagonal));
    }
    if part == 3u % LANES {
        moments[k + 3u] = vec4<u32>(bitcast<vec3<u32>>(s.mixed), xv0.x);
    }
    if part == 0u {
        moments[k + 4u] = vec4<u32>(xv0.yz, xv1.xy);
    }
    if part == 1u % LANES {
        moments[k + 5u] = vec4<u32>(xv1.z, xv2);
    }
}
