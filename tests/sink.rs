//! Recordings, shared memory and tables: what arrives is what was sent, and every failure has a name.

use foxglove::Decode;
use foxglove::messages::{FrameTransform, Grid, PointCloud, PosesInFrame, SceneUpdate, VoxelGrid};
use squirm::analyze::{AnalyzeError, Limits, Live, Recording, Source};
use squirm::sink::{Job, Outlets, Provenance, Publisher, Recorder, SinkError, Tables, Targets, Writer};
use squirm::wire::{Fields, Header, Kind, Particles, Scalars, SpeciesRow, Squirmers, Stamp, domain};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

fn stamp(seq: u64) -> Stamp {
    Stamp {
        run_id: [0xab; 16],
        step: 20 * seq,
        time: 0.5 * seq as f64,
        seq,
        every: 20,
        box_size: [48.0, 12.0, 24.0],
        walls: true,
    }
}

/// One prolate squirmer whose axis is y: a quarter turn about x takes z to -y, so minus a quarter takes it to y.
fn squirmers() -> Squirmers {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    Squirmers {
        id: vec![3],
        species: vec![0],
        position: vec![[1.0, 2.0, 3.0]],
        unwrapped: vec![[49.0, 2.0, 3.0]],
        axis: vec![[0.0, 1.0, 0.0]],
        orientation: vec![[-half, 0.0, 0.0, half]],
        velocity: vec![[0.0, 0.25, 0.0]],
        angular_velocity: vec![[0.0; 3]],
        force: vec![[0.5, 0.0, 0.0]],
        torque: vec![[0.0; 3]],
        table: vec![SpeciesRow {
            name: "puller".into(),
            along: 4.0,
            across: 2.0,
            b1: 0.1,
            beta: 1.0,
            rotlet: 0.0,
            u0: 0.07,
        }],
    }
}

fn scalars(value: f64) -> Scalars {
    let mut scalars = Scalars::default();
    scalars.push("temperature", "kT", value);
    scalars.push("swim_speed", "sqrt(kT/m)", 0.1);
    scalars
}

fn provenance() -> Provenance {
    Provenance { run: "test".into(), run_id: [0xab; 16], seed: 7, version: "1.2.3".into(), ..Provenance::default() }
}

/// A snapshot of one message.
fn job(bytes: Vec<u8>, targets: Targets) -> Job {
    Job::snapshot(move || vec![(bytes, targets)])
}

/// Topic, log time and data of every message; checksums verified.
fn messages(path: &std::path::Path) -> Vec<(String, u64, Vec<u8>)> {
    let bytes = std::fs::read(path).unwrap();
    let stream = mcap::MessageStream::new_with_options(&bytes, mcap::read::Options::ValidateChunkCrcs.into()).unwrap();
    stream.map(Result::unwrap).map(|m| (m.channel.topic.clone(), m.log_time, m.data.into_owned())).collect()
}

fn of<'a>(messages: &'a [(String, u64, Vec<u8>)], topic: &str) -> &'a [u8] {
    &messages.iter().find(|m| m.0 == topic).unwrap_or_else(|| panic!("no message on {topic}")).2
}

#[test]
fn a_recording_holds_the_bytes_and_says_where_they_come_from() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &provenance(), "steps = 40\n").unwrap();
    let fields = Fields { block: 2, blocks: [1, 1, 2], density: vec![10.0; 2], velocity: vec![[0.0; 3]; 2] };
    let all = [squirmers().encode(&stamp(3)), scalars(1.0).encode(&stamp(3)), fields.encode(&stamp(3))];
    all.iter().for_each(|message| recorder.write(message).unwrap());
    recorder.sync().unwrap();
    let files = recorder.finish().unwrap();
    let path = dir.path().join("run.mcap");
    assert_eq!((files.len(), &files[0].path, files[0].messages), (1, &path, 10));
    assert_eq!(files[0].bytes, path.metadata().unwrap().len());

    let read = messages(&path);
    assert!(read.iter().all(|m| m.1 == 1_500_000_000));
    for (topic, bytes) in ["/squirm/squirmers", "/squirm/scalars", "/squirm/fields"].iter().zip(&all) {
        assert_eq!(of(&read, topic), bytes.as_slice());
    }
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let attached = |i: usize| mcap::read::attachment(&bytes, &summary.attachment_indexes[i]).unwrap();
    assert_eq!((attached(0).name.as_str(), &attached(0).data[..]), ("pipeline.toml", &b"steps = 40\n"[..]));
    let provenance: serde_json::Value = serde_json::from_slice(&attached(1).data).unwrap();
    assert_eq!((&provenance["seed"], &provenance["run_id"]), (&7.into(), &"ab".repeat(16).into()));
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert_eq!((metadata.name.as_str(), metadata.metadata["version"].as_str()), ("squirm:run", "1.2.3"));
    let schema = summary.schemas.values().find(|s| s.name == "squirm.Snapshot").unwrap();
    assert!(schema.data.starts_with(b"# Snapshots"));
}

#[test]
fn viewers_see_spheroids_headings_and_the_box() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &provenance(), "").unwrap();
    recorder.write(&squirmers().encode(&stamp(1))).unwrap();
    recorder.finish().unwrap();
    let read = messages(&dir.path().join("run.mcap"));

    let poses = PosesInFrame::decode(of(&read, "/squirmers/poses")).unwrap();
    let q = poses.poses[0].orientation.unwrap();
    let along = glam::DQuat::from_xyzw(q.x, q.y, q.z, q.w) * glam::DVec3::X;
    assert!((along - glam::DVec3::Y).length() < 1e-6, "{along}");
    assert_eq!(poses.timestamp.unwrap().total_nanos(), 500_000_000);

    let scene = SceneUpdate::decode(of(&read, "/squirmers/scene")).unwrap();
    let [bodies] = &scene.entities[..] else { panic!("{} entities", scene.entities.len()) };
    let size = bodies.spheres[0].size.unwrap();
    assert_eq!((size.x, size.y, size.z, bodies.arrows.len()), (4.0, 4.0, 8.0, 1));

    let surroundings = SceneUpdate::decode(of(&read, "/box")).unwrap();
    let [edges, walls] = &surroundings.entities[..] else { panic!("{} entities", surroundings.entities.len()) };
    let centre = |i: usize| walls.cubes[i].pose.as_ref().unwrap().position.unwrap();
    let thick = walls.cubes[0].size.unwrap();
    assert_eq!((walls.cubes.len(), thick.x, thick.z), (2, 48.0, 24.0));
    assert_eq!((centre(0).y + thick.y / 2.0, centre(1).y - thick.y / 2.0), (0.0, 12.0));
    let corners = &edges.lines[0].points;
    assert_eq!(corners.len(), 24);
    let length =
        |p: &[foxglove::messages::Point3]| (p[0].x - p[1].x).abs() + (p[0].y - p[1].y).abs() + (p[0].z - p[1].z).abs();
    assert_eq!(corners.chunks(2).map(length).sum::<f64>(), 4.0 * (48.0 + 12.0 + 24.0));

    let points = PointCloud::decode(of(&read, "/squirmers/points")).unwrap();
    assert_eq!((points.point_stride, points.data.len(), points.fields[6].name.as_str()), (36, 36, "id"));
    assert_eq!((&points.data[24..28], &points.data[32..]), (&3u32.to_le_bytes()[..], &[230, 159, 0, 255][..]));
    assert_eq!(FrameTransform::decode(of(&read, "/tf")).unwrap().child_frame_id, "box");
}

#[test]
fn viewers_see_the_middle_plane_of_the_fluid() {
    // Blocks of 4 in a box of 48 x 12 x 24: each has its own numbers, and one of the plane at y = 6 is empty.
    let blocks = [12, 3, 6];
    let places: Vec<[u32; 3]> =
        (0..12 * 3 * 6).map(|i| [i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])]).collect();
    let mut fields = Fields {
        block: 4,
        blocks,
        density: vec![10.0; places.len()],
        velocity: places.iter().map(|p| p.map(|c| c as f32)).collect(),
    };
    let empty = places.iter().position(|p| *p == [2, 1, 0]).unwrap();
    (fields.density[empty], fields.velocity[empty]) = (0.0, [0.0; 3]);
    let fast = places.iter().position(|p| *p == [7, 1, 3]).unwrap();
    fields.velocity[fast] = [50.0, 0.0, 0.0];
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &provenance(), "").unwrap();
    recorder.write(&fields.encode(&stamp(1))).unwrap();
    recorder.write(&scalars(1.0).encode(&stamp(1))).unwrap();
    recorder.write(&squirmers().encode(&stamp(1))).unwrap();
    recorder.finish().unwrap();
    let read = messages(&dir.path().join("run.mcap"));
    // What all topics of one step share is there once.
    assert_eq!(["/tf", "/box"].map(|topic| read.iter().filter(|m| m.0 == topic).count()), [1, 1]);

    let grid = Grid::decode(of(&read, "/fluid/slice")).unwrap();
    let slab = VoxelGrid::decode(of(&read, "/fluid/slab")).unwrap();
    let cell = |x: usize, z: usize| &grid.data[z * grid.row_stride as usize + x * grid.cell_stride as usize..][..24];
    let numbers = |x, z| bytemuck::pod_collect_to_vec::<u8, f32>(&cell(x, z)[..20]);
    assert_eq!((grid.column_count, grid.data.len(), &grid.data), (12, 24 * 12 * 6, &slab.data));
    assert_eq!(numbers(3, 5), [35f32.sqrt(), 10.0, 3.0, 1.0, 5.0]);
    assert_eq!((cell(2, 0)[23], cell(3, 0)[23]), (0, 255));
    // Root mean square over the plane but the empty block, twice of which is the darkest blue: 247 - 239 share red.
    let squares: f32 = places.iter().filter(|p| p[1] == 1).map(|p| p.iter().map(|c| (c * c) as f32).sum::<f32>()).sum();
    let fast = 2.0 * ((squares - 5.0 - 59.0 + 2500.0) / 71.0).sqrt();
    let red = |speed: f32| (247.0 - 239.0 * (speed / fast).min(1.0)).round() as u8;
    assert_eq!((cell(3, 5)[20], cell(0, 0)[20]), (red(35f32.sqrt()), red(1.0)));
    assert_eq!(&cell(7, 3)[20..], [8, 48, 107, 255]);
    let names: Vec<_> = grid.fields.iter().map(|f| (f.name.as_str(), f.offset)).collect();
    assert_eq!((names[0], names[4], names[8]), (("speed", 0), ("vz", 16), ("alpha", 23)));
    // The plane's own x and y are the x and z of the box, and it begins at the box's lower corner.
    let pose = grid.pose.unwrap();
    let q = pose.orientation.unwrap();
    let turned = glam::DQuat::from_xyzw(q.x, q.y, q.z, q.w) * glam::DVec3::Y;
    assert!((turned - glam::DVec3::Z).length() < 1e-12, "{turned}");
    assert_eq!(pose.position.map(|p| [p.x, p.y, p.z]), Some([0.0, 6.0, 0.0]));
    let size = slab.cell_size.unwrap();
    assert_eq!((slab.row_count, slab.slice_stride, size.x, size.z), (1, 24 * 12, 4.0, 4.0));
}

#[test]
fn the_fluid_has_its_own_file_and_viewers_a_share() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &provenance(), "").unwrap();
    let n = 250_000;
    let particles = Particles {
        fraction: 0.5,
        population: 500_000,
        position: vec![[1.0; 3]; n],
        velocity: vec![[0.5; 3]; n],
        ..Particles::default()
    };
    let bytes = particles.encode(&stamp(0));
    recorder.write(&bytes).unwrap();
    let files = recorder.finish().unwrap();
    assert_eq!(files.iter().map(|f| f.messages).collect::<Vec<_>>(), [0, 2]);
    let read = messages(&files[1].path);
    assert_eq!(of(&read, "/squirm/particles"), bytes);
    let points = PointCloud::decode(of(&read, "/fluid/points")).unwrap();
    assert_eq!((points.point_stride, points.data.len()), (24, 24 * 125_000));
}

#[test]
fn nothing_is_overwritten() {
    for name in ["run.mcap", "run.fluid.mcap", "scalars.csv"] {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join(name), "mine").unwrap();
        let recorded = Recorder::create(dir.path(), &provenance(), "").err();
        let tabled = Tables::create(dir.path()).err();
        let error = if name.ends_with("csv") { tabled } else { recorded };
        assert!(matches!(error, Some(SinkError::Exists(path)) if path.ends_with(name)));
        assert_eq!(std::fs::read(dir.path().join(name)).unwrap(), b"mine");
    }
}

#[test]
fn a_recording_that_was_never_finished_reads_to_its_last_snapshot() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &provenance(), "").unwrap();
    (0..5).for_each(|seq| recorder.write(&squirmers().encode(&stamp(seq))).unwrap());
    // What a kill leaves behind: nothing more is written.
    std::mem::forget(recorder);
    let mut steps = Vec::new();
    let ending = Recording::new(&dir.path().join("run.mcap")).drive(&[Kind::Squirmers], &mut |s| {
        steps.push(s.header.step);
        Ok(ControlFlow::Continue(()))
    });
    assert_eq!((steps, ending.unwrap().warnings.len()), (vec![0, 20, 40, 60, 80], 1));
}

/// The index of a file is in memory until its end, so that a run of weeks must not write a single one.
#[test]
fn a_full_file_is_finished_and_the_recording_goes_on_in_the_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut recorder = Recorder::create(folder.path(), &provenance(), "").expect("created").in_segments_of(3);
    let particles = Particles { position: vec![[1.0; 3]], velocity: vec![[0.5; 3]], ..Particles::default() };
    for seq in 0..8 {
        recorder.write(&scalars(seq as f64).encode(&stamp(seq))).expect("written");
        recorder.write(&particles.encode(&stamp(seq))).expect("written");
    }
    let durable = recorder.sync().expect("synced");
    let files = recorder.finish().expect("finished");
    let names: Vec<String> =
        files.iter().map(|f| f.path.file_name().expect("a name").to_string_lossy().into_owned()).collect();
    assert_eq!(names[..4], ["run.mcap", "run.fluid.mcap", "run.0001.mcap", "run.fluid.0001.mcap"], "{names:?}");
    assert_eq!(durable.files.iter().map(|p| p.name.clone()).collect::<Vec<_>>(), names);
    let (mut seen, kinds) = (Vec::new(), [Kind::Scalars, Kind::Particles]);
    let ending = Recording::new(folder.path()).drive(&kinds, &mut |s| {
        seen.push((s.header.seq, s.kind()));
        Ok(ControlFlow::Continue(()))
    });
    assert_eq!(ending.expect("readable").warnings, [""; 0]);
    assert_eq!(seen, (0..8).flat_map(|seq| kinds.map(|kind| (seq, kind))).collect::<Vec<_>>());
    for file in &files {
        let found = squirm::recording::verify(&file.path).expect("readable");
        assert!(found.findings.is_empty(), "{:?}", found.findings);
    }
}

#[test]
fn tables_have_units_and_one_row_per_squirmer() {
    let dir = tempfile::tempdir().unwrap();
    let mut tables = Tables::create(dir.path()).unwrap();
    (0..2).for_each(|seq| tables.write(&squirmers().encode(&stamp(seq))).unwrap());
    tables.write(&scalars(1.25).encode(&stamp(1))).unwrap();
    let text = std::fs::read_to_string(dir.path().join("scalars.csv")).unwrap();
    assert_eq!(text, "step,time [tau],temperature [kT],swim_speed [sqrt(kT/m)]\n20,0.5,1.25,0.1\n");
    let text = std::fs::read_to_string(dir.path().join("squirmers.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0].len(), rows[1].len()), (3, 25, 25));
    assert_eq!((rows[0][7], rows[2][7], rows[0][11], rows[2][11]), ("unwrapped_x [a]", "49", "ey", "1"));
    let mut changed = Scalars::default();
    changed.push("other", "", 0.0);
    assert!(tables.write(&changed.encode(&stamp(2))).is_err());
}

/// A name that no other test or run has.
fn unique(name: &str) -> String {
    format!("{name}-{}", std::process::id())
}

/// Sequence numbers that a live source gives, and its ending.
fn follow(run: &str, limits: Limits, pause: Duration) -> Result<(Vec<u64>, squirm::analyze::Ending), AnalyzeError> {
    let mut seen = Vec::new();
    let ending = Live::new(run, limits).drive(&[Kind::Scalars], &mut |s| {
        seen.push(s.header.seq);
        std::thread::sleep(pause);
        Ok(ControlFlow::Continue(()))
    })?;
    Ok((seen, ending))
}

fn open(run: &str) -> Publisher {
    Publisher::open(run, &[(Kind::Scalars, scalars(0.0).encode(&stamp(0)).len())]).unwrap()
}

#[test]
fn a_late_joiner_gets_the_newest_snapshot_from_an_idle_writer() {
    let run = unique("late");
    let outlets = Outlets { publisher: Some(open(&run)), ..Outlets::default() };
    let mut writer = Writer::spawn(outlets, 4).unwrap();
    let targets = Targets { publish: true, ..Targets::default() };
    (0..7).for_each(|seq| writer.send(job(scalars(0.0).encode(&stamp(seq)), targets)).unwrap());
    writer.sync().unwrap();
    let limits = Limits { snapshots: Some(1), duration: Some(Duration::from_secs(10)), ..Limits::default() };
    assert_eq!(follow(&run, limits, Duration::ZERO).unwrap().0, [6]);
    assert_eq!(writer.finish().unwrap().snapshots, 7);
}

#[test]
fn a_late_joiner_of_a_rare_topic_gets_its_newest_snapshot_from_a_busy_writer() {
    let run = unique("rare");
    let length = |message: Vec<u8>| message.len();
    let topics = [
        (Kind::Scalars, length(scalars(0.0).encode(&stamp(0)))),
        (Kind::Squirmers, length(squirmers().encode(&stamp(0)))),
    ];
    let outlets = Outlets { publisher: Some(Publisher::open(&run, &topics).unwrap()), ..Outlets::default() };
    let mut writer = Writer::spawn(outlets, 4).unwrap();
    let targets = Targets { publish: true, ..Targets::default() };
    writer.send(job(squirmers().encode(&stamp(3)), targets)).unwrap();
    writer.sync().unwrap();
    let reader = std::thread::spawn(move || {
        let limits = Limits { snapshots: Some(1), duration: Some(Duration::from_secs(20)), ..Limits::default() };
        let mut seen = Vec::new();
        let ending = Live::new(&run, limits).drive(&[Kind::Squirmers], &mut |s| {
            seen.push(s.header.seq);
            Ok(ControlFlow::Continue(()))
        });
        ending.unwrap();
        seen
    });
    // Never idle for as long as newcomers may wait.
    let mut seq = 0;
    while !reader.is_finished() {
        writer.send(job(scalars(0.0).encode(&stamp(seq)), targets)).unwrap();
        seq += 1;
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(reader.join().unwrap(), [3]);
    writer.finish().unwrap();
}

#[test]
fn a_slow_reader_loses_snapshots_and_counts_them_but_holds_nobody_up() {
    let run = unique("slow");
    let mut publisher = open(&run);
    let reader = {
        let run = run.clone();
        std::thread::spawn(move || follow(&run, Limits::default(), Duration::from_millis(5)).unwrap())
    };
    let begin = Instant::now();
    let (mut seq, mut reached) = (0, 0);
    while reached < 400 && begin.elapsed().as_secs() < 20 {
        reached += publisher.publish(&scalars(0.0).encode(&stamp(seq))).unwrap();
        seq += 1;
        std::thread::sleep(Duration::from_micros(100));
    }
    drop(publisher);
    let (seen, ending) = reader.join().unwrap();
    assert!(ending.lost > 0 && ending.warnings.len() == 1, "{ending:?}");
    assert_eq!(
        seen[0] + seen.len() as u64 + ending.lost,
        seq,
        "every snapshot since the first was seen or counted as lost"
    );
    assert!(seen.windows(2).all(|w| w[0] < w[1]));
}

/// The memory set aside is enough for the worst that the allowed number of subscribers can do.
#[test]
fn subscribers_that_hold_all_they_may_cost_no_snapshot() {
    use iceoryx2::prelude::{NodeBuilder, SignalHandlingMode, ipc};
    let run = unique("held");
    let mut publisher = open(&run);
    let mut seq = 0..;
    let mut publish = |n| {
        (0..n)
            .map(|_| publisher.publish(&scalars(0.0).encode(&stamp(seq.next().unwrap()))).unwrap())
            .collect::<Vec<_>>()
    };
    let builder =
        NodeBuilder::new().config(&domain::config().unwrap()).signal_handling_mode(SignalHandlingMode::Disabled);
    let node = builder.create::<ipc::Service>().unwrap();
    let service = node.service_builder(&domain::service(&run, "scalars").unwrap());
    let service = service.publish_subscribe::<[domain::Block]>().user_header::<Header>().open().unwrap();
    let subscribers = [(); domain::MAX_SUBSCRIBERS].map(|()| service.subscriber_builder().create().unwrap());
    assert!(service.subscriber_builder().create().is_err());
    let mut held = Vec::new();
    for subscriber in &subscribers {
        publish(domain::BUFFER);
        held.extend([(); domain::MAX_BORROWED].map(|()| subscriber.receive().unwrap().unwrap()));
    }
    let mut seqs: Vec<u64> = held.iter().map(|sample| sample.user_header().seq).collect();
    seqs.dedup();
    assert_eq!(seqs.len(), domain::MAX_SUBSCRIBERS * domain::MAX_BORROWED, "every subscriber holds others");
    assert_eq!(publish(10), [domain::MAX_SUBSCRIBERS; 10]);
    assert_eq!(publisher.dropped(), 0);
}

#[test]
fn names_lengths_and_topics_are_checked() {
    let run = unique("taken");
    let mut publisher = open(&run);
    assert!(matches!(Publisher::open(&run, &[(Kind::Scalars, 4096)]), Err(SinkError::Taken(name)) if name == run));
    assert!(matches!(publisher.publish(&squirmers().encode(&stamp(0))), Err(SinkError::NotOpen("squirmers"))));
    let mut long = scalars(0.0);
    long.push("more", "", 1.0);
    assert!(matches!(publisher.publish(&long.encode(&stamp(0))), Err(SinkError::TooLong { .. })));
    assert!(matches!(publisher.publish(&[0; 320]), Err(SinkError::Wire(_))));
    let error = follow(&unique("absent"), Limits::default(), Duration::ZERO).unwrap_err().to_string();
    assert!(error.contains("publishes scalars here") && error.contains(&run), "{error}");
}

#[test]
fn shared_memory_that_is_too_small_is_refused_before_it_is_touched() {
    let Err(SinkError::SharedMemory { need, free, .. }) =
        Publisher::open(&unique("huge"), &[(Kind::Particles, 1 << 50)])
    else {
        panic!("a petabyte was granted");
    };
    assert!(need > free);
}

#[test]
fn a_limit_in_time_ends_a_live_source() {
    let run = unique("limited");
    let _publisher = open(&run);
    let begin = Instant::now();
    let limits = Limits { duration: Some(Duration::from_millis(300)), ..Limits::default() };
    assert_eq!(follow(&run, limits, Duration::ZERO).unwrap().0, [0u64; 0]);
    assert!((0.25..5.0).contains(&begin.elapsed().as_secs_f64()));
}

#[test]
fn a_failed_job_is_reported_and_the_recording_is_finished_all_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let recorder = Recorder::create(dir.path(), &provenance(), "").unwrap();
    let mut writer = Writer::spawn(Outlets { recorder: Some(recorder), ..Outlets::default() }, 2).unwrap();
    let targets = Targets { record: true, ..Targets::default() };
    writer.send(job(scalars(1.0).encode(&stamp(0)), targets)).unwrap();
    writer.sync().unwrap();
    writer.send(job(vec![0; 320], targets)).unwrap();
    assert!(matches!(writer.finish(), Err(SinkError::Wire(_))));
    let bytes = std::fs::read(dir.path().join("run.mcap")).unwrap();
    assert_eq!(mcap::Summary::read(&bytes).unwrap().unwrap().stats.unwrap().message_count, 1);
}

/// Not a test of its own: the process that the next test kills.
#[test]
fn publishes_until_it_is_killed() {
    let Ok(run) = std::env::var("SQUIRM_TEST_PUBLISHER") else { return };
    let mut publisher = open(&run);
    for seq in 0..10_000 {
        publisher.publish(&scalars(0.0).encode(&stamp(seq))).unwrap();
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_reader_outlives_a_killed_run_and_the_name_is_free_again() {
    let run = unique("killed");
    let mut child = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "publishes_until_it_is_killed"])
        .env("SQUIRM_TEST_PUBLISHER", &run)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    let first = Limits { snapshots: Some(3), ..Limits::default() };
    while follow(&run, first.clone(), Duration::ZERO).is_err() {
        assert!(begin.elapsed().as_secs() < 20, "the run does not begin");
        std::thread::sleep(Duration::from_millis(5));
    }
    let reader = {
        let run = run.clone();
        std::thread::spawn(move || follow(&run, Limits::default(), Duration::ZERO).unwrap())
    };
    std::thread::sleep(Duration::from_millis(100));
    child.kill().unwrap();
    child.wait().unwrap();
    let (seen, _) = reader.join().unwrap();
    assert!(!seen.is_empty());
    open(&run);
}
