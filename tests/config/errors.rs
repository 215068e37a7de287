//! Wrong values: each is reported at its place, with the reason and the remedy, all in one go.

use super::{GOOD, changed, lines, says, with};

#[test]
fn unknown_keys_and_words_get_a_suggestion() {
    says(&[("seed = 3", "sede = 3")], "2:1", &["error: [run] has no parameter `sede`", "did you mean `seed`?"]);
    says(&[("name = \"puller\"", "colour = 1")], "15:1", &["no parameter `colour`", "allowed here: name, count"]);
    says(&[("\"no-slip\"", "\"noslip\"")], "8:35", &["`condition` cannot be \"noslip\"", "did you mean `no-slip`?"]);
    let across =
        ["`axis` cannot be \"x\"", "it can only be \"y\": The axis across the slit: walls exist only across y"];
    says(&[("axis = \"y\"", "axis = \"x\"")], "8:18", &across);
    says(&[("\"scalars\"]", "\"scalar\"]")], "46:24", &["`record` cannot be \"scalar\"", "did you mean `scalars`?"]);
    says(&[("across = 2.0 }", "across = 2.0, x = 1 }")], "17:42", &["`semi_axes` has no parameter `x`"]);
    says(&[("[fluid]", "[fluids]")], "10:2", &["no section `fluids`", "did you mean `fluid`?"]);
    says(&[("[run]", "density = 3\n[run]")], "1:1", &["no section `density`", "`density` belongs under [fluid]"]);
}

#[test]
fn types_and_ranges() {
    says(&[("steps = 100", "steps = \"many\"")], "3:9", &["must be a whole number, but this is a text"]);
    says(&[("steps = 100", "steps = -1")], "3:9", &["whole number, 0 or more: -1 is out of range"]);
    says(&[("steps = 100", "steps = 1e3")], "3:9", &["whole number", "(help: write 1000)"]);
    says(&[("steps = 100", "steps = 1.5")], "3:9", &["this is a number with a fraction"]);
    says(
        &[("steps = 100", "steps = 99999999999999999999")],
        "3:9",
        &["at most 9223372036854775807, but this is beyond it"],
    );
    says(&[("dt = 0.05", "dt = -0.1")], "4:6", &["a number from 0.000001 to 10: -0.1 is out of range", "in tau"]);
    says(&[("dt = 0.05", "dt = nan")], "4:6", &["`dt` is not a number"]);
    says(&[("temperature = 1.0", "temperature = inf")], "12:15", &["`temperature` is infinite"]);
    says(&[("[24, 20, 24]", "[24, 20]")], "7:8", &["needs 3 numbers, but this has 2"]);
    says(&[("[24, 20, 24]", "[24, 0, 24]")], "7:13", &["0 is out of range"]);
    says(&[("[24, 20, 24]", "24")], "7:8", &["a list of 3 whole numbers, but this is a whole number"]);
    says(&[("beta = 1.0", "beta = true")], "19:8", &["must be a number, but this is true or false"]);
    says(&[("beta = 1.0", "beta = 1979-05-27")], "19:8", &["this is a date"]);
    says(&[("beta = 1.0", "passive = 1")], "19:11", &["must be true or false"]);
    says(&[("name = \"puller\"", "name = 7")], "15:8", &["must be a text in quotes"]);
    says(&[("{ along = 4.0, across = 2.0 }", "4.0")], "17:13", &["`semi_axes` must be a table"]);
    says(&[("angle = 130", "angle = 300")], "41:9", &["300 is out of range", "in degree"]);
}

#[test]
fn numbers_stand_without_units() {
    let line = super::only(&[("dt = 0.05", "dt = 0.05 tau")]);
    assert!(line.starts_with("f.toml:4:") && line.contains("numbers carry no unit: write 0.05 alone"), "{line}");
    says(&[("dt = 0.05", "dt = \"0.05 tau\"")], "4:6", &["numbers carry no unit: write 0.05 alone", "in tau"]);
    let found = lines(GOOD, &["run.dt=0.05tau"]);
    assert!(found.len() == 1 && found[0].contains("write 0.05 alone"), "{found:?}");
}

#[test]
fn an_angle_in_radians_is_noticed() {
    let small =
        ["warning: a rotation by 2.27 degrees hardly mixes", "more a gas than a liquid", "in degrees, not radians"];
    says(&[("angle = 130", "angle = 2.27")], "41:9", &small);
    says(&[("angle = 130", "angle = 0")], "41:9", &["warning: without a rotation", "in degrees"]);
    assert_eq!(lines(GOOD, &["stage.rotate.angle=60"]), Vec::<String>::new());
}

#[test]
fn what_is_missing_is_said_at_the_table_that_lacks_it() {
    says(&[("steps = 100\n", "")], "1:1", &["[run] lacks `steps`", "add steps = ..."]);
    says(&[("along = 4.0, ", "")], "17:13", &["`semi_axes` lacks `along`"]);
    says(&[("count = 2\n", "")], "14:1", &["[[squirmers]] lacks `count`"]);
    says(&[("kind = \"rotate\"\n", "")], "39:1", &["a stage needs a kind", "rotate"]);
    says(
        &[("[box]\nsize = [24, 20, 24]\nwalls = { axis = \"y\", condition = \"no-slip\" }\n", "")],
        "1:1",
        &["the section [box] is missing", "add [box] with size"],
    );
}

#[test]
fn sections_of_the_wrong_kind() {
    says(&[("[fluid]", "[[fluid]]")], "10:1", &["its section cannot repeat", "write [fluid]"]);
    says(&[("[[output]]", "[output]")], "45:1", &["`output` may repeat", "write [[output]]"]);
    says(&[("kind = \"rotate\"", "kind = 4")], "40:8", &["`kind` must be a text"]);
}

#[test]
fn syntax_errors_do_not_hide_other_errors_nor_make_new_ones() {
    let found = lines(&changed(&[("steps = 100", "steps = "), ("beta = 1.0", "beta = \"a\"")]), &[]);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].starts_with("f.toml:3:") && found[0].contains("this is not TOML"), "{found:#?}");
    assert!(found[1].starts_with("f.toml:19:8: ") && found[1].contains("must be a number"), "{found:#?}");
    says(&[("seed = 3", "seed = 3\nseed = 4")], "3:1", &["`seed` is given twice"]);
}

#[test]
fn all_errors_come_in_one_go_in_the_order_of_the_file() {
    let text = changed(&[("seed = 3", "sede = 3"), ("density = 10", "density = -1"), ("\"rotate\"", "\"rotat\"")]);
    let found = lines(&text, &["run.dt=x", "nowhere.a=1"]);
    let places = ["f.toml:2:1", "f.toml:11:11", "f.toml:40:8", "--set run.dt=x:1:8", "--set nowhere.a=1:1:1"];
    assert_eq!(found.len(), places.len(), "{found:#?}");
    for (line, place) in found.iter().zip(places) {
        assert!(line.starts_with(place), "{place}: {found:#?}");
    }
}

#[test]
fn overrides_replace_values_and_their_errors_name_them() {
    let loaded =
        with(GOOD, &["run.steps=200", "squirmers.puller.b1=0.2", "stage.rotate.angle=90", "box.size=[30,20,24]"]);
    let plan = loaded.unwrap_or_else(|f| panic!("{f}")).plan;
    assert_eq!(plan.system.run.steps, 200);
    assert_eq!(plan.system.species[0].b1, 0.2);
    assert_eq!(plan.system.domain.size, [30, 20, 24]);
    let rotate = plan.stages.iter().find(|s| s.entry.kind == "rotate").unwrap();
    assert_eq!(rotate.values.get("angle"), Some(&squirm::params::Value::Float(90.0)));
    let found = lines(GOOD, &["run.steps=abc"]);
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("--set run.steps=abc:1:11: error: `steps` must be a whole number"), "{found:?}");
}

#[test]
fn bodies_must_fit() {
    let found = lines(&changed(&[("size = [24, 20, 24]", "size = [8, 20, 24]")]), &[]);
    let small = "f.toml:17:13: error: along x the box is 8 long, so \"puller\" would touch its own image";
    assert!(found[0].starts_with(small) && found[0].contains("longer than 8.56 along x"), "{found:#?}");
    says(&[("size = [24, 20, 24]", "size = [24, 4, 24]")], "17:13", &["the slit is 4 wide", "more than 4.50"]);
    let found = lines(&changed(&[("count = 2", "count = 200")]), &[]);
    assert!(found.iter().any(|l| l.contains("error: the squirmers fill 135 % of the box")), "{found:#?}");
}

#[test]
fn squirmers_must_make_sense() {
    let found = lines(&changed(&[("start = \"random\"", "passive = true")]), &[]);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].starts_with("f.toml:18:6: error: \"puller\" is passive, but has b1 = 0.1"), "{found:#?}");
    assert!(found[1].starts_with("f.toml:19:8: error: \"puller\" is passive, but has beta = 1"), "{found:#?}");
    says(&[("b1 = 0.1\nbeta = 1.0\n", "")], "14:1", &["warning: \"puller\" has no slip velocity", "passive = true"]);
    says(&[("b1 = 0.1\n", "rotlet = 0.1\n")], "19:8", &["warning: beta has no effect without b1"]);
    says(&[("b1 = 0.1", "b1 = 0.9")], "18:6", &["warning: the surface of \"puller\" slips at Mach"]);
    let twin =
        "[[squirmers]]\nname = \"puller\"\ncount = 1\nsemi_axes = { along = 2.0, across = 2.0 }\npassive = true\n";
    says(&[("[[stage]]", &format!("{twin}[[stage]]"))], "23:8", &["two species are named \"puller\""]);
}

#[test]
fn poses_are_checked_one_by_one() {
    let listed = |rows: &str| format!("start = \"listed\"\nposes = [{rows}]");
    let start = "start = \"random\"";
    says(&[(start, "start = \"listed\"")], "20:9", &["there is no `poses`"]);
    says(&[(start, &listed("[5,5,5,1,0,0]"))], "21:9", &["`poses` has 1 rows, but count is 2"]);
    says(&[(start, &listed("[5,5,5,1,0,0],[5,5,5,0,0,0]"))], "21:24", &["the axis is zero"]);
    says(&[(start, &listed("[5,5,5,1,0,0],[25,5,5,1,0,0]"))], "21:24", &["x = 25 lies outside the box"]);
    says(
        &[(start, &listed("[5,5,5,1,0,0],[5,3,5,0,1,0]"))],
        "21:24",
        &["reaches through a wall", "half height 4.12", "4.12 <= y <= 15.88"],
    );
    // Where the hull, which keeps the fluid off, begins to fit.
    let at = |y: &str| changed(&[(start, &listed(&format!("[5,{y},5,0,1,0],[15,9,15,1,0,0]")))]);
    assert!(lines(&at("4.11"), &[])[0].contains("reaches through a wall"));
    assert_eq!(lines(&at("4.12"), &[]), Vec::<String>::new());
    says(&[(start, &listed("[5,5,5,1,0,0],[5,5,5,1,0]"))], "21:24", &["needs 6 numbers, but this has 5"]);
    says(&[(start, "poses = [[5,5,5,1,0,0],[9,9,9,1,0,0]]")], "20:9", &["starts from \"random\""]);
}

#[test]
fn an_axis_that_fits_nowhere_is_to_be_turned() {
    let slit = ("size = [24, 20, 24]", "size = [24, 8, 24]");
    let upright = ("start = \"random\"", "start = \"listed\"\nposes = [[5,4,5,1,0,0],[15,4,5,0,1,0]]");
    let parts = ["8.24 high and reaches through both walls", "turn the axis", "wider than 8.24"];
    says(&[slit, upright], "21:24", &parts);
}

/// The functions that place squirmers when the run starts say before it what the user placed badly.
#[test]
fn placed_squirmers_must_have_room() {
    let start = "start = \"random\"";
    let listed = "start = \"listed\"\nposes = [[5,5,5,1,0,0],[9,6,5,1,0,0]]";
    says(&[(start, listed)], "21:24", &["error: squirmers 0 and 1 overlap", "move them apart in `poses`"]);
    let apart = listed.replace("[9,6,5", "[15,6,5");
    assert_eq!(lines(&changed(&[(start, &apart)]), &[]), Vec::<String>::new());
    // A second species is counted on; its rows are its own.
    let more = "[[squirmers]]\nname = \"b\"\ncount = 1\nsemi_axes = { along = 2.0, across = 2.0 }\npassive = true\n";
    let twin = format!("{more}start = \"listed\"\nposes = [[15,6,7,1,0,0]]\n[[stage]]");
    says(&[(start, &apart), ("[[stage]]", &twin)], "29:10", &["error: squirmers 1 and 2 overlap"]);
    let lattice = [("count = 2", "count = 65"), (start, "start = \"lattice\"")];
    says(&lattice, "14:1", &["error: a lattice with axes along x has no room for 65 squirmers"]);
}

#[test]
fn where_random_places_are_not_sure_it_is_said() {
    assert_eq!(lines(&changed(&[("count = 2", "count = 50")]), &[]), Vec::<String>::new());
    // Few are tried, many are not.
    let few = ["error: 80 squirmers, 53.9 % of the box, could not be placed", "start = \"lattice\""];
    says(&[("count = 2", "count = 80")], "14:1", &few);
    let many = [("count = 2", "count = 300"), ("[24, 20, 24]", "[48, 20, 48]")];
    let parts = ["warning: the squirmers fill 50.5 %", "67 % of the room", "may find no places", "start = \"lattice\""];
    says(&many, "16:9", &parts);
    says(&[("count = 2", "count = 100")], "16:9", &["fill 67 % of the box", "lower for random places"]);
}

#[test]
fn walls_fluid_and_time_step() {
    let wall = |v: &str| format!("condition = \"no-slip\", velocity_low = {v}");
    let condition = "condition = \"no-slip\"";
    says(&[(condition, &wall("[0, 0.1, 0]"))], "8:61", &["error: `velocity_low` would move the wall along y"]);
    says(&[(condition, &wall("[1, 0, 0]"))], "8:61", &["warning: the wall slides at Mach 0.77"]);
    says(&[("density = 10", "density = 10\nacceleration = [0, 1e-4, 0]")], "12:16", &["across the slit"]);
    says(&[("dt = 0.05", "dt = 0.001")], "4:6", &["warning: a particle flies only 1.0e-3 cells"]);
    let found = lines(&changed(&[("dt = 0.05", "dt = 1.5")]), &[]);
    assert!(found[0].starts_with("f.toml:4:6: warning: a particle flies 1.50 cells"), "{found:#?}");
}

#[test]
fn outputs_must_write_something() {
    says(&[("record = [\"squirmers\", \"scalars\"]\n", "")], "45:1", &["warning: this output names nothing"]);
    says(&[("every = 20", "every = 200")], "47:9", &["the run ends after 100 steps: this output shows its start"]);
}

#[test]
fn a_file_without_outputs_is_warned_about_last() {
    let text = super::GOOD.split("[[output]]").next().expect("what stands before").replace("b1 = 0.1", "b1 = 0.7");
    let found = lines(&text, &[]);
    assert!(found.len() == 2 && found[0].contains("Mach"), "{found:#?}");
    assert!(found[1].contains("there is no [[output]], so a run leaves nothing but its summary"), "{found:#?}");
}

#[test]
fn a_share_of_zero_is_warned_about() {
    let changes = [("record = [\"squirmers\", \"scalars\"]", "record = [\"particles\"]\nfraction = 0")];
    says(&changes, "47:12", &["warning: `record` asks for particles, but takes none of them"]);
}

#[test]
fn names_have_room_in_snapshots() {
    says(&[("\"puller\"", "\"\"")], "15:8", &["has no letter"]);
    says(&[("\"puller\"", "\"a-name-that-is-much-longer-than-snapshots-allow\"")], "15:8", &["takes 47 bytes"]);
}

#[test]
fn huge_numbers_are_told_briefly() {
    says(&[("dt = 0.05", "dt = 1e300")], "4:6", &["1e300 is out of range"]);
}

#[test]
fn starts_that_cannot_be_made_are_told_at_their_place() {
    use squirm::state::start::StartError;
    let loaded = super::good(GOOD);
    let line = |error: StartError| loaded.cannot_start(&error).plain(&loaded.sources);
    let crowded = line(StartError::Crowded { count: 2, share: 0.5 });
    assert!(crowded.starts_with("f.toml:14:1: error: ") && crowded.contains("take fewer"), "{crowded}");
    let full = line(StartError::NoFluid);
    assert!(full.starts_with("f.toml:7:8: error: ") && full.contains("make the box larger"), "{full}");
}

#[test]
fn what_no_adapter_can_hold_is_told_at_the_size_of_the_box() {
    let loaded = super::good(GOOD);
    let line = loaded.too_large("a kernel needs more".into()).plain(&loaded.sources);
    assert!(line.starts_with("f.toml:7:8: error: a kernel needs more") && line.contains("smaller box"), "{line}");
}

#[test]
fn what_no_index_can_reach_is_refused() {
    // Bricks are whole: 600 x 604 x 600 cells.
    let cells = "217440000 cells and the room for their particles are more than 32-bit indices can tell apart";
    let large = ("size = [24, 20, 24]", "size = [600, 600, 600]");
    says(&[large], "7:8", &[cells]);
    says(&[large, ("density = 10", "density = 20")], "7:8", &["particles are more than a 32-bit index"]);
}
