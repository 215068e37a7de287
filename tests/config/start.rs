//! A start from a table of particles: errors name the file and the line.

use super::{GOOD, changed};
use squirm::config::load;
use std::path::Path;

/// Loads a file that starts from this table, and gives the particles or the diagnostics.
fn start(table: &str) -> Result<u64, Vec<String>> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("p.csv"), table).expect("written");
    load_in(folder.path(), "p.csv")
}

fn load_in(folder: &Path, name: &str) -> Result<u64, Vec<String>> {
    let text = format!("init.from = \"{name}\"\n{GOOD}");
    match load("f.toml", &text, &[], folder) {
        Ok(loaded) => {
            let from = loaded.plan.system.init.from.expect("a start");
            assert!(Path::new(&from).is_absolute() && loaded.plan.resolved.contains("[init]"), "{from}");
            Ok(loaded.particles)
        }
        Err(failure) => Err(failure.diagnostics.iter().map(|d| d.plain(&failure.sources)).collect()),
    }
}

#[test]
fn rows_are_particles() {
    assert_eq!(start("x,y,z,vx,vy,vz\n1,2,3,0,0,0\n4, 5, 6.5, -1, 0, 1e-3\n"), Ok(2));
}

#[test]
fn wrong_rows_are_named_by_line() {
    let table = "x,y,z,vx,vy,vz\n1,2,3,0,0,0\n1,2,3,0,0\n1,2,x,0,0,0\n1,2,3,0,nan,0\n1,20,3,0,0,0\n1,2,3,0,0,12\n1,2,3,0,0,-50\n";
    let found = start(table).expect_err("wrong rows");
    let parts = [
        "p.csv:3: the row has 5 values",
        "p.csv:4: `x` in column z is not a number",
        "p.csv:5: `nan` in column vy is not finite",
        "p.csv:6: y = 20 lies outside the box",
        "p.csv:8: the speed 50 is above 12, the largest at this temperature",
    ];
    assert_eq!(found.len(), parts.len(), "{found:#?}");
    for (line, part) in found.iter().zip(parts) {
        assert!(line.starts_with("f.toml:1:13: error: ") && line.contains(part), "{part}: {line}");
    }
}

#[test]
fn many_wrong_rows_are_counted() {
    let table = format!("x,y,z,vx,vy,vz\n{}", "a,b,c,d,e,f\n".repeat(100));
    let found = start(&table).expect_err("wrong rows");
    assert_eq!(found.len(), 11);
    assert!(found[10].contains("90 more rows are wrong"), "{}", found[10]);
}

#[test]
fn header_and_file_are_checked() {
    let found = start("x,y,z\n1,2,3\n").expect_err("wrong header");
    assert!(found[0].contains("p.csv:1: the header is `x,y,z`, but must be `x,y,z,vx,vy,vz`"), "{found:?}");
    let found = start("x,y,z,vx,vy,vz\n").expect_err("no rows");
    assert!(found[0].contains("the table has no row"), "{found:?}");
    assert_eq!(start("\u{feff}x,y,z,vx,vy,vz\r\n1,2,3,0,0,0\r\n"), Ok(1), "as spreadsheets write it");
    let found = load_in(Path::new("/"), "tmp").expect_err("a folder");
    assert!(found[0].contains("cannot be read") && found.len() == 1, "{found:?}");
    let found = load_in(Path::new("/nonexistent"), "p.csv").expect_err("no file");
    assert!(found[0].contains("cannot be read") && found.len() == 1, "{found:?}");
}

/// What a file means follows from the particles that there are, and says where that is not what the file declares.
#[test]
fn the_meaning_is_that_of_the_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!("init.from = \"p.csv\"\n{}", changed(&[("count = 2", "count = 1")]));
    let meaning = |rows: usize| {
        std::fs::write(folder.path().join("p.csv"), format!("x,y,z,vx,vy,vz\n{}", "1,2,3,0,0,0\n".repeat(rows)))
            .expect("written");
        squirm::config::meaning(&load("f.toml", &text, &[], folder.path()).unwrap_or_else(|f| panic!("{f}")))
    };
    // 11,520 a^3 less one hull of 4.12 x 2.12 x 2.12, 77.6 a^3.
    let (thin, dense) = (meaning(1000), meaning(114_424));
    assert!((thin.density[0] - 1000.0 / 11442.4).abs() < 1e-4 && thin.density[1] == 10.0, "{:?}", thin.density);
    assert!(thin.to_string().contains("0.0874 particles per a^3 in the table; ghosts and masses are for density = 10"));
    assert!(!dense.to_string().contains("in the table"), "{dense}");
    let [thin, dense] = [thin, dense].map(|m| m.transport.expect("it rotates").viscosity);
    let declared = super::good(super::GOOD);
    let expected = squirm::config::meaning(&declared).transport.expect("it rotates").viscosity;
    assert!((dense / expected - 1.0).abs() < 1e-4 && thin < 0.1 * expected, "{thin} {dense} {expected}");
}

#[test]
fn without_a_table_the_density_counts() {
    let text = changed(&[("density = 10", "density = 5")]);
    let loaded = load("f.toml", &text, &[], Path::new("")).unwrap_or_else(|f| panic!("{f}"));
    assert_eq!(loaded.particles, loaded.plan.system.particle_count());
}
