// squirmer-collide: particles that met a squirmer during the step follow their path again with the squirmers in the way. Each hit
// is found exactly in the moving body's frame; the particle bounces off the surface's velocity and the body takes the momentum.
//!include dispatch
//!include cells
//!include particles-store
//!include path
//!include spheroid
//!include absorb
//!include wall-impulse

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: SquirmerCollideSettings;
@group(0) @binding(2) var<storage, read_write> particles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> velocities_yz: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read> species: array<SpeciesUniform>;
@group(0) @binding(5) var<storage, read_write> squirmers: array<SquirmerState>;
@group(0) @binding(6) var<storage, read_write> squirmer_map: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> squirmer_lists: array<u32>;
@group(0) @binding(7) var<storage, read_write> impulses: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> fluid_force: array<f32>;
@group(0) @binding(9) var<storage, read_write> wall_impulses: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> faults: array<atomic<u32>>;

// Most squirmers that a cell lists.
const MAP_SLOTS: u32 = 7u;
// Particles leave a surface this much outside, relative to the semi-axes: more than f32 rounding, far less than a mean free path.
const OUTSIDE: f32 = 1.00001;
// A path whose end is so far from the centre, squared and relative to the surface, is outside whatever rounding does.
const WELL_OUTSIDE: f32 = 1.001;

fn map_cleared(cell: u32) {
    atomicStore(&squirmer_map[cell], 0u);
}

@compute @workgroup_size(WORKGROUP)
fn clear_map(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        map_cleared(cell);
    }
}

// How far from the squirmer's centre a cell's centre may be along each axis, if a point of the cell is within the margin.
fn box_of(orientation: vec4<f32>, b: vec3<f32>) -> vec3<f32> {
    let e = turn(orientation, vec3<f32>(0.0, 0.0, 1.0));
    return sqrt(vec3<f32>(b.x * b.x) + (b.z * b.z - b.x * b.x) * e * e) + vec3<f32>(settings.margin + 0.867);
}

// A plane that touches a squirmer, all of which lies behind it.
struct Touching {
    // Away from the squirmer, in body axes.
    normal: vec3<f32>,
    // How far in front of it a cell's centre is: a proof that it is no nearer to the squirmer (support function).
    distance: f32,
}

// The plane for a cell whose centre is at q b from the squirmer's, in body axes; inside the squirmer it is some plane. With p = q b its normal is along
// q/b, so that n.p = |q|^2/|q/b| and |b n| = |q|/|q/b|.
fn touching(b: vec3<f32>, q: vec3<f32>) -> Touching {
    let away = q * (1.0 / b);
    let reach = sqrt(dot(q, q));
    let at_centre = reach < 1e-6;
    let by_size = inverseSqrt(max(dot(away, away), 1e-30));
    let n = select(away * by_size, vec3<f32>(0.0, 0.0, 1.0), at_centre);
    return Touching(n, (reach - 1.0) * select(reach * by_size, b.z, at_centre));
}

// No point of a cell is farther from its centre than this.
const CORNER: f32 = 0.8661;
// The word of a cell of the map: how many squirmers are near in the lowest bits, and above them, where it is one, a plane that touches
// it: three components of its normal and the distance of the cell's centre, 7 bits each.
const COUNT_BITS: u32 = 4u;
const COUNT_MASK: u32 = 15u;
const PLANE_BITS: u32 = 7u;
const PLANE_MASK: u32 = 127u;

// How many distances the plane's 7 bits tell apart per cell, from one cell behind the plane on.
fn distance_scale() -> f32 {
    return f32(PLANE_MASK) / (settings.margin + CORNER + 1.0);
}

// As the word of a cell near one squirmer, `nearer` what this may have come nearer in the step.
fn packed_plane(orientation: vec4<f32>, plane: Touching, nearer: f32) -> u32 {
    let n = vec3<u32>(vec3<i32>(round(turn(orientation, plane.normal) * 63.0)) + 64);
    // Rounded towards the squirmer.
    let distance = u32(clamp((plane.distance - nearer + 1.0) * distance_scale(), 0.0, f32(PLANE_MASK)));
    return ((((distance << PLANE_BITS | n.z) << PLANE_BITS | n.y) << PLANE_BITS | n.x) << COUNT_BITS) | 1u;
}

// Above what rounding a normal's components to 1/63 makes of a distance half a cell's diagonal away, 0.0119.
const ROUNDING: f32 = 0.0125;

// How far a point in the cell of this word, `x` from the centre, is at least from the one squirmer near, wherever that was during the
// step.
fn clearance(word: u32, x: vec3<f32>) -> f32 {
    let n = vec3<u32>(word >> COUNT_BITS, word >> (COUNT_BITS + PLANE_BITS), word >> (COUNT_BITS + 2u * PLANE_BITS)) & vec3<u32>(PLANE_MASK);
    let distance = f32(word >> (COUNT_BITS + 3u * PLANE_BITS)) / distance_scale() - 1.0;
    return dot(vec3<f32>(n) - 64.0, x) * (1.0 / 63.0) + distance - ROUNDING;
}

// By how much a point of the squirmer's surface may have moved in the step.
fn moved_at_most(i: u32, b: vec3<f32>) -> f32 {
    let a = squirmers[i].orientation_before;
    let turned = min(length(squirmers[i].orientation - a), length(squirmers[i].orientation + a));
    // The chord between two rotations: the angle is up to 2.24 times as long, as long as it is below half a turn.
    return length(separation(squirmers[i].position, squirmers[i].position_before)) + 2.24 * turned * max(b.x, b.z);
}

// Comes as near as no plane can tell.
const NO_PLANE: f32 = 1e6;

// Whether points of the cell whose centre is at `d` see different images of the squirmer.
fn at_seam(d: vec3<f32>) -> bool {
    let across = abs(d) + 0.5 >= 0.5 * vec3<f32>(system.size);
    return across.x || across.z || (system.walled == 0u && across.y);
}

fn mark(cell: u32, i: u32, plane: u32) {
    let slot = atomicAdd(&squirmer_map[cell], plane) & COUNT_MASK;
    if slot < MAP_SLOTS {
        squirmer_lists[cell * MAP_SLOTS + slot] = i;
    } else {
        report(FAULT_CROWDED, cell, Witness(SITE_SQUIRMER_COLLIDE, i, UNKNOWN));
    }
}

// Every cell that a point within `margin` of the squirmer can lie in names the squirmer: a column of cells along z.
@compute @workgroup_size(WORKGROUP)
fn mark_map(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = invocation(group, groups, lane);
    let edge = system.box_edge;
    let i = k / (edge * edge);
    if i >= system.squirmer_count {
        return;
    }
    let column = vec2<u32>(k % edge, (k / edge) % edge);
    // In a periodic box smaller than the squirmer's box each cell is visited once; across a slit nothing repeats.
    if column.x >= system.size.x || (system.walled == 0u && column.y >= system.size.y) {
        return;
    }
    let centre = squirmers[i].position;
    let orientation = squirmers[i].orientation;
    let b = hull(species[squirmers[i].species]);
    let size = vec3<i32>(system.size);
    let first = vec3<i32>(
        i32(split(centre.x, system.period.x).x),
        i32(split(centre.y, system.period.y).x),
        i32(split(centre.z, system.period.z).x),
    ) + vec3<i32>(vec2<i32>(column), 0) - vec3<i32>(i32(edge / 2u));
    if system.walled == 1u && (first.y < 0 || first.y >= size.y) {
        return;
    }
    let reach = box_of(orientation, b);
    var cell = (first + 2 * size) % size;
    let beside = from_cell(cell, centre).xy;
    if any(abs(beside) > reach.xy) {
        return;
    }
    let nearer = moved_at_most(i, b);
    // What a column has in common, and what a step along z adds.
    let beneath = turn_back(orientation, vec3<f32>(beside, 0.0)) / b;
    let above = turn_back(orientation, vec3<f32>(0.0, 0.0, 1.0)) / b;
    for (var z = 0; z < min(i32(edge), size.z); z++) {
        let d = vec3<f32>(beside, from_cell(cell, centre).z);
        if abs(d.z) <= reach.z {
            let plane = touching(b, fma(vec3<f32>(d.z), above, beneath));
            if plane.distance <= settings.margin + CORNER {
                mark(cell_index(vec3<u32>(cell)), i, packed_plane(orientation, plane, select(nearer, NO_PLANE, at_seam(d))));
            }
        }
        cell.z = select(cell.z + 1, 0, cell.z + 1 == size.z);
    }
}

// From the squirmer's centre to a cell's; a place, unlike a displacement, may lie more than half a turn from 0.
fn from_cell(cell: vec3<i32>, centre: vec3<u32>) -> vec3<f32> {
    return separation(vec3<u32>((vec3<f32>(cell) + 0.5) * system.units), centre);
}

fn cell_of(position: vec3<u32>) -> u32 {
    return locate(position, vec3<u32>(0u)).cell;
}

fn neighbours(cell: u32) -> u32 {
    return min(atomicLoad(&squirmer_map[cell]) & COUNT_MASK, MAP_SLOTS);
}

// The next thing that happens on a path.
struct Event {
    // Share of the remaining path after which it happens; above 1: nothing happens.
    share: f32,
    squirmer: u32,
    // Contact in body coordinates scaled to the unit sphere.
    contact: vec3<f32>,
    // The path began inside: the particle is put onto the surface and bounces only if it moves inwards.
    inside: bool,
    // The least |q|^2 of the squirmers looked at, q being the path's end in body coordinates scaled to the unit sphere.
    nearest_end: f32,
}

const NOTHING: Event = Event(2.0, 0xffffffffu, vec3<f32>(), false, 1e30);

// Pose of a squirmer at a share of the step.
struct Pose {
    // From where the squirmer began the step, in cells.
    moved: vec3<f32>,
    orientation: vec4<f32>,
}

fn pose_at(i: u32, share: f32) -> Pose {
    var p: Pose;
    p.moved = separation(squirmers[i].position, squirmers[i].position_before) * share;
    let a = squirmers[i].orientation_before;
    let b = squirmers[i].orientation;
    let near = select(b, -b, dot(a, b) < 0.0);
    p.orientation = normalize(mix(a, near, share));
    return p;
}

fn earlier(before: Event, p: vec3<f32>, q: vec3<f32>, i: u32) -> Event {
    var e = before;
    e.nearest_end = min(e.nearest_end, dot3(q, q));
    let cc = dot3(p, p) - 1.0;
    if cc < 0.0 {
        // Inside already: at once.
        if e.share > 0.0 || i < e.squirmer {
            return Event(0.0, i, p, true, e.nearest_end);
        }
        return e;
    }
    let d = q - p;
    let a = dot3(d, d);
    let b = dot3(p, d);
    let discriminant = fma(b, b, -a * cc);
    if b >= 0.0 || discriminant <= 0.0 {
        return e;
    }
    let share = cc / (sqrt(discriminant) - b);
    if share <= 1.0 && (share < e.share || (share == e.share && i < e.squirmer)) {
        return Event(share, i, p + share * d, false, e.nearest_end);
    }
    return e;
}

fn listed(cell: u32, k: u32) -> u32 {
    return squirmer_lists[cell * MAP_SLOTS + k];
}

// Whether a squirmer is among the first `count` that are listed in a cell.
fn lists(cell: u32, count: u32, i: u32) -> bool {
    for (var k = 0u; k < count; k++) {
        if listed(cell, k) == i {
            return true;
        }
    }
    return false;
}

// The first meeting with a squirmer listed in `cell`, but not among the first `count` of `known`, on the straight path of `velocity` for
// `rest`, begun at `elapsed` of the step.
fn first_hit(found: Event, cell: u32, known: u32, count: u32, start: Path, rest: f32) -> Event {
    var e = found;
    let elapsed = 1.0 - rest / system.dt;
    for (var k = 0u; k < neighbours(cell); k++) {
        let i = listed(cell, k);
        if lists(known, count, i) {
            continue;
        }
        let b = hull(species[squirmers[i].species]);
        let origin = separation(start.position, squirmers[i].position_before);
        let first = pose_at(i, elapsed);
        let last = pose_at(i, 1.0);
        let p = turn_back(first.orientation, origin - first.moved) / b;
        let q = turn_back(last.orientation, origin + start.velocity * rest - last.moved) / b;
        e = earlier(e, p, q, i);
    }
    return e;
}

// Puts the particle at the contact and gives it the velocity v' = 2 u_s - v (Theers et al. 2016); the squirmer takes v - v'.
fn bounce(start: Path, e: Event, elapsed: f32) -> Path {
    var p = start;
    let i = e.squirmer;
    let kind = species[squirmers[i].species];
    let b = hull(kind);
    let pose = pose_at(i, elapsed);
    let contact = normalize(e.contact);
    let body = contact * b;
    let s = turn(pose.orientation, body);
    p.position = squirmers[i].position_before + to_units(pose.moved + OUTSIDE * s);
    let surface = squirmers[i].drift + cross3(squirmers[i].spin, s) + turn(pose.orientation, slip(kind, contact));
    let inwards = dot(p.velocity - surface, turn(pose.orientation, body / (b * b))) < 0.0;
    if inwards || !e.inside {
        let v = p.velocity;
        p.velocity = 2.0 * surface - v;
        let j = v - p.velocity;
        add_impulse(i, j, cross3(s, j), Witness(SITE_SQUIRMER_COLLIDE, i, UNKNOWN));
    }
    return p;
}

// A particle still inside a squirmer at the end of the step is put onto the surface.
fn expel(start: Path, cell: u32) -> Path {
    var p = start;
    for (var k = 0u; k < neighbours(cell); k++) {
        let i = listed(cell, k);
        let b = hull(species[squirmers[i].species]);
        let r = turn_back(squirmers[i].orientation, separation(p.position, squirmers[i].position)) / b;
        if dot3(r, r) < 1.0 {
            let s = turn(squirmers[i].orientation, normalize(r) * b);
            p.position = squirmers[i].position + to_units(OUTSIDE * s);
        }
    }
    return p;
}

fn inside_any(p: Path) -> bool {
    let cell = cell_of(p.position);
    for (var k = 0u; k < neighbours(cell); k++) {
        let i = listed(cell, k);
        let b = hull(species[squirmers[i].species]);
        let r = turn_back(squirmers[i].orientation, separation(p.position, squirmers[i].position)) / b;
        if dot3(r, r) < 1.0 {
            return true;
        }
    }
    return false;
}

// Where its flight began.
fn beginning(flown: Particle) -> Path {
    let kick = system.acceleration * (0.5 * system.dt);
    return fly(Path(flown.position, flown.velocity - kick, vec3<f32>(0.0), vec3<f32>(0.0)), -system.dt);
}

// Whether a squirmer is so near to the end of its flight that it may have met it: all of the flight is within its length from there.
fn may_bounce(flown: Particle) -> bool {
    let reach = fma(sqrt(dot3(flown.velocity, flown.velocity)), system.dt, settings.slack);
    if reach > settings.far {
        return true;
    }
    let place = locate(flown.position, vec3<u32>(0u));
    let word = atomicLoad(&squirmer_map[place.cell]);
    if (word & COUNT_MASK) == 1u {
        return clearance(word, place.offset) < reach;
    }
    return word != 0u;
}

fn bounced(k: u32, flown: Particle) -> Particle {
    if !may_bounce(flown) {
        return flown;
    }
    let p = follow(beginning(flown), k);
    if !p.met {
        return flown;
    }
    if any(p.path.low != vec3<f32>(0.0)) {
        add_wall_impulse(k / WORKGROUP, 0u, p.path.low);
    }
    if any(p.path.high != vec3<f32>(0.0)) {
        add_wall_impulse(k / WORKGROUP, 1u, p.path.high);
    }
    return Particle(p.path.position, kicked(p.path.velocity, p.path.position));
}

@compute @workgroup_size(WORKGROUP)
fn collide(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = invocation(group, groups, lane);
    if k >= system.particle_count {
        return;
    }
    let flown = particle_at(k);
    let p = bounced(k, flown);
    // Few particles met a squirmer.
    if any(p.position != flown.position) || any(bitcast<vec3<u32>>(p.velocity) != bitcast<vec3<u32>>(flown.velocity)) {
        store_particle(k, p);
    }
}

struct Followed {
    path: Path,
    // It met a squirmer; otherwise the free flight already done stands.
    met: bool,
}

// The whole step again, event by event, always the earliest first.
fn follow(begin: Path, k: u32) -> Followed {
    var out = Followed(begin, false);
    var rest = system.dt;
    var clear = false;
    for (var hit = 0u; hit < settings.max_hits; hit++) {
        let displacement = out.path.velocity * rest;
        let wall = wall_share(out.path.position.y, displacement.y);
        let here = cell_of(out.path.position);
        let end = out.path.position + to_units(displacement * min(wall, 1.0));
        let there = cell_of(vec3<u32>(end.x, select(end.y, out.path.position.y, beyond_wall(end.y)), end.z));
        // First where it is, then where it goes.
        var e = NOTHING;
        var cell = here;
        var known = 0u;
        for (var left = select(1u, 2u, there != here); left > 0u; left--) {
            e = first_hit(e, cell, here, known, out.path, rest);
            cell = there;
            known = neighbours(here);
        }
        if e.share > 1.0 && wall > 1.0 {
            out.path.position += to_units(displacement);
            rest = 0.0;
            clear = e.nearest_end > WELL_OUTSIDE;
            break;
        }
        if wall < e.share {
            out.path.position += to_units(displacement * wall);
            out.path = reflect_at_wall(out.path, displacement.y);
            rest = fma(-wall, rest, rest);
        } else {
            rest = fma(-e.share, rest, rest);
            out.path = bounce(out.path, e, 1.0 - rest / system.dt);
            out.met = true;
        }
        if rest <= 0.0 {
            break;
        }
    }
    if clear {
        return out;
    }
    return settle(out, rest);
}

// Whatever is left after the allowed number of hits is not flown; nothing may stay inside a squirmer or behind a wall.
fn settle(followed: Followed, rest: f32) -> Followed {
    var out = followed;
    if rest > 0.0 {
        out.met = true;
    }
    for (var attempt = 0; inside_any(out.path); attempt++) {
        if attempt == 4 {
            report(FAULT_STUCK, UNKNOWN, Witness(SITE_SQUIRMER_COLLIDE, UNKNOWN, UNKNOWN));
            break;
        }
        out.path = expel(out.path, cell_of(out.path.position));
        out.met = true;
        if beyond_wall(out.path.position.y) {
            out.path.position.y = select(0u, 0x7fffffffu, out.path.position.y < 0xc0000000u);
        }
    }
    return out;
}

// The squirmers take up what their hits gave them.
@compute @workgroup_size(WORKGROUP)
fn absorb(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.squirmer_count {
        absorb_impulse(i, true);
    }
}
