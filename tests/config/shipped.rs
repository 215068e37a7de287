//! The shipped pipelines and the schema.

use squirm::config::{load, meaning, schema};
use std::path::Path;

fn pipelines() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let files = std::fs::read_dir(folder).expect("the folder is there").map(|f| f.expect("a file").path());
    let toml = files.filter(|p| p.extension().is_some_and(|e| e == "toml"));
    toml.map(|p| (p.display().to_string(), std::fs::read_to_string(&p).expect("text"))).collect()
}

#[test]
fn every_pipeline_is_valid_without_warnings() {
    let all = pipelines();
    assert!(all.len() >= 7, "{}", all.len());
    for (name, text) in all {
        let loaded = load(&name, &text, &[], Path::new("")).unwrap_or_else(|f| panic!("{f}"));
        let warnings: Vec<String> = loaded.warnings.iter().map(|d| d.plain(&loaded.sources)).collect();
        assert_eq!(warnings, Vec::<String>::new());
        assert!(meaning(&loaded).to_string().contains("viscosity"));
    }
}

#[test]
fn every_pipeline_points_to_the_schema_and_says_what_it_shows() {
    for (name, text) in pipelines() {
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("#:schema ../squirm.schema.json"), "{name}");
        assert!(lines.next().is_some_and(|l| l.starts_with("# ") && l.len() > 40), "{name}");
    }
}

#[test]
fn the_schema_is_current() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("squirm.schema.json");
    let text = std::fs::read_to_string(file).expect("the schema is there");
    assert!(text == schema(), "squirm.schema.json is out of date: run `squirm schema > squirm.schema.json`");
}

#[test]
fn the_meaning_of_a_known_file() {
    let text = super::changed(&[("walls = { axis = \"y\", condition = \"no-slip\" }\n", "")])
        .replace("[[stage]]\nkind = \"wall-ghosts\"\n", "")
        .replace("size = [24, 20, 24]", "size = [60, 60, 60]")
        .replace("along = 4.0, across = 2.0", "along = 6.0, across = 3.0")
        .replace("dt = 0.05", "dt = 0.02")
        .replace("b1 = 0.1", "b1 = 0.05");
    let m = meaning(&super::good(&text));
    // Two bodies of 3.12 x 3.12 x 6.12, 249.55 a^3, in 216,000 a^3 at 10 particles per a^3.
    assert_eq!((m.cells, m.particles), (216_000, 2_155_009));
    let eta = m.transport.expect("it rotates").viscosity;
    assert!((eta - 18.59).abs() < 0.01, "{eta}");
    let s = &m.species[0];
    assert!((s.speed - 0.0413).abs() < 5e-5 && (s.mass - 2495.0).abs() < 0.5, "{s:?}");
    assert!((s.reynolds.expect("it swims") - 0.133).abs() < 1e-3, "{s:?}");
    assert!((s.peclet.expect("it swims") - 131.0).abs() < 1.0, "{s:?}");
    assert!((s.diffusion.expect("eta is known")[3] * eta * 2042.4 - 1.0).abs() < 1e-4, "{s:?}");
    let bytes = |name: &str| m.memory.iter().find(|(n, _)| *n == name).map(|(_, b)| *b);
    // 3,375 bricks, two of which share room for 1,584 particles; the row of all lies there, too, and is what a checkpoint has of them.
    assert_eq!(bytes("bricks_xy"), Some(1688 * 1584 * 8));
    assert_eq!(bytes("particles"), None);
    assert!((2_155_009 * 24..2_155_009 * 25).contains(&m.checkpoint), "{}", m.checkpoint);
    assert_eq!(bytes("operators"), Some(216_000 * 64));
}
