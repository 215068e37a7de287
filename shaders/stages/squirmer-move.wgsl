// squirmer-move: rigid-body motion of the squirmers under steric forces, position Verlet with exact free rotation.
//!include dispatch
//!include cells
//!include rigid
//!include steric
//!include wall-impulse
//!include fault

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: SquirmerMoveSettings;
@group(0) @binding(2) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(3) var<storage, read_write> squirmers: array<SquirmerState>;
@group(0) @binding(4) var<storage, read_write> bin_heads: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> bin_next: array<u32>;
@group(0) @binding(6) var<storage, read_write> steric: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> wall_impulses: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> steric_sums: array<atomic<i32>>;
var<immediate> now: Now;

// Whether squirmers are so many that they are looked for in bins. A CPU driver runs both sides of a branch, and without bins there is nothing
// to walk through but memory.
override BINS: bool = true;
// Words of a squirmer's sums: force, torque, number of contacts; zero between substeps.
const STERIC_WORDS: u32 = 8u;
// Partners and walls that may act on one squirmer; the fixed-point scales leave room for as many at their largest force.
const MOST_CONTACTS = 64u;

fn report_steric(i: u32) {
    report(FAULT_STERIC, UNKNOWN, Witness(SITE_SQUIRMER_MOVE, i, UNKNOWN));
}

// Moves the centre: whole coordinate units, the rest is kept in `remainder` so that slow motion is not lost.
// More than an eighth of a turn at once is a fault.
fn shifted(i: u32, before: SquirmerState) -> SquirmerState {
    var s = before;
    let path = fma(s.velocity, settings.half_step * system.units, s.remainder);
    let whole = floor(path);
    if !all(abs(whole) < vec3<f32>(536870912.0)) {
        report_steric(i);
        return s;
    }
    let step = vec3<i32>(whole);
    s.remainder = path - whole;
    s.position = before.position + bitcast<vec3<u32>>(step);
    let up = (step > vec3<i32>(0)) & (s.position < before.position);
    let down = (step < vec3<i32>(0)) & (s.position > before.position);
    var turns = select(vec3<i32>(0), vec3<i32>(1), up) - select(vec3<i32>(0), vec3<i32>(1), down);
    if system.walled == 1u {
        turns.y = 0;
        if s.position.y >= 0x80000000u {
            report_steric(i);
            s.position.y = select(0u, 0x7fffffffu, step.y > 0);
        }
    }
    s.image = s.image + turns;
    return s;
}

// Half a substep of free motion; adds its share to the mean velocity and angular velocity of the step.
fn drifted(i: u32, before: SquirmerState) -> SquirmerState {
    let kind = species[before.species];
    if kind.held == 1u {
        return before;
    }
    var s = shifted(i, before);
    s.orientation = turned(s.orientation, s.angular_momentum, settings.half_step, kind.inertia_along, kind.inertia_across);
    let e = 0.5 * (body_axis(before.orientation) + body_axis(s.orientation));
    let spin = top_velocity(e, s.angular_momentum, kind.inertia_along, kind.inertia_across);
    s.drift = fma(s.velocity, vec3<f32>(settings.share), s.drift);
    s.spin = fma(spin, vec3<f32>(settings.share), s.spin);
    return s;
}

@compute @workgroup_size(WORKGROUP)
fn drift_first(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.squirmer_count {
        return;
    }
    var s = squirmers[i];
    if now.repetition == 0u {
        s.position_before = s.position;
        s.orientation_before = s.orientation;
        s.drift = vec3<f32>(0.0);
        s.spin = vec3<f32>(0.0);
    }
    squirmers[i] = drifted(i, s);
}

@compute @workgroup_size(WORKGROUP)
fn clear_bins(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.bins.x * system.bins.y * system.bins.z {
        return;
    }
    atomicStore(&bin_heads[i], 0u);
}

// Bin of a position per axis, from the upper 16 bits of its share of the box; in a slit the box is half a turn across.
fn bin_of(position: vec3<u32>) -> vec3<u32> {
    let share = vec3<u32>(position.x, position.y << system.walled, position.z) >> vec3<u32>(16u);
    return (share * system.bins) >> vec3<u32>(16u);
}

fn bin_index(bin: vec3<u32>) -> u32 {
    return (bin.z * system.bins.y + bin.y) * system.bins.x + bin.x;
}

@compute @workgroup_size(WORKGROUP)
fn fill_bins(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.squirmer_count {
        return;
    }
    bin_next[i] = atomicExchange(&bin_heads[bin_index(bin_of(squirmers[i].position))], i + 1u);
}

fn spheroid(i: u32) -> Spheroid {
    let kind = species[squirmers[i].species];
    return Spheroid(body_axis(squirmers[i].orientation), kind.across + settings.safety, kind.along + settings.safety);
}

// Force and torque in fixed point: integers add up to the same sum in any order, whoever finds a contact first.
struct Sum {
    force: vec3<i32>,
    torque: vec3<i32>,
    contacts: i32,
}

fn add_contact(i: u32, before: Sum, force: vec3<f32>, torque: vec3<f32>) -> Sum {
    var sum = before;
    sum.contacts = sum.contacts + 1;
    let fits = all(abs(force) <= vec3<f32>(1.001 * settings.max_force)) && all(abs(torque) <= vec3<f32>(settings.max_torque));
    if !fits {
        report_steric(i);
        return sum;
    }
    sum.force = sum.force + vec3<i32>(round(force * settings.force_scale));
    sum.torque = sum.torque + vec3<i32>(round(torque * settings.torque_scale));
    return sum;
}

fn add_wall(i: u32, sum: Sum, body: Spheroid, height: f32, inward: f32) -> Sum {
    let c = wall_contact(body, height, inward);
    if c.gap >= settings.cutoff {
        return sum;
    }
    let strength = repulsion(c, settings.sigma, settings.epsilon, settings.max_force);
    return add_contact(i, sum, strength * c.by_shift, strength * c.by_turn_b);
}

// The wall receives the opposite of what it gives a free squirmer in this substep.
fn lean_on_wall(before: Sum, i: u32, body: Spheroid, wall: u32, height: f32) -> Sum {
    let after = add_wall(i, before, body, height, select(1.0, -1.0, wall == 1u));
    let given = vec3<f32>(after.force - before.force) * (1.0 / settings.force_scale);
    if any(given != vec3<f32>(0.0)) && species[squirmers[i].species].held == 0u {
        add_wall_impulse(i / WORKGROUP, wall, -2.0 * settings.half_step * given);
    }
    return after;
}

// The pair is computed with the lower index first by both partners: action equals reaction in every bit.
fn add_partner(sum: Sum, i: u32, body: Spheroid, j: u32) -> Sum {
    let low = min(i, j);
    let r = separation(squirmers[max(i, j)].position, squirmers[low].position);
    let kind = species[squirmers[j].species];
    let reach = max(body.across, body.along) + max(kind.across, kind.along) + settings.safety + settings.cutoff;
    let square = dot3(r, r);
    if square >= reach * reach {
        return sum;
    }
    if square < 1e-8 * reach * reach {
        report_steric(i);
        return sum;
    }
    var first = spheroid(j);
    var second = body;
    if i == low {
        second = first;
        first = body;
    }
    let c = contact(first, second, r);
    if c.gap >= settings.cutoff {
        return sum;
    }
    let strength = repulsion(c, settings.sigma, settings.epsilon, settings.max_force);
    let sign = select(1.0, -1.0, i == low);
    return add_contact(i, sum, (sign * strength) * c.by_shift, strength * select(c.by_turn_b, c.by_turn_a, i == low));
}

fn may_touch(i: u32, position: vec3<u32>, j: u32) -> bool {
    let r = separation(squirmers[j].position, position);
    return j != i && dot3(r, r) < settings.reach * settings.reach;
}

// Few squirmers: each part looks at every so manieth of all. Parts find their next partner together before any computes its contact.
fn among_all(i: u32, body: Spheroid, part: u32) -> Sum {
    let position = squirmers[i].position;
    var sum: Sum;
    for (var j = part; j < system.squirmer_count; j = j + settings.parts) {
        while j < system.squirmer_count && !may_touch(i, position, j) {
            j = j + settings.parts;
        }
        if j < system.squirmer_count {
            sum = add_partner(sum, i, body, j);
        }
    }
    return sum;
}

// Many: each part takes some of the bins that a partner in reach can lie in, each distinct bin once, also where the axis has few. The
// small term covers the 16 bits that bin_of drops.
fn among_bins(i: u32, body: Spheroid, part: u32) -> Sum {
    let bins = vec3<f32>(system.bins);
    let near = vec3<u32>(floor(fma(settings.reach / vec3<f32>(system.size), bins, bins * 3.0517578e-5))) + vec3<u32>(1u);
    let every = 2u * near + vec3<u32>(1u) >= system.bins;
    let count = select(2u * near + vec3<u32>(1u), system.bins, every);
    let first = select(bin_of(squirmers[i].position) + system.bins - near, vec3<u32>(0u), every);
    var sum: Sum;
    for (var k = part; k < count.x * count.y * count.z; k = k + settings.parts) {
        let bin = first + vec3<u32>(k % count.x, (k / count.x) % count.y, k / (count.x * count.y));
        var next = atomicLoad(&bin_heads[bin_index(bin % system.bins)]);
        while next != 0u {
            let j = next - 1u;
            if j != i {
                sum = add_partner(sum, i, body, j);
            }
            next = bin_next[j];
        }
    }
    return sum;
}

@compute @workgroup_size(WORKGROUP)
fn force(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = invocation(group, groups, lane);
    let i = k / settings.parts;
    let part = k % settings.parts;
    if i >= system.squirmer_count {
        return;
    }
    let body = spheroid(i);
    var sum: Sum;
    if BINS && system.bins.x != 0u {
        sum = among_bins(i, body, part);
    } else {
        sum = among_all(i, body, part);
    }
    if system.walled == 1u && part < 2u {
        // Heights from whole units above the nearer wall: a global f32 coordinate would lose digits at the far one.
        let y = squirmers[i].position.y;
        let height = select(y, 0x80000000u - y, part == 1u);
        sum = lean_on_wall(sum, i, body, part, f32(height) * system.cell_per_unit.y);
    }
    if sum.contacts == 0 {
        return;
    }
    for (var axis = 0u; axis < 3u; axis++) {
        atomicAdd(&steric_sums[i * STERIC_WORDS + axis], sum.force[axis]);
        atomicAdd(&steric_sums[i * STERIC_WORDS + 3u + axis], sum.torque[axis]);
    }
    atomicAdd(&steric_sums[i * STERIC_WORDS + 6u], sum.contacts);
}

struct Load {
    force: vec3<f32>,
    torque: vec3<f32>,
}

// Force and torque of all contacts, as `steric` shows them; the sums begin anew.
fn take_steric(i: u32) -> Load {
    let word = i * STERIC_WORDS;
    // All is read before anything is written, so that the reads wait for memory together.
    var sums: array<f32, 7>;
    for (var k = 0u; k < 7u; k++) {
        sums[k] = f32(atomicLoad(&steric_sums[word + k]));
    }
    for (var k = 0u; k < 7u; k++) {
        atomicStore(&steric_sums[word + k], 0);
    }
    let force = vec3<f32>(sums[0], sums[1], sums[2]);
    let torque = vec3<f32>(sums[3], sums[4], sums[5]);
    if sums[6] > f32(MOST_CONTACTS) {
        report_steric(i);
    }
    let load = Load(force * (1.0 / settings.force_scale), torque * (1.0 / settings.torque_scale));
    steric[2u * i] = vec4<f32>(load.force, 0.0);
    steric[2u * i + 1u] = vec4<f32>(load.torque, 0.0);
    return load;
}

@compute @workgroup_size(WORKGROUP)
fn kick_drift(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.squirmer_count {
        return;
    }
    var s = squirmers[i];
    let kind = species[s.species];
    let load = take_steric(i);
    if kind.held == 0u {
        let substep = 2.0 * settings.half_step;
        s.velocity = fma(load.force + kind.force, vec3<f32>(substep / kind.mass), s.velocity);
        s.angular_momentum = fma(load.torque, vec3<f32>(substep), s.angular_momentum);
    }
    squirmers[i] = drifted(i, s);
}
