// What a snapshot holds of the fluid: totals, fields averaged over blocks, a sample of particles. Runs at the end of a step, when
// the moments of the collision are stale, and uses their buffer for the moments of the fluid alone on the unshifted grid.
//!include dispatch
//!include cells
//!include particles
//!include deposit
//!include wide
//!include workgroup-sum

@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<uniform> settings: MeasureSettings;
@group(0) @binding(2) var<storage, read> particles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> velocities_yz: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> moments: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> totals: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> fields: array<f32>;
@group(0) @binding(7) var<storage, read_write> samples: array<u32>;
@group(0) @binding(8) var<storage, read_write> faults: array<atomic<u32>>;

fn signed3(a: u32, b: u32, c: u32) -> vec3<f32> {
    return vec3<f32>(vec3<i32>(bitcast<i32>(a), bitcast<i32>(b), bitcast<i32>(c)));
}

fn moment(cell: u32, word: u32) -> u32 {
    return atomicLoad(&moments[cell * MOMENT_WORDS + word]);
}

fn number(cell: u32) -> u32 {
    return number_in(moment(cell, 0u));
}

fn velocity_sum(cell: u32) -> vec3<f32> {
    return signed3(moment(cell, 1u), moment(cell, 2u), moment(cell, 3u)) * system.inverse_velocity;
}

@compute @workgroup_size(1)
fn clear_totals() {
    for (var k = 0u; k < 14u; k++) {
        atomicStore(&totals[k], 0u);
    }
}

@compute @workgroup_size(WORKGROUP)
fn clear(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        for (var k = 0u; k < MOMENT_WORDS; k++) {
            atomicStore(&moments[cell * MOMENT_WORDS + k], 0u);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn reduce(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i < system.particle_count {
        let p = particle_at(i);
        let place = locate(p.position, vec3<u32>(0u));
        deposit(FLUID, place.cell, place.offset, p.velocity, Witness(SITE_SNAPSHOT, i, UNKNOWN));
    }
}

// Wide sums over the fluid: 0 particles, 1-3 velocity, 4 squared speed, 5 the same relative to the cells' means, 6 degrees of freedom.
@compute @workgroup_size(WORKGROUP)
fn total(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    clear_sums_of_workgroup(lane);
    let cell = invocation(group, groups, lane);
    if cell < system.cell_count {
        let n = number(cell);
        if n > 0u {
            let v = velocity_sum(cell);
            let energy = f32(moment(cell, 4u)) * system.inverse_energy;
            collect(0u, i32(n));
            for (var k = 0u; k < 3u; k++) {
                collect(1u + k, i32(round(v[k] * settings.scale)));
            }
            collect(4u, i32(round(energy * settings.scale)));
            if n > 1u {
                collect(5u, i32(round((energy - dot(v, v) / f32(n)) * settings.scale)));
                collect(6u, 3 * (i32(n) - 1));
            }
        }
    }
    workgroupBarrier();
    if lane < 7u {
        let share = collected(lane);
        let old = atomicAdd(&totals[2u * lane], share.x);
        atomicAdd(&totals[2u * lane + 1u], share.y + select(0u, 1u, old + share.x < old));
    }
}

@compute @workgroup_size(WORKGROUP)
fn coarsen(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = invocation(group, groups, lane);
    let n = settings.blocks;
    if block >= n.x * n.y * n.z {
        return;
    }
    let low = vec3<u32>(block % n.x, (block / n.x) % n.y, block / (n.x * n.y)) * settings.edge;
    let high = min(low + settings.edge, system.size);
    var count = 0.0;
    var velocity = vec3<f32>(0.0);
    for (var z = low.z; z < high.z; z++) {
        for (var y = low.y; y < high.y; y++) {
            for (var x = low.x; x < high.x; x++) {
                let cell = cell_index(vec3<u32>(x, y, z));
                count += f32(number(cell));
                velocity += velocity_sum(cell);
            }
        }
    }
    fields[4u * block] = count;
    fields[4u * block + 1u] = velocity.x;
    fields[4u * block + 2u] = velocity.y;
    fields[4u * block + 3u] = velocity.z;
}

@compute @workgroup_size(WORKGROUP)
fn sample(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = invocation(group, groups, lane);
    if k >= settings.samples {
        return;
    }
    let p = particle_at(k * settings.stride);
    for (var axis = 0u; axis < 3u; axis++) {
        samples[6u * k + axis] = p.position[axis];
        samples[6u * k + 3u + axis] = bitcast<u32>(p.velocity[axis]);
    }
}
