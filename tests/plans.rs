//! Every shipped pipeline file ends in the same bits whether its stages share kernels or not.

use squirm::buffers::Gathering;
use squirm::gpu::{Form, Gpu, Session};
use std::path::{Path, PathBuf};

/// Particles that a run on a CPU may have here; a GPU takes the files as they are.
const FEW: f64 = 250_000.0;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    found.sort();
    found
}

/// What `squirm check` says of a run's memory is what the run takes, but for the rounding of each buffer to 16 bytes, and of the places of those
/// that lie beside each other in one to 256.
fn predicts_memory(session: &Session, plan: &squirm::graph::Plan) {
    let names = squirm::graph::fused::bound(plan, session.sizes()).expect("valid shaders");
    let predicted: u64 =
        squirm::graph::memory(names.iter().map(String::as_str), session.sizes()).iter().map(|(_, n)| n).sum();
    let more = session.memory().checked_sub(predicted);
    assert!(more.is_some_and(|more| more < 16 * 32 + 4 * 256), "{}: {} for {predicted}", plan.name, session.memory());
}

/// State, forces and wall impulses after two submissions.
fn left(gpu: &Gpu, path: &Path, sets: &[String], form: Form) -> (String, Vec<u32>, [glam::DVec3; 2]) {
    let text = std::fs::read_to_string(path).expect("readable");
    let folder = path.parent().expect("a folder");
    let loaded = squirm::config::load(&path.to_string_lossy(), &text, sets, folder)
        .unwrap_or_else(|e| panic!("{}: {e:?}", path.display()));
    let state = squirm::state::start::start(&loaded.plan.system).expect("a start");
    let mut session = Session::formed(gpu, &loaded.plan, &state, form).expect("a session");
    if form == Form::Fused {
        predicts_memory(&session, &loaded.plan);
        assert_eq!(Some(session.sizes().gathering()), gpu.gathering, "{}", path.display());
    }
    for steps in [1, 4] {
        session.advance(steps, false);
        session.wait().expect("done");
    }
    let walls =
        squirm::state::packed::wall_impulses(&loaded.plan.system, &session.read("wall_impulses").expect("readable"));
    (session.raw().expect("readable").digest(), session.read("fluid_force").expect("readable"), walls)
}

#[test]
fn shipped_pipelines_end_in_the_same_bits() {
    let gpu = Gpu::open(std::env::var("SQUIRM_ADAPTER").ok().as_deref()).expect("an adapter");
    let paths: Vec<PathBuf> = files("pipelines").into_iter().chain(files("pipelines/validation")).collect();
    assert!(paths.len() > 25);
    for path in paths {
        let text = std::fs::read_to_string(&path).expect("readable");
        let folder = path.parent().expect("a folder");
        let plan = squirm::config::load(&path.to_string_lossy(), &text, &[], folder).expect("it is valid").plan;
        #[allow(clippy::cast_precision_loss)]
        let share = FEW / plan.system.particle_count() as f64;
        let thinner = share < 1.0 && gpu.summary.kind == "CPU";
        let density = plan.system.fluid.density * if thinner { share } else { 1.0 };
        let sets = [format!("fluid.density={density:?}")];
        let loose = left(&gpu, &path, &sets, Form::Loose);
        let same = |gathering, sets: &[String]| {
            let mut other = gpu.clone();
            other.gathering = Some(gathering);
            assert!(loose == left(&other, &path, sets, Form::Fused), "{} {sets:?} {gathering:?}", path.display());
        };
        for every in [1, 3, 1000] {
            let mut sets = sets.to_vec();
            if plan.stages.iter().any(|s| s.entry.kind == "sort-reorder") {
                sets.push(format!("stage.sort-reorder.every={every}"));
            } else if every > 1 {
                continue;
            }
            same(Gathering::Chains, &sets);
        }
        same(Gathering::Bricks, &sets);
    }
}
