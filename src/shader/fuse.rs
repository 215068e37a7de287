//! One kernel from the functions of several stages: each element is read once, goes through all of them, and is written once.

use super::lanes::Lanes;
use super::reflect::{Module, ShaderError};
use crate::buffers::{Extent, OVERLAYS};
use std::fmt::Write as _;

/// An entry point that does much for a few particles and little for the others. The fused plan gives the few a kernel of their own: on a GPU
/// neighbours that do the same keep each other busy, and what a CPU driver does for one particle it does for all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rare {
    /// The entry point.
    pub entry: &'static str,
    /// What there must be for anyone to be among the few.
    pub of: Extent,
    /// Function `(p: Particle) -> bool` that tells, before it is done, who they are or may be.
    pub condition: &'static str,
    /// What the others get, a function `(i: u32, p: Particle) -> Particle`; empty: nothing.
    pub otherwise: &'static str,
}

/// What a stage gives to a fused kernel.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The stage.
    pub kind: &'a str,
    /// WGSL text that has the function.
    pub wgsl: &'a str,
    /// Declaration of the stage's uniform.
    pub settings: &'a str,
    /// The function for one element.
    pub function: &'a str,
    /// It does much for a few particles only.
    pub rare: Option<Rare>,
    /// It belongs to the step before: its `shift` is `shift_before`.
    pub late: bool,
}

impl Part<'_> {
    /// Its function `(cell: u32)` does something else for a cell than to change the operator.
    #[must_use]
    pub fn aside(&self) -> bool {
        self.has("(cell: u32)")
    }

    /// Its function `(brick: u32, lane: u32)` is the work of a brick's whole workgroup, between the sums over particles and their use.
    fn brickwise(&self) -> bool {
        self.has("(brick: u32, lane: u32)")
    }

    /// Its function adds to the sums of a cell.
    fn adds(&self) -> bool {
        self.has("(cell: u32, s: Sums) -> Sums")
    }

    /// It comes between the sums over the particles of cells and their use.
    #[must_use]
    pub fn between(&self) -> bool {
        self.brickwise() || self.adds()
    }

    fn has(&self, signature: &str) -> bool {
        self.wgsl.contains(&format!("fn {}{signature} {{", self.function))
    }
}

/// What a fused kernel has one invocation for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Particles: functions `(i, Particle) -> Particle`.
    Particles,
    /// The same, but the few of parts that are rare wait for the next kernel.
    Sifted,
    /// Particles that waited.
    Held,
    /// Particles that lie brick by brick, one workgroup for each brick; a part without a function only declares.
    Bricks {
        /// Whence and whither.
        route: Route,
        /// So many of the first parts are those over cells of bricks: they make the operators that the others apply.
        cells: usize,
        /// Somebody needs the operators of cells at walls afterwards.
        kept: bool,
    },
    /// Cells of bricks: as cells, after a first function that hands out the sums of one once those of the brick are there. Before it come functions
    /// `(brick, lane)`, after it functions `(cell, Sums) -> Sums`.
    BrickCells {
        /// The operators in memory matter.
        operators: bool,
    },
    /// Cells: functions `(cell, Moments, Operator) -> Operator`, or `(cell)` for something aside, after a first `(cell) -> Sums` or
    /// the moments in memory.
    Cells {
        /// The first function makes the sums.
        sums: bool,
        /// The operators in memory matter.
        operators: bool,
    },
}

/// Where a kernel over particles that lie brick by brick takes them from, and where it leaves them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Route {
    /// From the row of all particles into the bricks, by the last function.
    Enter,
    /// From bricks to bricks.
    Stay,
    /// The same, but the few of parts that are rare are held back, to come with the next kernel.
    Sift,
    /// From bricks to bricks, those who were held back.
    Held,
    /// From the bricks back into a row.
    Leave,
}

/// The entry point of a fused module.
pub const ENTRY: &str = "fused";

/// The uniform of a stage in a fused module.
#[must_use]
pub fn settings_name(kind: &str) -> String {
    format!("settings_{}", kind.replace('-', "_"))
}

/// A stage's text as it stands beside others: its uniform, one member or all of it, goes by its own name.
pub(super) fn with_own_settings(wgsl: &str, kind: &str) -> String {
    let name = settings_name(kind);
    wgsl.replace("settings.", &format!("{name}.")).replace(", settings)", &format!(", {name})"))
}

/// Composes the fused module; what shares its work among invocations has so many.
///
/// # Errors
/// If the parts do not fit together as WGSL, for instance since two of them have functions of one name.
pub fn fuse(parts: &[Part<'_>], over: Over, lanes: Lanes) -> Result<Module, ShaderError> {
    let mut includes = vec!["dispatch".to_owned()];
    let (mut bindings, mut bodies, mut declarations) = (Vec::new(), String::new(), String::new());
    includes.extend(match over {
        Over::Particles => vec!["particles-store".to_owned()],
        Over::Sifted => {
            bindings.extend(held_bindings(true));
            vec!["particles-store".to_owned(), "held-store".to_owned()]
        }
        Over::Held => {
            bindings.extend(held_bindings(false));
            vec!["particles-store".to_owned(), "held".to_owned()]
        }
        Over::Bricks { route, cells, kept } => {
            let row = if route == Route::Leave { "particles-leave" } else { "particles" };
            if route == Route::Leave {
                let types = OVERLAYS[1].guests.into_iter().zip(["array<vec4<u32>>", "array<vec2<f32>>"]);
                bindings.extend(types.map(|(name, ty)| Bound::storage(name, "read_write", ty)));
            }
            let made = [(cells > 0).then_some("operator-brick"), kept.then_some("operator-store")];
            [row].into_iter().chain(made.into_iter().flatten()).map(str::to_owned).collect()
        }
        Over::BrickCells { operators } => {
            let loads = [operators.then_some("operator-load")];
            loads.into_iter().flatten().chain(["operator-store"]).map(str::to_owned).collect()
        }
        Over::Cells { sums, operators } => {
            let loads = [(!sums).then_some("moments-load"), operators.then_some("operator-load")];
            loads.into_iter().flatten().chain(["operator-store"]).map(str::to_owned).collect()
        }
    });
    for (k, part) in parts.iter().enumerate() {
        if parts[..k].iter().all(|p| p.kind != part.kind) {
            declarations.push_str(part.settings);
        }
        let mut text = with_own_settings(part.wgsl, part.kind);
        if part.late {
            text = after_the_shift(&text);
        }
        // What one text has for two parts stands once.
        let mut again = String::new();
        let known = parts[..k].iter().any(|p| p.wgsl == part.wgsl);
        take(&text, part, &mut includes, &mut bindings, if known { &mut again } else { &mut bodies });
    }
    if matches!(over, Over::Bricks { cells: 1.., .. }) {
        // Operators stay in the workgroup.
        includes.retain(|name| name != "operator-load");
    }
    let mut text = String::new();
    for name in &includes {
        let _ = writeln!(text, "//!include {name}");
    }
    text.push_str(&bind_lines(&bindings));
    text.push_str("var<immediate> now: Now;\n");
    text.push_str(&bodies);
    text.push_str(&entry(parts, over));
    let kinds: Vec<&str> = parts.iter().map(|p| p.kind).collect();
    Module::new(&kinds.join(" + "), &lanes.chosen(&text), &declarations)
}

/// WGSL of a stage that comes when the grid has been moved: the shift that it asks for is the one before.
#[must_use]
pub fn after_the_shift(wgsl: &str) -> String {
    wgsl.replace("shift[", "shift_before[").replace("> shift:", "> shift_before:")
}

/// A variable of a fused module.
pub(super) struct Bound {
    name: String,
    space: String,
    ty: String,
}

impl Bound {
    fn storage(name: &str, access: &str, ty: &str) -> Self {
        Self { name: name.to_owned(), space: format!("storage, {access}"), ty: ty.to_owned() }
    }
}

/// The list of particles that wait; what tells how many workgroups they need cannot be written meanwhile.
fn held_bindings(written: bool) -> [Bound; 2] {
    let (space, groups) = if written { ("read_write", "array<atomic<u32>>") } else { ("read", "array<u32>") };
    [("held", "array<u32>"), ("held_groups", groups)].map(|(name, ty)| Bound::storage(name, space, ty))
}

/// Declarations of these variables.
pub(super) fn bind_lines(bindings: &[Bound]) -> String {
    let line =
        |(number, b): (usize, &Bound)| format!("@group(0) @binding({number}) var<{}> {}: {};\n", b.space, b.name, b.ty);
    bindings.iter().enumerate().map(line).collect()
}

/// Sorts the lines of a part: what it includes, what it binds, and all else but its entry points.
pub(super) fn take(
    text: &str,
    part: &Part<'_>,
    includes: &mut Vec<String>,
    bindings: &mut Vec<Bound>,
    body: &mut String,
) {
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("//!include ") {
            includes.push(name.trim().to_owned());
        } else if line.starts_with("@group(") {
            bind(line, part, bindings);
        } else if line.starts_with("@compute") {
            for inside in lines.by_ref() {
                if inside == "}" {
                    break;
                }
            }
        } else if !line.starts_with("var<immediate>") && !line.starts_with("//") {
            body.push_str(line);
            body.push('\n');
        }
    }
}

/// Enters a line `@group(0) @binding(1) var<storage, read> name: type;` into the list; one part that writes is enough for `read_write`.
fn bind(line: &str, part: &Part<'_>, bindings: &mut Vec<Bound>) {
    let rest = line.split_once("var<").map_or("", |(_, rest)| rest);
    let (space, rest) = rest.split_once("> ").unwrap_or(("", ""));
    let (name, ty) = rest.trim_end_matches(';').split_once(": ").unwrap_or(("", ""));
    let name = match name {
        "settings" => settings_name(part.kind),
        name => name.to_owned(),
    };
    match bindings.iter_mut().find(|b| b.name == name) {
        Some(known) if space.ends_with("read_write") => space.clone_into(&mut known.space),
        Some(_) => {}
        None => bindings.push(Bound { name, space: space.to_owned(), ty: ty.to_owned() }),
    }
}

fn entry(parts: &[Part<'_>], over: Over) -> String {
    let lines = match over {
        Over::Particles | Over::Bricks { route: Route::Enter, .. } => each_particle(parts, over == Over::Particles),
        Over::Sifted => each_sifted(parts),
        Over::Held => each_held(parts),
        Over::Bricks { route, cells, kept } => {
            let (made, moved) = parts.split_at(cells);
            each_brick((made, kept), moved, route)
        }
        Over::BrickCells { operators } => each_brick_cell(parts, operators),
        Over::Cells { sums, operators } => each_cell(parts, sums, operators),
    };
    let (size, index) = match over {
        Over::Bricks { route: Route::Held, .. } => ("HELD_LANES", "brick_of(group, groups)"),
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

/// Particles of a brick that an invocation has at a time, where all of them move.
const PER_LANE: usize = 4;

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
/// The particles, or the last of them if there are many, stay at hand.
fn made_and_kept(parts: &[Part<'_>], kept: bool) -> Vec<String> {
    let head = [
        for_each(PER_LANE, "BRICK_LANES", "var p#: Particle;"),
        format!("for (var base = 0u; base < count; base += {PER_LANE}u * BRICK_LANES) {{"),
        for_each(PER_LANE, "BRICK_LANES", "p# = fetched(index, NTH, count);"),
        for_each(PER_LANE, "BRICK_LANES", "if NTH < count { add_particle(p#); }"),
        "}".to_owned(),
        in_between(parts),
        "workgroupBarrier();".to_owned(),
        "if lane < BRICK_CELLS {".to_owned(),
        "let i = index * BRICK_CELLS + lane;".to_owned(),
    ];
    let wall = if kept { "if at_wall(row_of(i)) { store_operator(i, o); }" } else { "" };
    let tail = ["keep_operator(lane, o);", wall, "}", "workgroupBarrier();"];
    head.into_iter().chain(operator(parts, true, false)).chain(tail.map(str::to_owned)).collect()
}

/// A brick's particles, moved on. The last part of those who stay is replaced by what settles them. `made`: parts that make the operators first,
/// of the step before.
fn each_brick((made, kept): (&[Part<'_>], bool), parts: &[Part<'_>], route: Route) -> Vec<String> {
    let head = [
        "if index * BRICK_CELLS >= system.cell_count { return; }",
        if route == Route::Leave { "" } else { "clear_going(lane);" },
        if made.is_empty() { "" } else { "clear_sums(lane, BRICK_LANES);" },
        "let count = particles_of_brick(index, lane);",
    ];
    let mut lines: Vec<String> = head.map(str::to_owned).to_vec();
    if !made.is_empty() {
        lines.extend(made_and_kept(made, kept));
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
    let (lanes, most) = match route {
        Route::Held => ("HELD_LANES", 1),
        _ => ("BRICK_LANES", if made.is_empty() { 1 } else { PER_LANE }),
    };
    let each = |line: &str| for_each(most, lanes, line);
    let (fetch, step) = if made.is_empty() {
        lines.push(each("var p#: Particle;"));
        (String::new(), "now.step_low")
    } else {
        // Those at hand need not be fetched again.
        (format!("if count > {most}u * {lanes} "), "now.step_low + 1u")
    };
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
    let left = if route == Route::Sift { "atomicLoad(&held_back)" } else { "0u" };
    lines.push(format!("if lane == 0u {{ atomicStore(&brick_counts[index], {left}); }}"));
    lines
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
        "if i == 0u { empty_other_list(); }".to_owned(),
        "if i >= system.particle_count { return; }".to_owned(),
        "var p = particle_at(i); var q: Particle; var held = false;".to_owned(),
        sifting(parts),
        "if held { hold(i); } else { p = q; }".to_owned(),
        "store_particle(i, p);".to_owned(),
    ];
    lines.to_vec()
}

fn each_held(parts: &[Part<'_>]) -> Vec<String> {
    let lines = [
        "for (var k = index; k < held_groups[held_list() + 3u]; k += WORKGROUP * groups.x) {".to_owned(),
        "    let i = held[k];".to_owned(),
        "    var p = particle_at(i);".to_owned(),
        format!("    {}", moves(parts)),
        "    store_particle(i, p);".to_owned(),
        "}".to_owned(),
    ];
    lines.to_vec()
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
