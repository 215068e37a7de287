//! The architecture's rules as tests: what may use what, sizes of files and functions, and files that belong together.

use squirm::shader::compose;
use squirm::stages::REGISTRY;
use std::collections::BTreeSet;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// Which rooms of `src` a room may use besides itself, the lowest first: a room may use only rooms that stand above it in
/// this list, so arrows cannot run in circles. `shared` is src/shader/shared.rs, a leaf below the rest of `shader` and `buffers`.
const ROOMS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("diag", &[]),
    ("params", &[]),
    ("shared", &[]),
    ("wire", &[]),
    ("segments", &[]),
    ("checkpoint", &[]),
    ("buffers", &["shared"]),
    ("shader", &["buffers", "math"]),
    ("state", &["buffers", "math", "params"]),
    ("stages", &["buffers", "math", "params", "shader", "shared", "state"]),
    ("recording", &["wire"]),
    ("sink", &["recording", "wire"]),
    ("replay", &["recording", "sink", "wire"]),
    ("export", &["recording", "wire"]),
    ("analyze", &["math", "params", "recording", "wire"]),
    ("graph", &["analyze", "buffers", "math", "params", "shader", "stages", "state"]),
    ("config", &["analyze", "buffers", "diag", "graph", "math", "params", "stages", "state", "wire"]),
    ("gpu", &["buffers", "graph", "math", "shader", "stages", "state"]),
    ("sim", &["analyze", "buffers", "checkpoint", "gpu", "graph", "sink", "state", "wire"]),
    ("bench", &["buffers", "gpu", "graph", "sim", "state"]),
    ("lib", &[]),
    (
        "cli",
        &[
            "analyze",
            "bench",
            "config",
            "diag",
            "export",
            "gpu",
            "graph",
            "params",
            "recording",
            "replay",
            "sim",
            "sink",
            "stages",
            "wire",
        ],
    ),
    ("main", &["cli"]),
    ("squirm-analyze", &["analyze", "params"]),
    ("squirm-faults", &["analyze", "checkpoint", "config", "diag", "recording", "wire"]),
    ("squirm-validate", &["analyze", "buffers", "config", "gpu", "graph", "math", "params", "state"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below a folder of the repository whose name ends so, as a path from the root; build products are left out.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            if path.is_dir() && !["target", "runs", ".git"].contains(&name.as_str()) {
                folders.push(path);
            } else if path.is_file() && name.ends_with(ending) {
                found.push(path.strip_prefix(root()).expect("below the root").to_owned());
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no {ending} in {folder}");
    found
}

fn text(file: &Path) -> String {
    read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// Text without comments that take a whole line.
fn code(file: &Path) -> String {
    text(file).lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn fail_if_any(found: &[String], rule: &str) {
    assert!(found.is_empty(), "{rule}:\n  {}", found.join("\n  "));
}

fn room(file: &Path) -> String {
    if file == Path::new("src/shader/shared.rs") {
        return "shared".into();
    }
    let inside = file.strip_prefix("src").or_else(|_| file.strip_prefix("tools")).expect("src or tools");
    let first = inside.components().next().expect("a component").as_os_str().to_string_lossy().into_owned();
    first.strip_suffix(".rs").unwrap_or(&first).to_owned()
}

fn identifier(text: &str) -> &str {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("")
}

/// First names of the paths behind `crate::` or `squirm::`, also in a list in braces.
fn names(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(prefix) {
        let rest = &code[at + prefix.len()..];
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let Some(list) = rest.strip_prefix('{') else {
            let path = rest.strip_prefix("shader::shared").map_or(rest, |_| "shared");
            found.insert(identifier(path).to_owned());
            continue;
        };
        let (mut depth, mut item) = (1, String::new());
        for c in list.chars() {
            depth += i32::from(c == '{') - i32::from(c == '}');
            if depth == 0 || (depth == 1 && c == ',') {
                found.insert(identifier(item.trim()).to_owned());
                item.clear();
            } else {
                item.push(c);
            }
            if depth == 0 {
                break;
            }
        }
    }
    found.remove("");
    found
}

#[test]
fn names_are_found_in_every_form_of_path() {
    let code =
        "use crate::a::B; use crate::{c, d::{E, F}, g as h}; $crate::i! { mycrate::j; crate::shader::shared::K }";
    let expected = ["a", "c", "d", "g", "i", "shared"].map(str::to_owned);
    assert_eq!(names(code, "crate::"), BTreeSet::from(expected));
}

#[test]
fn arrows_point_down() {
    let place = |name: &str| ROOMS.iter().position(|(n, _)| *n == name);
    for (index, (name, below)) in ROOMS.iter().enumerate() {
        for other in *below {
            assert!(
                place(other).is_some_and(|p| p < index),
                "the table lets {name} use {other}, which is not below it"
            );
        }
    }
    let (mut wrong, mut used) = (Vec::new(), BTreeSet::new());
    for file in files("src", ".rs").into_iter().chain(files("tools", ".rs")) {
        let room = room(&file);
        let prefix = if ["cli", "main", "squirm-analyze", "squirm-faults", "squirm-validate"].contains(&room.as_str()) {
            "squirm::"
        } else {
            "crate::"
        };
        let Some(index) = place(&room) else { panic!("{}: no room `{room}` in the table", file.display()) };
        for name in names(&code(&file), prefix) {
            // Macros and re-exports have names of their own; what is no room is no arrow.
            if place(&name).is_none() || name == room {
                continue;
            }
            used.insert((room.clone(), name.clone()));
            if !ROOMS[index].1.contains(&name.as_str()) {
                wrong.push(format!("{}: {room} uses {name}", file.display()));
            }
        }
    }
    fail_if_any(&wrong, "arrows that the table of rooms does not have");
    let all = ROOMS.iter().flat_map(|(room, below)| below.iter().map(move |b| (*room, *b)));
    let idle: Vec<String> = all
        .filter(|(room, b)| *room != "main" && !used.contains(&((*room).to_owned(), (*b).to_owned())))
        .map(|(room, b)| format!("{room} -> {b}"))
        .collect();
    fail_if_any(&idle, "arrows of the table that nothing uses: take them out");
}

#[test]
fn only_the_gpu_room_names_wgpu() {
    let named = |file: &PathBuf| names(&code(file), "wgpu::").first().is_some() || code(file).contains("use wgpu");
    let found: Vec<String> = files("src", ".rs")
        .into_iter()
        .chain(files("tools", ".rs"))
        .filter(|f| !f.starts_with("src/gpu") && named(f))
        .map(|f| f.display().to_string())
        .collect();
    fail_if_any(&found, "wgpu outside src/gpu");
    assert!(files("src/gpu", ".rs").iter().any(named), "the search finds nothing where wgpu is used");
}

/// Lines of every function longer than the limit: rustfmt closes a body at its own indentation.
fn long_functions(file: &Path, limit: usize) -> Vec<String> {
    let text = text(file);
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let trimmed = line.trim_start();
        let named = trimmed.starts_with("fn ")
            || (trimmed.contains(" fn ") && ["pub", "const", "unsafe", "async"].iter().any(|w| trimmed.starts_with(w)));
        let body = named
            && lines[start..]
                .iter()
                .find(|l| l.ends_with('{') || l.ends_with(';') || l.ends_with('}'))
                .is_some_and(|l| l.ends_with('{'));
        if !body {
            continue;
        }
        let end = format!("{}}}", &line[..line.len() - trimmed.len()]);
        let length = lines[start..].iter().position(|l| *l == end).map_or(usize::MAX, |n| n + 1);
        if length >= limit {
            found.push(format!("{}:{}: {length} lines", file.display(), start + 1));
        }
    }
    found
}

fn sources() -> impl Iterator<Item = PathBuf> {
    ["src", "tools", "tests", "examples"].iter().flat_map(|f| files(f, ".rs")).chain(files("shaders", ".wgsl"))
}

#[test]
fn files_and_functions_stay_short() {
    let long: Vec<String> = sources()
        .map(|f| (text(&f).lines().count(), f))
        .filter(|(n, _)| *n > 500)
        .map(|(n, f)| format!("{}: {n} lines", f.display()))
        .collect();
    fail_if_any(&long, "files of more than 500 lines");
    let long: Vec<String> = sources().flat_map(|f| long_functions(&f, 80)).collect();
    fail_if_any(&long, "functions of 80 lines or more");
    assert!(!long_functions(Path::new("tests/tidy.rs"), 10).is_empty(), "the search finds no function at all");
}

#[test]
fn the_first_line_says_what_a_file_is_for() {
    let missing: Vec<String> = sources()
        .filter(|f| {
            let text = text(f);
            let first = text.lines().next().unwrap_or("");
            let opening = if f.extension().is_some_and(|e| e == "rs") { "//! " } else { "// " };
            !first.starts_with(opening) || first.len() < 20
        })
        .map(|f| f.display().to_string())
        .collect();
    fail_if_any(&missing, "files whose first line does not say what they are for");
}

#[test]
fn every_stage_has_its_two_files_and_every_file_its_stage() {
    let kinds: BTreeSet<String> = REGISTRY.iter().map(|e| e.kind.to_owned()).collect();
    let stems = |folder: &str, ending: &str| -> BTreeSet<String> {
        let stem = |f: PathBuf| f.file_stem().expect("a stem").to_string_lossy().replace('_', "-");
        files(folder, ending).into_iter().map(stem).filter(|s| s != "mod" && s != "entry").collect()
    };
    assert_eq!(stems("src/stages", ".rs"), kinds);
    assert_eq!(stems("shaders/stages", ".wgsl"), kinds);
}

#[test]
fn every_library_file_can_be_included() {
    for file in files("shaders/lib", ".wgsl") {
        let name = file.file_stem().expect("a stem").to_string_lossy().into_owned();
        assert!(compose(&format!("//!include {name}\n"), "").is_ok(), "{name} is not in the composer's library");
    }
}

#[test]
fn nothing_is_left_to_do_in_comments() {
    let words = [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("../", "shared")];
    let endings = [".rs", ".wgsl", ".toml", ".md", ".sh", ".json"];
    let mut found = Vec::new();
    for file in endings.iter().flat_map(|e| files("", e)) {
        let text = text(&file);
        found.extend(words.iter().filter(|w| text.contains(**w)).map(|w| format!("{}: {w}", file.display())));
    }
    fail_if_any(&found, "words that do not belong into a file");
}

#[test]
fn the_readme_names_every_pipeline() {
    let readme = text(Path::new("README.md"));
    let missing: Vec<String> = files("pipelines", ".toml")
        .iter()
        .filter(|f| !f.starts_with("pipelines/validation"))
        .map(|f| f.display().to_string())
        .filter(|f| !readme.contains(&format!("({f})")))
        .collect();
    fail_if_any(&missing, "pipelines without a link in README.md");
}

#[test]
fn links_between_documents_lead_somewhere() {
    let (mut dead, mut seen) = (Vec::new(), 0);
    for file in files("", ".md") {
        let text = text(&file);
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.contains("://") || target.starts_with('#') {
                continue;
            }
            seen += 1;
            let path = root().join(&file).parent().expect("a folder").join(target.split('#').next().unwrap_or(""));
            if !path.exists() {
                dead.push(format!("{}: {target}", file.display()));
            }
        }
    }
    fail_if_any(&dead, "dead links");
    assert!(seen > 10, "{seen} links");
}
