//! One kernel from the functions of several stages: each element is read once, goes through all of them, and is written once.

use super::entry::entry;
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
    pub(super) fn brickwise(&self) -> bool {
        self.has("(brick: u32, lane: u32)")
    }

    /// Its function adds to the sums of a cell.
    pub(super) fn adds(&self) -> bool {
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
        /// Particles stay at hand from the sums to their motion.
        hold: bool,
    },
    /// Cells of bricks: as cells, after a first function that hands out the sums of one once those of the brick are there. Before it come functions
    /// `(brick, lane)`, after it functions `(cell, Sums) -> Sums`.
    BrickCells {
        /// The operators in memory matter.
        operators: bool,
    },
    /// Cells that walk their chains twice: as cells that make their sums, then functions over particles for each of theirs.
    Walked {
        /// So many of the first parts are those over cells.
        cells: usize,
        /// Somebody needs the operators afterwards.
        kept: bool,
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
        Over::Bricks { route, cells, kept, .. } => {
            let row = if route == Route::Leave { "particles-leave" } else { "particles" };
            if route == Route::Leave {
                let types = OVERLAYS[1].guests.into_iter().zip(["array<vec4<u32>>", "array<vec2<f32>>"]);
                bindings.extend(types.map(|(name, ty)| Bound::storage(name, "read_write", ty)));
            }
            let waits: &[&str] = match route {
                Route::Sift => &["held-handfuls-store"],
                Route::Held => &["held-handfuls"],
                _ => &[],
            };
            if !waits.is_empty() {
                bindings.extend(held_bindings(route == Route::Sift));
            }
            let made = [(cells > 0).then_some("operator-brick"), kept.then_some("operator-store")];
            let all = [row].into_iter().chain(waits.iter().copied()).chain(made.into_iter().flatten());
            all.map(str::to_owned).collect()
        }
        Over::Walked { kept, .. } => {
            let made = ["particles-store", "operator-own"].into_iter().chain(kept.then_some("operator-store"));
            made.map(str::to_owned).collect()
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
    if matches!(over, Over::Bricks { cells: 1.., .. } | Over::Walked { .. }) {
        // Operators stay in the workgroup, or with their cell.
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
