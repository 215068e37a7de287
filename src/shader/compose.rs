//! Composition of one WGSL module from a stage's file, the library files it includes and the structs it shares with Rust.

use super::Shared;
use crate::buffers::{Fault, Now, Site, SpeciesUniform, SquirmerState, SystemUniform};
use crate::math::rng::Purpose;
use std::fmt::Write as _;

/// The library: pure functions, and functions over buffers that the including file binds.
const LIBRARY: &[(&str, &str)] = &[
    ("absorb", include_str!("../../shaders/lib/absorb.wgsl")),
    ("bricks", include_str!("../../shaders/lib/bricks.wgsl")),
    ("bricks-near", include_str!("../../shaders/lib/bricks-near.wgsl")),
    ("bricks-settle", include_str!("../../shaders/lib/bricks-settle.wgsl")),
    ("cells", include_str!("../../shaders/lib/cells.wgsl")),
    ("operator-own", include_str!("../../shaders/lib/operator-own.wgsl")),
    ("chains", include_str!("../../shaders/lib/chains.wgsl")),
    ("contribution", include_str!("../../shaders/lib/contribution.wgsl")),
    ("deposit", include_str!("../../shaders/lib/deposit.wgsl")),
    ("dispatch", include_str!("../../shaders/lib/dispatch.wgsl")),
    ("energies", include_str!("../../shaders/lib/energies.wgsl")),
    ("exact", include_str!("../../shaders/lib/exact.wgsl")),
    ("fault", include_str!("../../shaders/lib/fault.wgsl")),
    ("ghosts", include_str!("../../shaders/lib/ghosts.wgsl")),
    ("ghosts-draw", include_str!("../../shaders/lib/ghosts-draw.wgsl")),
    ("ghosts-gain", include_str!("../../shaders/lib/ghosts-gain.wgsl")),
    ("ghosts-rigid", include_str!("../../shaders/lib/ghosts-rigid.wgsl")),
    ("held", include_str!("../../shaders/lib/held.wgsl")),
    ("held-handfuls", include_str!("../../shaders/lib/held-handfuls.wgsl")),
    ("held-handfuls-store", include_str!("../../shaders/lib/held-handfuls-store.wgsl")),
    ("held-store", include_str!("../../shaders/lib/held-store.wgsl")),
    ("impulse-fixed", include_str!("../../shaders/lib/impulse-fixed.wgsl")),
    ("impulse", include_str!("../../shaders/lib/impulse.wgsl")),
    ("lanes", include_str!("../../shaders/lib/lanes.wgsl")),
    ("lanes-four", include_str!("../../shaders/lib/lanes-four.wgsl")),
    ("moments", include_str!("../../shaders/lib/moments.wgsl")),
    ("moments-load", include_str!("../../shaders/lib/moments-load.wgsl")),
    ("nearest", include_str!("../../shaders/lib/nearest.wgsl")),
    ("operator", include_str!("../../shaders/lib/operator.wgsl")),
    ("operator-brick", include_str!("../../shaders/lib/operator-brick.wgsl")),
    ("operator-load", include_str!("../../shaders/lib/operator-load.wgsl")),
    ("operator-store", include_str!("../../shaders/lib/operator-store.wgsl")),
    ("particle", include_str!("../../shaders/lib/particle.wgsl")),
    ("particles", include_str!("../../shaders/lib/particles.wgsl")),
    ("particles-leave", include_str!("../../shaders/lib/particles-leave.wgsl")),
    ("particles-store", include_str!("../../shaders/lib/particles-store.wgsl")),
    ("path", include_str!("../../shaders/lib/path.wgsl")),
    ("places", include_str!("../../shaders/lib/places.wgsl")),
    ("rigid", include_str!("../../shaders/lib/rigid.wgsl")),
    ("rng", include_str!("../../shaders/lib/rng.wgsl")),
    ("spheroid", include_str!("../../shaders/lib/spheroid.wgsl")),
    ("split", SPLIT),
    ("split-wide", SPLIT_WIDE),
    ("steric", include_str!("../../shaders/lib/steric.wgsl")),
    ("sums-load", include_str!("../../shaders/lib/sums-load.wgsl")),
    ("sums-store", include_str!("../../shaders/lib/sums-store.wgsl")),
    ("sums-words", include_str!("../../shaders/lib/sums-words.wgsl")),
    ("sums-workgroup", include_str!("../../shaders/lib/sums-workgroup.wgsl")),
    ("symmetric", include_str!("../../shaders/lib/symmetric.wgsl")),
    ("wall-ghosts", include_str!("../../shaders/lib/wall-ghosts.wgsl")),
    ("wall-impulse", include_str!("../../shaders/lib/wall-impulse.wgsl")),
    ("walls", include_str!("../../shaders/lib/walls.wgsl")),
    ("workgroup-sum", include_str!("../../shaders/lib/workgroup-sum.wgsl")),
    ("wide", include_str!("../../shaders/lib/wide.wgsl")),
];

const SPLIT: &str = include_str!("../../shaders/lib/split.wgsl");
const SPLIT_WIDE: &str = include_str!("../../shaders/lib/split-wide.wgsl");

/// A composed text as it is for an adapter with whole numbers of 64 bits.
#[must_use]
pub fn widened(text: &str) -> String {
    text.replace(SPLIT, SPLIT_WIDE)
}

/// An include that the library does not have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`//!include {0}` names no file of shaders/lib")]
pub struct UnknownInclude(pub String);

/// The complete WGSL text of a module: shared structs, constants, each included library file once, then `text`.
///
/// # Errors
/// If `text`, or a file it includes, includes a file that the library does not have.
pub fn compose(text: &str, settings: &str) -> Result<String, UnknownInclude> {
    let mut module = String::new();
    for declaration in [SystemUniform::WGSL, SquirmerState::WGSL, SpeciesUniform::WGSL, Now::WGSL, settings] {
        module.push_str(declaration);
    }
    for purpose in Purpose::ALL {
        let _ = writeln!(module, "const PURPOSE_{}: u32 = {}u;", constant(&format!("{purpose:?}")), *purpose as u32);
    }
    for fault in Fault::ALL {
        let _ = writeln!(module, "const FAULT_{}: u32 = {}u;", constant(&format!("{fault:?}")), *fault as u32);
    }
    for site in Site::ALL {
        let _ = writeln!(module, "const SITE_{}: u32 = {}u;", constant(&format!("{site:?}")), *site as u32);
    }
    let mut included = Vec::new();
    include(text, &mut included, &mut module)?;
    Ok(module)
}

/// A text with the library files that it includes, as far as there are such.
pub(super) fn with_library(text: &str) -> String {
    let mut module = String::new();
    // What is missing is said when the module is made.
    let _ = include(text, &mut Vec::new(), &mut module);
    module
}

fn include(text: &str, included: &mut Vec<String>, module: &mut String) -> Result<(), UnknownInclude> {
    for name in text.lines().filter_map(|line| line.strip_prefix("//!include ")).map(str::trim) {
        if included.iter().any(|n| n == name) {
            continue;
        }
        let (_, file) = LIBRARY.iter().find(|(n, _)| *n == name).ok_or_else(|| UnknownInclude(name.to_owned()))?;
        included.push(name.to_owned());
        include(file, included, module)?;
    }
    module.push_str(text);
    module.push('\n');
    Ok(())
}

/// `WallGhost` becomes `WALL_GHOST`.
fn constant(camel: &str) -> String {
    let mut out = String::new();
    for (i, c) in camel.chars().enumerate() {
        if c.is_uppercase() && i > 0 {
            out.push('_');
        }
        out.extend(c.to_uppercase());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_file_is_included_once() {
        let module =
            compose("//!include rng\n//!include rng\n//!include ghosts\nfn f() {}\n", "").expect("known includes");
        assert_eq!(module.matches("fn threefry(").count(), 1);
        assert!(module.ends_with("fn f() {}\n\n"));
    }

    #[test]
    fn an_unknown_include_is_named() {
        assert_eq!(compose("//!include nowhere\n", ""), Err(UnknownInclude("nowhere".into())));
    }

    #[test]
    fn constants_follow_the_enums() {
        assert_eq!(constant("WallGhost"), "WALL_GHOST");
        assert!(compose("", "").expect("no includes").contains("const PURPOSE_WALL_GHOST: u32 = 4u;"));
    }
}
