//! Structs shared with the shaders lie in memory as WGSL has them; catalogue entries are as long as the shaders' records.

use squirm::buffers::{MeasureSettings, Now, SpeciesUniform, SquirmerState, SystemUniform, find};
use squirm::shader::Shared;
use squirm::stages::REGISTRY;

/// Member names and offsets, size and stride of the struct that a WGSL text declares.
fn reflected(wgsl: &str) -> (Vec<(String, usize)>, usize) {
    let module = naga::front::wgsl::parse_str(wgsl).expect("valid WGSL");
    let mut structs = module.types.iter().filter_map(|(_, t)| match &t.inner {
        naga::TypeInner::Struct { members, span } => {
            let member = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset as usize);
            Some((members.iter().map(member).collect(), *span as usize))
        }
        _ => None,
    });
    let found = structs.next().expect("a struct");
    assert!(structs.next().is_none(), "{wgsl}");
    found
}

fn assert_alike(wgsl: &str, rust: &[(&'static str, usize)], size: usize) {
    let (members, span) = reflected(wgsl);
    let rust: Vec<(String, usize)> = rust.iter().map(|(name, offset)| ((*name).to_owned(), *offset)).collect();
    assert_eq!(members, rust, "{wgsl}");
    // Arrays of the struct have this stride.
    assert_eq!(span, size, "{wgsl}");
}

fn assert_shared<S: Shared>() {
    assert!(S::WGSL.contains(S::NAME));
    assert_alike(S::WGSL, &S::offsets(), size_of::<S>());
}

#[test]
fn structs_of_every_kernel() {
    assert_shared::<SystemUniform>();
    assert_shared::<SquirmerState>();
    assert_shared::<SpeciesUniform>();
    assert_shared::<Now>();
    assert_shared::<MeasureSettings>();
}

#[test]
fn settings_of_every_stage() {
    let system = squirm::state::System {
        run: squirm::state::Run { seed: 1, steps: 0, dt: 0.1, live: true },
        domain: squirm::state::Domain { size: [8, 8, 8], walls: None },
        fluid: squirm::state::Fluid { density: 10.0, temperature: 1.0, acceleration: [0.0; 3] },
        species: Vec::new(),
        init: squirm::state::Init { from: None },
    };
    for entry in REGISTRY {
        let values = squirm::params::Values::defaults(&(entry.fields)());
        let bytes = (entry.uniform)(&values, &system);
        assert_alike(entry.uniform_wgsl, &(entry.uniform_offsets)(), bytes.len());
    }
}

/// The value of `const NAME: u32 = ...u;` in some WGSL text.
fn constant(text: &str, name: &str) -> Option<usize> {
    let rest = text.split(&format!("const {name}: u32 = ")).nth(1)?;
    rest.split('u').next()?.parse().ok()
}

#[test]
fn records_are_as_long_as_the_catalogue_says() {
    let records = [
        ("moments", "MOMENT_WORDS"),
        ("operators", "OPERATOR_WORDS"),
        ("impulses", "IMPULSE_WORDS"),
        ("ghost_sums", "SUM_WORDS"),
        ("squirmer_lists", "MAP_SLOTS"),
        ("steric_sums", "STERIC_WORDS"),
        ("wall_sums", "WALL_SUM_WORDS"),
        ("wall_shear", "WALL_SHEAR_WORDS"),
    ];
    let text = squirm::stages::find("wall-ghosts").expect("a stage").module().expect("a module").text;
    assert_eq!(constant(&text, "TILE"), Some(squirm::buffers::WALL_TILE as usize));
    let fused = squirm::stages::find("shift-grid").and_then(|entry| entry.fused).expect("it does something ahead");
    let ahead = fused.text("shift_ahead");
    assert_eq!(constant(ahead, "AHEAD"), Some(squirm::buffers::STEPS_AHEAD as usize));
    assert_eq!(constant(ahead, "STRIDE"), find("shifts").map(|b| b.words / 4));
    for (buffer, name) in records {
        let words = find(buffer).expect("a buffer of the catalogue").words;
        let mut seen = 0;
        for entry in REGISTRY {
            let text = entry.module().expect("a module").text;
            if let Some(value) = constant(&text, name) {
                assert_eq!(value, words, "{name} in {}", entry.kind);
                seen += 1;
            }
        }
        assert!(seen > 0, "no shader declares {name}");
    }
}
