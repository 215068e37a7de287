//! One kernel from the functions of several stages: each element is read once, goes through all of them, and is written once.

use super::reflect::{Module, ShaderError};
use std::fmt::Write as _;

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
    /// It belongs to the step before: its `shift` is `shift_before`.
    pub late: bool,
}

impl Part<'_> {
    /// Its function `(cell: u32)` does something else for a cell than to change the operator.
    #[must_use]
    pub fn aside(&self) -> bool {
        self.wgsl.contains(&format!("fn {}(cell: u32) {{", self.function))
    }
}

/// What a fused kernel has one invocation for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Particles: functions `(i, Particle) -> Particle`.
    Particles,
    /// Cells: functions `(cell, Moments, Operator) -> Operator`, or `(cell)` for something aside, after a first `(cell) -> Sums` or
    /// the moments in memory.
    Cells {
        /// The first function makes the sums.
        sums: bool,
        /// The operators in memory matter.
        operators: bool,
    },
}

/// How many invocations share the work for one cell, and whether they know of the others of their subgroup.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Lanes {
    /// One: what suits a CPU.
    #[default]
    One,
    /// Four neighbours of a subgroup: more loads under way at a time, which suits a GPU.
    Four,
}

impl Lanes {
    /// Their number.
    #[must_use]
    pub fn count(self) -> u64 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }

    /// WGSL that includes `lanes` for one invocation, for this many.
    #[must_use]
    pub fn chosen(self, wgsl: &str) -> String {
        match self {
            Self::One => wgsl.to_owned(),
            Self::Four => wgsl.replace("//!include lanes\n", "//!include lanes-four\n"),
        }
    }
}

/// The entry point of a fused module.
pub const ENTRY: &str = "fused";

/// The uniform of a stage in a fused module.
#[must_use]
pub fn settings_name(kind: &str) -> String {
    format!("settings_{}", kind.replace('-', "_"))
}

/// Composes the fused module.
///
/// # Errors
/// If the parts do not fit together as WGSL, for instance since two of them have functions of one name.
pub fn fuse(parts: &[Part<'_>], over: Over) -> Result<Module, ShaderError> {
    let mut includes = vec!["dispatch".to_owned()];
    includes.extend(match over {
        Over::Particles => vec!["particles-store".to_owned()],
        Over::Cells { sums, operators } => {
            let loads = [(!sums).then_some("moments-load"), operators.then_some("operator-load")];
            loads.into_iter().flatten().chain(["operator-store"]).map(str::to_owned).collect()
        }
    });
    let (mut bindings, mut bodies, mut declarations) = (Vec::new(), String::new(), String::new());
    for (k, part) in parts.iter().enumerate() {
        if parts[..k].iter().all(|p| p.kind != part.kind) {
            declarations.push_str(part.settings);
        }
        let mut text = part.wgsl.replace("settings.", &format!("{}.", settings_name(part.kind)));
        if part.late {
            text = text.replace("shift[", "shift_before[");
        }
        take(&text, part, &mut includes, &mut bindings, &mut bodies);
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
    Module::new(&kinds.join(" + "), &text, &declarations)
}

/// A variable of a fused module.
pub(super) struct Bound {
    name: String,
    space: String,
    ty: String,
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
        "shift" if part.late => "shift_before".to_owned(),
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
        Over::Particles => each_particle(parts),
        Over::Cells { sums, operators } => each_cell(parts, sums, operators),
    };
    format!(
        "@compute @workgroup_size(WORKGROUP)\nfn {ENTRY}(@builtin(workgroup_id) group: vec3<u32>, \
         @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{\n    \
         let index = invocation(group, groups, lane);\n    {}\n}}\n",
        lines.join("\n    ")
    )
}

fn each_particle(parts: &[Part<'_>]) -> Vec<String> {
    let calls = parts.iter().map(|part| format!("p = {}(i, p);", part.function)).collect::<Vec<_>>().join(" ");
    let lines = [
        "let i = index;",
        "if i >= system.particle_count { return; }",
        "var p = particle_at(i);",
        &calls,
        "store_particle(i, p);",
    ];
    lines.map(str::to_owned).to_vec()
}

fn each_cell(parts: &[Part<'_>], sums: bool, operators: bool) -> Vec<String> {
    let mut lines = vec!["let i = index;".to_owned(), "if i >= system.cell_count { return; }".to_owned()];
    lines.push(if sums {
        format!("let m = moments_of({}(i));", parts[0].function)
    } else {
        "let m = moments_at(i);".to_owned()
    });
    lines.push(format!("var o = {};", if operators { "operator_at(i)" } else { "no_collision()" }));
    let call = |part: &Part<'_>| match part.aside() {
        true => format!("{}(i);", part.function),
        false => format!("o = {}(i, m, o);", part.function),
    };
    lines.extend(parts[usize::from(sums)..].iter().map(call));
    lines.push("store_operator(i, o);".to_owned());
    lines
}
