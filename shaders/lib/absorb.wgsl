// A squirmer takes up the momentum handed to it. The including file binds `squirmers`, `species`, `impulses` and `fluid_force`.
//!include impulse

fn take_impulse(squirmer: u32, component: u32) -> f32 {
    let word = squirmer * IMPULSE_WORDS + 2u * component;
    let value = wide_value(atomicLoad(&impulses[word]), atomicLoad(&impulses[word + 1u]));
    atomicStore(&impulses[word], 0u);
    atomicStore(&impulses[word + 1u], 0u);
    return value;
}

// `first` starts the step's account of the fluid's force and torque afresh.
fn absorb_impulse(i: u32, first: bool) {
    let force = vec3<f32>(take_impulse(i, 0u), take_impulse(i, 1u), take_impulse(i, 2u)) * (system.impulse_unit / FORCE_SCALE);
    let torque = vec3<f32>(take_impulse(i, 3u), take_impulse(i, 4u), take_impulse(i, 5u)) * (system.impulse_unit / TORQUE_SCALE);
    let kind = species[squirmers[i].species];
    if kind.held == 0u {
        squirmers[i].velocity += force / kind.mass;
        squirmers[i].angular_momentum += torque;
    }
    for (var k = 0u; k < 3u; k++) {
        let f = 8u * i + k;
        let t = f + 4u;
        fluid_force[f] = select(fluid_force[f], 0.0, first) + force[k] / system.dt;
        fluid_force[t] = select(fluid_force[t], 0.0, first) + torque[k] / system.dt;
    }
}
