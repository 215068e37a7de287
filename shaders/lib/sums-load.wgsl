// Reads the sums of a cell. The including file binds `moments` as vectors of four words.
//!include moments
//!include places

fn sums_at(cell: u32) -> Sums {
    let k = 6u * cell;
    let a = moments[k];
    let b = moments[k + 1u];
    var s: Sums;
    s.count = a.x;
    s.v = bitcast<vec3<i32>>(a.yzw);
    s.energy = b.x;
    s.coarse = b.y;
    if PLACES {
        let c = moments[k + 2u];
        let d = moments[k + 3u];
        let e = moments[k + 4u];
        let f = moments[k + 5u];
        s.x = bitcast<vec3<i32>>(vec3<u32>(b.zw, c.x));
        s.diagonal = bitcast<vec3<i32>>(c.yzw);
        s.mixed = bitcast<vec3<i32>>(d.xyz);
        s.xv0 = bitcast<vec3<i32>>(vec3<u32>(d.w, e.xy));
        s.xv1 = bitcast<vec3<i32>>(vec3<u32>(e.zw, f.x));
        s.xv2 = bitcast<vec3<i32>>(f.yzw);
    }
    return s;
}
