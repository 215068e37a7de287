//! What must hold between parameters: bodies that fit, walls that have ghosts, heat that someone takes away.

use super::list::Listed;
use super::node::Node;
use super::room::{self, Place};
use crate::buffers::{Extent, Sizes, find};
use crate::diag::Diagnostic;
use crate::graph::sizes::{contact_range, sizes};
use crate::math::steric::SAFETY;
use crate::params::{Params, Value};
use crate::stages::squirmer_move::SquirmerMove;
use crate::state::packed::{bins, brick_room};
use crate::state::{Species, System};
use glam::DVec3;

/// Speed of sound in units of sqrt(kT/m): sqrt(5/3), since the particles are an ideal gas.
pub const SOUND: f64 = 1.290_994_448_735_805_6;

/// Mach number above which the fluid's compressibility shows.
const MAX_MACH: f64 = 0.2;

/// Bytes of a species' name in a snapshot.
const LONGEST_NAME: usize = 32;

/// Checks the physical system by itself.
pub fn system(system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    run(system, root, found);
    walls(system, root, found);
    for (index, species) in system.species.iter().enumerate() {
        let at = Place { root, index: index.to_string() };
        named(species, &at, found);
        fits(species, system, &at, found);
        slip(species, system, &at, found);
        room::poses(species, system, &at, found);
        if let Some(first) = system.species[..index].iter().position(|s| s.name == species.name) {
            found.push(
                Diagnostic::error(format!(
                    "two species are named \"{}\", so outputs could not tell them apart",
                    species.name
                ))
                .at(at.of(&["name"]), "again here")
                .at(Place { root, index: first.to_string() }.of(&["name"]), "first here")
                .help("give each [[squirmers]] a name of its own"),
            );
        }
    }
    room::fraction(system, root, found);
    room::places(system, root, found);
}

fn run(system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    let path = system.run.dt * system.fluid.temperature.sqrt();
    let dt = root.place(&["run", "dt"]);
    if path > 1.0 {
        found.push(
            Diagnostic::warning(format!(
                "a particle flies {path:.2} cells between collisions, so the fluid is a thin gas"
            ))
            .at(dt, "large time step")
            .help("liquids need dt from 0.01 to 0.1"),
        );
    } else if path < 0.005 {
        found.push(
            Diagnostic::warning(format!(
                "a particle flies only {path:.1e} cells between collisions: most steps do nothing"
            ))
            .at(dt, "small time step")
            .help("0.01 to 0.1 is usual; the viscosity grows as 1/dt"),
        );
    }
    if system.fluid.density == 0.0 {
        found.push(
            Diagnostic::warning(
                "there is no fluid particle: nothing flows, and a squirmer has the mass of one particle",
            )
            .at(root.place(&["fluid", "density"]), "no fluid")
            .help("5 to 50 particles per cell are usual"),
        );
    }
    let size = |message: String, label: &str| {
        let error = Diagnostic::error(message).at(root.place(&["box", "size"]), label);
        error.help("take a smaller box or a lower density")
    };
    // Elements of the longest arrays, in the words by which they are addressed; places in rooms are listed with one bit more.
    let cells = sizes(system).cells;
    let words = cells * find("moments").map_or(0, |b| b.words as u64);
    let rooms = Sizes { room: brick_room(system), ..sizes(system) }.count(Extent::Rooms);
    if system.particle_count() > u64::from(u32::MAX) {
        let message = format!("{} particles are more than a 32-bit index can tell apart", system.particle_count());
        found.push(size(message, "times the density"));
    } else if words.max(2 * rooms) > u64::from(u32::MAX) {
        let message =
            format!("{cells} cells and the room for their particles are more than 32-bit indices can tell apart");
        found.push(size(message, "size of the box"));
    }
}

fn walls(system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    let Some(walls) = &system.domain.walls else {
        if system.fluid.acceleration != [0.0; 3] {
            found.push(
                Diagnostic::warning("without walls nothing holds the fluid, so the body force accelerates it for ever")
                    .at(root.place(&["fluid", "acceleration"]), "body force")
                    .help("add walls = { axis = \"y\" } to [box]"),
            );
        }
        return;
    };
    for (key, velocity) in [("velocity_low", walls.velocity_low), ("velocity_high", walls.velocity_high)] {
        let place = root.place(&["box", "walls", key]);
        if velocity[1] != 0.0 {
            found.push(
                Diagnostic::error(format!("`{key}` would move the wall along y, out of its plane"))
                    .at(place, format!("y component {}", velocity[1]))
                    .help("a wall may only slide: write 0 as the second number"),
            );
        }
        let mach = velocity[0].hypot(velocity[2]) / (SOUND * system.fluid.temperature.sqrt());
        too_fast(mach, "the wall slides", place, found);
    }
    if system.fluid.acceleration[1] != 0.0 {
        found.push(
            Diagnostic::warning(
                "the body force has a part across the slit, which only presses the fluid against a wall",
            )
            .at(root.place(&["fluid", "acceleration"]), "second number")
            .help("write 0 as the second number"),
        );
    }
}

fn too_fast(mach: f64, what: &str, place: crate::diag::Span, found: &mut Vec<Diagnostic>) {
    if mach > MAX_MACH {
        found.push(
            Diagnostic::warning(format!(
                "{what} at Mach {mach:.2}, where the compressible fluid is no liquid any more"
            ))
            .at(place, "fast")
            .help(format!("stay below Mach {MAX_MACH}")),
        );
    }
}

/// The name goes into tables, and into snapshots with room for so many bytes.
fn named(species: &Species, at: &Place<'_>, found: &mut Vec<Diagnostic>) {
    let length = species.name.len();
    if length == 0 || length > LONGEST_NAME {
        let what = if length == 0 { "has no letter".to_owned() } else { format!("takes {length} bytes") };
        found.push(
            Diagnostic::error(format!("the name of this species {what}"))
                .at(at.of(&["name"]), "this name")
                .help(format!("give it a name of 1 to {LONGEST_NAME} letters")),
        );
    }
}

fn fits(species: &Species, system: &System, at: &Place<'_>, found: &mut Vec<Diagnostic>) {
    let axes = &species.semi_axes;
    let (longest, shortest) = (axes.along.max(axes.across), axes.along.min(axes.across));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let edge = f64::from(system.domain.size[axis]);
        let slit = axis == 1 && system.domain.walls.is_some();
        let needed = if slit { 2.0 * (shortest + SAFETY) } else { contact_range(longest) };
        if edge <= needed {
            let why = if slit {
                format!("the slit is {edge} wide, but \"{}\" needs more than {needed:.2}", species.name)
            } else {
                format!("along {name} the box is {edge} long, so \"{}\" would touch its own image", species.name)
            };
            found.push(
                Diagnostic::error(why)
                    .at(at.of(&["semi_axes"]), "shape")
                    .at(at.root.place(&["box", "size"]), "box")
                    .help(format!("make the box longer than {needed:.2} along {name}, or the body smaller")),
            );
        }
    }
    let flight = system.run.dt * system.fluid.temperature.sqrt();
    if flight > shortest {
        found.push(
            Diagnostic::error(format!(
                "a particle flies {flight:.2} cells in a step and would jump over \"{}\"",
                species.name
            ))
            .at(at.root.place(&["run", "dt"]), "time step")
            .at(at.of(&["semi_axes"]), format!("smallest semi-axis {shortest}"))
            .help("take a smaller dt"),
        );
    }
}

fn slip(species: &Species, system: &System, at: &Place<'_>, found: &mut Vec<Diagnostic>) {
    if species.passive {
        for (key, value) in [("b1", species.b1), ("beta", species.beta), ("rotlet", species.rotlet)] {
            if value != 0.0 {
                found.push(
                    Diagnostic::error(format!("\"{}\" is passive, but has {key} = {value}", species.name))
                        .at(at.of(&[key]), "a passive body has no slip")
                        .at(at.of(&["passive"]), "passive here")
                        .help(format!("remove {key}, or passive")),
                );
            }
        }
        return;
    }
    if species.b1 == 0.0 && species.beta != 0.0 {
        found.push(
            Diagnostic::warning("beta has no effect without b1: the stresslet is B2 = beta B1")
                .at(at.of(&["beta"]), "multiplies zero")
                .help("set b1"),
        );
    }
    if species.b1 == 0.0 && species.rotlet == 0.0 {
        found.push(
            Diagnostic::warning(format!("\"{}\" has no slip velocity, so it does not swim", species.name))
                .at(at.of(&[]), "neither b1 nor rotlet")
                .help("set b1, or write passive = true"),
        );
    }
    let mach = fastest_slip(species) / (SOUND * system.fluid.temperature.sqrt());
    too_fast(mach, &format!("the surface of \"{}\" slips", species.name), at.of(&["b1"]), found);
}

/// Largest slip velocity on the surface.
fn fastest_slip(species: &Species) -> f64 {
    let shape = species.spheroid();
    let speed = |step: i32| {
        let zeta = f64::from(step) / 100.0;
        let s = DVec3::new(shape.across * (1.0 - zeta * zeta).max(0.0).sqrt(), 0.0, shape.along * zeta);
        shape.slip(species.b1, species.b1 * species.beta, species.rotlet, s, DVec3::Z).length()
    };
    (-100..=100).map(speed).fold(0.0, f64::max)
}

/// Checks the system against the stages.
pub fn together(system: &System, stages: &[Listed], root: &Node, found: &mut Vec<Diagnostic>) {
    for stage in stages {
        let Some(values) = &stage.values else { continue };
        for finding in (stage.entry.check)(values, system) {
            let path = ["stage", &stage.index.map_or(String::new(), |i| i.to_string()), finding.field];
            let place = if stage.index.is_some() && !finding.field.is_empty() { root.place(&path) } else { stage.span };
            let make = match finding.gravity {
                crate::stages::Gravity::Warning => Diagnostic::warning,
                crate::stages::Gravity::Error => Diagnostic::error,
            };
            found.push(make(finding.message).at(place, format!("stage `{}`", stage.entry.kind)).help(finding.help));
        }
    }
    if stages.is_empty() {
        return;
    }
    pair_search(system, stages, found);
    let has = |kind: &str| stages.iter().any(|s| s.entry.kind == kind);
    if !has("stream") {
        found.push(
            Diagnostic::warning("no stage `stream`, so the fluid particles never move")
                .at(root.place(&["stage", "0", "kind"]), "the list begins here")
                .help("add a [[stage]] with kind = \"stream\""),
        );
    }
    wall_stages(system, stages, root, found);
    squirmer_stages(system, stages, root, found);
    heating(system, stages, root, found);
}

/// The bins of the pair search are made for the default reach of the steric forces.
fn pair_search(system: &System, stages: &[Listed], found: &mut Vec<Diagnostic>) {
    let Some(stage) = stages.iter().find(|s| s.entry.kind == "squirmer-move") else { return };
    let Some(values) = &stage.values else { return };
    let reach = SquirmerMove::from_values(values).reach(system);
    let widths = bins(system).into_iter().zip(system.domain.size);
    let narrow = widths.filter(|(n, _)| *n > 1).map(|(n, edge)| f64::from(edge) / f64::from(n));
    let narrowest = narrow.fold(f64::MAX, f64::min);
    if reach > narrowest {
        found.push(
            Diagnostic::error(format!(
                "steric forces reach {reach:.2}, beyond the bins of the pair search, {narrowest:.2}"
            ))
            .at(stage.span, "`safety` or `sigma` is large")
            .help("keep safety and sigma near their defaults, or make the bodies themselves larger"),
        );
    }
}

fn wall_stages(system: &System, stages: &[Listed], root: &Node, found: &mut Vec<Diagnostic>) {
    let sticky = system.domain.walls.as_ref().is_some_and(|w| w.condition == "no-slip");
    if sticky && !stages.iter().any(|s| s.entry.kind == "wall-ghosts") {
        found.push(
            Diagnostic::warning("no-slip walls without ghosts let the fluid slip: the slip length is about one cell")
                .at(root.place(&["box", "walls"]), "walls")
                .help("add a [[stage]] with kind = \"wall-ghosts\" after cell-reduce"),
        );
    }
}

fn squirmer_stages(system: &System, stages: &[Listed], root: &Node, found: &mut Vec<Diagnostic>) {
    if system.species.is_empty() {
        for stage in stages.iter().filter(|s| s.entry.kind.starts_with("squirmer-")) {
            found.push(
                Diagnostic::warning(format!("`{}` has no effect: there is no [[squirmers]]", stage.entry.kind))
                    .at(stage.span, "nothing to do")
                    .help("remove the stage, or add a species"),
            );
        }
        return;
    }
    let place = root.place(&["squirmers", "0"]);
    for (kind, without) in [
        ("squirmer-move", "squirmers never move"),
        ("squirmer-collide", "the fluid flows through the squirmers"),
        ("squirmer-fill", "cells cut by a squirmer hold too few particles, and the surface is not no-slip"),
    ] {
        if stages.iter().any(|s| s.entry.kind == kind) {
            continue;
        }
        let message = format!("there are squirmers, but no stage `{kind}`: {without}");
        let diagnostic =
            if kind == "squirmer-fill" { Diagnostic::warning(message) } else { Diagnostic::error(message) };
        found.push(diagnostic.at(place, "species").help(format!("add a [[stage]] with kind = \"{kind}\"")));
    }
}

/// Whether the collision keeps angular momentum; and whether it keeps the temperature.
#[must_use]
pub fn restores(kind: &str, values: &crate::params::Values) -> (bool, bool) {
    if kind != "restore-thermostat" {
        return (false, false);
    }
    let momentum = !matches!(values.get("angular_momentum"), Some(Value::Boolean(false)));
    (momentum, matches!(values.get("mode"), Some(Value::Text(m)) if m == "thermostat"))
}

fn heating(system: &System, stages: &[Listed], root: &Node, found: &mut Vec<Diagnostic>) {
    let collides = stages.iter().any(|s| s.entry.kind == "rotate");
    let restored = stages.iter().filter_map(|s| Some(restores(s.entry.kind, s.values.as_ref()?)));
    let (momentum, thermostat) = restored.fold((false, false), |(a, b), (c, d)| (a || c, b || d));
    if stages.iter().any(|s| s.values.is_none()) || !collides {
        return;
    }
    let last = stages.iter().rfind(|s| s.index.is_some()).map_or(root.span, |s| s.span);
    let active = system.species.iter().any(|s| s.b1 != 0.0 || s.rotlet != 0.0);
    let sliding = system.domain.walls.as_ref().is_some_and(|w| w.velocity_low != w.velocity_high);
    let source = [
        (active, "squirmers"),
        (system.fluid.acceleration != [0.0; 3], "the body force"),
        (sliding, "the sliding walls"),
    ];
    let sources: Vec<&str> = source.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
    if !sources.is_empty() && !thermostat {
        found.push(
            Diagnostic::warning(format!(
                "no stage takes away the heat that {} put into the fluid",
                sources.join(" and ")
            ))
            .at(last, "no thermostat in this list")
            .help("add a [[stage]] with kind = \"restore-thermostat\" and mode = \"thermostat\" after rotate"),
        );
    }
    if !system.species.is_empty() && !momentum {
        found.push(
            Diagnostic::warning("cells do not keep angular momentum, so torques on the squirmers are wrong")
                .at(last, "angular momentum is lost")
                .help("add `restore-thermostat` with angular_momentum = true after rotate"),
        );
    }
}
