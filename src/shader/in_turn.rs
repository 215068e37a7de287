//! One kernel of entry points over the same elements: an invocation does for its element one after the other.

use super::fuse::{ENTRY, Part};
use super::reflect::{Module, ShaderError};
use super::small::{INDEX, of_elements, prefix, together};
use std::fmt::Write as _;

/// Composes the module; a part's function is its entry point.
///
/// # Errors
/// If the parts do not fit together as WGSL.
pub fn in_turn(parts: &[Part<'_>]) -> Result<Module, ShaderError> {
    let mut entry = format!(
        "@compute @workgroup_size(WORKGROUP)\nfn {ENTRY}(@builtin(workgroup_id) group: vec3<u32>, \
         @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{\n    \
         let i = {INDEX};\n"
    );
    for part in parts {
        let _ = writeln!(entry, "    {}_{}(i);", prefix(parts, part), part.function);
    }
    together(parts, of_elements, |bindings| bindings, &(entry + "}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_goes_through_all() {
        let wgsl = "//!include dispatch\n@group(0) @binding(0) var<storage, read_write> shift: array<u32>;\n\
                    @compute @workgroup_size(WORKGROUP)\nfn f(@builtin(workgroup_id) group: vec3<u32>) {\n    \
                    let i = invocation(group, groups, lane);\n    if i > 3u {\n        return;\n    }\n    shift[i] = 1u;\n}\n";
        let part = |kind| Part { kind, wgsl, settings: "", function: "f", rare: None, late: false };
        let module = in_turn(&[part("a-b"), part("a-b")]).expect("valid");
        let body = module.text.split("fn fused(").nth(1).expect("the entry point");
        assert!(
            body.ends_with("let i = invocation(group, groups, lane);\n    a_b_f(i);\n    a_b_f(i);\n}\n\n"),
            "{body}"
        );
    }
}
