//! The entry point of a fused module: whence its elements come, what the parts do to them, and whither they go.

use super::fuse::{ENTRY, Over, Part, Route};
use std::fmt::Write as _;

/// Its text.
pub(super) fn entry(parts: &[Part<'_>], over: Over) -> String {
    let lines = match over {
        Over::Particles | Over::Bricks { route: Route::Enter, .. } => each_particle(parts, over == Over::Particles),
        Over::Sifted => each_sifted(parts),
        Over::Held => each_held(parts),
        Over::Bricks { route, cells, kept, hold } => {
            let (made, moved) = parts.split_at(cells);
            each_brick((made, kept, hold), moved, route)
        }
        Over::Walked { cells, kept } => {
            let (made, moved) = parts.split_at(cells);
            each_walked((made, kept), moved)
        }
        Over::BrickCells { operators } => each_brick_cell(parts, operators),
        Over::Cells { sums, operators } => each_cell(parts, sums, operators),
    };
    let (size, index) = match over {
        Over::Bricks { route: Route::Held, .. } => ("WORKGROUP", "brick_of(group, groups)"),
        Over::Bricks { route: Route::Stay | Route::Sift | Route::Leave, .. } | Over::BrickCells { .. } => {
            ("BRICK_LANES", "brick_of(group, groups)")
        }
        _ => ("WORKGROUP", "invocation(group, groups, lane)"),
    };
    format!(
        "@compute @workgroup_size({size})\nfn {ENTRY}(@builtin(workgroup_id) group: vec3<u32>, \
         @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{\n    \
         let index = {index};\n    {}\n}}\n",
        lines.join("\n    ")
    )
}

/// What each part does to particle `i`, which is `p`.
fn moves(parts: &[Part<'_>]) -> String {
    let own = parts.iter().filter(|part| !part.function.is_empty());
    own.map(|part| format!("p = {}(i, p);", part.function)).collect::<Vec<_>>().join(" ")
}

/// Particles of a brick that an invocation has at a time, where all of them move: those that it holds from the sums on, and those that it fetches again.
const HELD_PER_LANE: usize = 4;
const FETCHED_PER_LANE: usize = 3;

/// One line for each of the particles that an invocation has; `#` in it is which, `NTH` its place in the brick.
fn for_each(most: usize, lanes: &str, line: &str) -> String {
    let one = |k: usize| line.replace("NTH", &format!("base + {k}u * {lanes} + lane")).replace('#', &k.to_string());
    (0..most).map(one).collect::<Vec<_>>().join(" ")
}

/// What the whole workgroup of a brick does between the sums over particles and their use.
fn in_between(parts: &[Part<'_>]) -> String {
    let own = parts.iter().filter(|part| part.brickwise());
    own.map(|part| format!("{}(index, lane);", part.function)).collect::<Vec<_>>().join(" ")
}

/// The operators of a brick's cells, made and kept in the workgroup; those of cells at walls in memory, too, if the walls receive something.
/// The particles, or the last of them if there are many, may stay at hand: that is as many registers less for the operators.
fn made_and_kept(parts: &[Part<'_>], kept: bool, hold: bool) -> Vec<String> {
    let sums = if hold {
        vec![
            for_each(HELD_PER_LANE, "BRICK_LANES", "var p#: Particle;"),
            format!("for (var base = 0u; base < count; base += {HELD_PER_LANE}u * BRICK_LANES) {{"),
            for_each(HELD_PER_LANE, "BRICK_LANES", "p# = fetched(index, NTH, count);"),
            for_each(HELD_PER_LANE, "BRICK_LANES", "if NTH < count { add_particle(p#); }"),
            "}".to_owned(),
        ]
    } else {
        let one = "add_particle(particle_in_brick(slot_of(index, k)));";
        vec![format!("for (var k = lane; k < count; k += BRICK_LANES) {{ {one} }}")]
    };
    let head = [
        in_between(parts),
        "workgroupBarrier();".to_owned(),
        "if lane < BRICK_CELLS {".to_owned(),
        "let i = index * BRICK_CELLS + lane;".to_owned(),
    ];
    let wall = if kept { "if at_wall(row_of(i)) { store_operator(i, o); }" } else { "" };
    let tail = ["keep_operator(lane, o);", wall, "}", "workgroupBarrier();"];
    let made = operator(parts, true, false);
    sums.into_iter().chain(head).chain(made).chain(tail.map(str::to_owned)).collect()
}

/// A brick's particles, moved on. The last part of those who stay is replaced by what settles them. `made`: parts that make the operators first,
/// of the step before.
fn each_brick((made, kept, hold): (&[Part<'_>], bool, bool), parts: &[Part<'_>], route: Route) -> Vec<String> {
    if route == Route::Held {
        return each_held_back(parts);
    }
    let head = [
        "if index * BRICK_CELLS >= system.cell_count { return; }",
        if route == Route::Leave { "" } else { "clear_going(lane);" },
        if made.is_empty() { "" } else { "clear_sums(lane, BRICK_LANES);" },
        "let count = particles_of_brick(index, lane);",
    ];
    let mut lines: Vec<String> = head.map(str::to_owned).to_vec();
    if !made.is_empty() {
        lines.extend(made_and_kept(made, kept, hold));
    }
    if route == Route::Leave {
        lines.extend([
            "let first = place_in_row(count, lane);".to_owned(),
            "for (var k = lane; k < count; k += BRICK_LANES) {".to_owned(),
            "    let i = slot_of(index, k);".to_owned(),
            format!("    var p = particle_in_brick(i); {}", moves(parts)),
            "    leave_for_row(first + k, p);".to_owned(),
            "}".to_owned(),
            "if lane == 0u { atomicStore(&brick_counts[index], 0u); }".to_owned(),
        ]);
        return lines;
    }
    // Those that only move are better fetched as they go: so more workgroups are at work at a time.
    let (lanes, step) = ("BRICK_LANES", if made.is_empty() { "now.step_low" } else { "now.step_low + 1u" });
    let most = match (made.is_empty(), hold) {
        (true, _) => 1,
        (false, true) => HELD_PER_LANE,
        (false, false) => FETCHED_PER_LANE,
    };
    let each = |line: &str| for_each(most, lanes, line);
    // Those at hand need not be fetched again.
    let fetch = if hold { format!("if count > {most}u * {lanes} ") } else { String::new() };
    if !hold {
        lines.push(each("var p#: Particle;"));
    }
    let parts = &parts[..parts.len() - 1];
    let (calls, what) = match route {
        Route::Sift => (
            format!("var held = false; {}", sifting(parts)),
            "if held { p# = p; what# = hold(); } else { p# = q; what# = leave(q, place); }",
        ),
        _ => (moves(parts), "p# = p; what# = leave(p, place);"),
    };
    let one = "if NTH < count { let i = slot_of(index, NTH); var p = p#; var q: Particle;";
    lines.extend([
        "let place = brick_place(index);".to_owned(),
        format!("for (var base = 0u; base < count; base += {most}u * {lanes}) {{"),
        format!("{fetch}{{ {} }}", each("p# = fetched(index, NTH, count);")),
        each("var what# = NOBODY;"),
        each(&format!("{one} {calls} {what} }}")),
        "ask_for_places(place, lane);".to_owned(),
        each(&format!("arrive(what#, p#, place, slot_of(index, NTH), {step});")),
        "}".to_owned(),
    ]);
    if route == Route::Sift {
        lines.push(format!("if index == 0u && lane == 0u {{ empty_other_list({step}); }}"));
    }
    lines.push("if lane == 0u { atomicStore(&brick_counts[index], 0u); }".to_owned());
    if route == Route::Sift {
        lines.push(format!("enlist_handfuls(index, lane, {step});"));
    }
    lines
}

/// Particles of bricks that waited: they lie here and there, so that each finds its place by itself.
fn each_held_back(parts: &[Part<'_>]) -> Vec<String> {
    let step = "now.step_low";
    let lines = [
        "let each = handfuls_of_workgroup();",
        &format!(
            "for (var k = index * each + lane / HANDFUL; k < held_groups[held_list({step}) + 3u]; k += each * groups.x) {{"
        ),
        "    let waiting = waiting_in(held[k], lane);",
        "    if waiting.there {",
        "        let i = waiting.slot;",
        "        var p = particle_in_brick(i);",
        &format!("        {}", moves(&parts[..parts.len() - 1])),
        &format!("        arrive(FAR, p, vec3<u32>(), i, {step});"),
        "    }",
        "}",
    ];
    lines.map(str::to_owned).to_vec()
}

fn each_brick_cell(parts: &[Part<'_>], operators: bool) -> Vec<String> {
    let head = [
        "if index * BRICK_CELLS >= system.cell_count { return; }",
        "gather_brick(index, lane);",
        &in_between(parts),
        "add_ghosts(index, lane);",
        "if lane >= BRICK_CELLS { return; }",
        "let i = index * BRICK_CELLS + lane;",
    ];
    head.map(str::to_owned).into_iter().chain(collision(parts, true, operators)).collect()
}

fn each_particle(parts: &[Part<'_>], store: bool) -> Vec<String> {
    let calls = moves(parts);
    let lines = [
        "let i = index;",
        "if i >= system.particle_count { return; }",
        "var p = particle_at(i);",
        &calls,
        if store { "store_particle(i, p);" } else { "" },
    ];
    lines.map(str::to_owned).to_vec()
}

/// What the parts do to particle `i`, which is `p` and becomes `q`; if one of them is rare and the particle among its few, it stays `p`, as it
/// was before the first rare part, and is `held`.
fn sifting(parts: &[Part<'_>]) -> String {
    let k = first_rare(parts);
    let mut text = format!("{} q = p;", moves(&parts[..k]));
    for part in &parts[k..] {
        let function = match part.rare {
            Some(rare) => {
                let _ = write!(text, " held = held || {}(q);", rare.condition);
                rare.otherwise
            }
            None => part.function,
        };
        if !function.is_empty() {
            let _ = write!(text, " if !held {{ q = {function}(i, q); }}");
        }
    }
    text
}

fn first_rare(parts: &[Part<'_>]) -> usize {
    parts.iter().position(|part| part.rare.is_some()).unwrap_or(parts.len())
}

fn each_sifted(parts: &[Part<'_>]) -> Vec<String> {
    let lines = [
        "let i = index;".to_owned(),
        "if i == 0u { empty_other_list(now.step_low); }".to_owned(),
        "if i >= system.particle_count { return; }".to_owned(),
        "var p = particle_at(i); var q: Particle; var held = false;".to_owned(),
        sifting(parts),
        "if held { enlist(i, WORKGROUP, now.step_low); } else { p = q; }".to_owned(),
        "store_particle(i, p);".to_owned(),
    ];
    lines.to_vec()
}

fn each_held(parts: &[Part<'_>]) -> Vec<String> {
    let lines = [
        "for (var k = index; k < held_groups[held_list(now.step_low) + 3u]; k += WORKGROUP * groups.x) {".to_owned(),
        "    let i = held[k];".to_owned(),
        "    var p = particle_at(i);".to_owned(),
        format!("    {}", moves(parts)),
        "    store_particle(i, p);".to_owned(),
        "}".to_owned(),
    ];
    lines.to_vec()
}

/// A cell's particles, moved on by the operator that it has just made. Where its chain ends is known before the sums leave it empty.
fn each_walked((made, kept): (&[Part<'_>], bool), parts: &[Part<'_>]) -> Vec<String> {
    let step = if made[0].late { "shift_before[3]" } else { "shift[3]" };
    let head = [
        "if index >= system.cell_count { return; }".to_owned(),
        format!("var link = end_of_chain(chain_of(index, {step}));"),
        "{".to_owned(),
        "let i = index;".to_owned(),
    ];
    let tail = [
        if kept { "store_operator(i, o);" } else { "" },
        "keep_operator(o);",
        "}",
        "while link != 0u {",
        "    let i = link - 1u;",
        "    var p = particle_at(i);",
        "    link = links[i];",
        &format!("    {}", moves(parts)),
        "    store_particle(i, p);",
        "}",
    ];
    head.into_iter().chain(operator(made, true, false)).chain(tail.map(str::to_owned)).collect()
}

fn each_cell(parts: &[Part<'_>], sums: bool, operators: bool) -> Vec<String> {
    let head = ["let i = index;", "if i >= system.cell_count { return; }"];
    head.map(str::to_owned).into_iter().chain(collision(parts, sums, operators)).collect()
}

/// From the sums of cell `i` to its operator in memory.
fn collision(parts: &[Part<'_>], sums: bool, operators: bool) -> Vec<String> {
    let mut lines = operator(parts, sums, operators);
    lines.push("store_operator(i, o);".to_owned());
    lines
}

/// From the sums of cell `i` to its operator `o`.
fn operator(parts: &[Part<'_>], sums: bool, operators: bool) -> Vec<String> {
    let mut lines = vec![if sums {
        let adding = parts.iter().filter(|part| part.adds());
        let all =
            adding.fold(format!("{}(i)", parts[0].function), |sums, part| format!("{}(i, {sums})", part.function));
        format!("let m = moments_of({all});")
    } else {
        "let m = moments_at(i);".to_owned()
    }];
    lines.push(format!("var o = {};", if operators { "operator_at(i)" } else { "no_collision()" }));
    let call = |part: &Part<'_>| match part.aside() {
        true => format!("{}(i);", part.function),
        false => format!("o = {}(i, m, o);", part.function),
    };
    lines.extend(parts[usize::from(sums)..].iter().filter(|part| !part.between()).map(call));
    lines
}
