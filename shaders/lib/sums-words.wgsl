// The sums of a cell as six vectors of four words, of which without places only the first two matter.
//!include moments
//!include places

fn words_of(s: Sums) -> array<vec4<u32>, 6> {
    let x = bitcast<vec3<u32>>(s.x);
    let xv0 = bitcast<vec3<u32>>(s.xv0);
    let xv1 = bitcast<vec3<u32>>(s.xv1);
    return array<vec4<u32>, 6>(
        vec4<u32>(s.count, bitcast<vec3<u32>>(s.v)),
        vec4<u32>(s.energy, s.ghosts, x.xy),
        vec4<u32>(x.z, bitcast<vec3<u32>>(s.diagonal)),
        vec4<u32>(bitcast<vec3<u32>>(s.mixed), xv0.x),
        vec4<u32>(xv0.yz, xv1.xy),
        vec4<u32>(xv1.z, bitcast<vec3<u32>>(s.xv2)),
    );
}

fn sums_of_words(words: array<vec4<u32>, 6>) -> Sums {
    let a = words[0];
    let b = words[1];
    var s: Sums;
    s.count = a.x;
    s.v = bitcast<vec3<i32>>(a.yzw);
    s.energy = b.x;
    s.ghosts = b.y;
    if PLACES {
        let c = words[2];
        let d = words[3];
        let e = words[4];
        let f = words[5];
        s.x = bitcast<vec3<i32>>(vec3<u32>(b.zw, c.x));
        s.diagonal = bitcast<vec3<i32>>(c.yzw);
        s.mixed = bitcast<vec3<i32>>(d.xyz);
        s.xv0 = bitcast<vec3<i32>>(vec3<u32>(d.w, e.xy));
        s.xv1 = bitcast<vec3<i32>>(vec3<u32>(e.zw, f.x));
        s.xv2 = bitcast<vec3<i32>>(f.yzw);
    }
    return s;
}
