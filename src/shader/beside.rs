//! One kernel of entry points that have nothing to do with each other: some of its workgroups do one, some the next.

use super::compose::with_library;
use super::fuse::{ENTRY, Part};
use super::reflect::{Module, ShaderError};
use super::small::{as_functions, prefix, together};
use std::fmt::Write as _;

/// One of the entry points; its part's function is its name.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// What the stage gives.
    pub part: Part<'a>,
    /// Workgroups.
    pub groups: u64,
}

const ARGUMENTS: &str = "group: vec3<u32>, groups: vec3<u32>, lane: u32";

/// Whether an entry point has workgroups of the common size and takes the usual arguments.
#[must_use]
pub fn usual(wgsl: &str, point: &str) -> bool {
    let head = format!(
        "fn {point}(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, \
         @builtin(local_invocation_index) lane: u32) {{"
    );
    let mut lines = wgsl.lines().zip(wgsl.lines().skip(1));
    lines.any(|(size, line)| size == "@compute @workgroup_size(WORKGROUP)" && line == head)
}

/// Whether two texts can be in one module: what both declare must be the same thing.
#[must_use]
pub fn compatible(a: &str, b: &str) -> bool {
    let bound = |text: &str| -> Vec<(String, String)> {
        let lines = text.lines().filter(|line| line.starts_with("@group(")).filter_map(|line| line.split_once("> "));
        let named = lines.filter_map(|(_, rest)| rest.split_once(": "));
        named.map(|(name, ty)| (name.to_owned(), ty.to_owned())).filter(|(name, _)| name != "settings").collect()
    };
    let declared = |text: &str| -> Vec<String> {
        let heads = ["struct ", "const ", "override ", "var<workgroup> "];
        let rest = text.lines().filter_map(|line| heads.iter().find_map(|head| line.strip_prefix(head)));
        rest.map(|rest| rest.split([':', ' ', '=']).next().unwrap_or_default().to_owned()).collect()
    };
    let of_b = bound(b);
    let alike = |(name, ty): &(String, String)| of_b.iter().all(|(other, of)| other != name || of == ty);
    let twice = |own: &str, other: &str| {
        let known = declared(&with_library(other));
        declared(own).iter().any(|name| known.contains(name))
    };
    bound(a).iter().all(alike) && !twice(a, b) && !twice(b, a)
}

/// Composes the module.
///
/// # Errors
/// If the parts do not fit together as WGSL.
pub fn side_by_side(sides: &[Side<'_>]) -> Result<Module, ShaderError> {
    let parts: Vec<Part<'_>> = sides.iter().map(|side| side.part).collect();
    let functions = |text: &str, points: &[&str]| as_functions(text, points, ARGUMENTS, str::to_owned);
    together(&parts, functions, |bindings| bindings, &entry(&parts, sides))
}

fn entry(parts: &[Part<'_>], sides: &[Side<'_>]) -> String {
    let mut text = format!(
        "@compute @workgroup_size(WORKGROUP)\nfn {ENTRY}(@builtin(workgroup_id) group: vec3<u32>, \
         @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{\n    \
         let k = group.y * groups.x + group.x;\n    "
    );
    let mut first = 0;
    for Side { part, groups } in sides {
        let end = first + groups;
        let call = format!("{}_{}", prefix(parts, part), part.function);
        let _ = write!(
            text,
            "if k < {end}u {{\n        {call}(vec3<u32>(k - {first}u, 0u, 0u), vec3<u32>({groups}u, 1u, 1u), lane);\n    }} else "
        );
        first = end;
    }
    // What is left over at the end of the last row does nothing.
    text.truncate(text.len() - " else ".len());
    text + "\n}\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "@compute @workgroup_size(WORKGROUP)\nfn f(@builtin(workgroup_id) group: vec3<u32>, \
        @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {\n";

    #[test]
    fn each_has_its_own_workgroups() {
        let text = |name: &str| {
            format!(
                "//!include dispatch\n@group(0) @binding(0) var<storage, read_write> {name}: array<u32>;\n{HEAD}    \
                 let i = invocation(group, groups, lane);\n    if i > 3u {{\n        return;\n    }}\n    {name}[i] = 1u;\n}}\n"
            )
        };
        let (a, b) = (text("shift"), text("bin_next"));
        assert!(usual(&a, "f") && !usual(&a, "g") && compatible(&a, &b));
        assert!(!usual(&a.replace("(WORKGROUP)", "(1)"), "f"));
        let part = |kind, wgsl| Part { kind, wgsl, settings: "", function: "f", rare: None, late: false };
        // Two texts of a stage may call functions alike.
        let twice = [Side { part: part("a-b", &a), groups: 3 }, Side { part: part("a-b", &b), groups: 5 }];
        assert!(side_by_side(&twice).expect("valid").text.contains("        a_b1_f(vec3<u32>(k - 3u, 0u, 0u)"));
        let sides = [Side { part: part("a-b", &a), groups: 3 }, Side { part: part("c", &b), groups: 5 }];
        let module = side_by_side(&sides).expect("valid");
        for line in [
            "if k < 3u {\n        a_b_f(vec3<u32>(k - 0u, 0u, 0u), vec3<u32>(3u, 1u, 1u), lane);\n    } else if k < 8u {",
            "        c_f(vec3<u32>(k - 3u, 0u, 0u), vec3<u32>(5u, 1u, 1u), lane);\n    }\n}\n",
            "fn a_b_f(group: vec3<u32>, groups: vec3<u32>, lane: u32) {",
        ] {
            assert!(module.text.contains(line), "{line}\n{}", module.text);
        }
        assert_eq!(module.bindings(ENTRY).len(), 2);
    }

    #[test]
    fn what_means_two_things_is_not_compatible() {
        let words = "@group(0) @binding(3) var<storage, read> moments: array<u32>;\nconst A: u32 = 1u;\n";
        let vectors = words.replace("array<u32>", "array<vec4<u32>>").replace("const A", "const B");
        assert!(!compatible(words, &vectors));
        assert!(compatible(words, &words.replace("const A", "const B")));
        assert!(!compatible("struct A {\n", words) && !compatible(words, "var<workgroup> A: u32;\n"));
        // What one declares may be in a file that the other includes.
        assert!(!compatible("//!include workgroup-sum\n", "var<workgroup> partial: u32;\n"));
        assert!(compatible("//!include workgroup-sum\n", "//!include workgroup-sum\n"));
        // A uniform of its own each.
        let settings = |ty: &str| format!("@group(0) @binding(1) var<uniform> settings: {ty};\n");
        assert!(compatible(&settings("X"), &settings("Y")));
    }
}
