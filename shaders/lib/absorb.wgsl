// A squirmer takes up the momentum handed to it. The including file binds `squirmers`, `species`, `impulses` and `fluid_force`.
//!include impulse

struct Handed {
    force: vec3<f32>,
    torque: vec3<f32>,
}

// Here and below all is read before anything is written, so that the reads wait for memory together.
fn take_impulse(squirmer: u32) -> Handed {
    let word = squirmer * IMPULSE_WORDS;
    var values: array<f32, 6>;
    for (var k = 0u; k < 6u; k++) {
        values[k] = wide_value(atomicLoad(&impulses[word + 2u * k]), atomicLoad(&impulses[word + 2u * k + 1u]));
    }
    for (var k = 0u; k < IMPULSE_WORDS; k++) {
        atomicStore(&impulses[word + k], 0u);
    }
    let unit = system.impulse_unit;
    return Handed(
        vec3<f32>(values[0], values[1], values[2]) * (unit / FORCE_SCALE),
        vec3<f32>(values[3], values[4], values[5]) * (unit / TORQUE_SCALE),
    );
}

// `first` starts the step's account of the fluid's force and torque afresh.
fn absorb_impulse(i: u32, first: bool) {
    var account: array<f32, 8>;
    for (var k = 0u; k < 8u; k++) {
        account[k] = select(fluid_force[8u * i + k], 0.0, first);
    }
    let kind = species[squirmers[i].species];
    let velocity = squirmers[i].velocity;
    let angular_momentum = squirmers[i].angular_momentum;
    let handed = take_impulse(i);
    let force = handed.force;
    let torque = handed.torque;
    if kind.held == 0u {
        squirmers[i].velocity = velocity + force / kind.mass;
        squirmers[i].angular_momentum = angular_momentum + torque;
    }
    for (var k = 0u; k < 3u; k++) {
        fluid_force[8u * i + k] = account[k] + force[k] / system.dt;
        fluid_force[8u * i + 4u + k] = account[4u + k] + torque[k] / system.dt;
    }
}
