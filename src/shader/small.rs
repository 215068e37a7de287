//! One kernel of a single workgroup from entry points over few elements: it does one after the other, with barriers in between.

use super::fuse::{Bound, ENTRY, Part, bind_lines, take};
use super::reflect::{Module, ShaderError};
use std::fmt::Write as _;

/// Invocations of the workgroup: what every adapter allows.
const INVOCATIONS: u32 = 256;

/// One of the entry points; its part's function is its name.
#[derive(Debug, Clone, Copy)]
pub struct Phase<'a> {
    /// What the stage gives.
    pub part: Part<'a>,
    /// Elements.
    pub count: u64,
    /// It uses what an entry point before it wrote, or writes what that used, since the last barrier.
    pub waits: bool,
}

/// The invocation's index among all, which becomes the element.
pub(super) const INDEX: &str = "invocation(group, groups, lane)";

/// Whether an entry point uses nothing of its workgroup but the index of the invocation, so that it does its work for one element.
#[must_use]
pub fn apart(wgsl: &str, point: &str) -> bool {
    let mut lines = wgsl.lines().skip_while(|l| !l.starts_with(&format!("fn {point}("))).skip(1);
    let own = |word: &str| ["lane", "group", "groups"].contains(&word);
    let shares = |line: &str| line.replace(INDEX, "").split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(own);
    !lines.by_ref().take_while(|l| *l != "}").any(shares)
}

/// Composes the module. Entry points become functions of their element, and functions bear their stage's name, since several stages may
/// call one alike.
///
/// # Errors
/// If the parts do not fit together as WGSL.
pub fn one_workgroup(phases: &[Phase<'_>]) -> Result<Module, ShaderError> {
    let parts: Vec<Part<'_>> = phases.iter().map(|p| p.part).collect();
    // Invocations read what others of the workgroup wrote.
    let coherent =
        |bindings: String| bindings.replace("var<storage, read_write>", "@coherent var<storage, read_write>");
    together(&parts, of_elements, coherent, &entry(&parts, phases))
}

/// One module of entry points that have become functions named after their stages, and what calls them.
pub(super) fn together(
    parts: &[Part<'_>],
    as_functions: fn(&str, &[&str]) -> String,
    bound: impl Fn(String) -> String,
    entry: &str,
) -> Result<Module, ShaderError> {
    let mut includes = vec!["dispatch".to_owned()];
    let (mut bindings, mut bodies, mut declarations) = (Vec::<Bound>::new(), String::new(), String::new());
    let mut kinds: Vec<&str> = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        if !kinds.contains(&part.kind) {
            kinds.push(part.kind);
            declarations.push_str(part.settings);
        }
        if parts[..k].iter().any(|p| p.wgsl == part.wgsl) {
            continue;
        }
        let points: Vec<&str> = parts.iter().filter(|p| p.wgsl == part.wgsl).map(|p| p.function).collect();
        let text = super::fuse::with_own_settings(part.wgsl, part.kind);
        let mut body = String::new();
        take(&as_functions(&text, &points), part, &mut includes, &mut bindings, &mut body);
        bodies.push_str(&named(&body, &prefix(parts, part)));
    }
    let mut text = String::new();
    for name in &includes {
        let _ = writeln!(text, "//!include {name}");
    }
    text.push_str(&bound(bind_lines(&bindings)));
    text.push_str("var<immediate> now: Now;\n");
    text.push_str(&bodies);
    text.push_str(entry);
    Module::new(&kinds.join(" + "), &text, &declarations)
}

/// What the functions of a part begin with: its stage, and which of the stage's texts it has, from the second on.
pub(super) fn prefix(parts: &[Part<'_>], part: &Part<'_>) -> String {
    let mut texts: Vec<&str> = Vec::new();
    for own in parts.iter().filter(|p| p.kind == part.kind).map(|p| p.wgsl) {
        if !texts.contains(&own) {
            texts.push(own);
        }
    }
    let which = texts.iter().position(|text| *text == part.wgsl).filter(|k| *k > 0);
    part.kind.replace('-', "_") + &which.map_or(String::new(), |k| k.to_string())
}

/// The text with these entry points as functions `(element: u32)`.
pub(super) fn of_elements(text: &str, points: &[&str]) -> String {
    as_functions(text, points, "element: u32", |line| line.replace(INDEX, "element"))
}

/// The text with these entry points as functions of `arguments`; `inside` changes the lines of their bodies.
pub(super) fn as_functions(text: &str, points: &[&str], arguments: &str, inside: fn(&str) -> String) -> String {
    let mut out = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let next = lines.peek().copied().unwrap_or_default();
        let point = points.iter().find(|p| next.starts_with(&format!("fn {p}(")));
        match point {
            Some(point) if line.starts_with("@compute") => {
                lines.next();
                let _ = writeln!(out, "fn {point}({arguments}) {{");
                for line in lines.by_ref().take_while(|l| *l != "}") {
                    out.push_str(&inside(line));
                    out.push('\n');
                }
                out.push_str("}\n");
            }
            _ => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
    out
}

/// The text with `PREFIX_` before the names of the functions that it declares.
fn named(text: &str, prefix: &str) -> String {
    let declared = |line: &'_ str| line.strip_prefix("fn ").and_then(|l| l.split_once('(')).map(|(n, _)| n.to_owned());
    let names: Vec<String> = text.lines().filter_map(declared).collect();
    let mut out = String::new();
    let mut word = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        if c == '(' && !out.ends_with('.') && names.contains(&word) {
            let _ = write!(out, "{prefix}_");
        }
        out.push_str(&word);
        word.clear();
        out.push(c);
    }
    out.push_str(&word);
    out
}

fn entry(parts: &[Part<'_>], phases: &[Phase<'_>]) -> String {
    let mut text =
        format!("@compute @workgroup_size({INVOCATIONS})\nfn {ENTRY}(@builtin(local_invocation_index) lane: u32) {{\n");
    for Phase { part, count, waits } in phases {
        if *waits {
            text.push_str("    storageBarrier();\n");
        }
        let call = format!("{}_{}(i);", prefix(parts, part), part.function);
        let _ = writeln!(text, "    for (var i = lane; i < {count}u; i += {INVOCATIONS}u) {{ {call} }}");
    }
    text.push_str("}\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_bear_their_stage_and_members_do_not() {
        let text = "fn force(a: Load) -> f32 {\n    return a.force + force(a) + enforce(a.force);\n}\n";
        let wanted = "fn move_force(a: Load) -> f32 {\n    return a.force + move_force(a) + enforce(a.force);\n}\n";
        assert_eq!(named(text, "move"), wanted);
    }

    #[test]
    fn entry_points_become_functions_of_their_element() {
        let text = "@compute @workgroup_size(WORKGROUP)\nfn f(@builtin(workgroup_id) group: vec3<u32>) {\n    \
                    let i = invocation(group, groups, lane);\n}\n@compute @workgroup_size(1)\nfn g() {\n}\n";
        let wanted = "fn f(element: u32) {\n    let i = element;\n}\n@compute @workgroup_size(1)\nfn g() {\n}\n";
        assert_eq!(of_elements(text, &["f"]), wanted);
    }

    #[test]
    fn what_uses_its_lane_is_not_apart() {
        let point = |body: &str| format!("fn f() {{\n    other({body});\n}}\nfn g(lane: u32) {{\n}}\n");
        assert!(apart(&point(INDEX), "f") && apart(&point("planet"), "f"));
        assert!(!apart(&point(&format!("{INDEX}, lane")), "f"));
    }

    #[test]
    fn phases_wait_for_each_other_where_they_must() {
        let wgsl = "//!include dispatch\n@group(0) @binding(0) var<storage, read_write> shift: array<u32>;\n\
                    @compute @workgroup_size(WORKGROUP)\nfn f(@builtin(workgroup_id) group: vec3<u32>) {\n    \
                    let i = invocation(group, groups, lane);\n    shift[i] = 1u;\n}\n";
        let part = |kind| Part { kind, wgsl, settings: "", function: "f", rare: None, late: false };
        let phases = [("a-b", 2, false), ("a-b", 300, true)].map(|(kind, count, waits)| Phase {
            part: part(kind),
            count,
            waits,
        });
        let module = one_workgroup(&phases).expect("valid");
        let body = module.text.split("fn fused(").nth(1).expect("the entry point");
        let line = |count| format!("    for (var i = lane; i < {count}u; i += 256u) {{ a_b_f(i); }}\n");
        assert!(body.ends_with(&format!("{}    storageBarrier();\n{}}}\n\n", line(2), line(300))), "{body}");
    }
}
