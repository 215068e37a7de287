//! The list of stages: order, duplicates, stale buffers, and stages that the system calls for.

use super::{GOOD, changed, good, lines, says};

#[test]
fn apply_is_implied_at_the_end() {
    let plan = good(GOOD).plan;
    assert_eq!(plan.stages.last().unwrap().entry.kind, "apply");
    let explicit = good(&format!("{GOOD}[[stage]]\nkind = \"apply\"\n")).plan;
    assert_eq!(explicit.stages.len(), plan.stages.len());
}

#[test]
fn kinds_are_known_and_unique() {
    says(&[("\"rotate\"", "\"rotat\"")], "40:8", &["no kind of stage \"rotat\"", "did you mean `rotate`?"]);
    says(
        &[("[[output]]", "[[stage]]\nkind = \"rotate\"\n[[output]]")],
        "46:8",
        &["the stage `rotate` is listed twice"],
    );
    says(&[("angle = 130", "angel = 130")], "41:1", &["stage `rotate` has no parameter `angel`", "`angle`"]);
}

#[test]
fn no_stage_at_all() {
    let (stages, outputs) = (GOOD.find("[[stage]]").unwrap(), GOOD.find("[[output]]").unwrap());
    let found = lines(&format!("{}{}", &GOOD[..stages], &GOOD[outputs..]), &[]);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].contains("the pipeline has no stage"), "{found:#?}");
}

#[test]
fn a_missing_stage_is_named_by_who_needs_its_result() {
    let found = lines(&changed(&[("[[stage]]\nkind = \"shift-grid\"\n", "")]), &[]);
    let at = |line: &str| found.iter().any(|l| l.starts_with(line));
    assert!(at("f.toml:29:8: error: `sort-reorder` reads `shift`, but no stage before it"), "{found:#?}");
    assert!(at("f.toml:32:8: error: `cell-reduce` reads `shift`, but no stage before it"), "{found:#?}");
    assert!(found[0].contains("add a [[stage]] with kind = \"shift-grid\" before `sort-reorder`"), "{found:#?}");

    let found = lines(&changed(&[("[[stage]]\nkind = \"cell-reduce\"\n", "")]), &[]);
    assert!(found.iter().any(|l| l.starts_with("f.toml:34:8: error: `wall-ghosts` reads `moments`")), "{found:#?}");
}

#[test]
fn who_spoils_a_buffer_is_named() {
    let stream = "[[stage]]\nkind = \"stream\"\n";
    let rotate = "[[stage]]\nkind = \"rotate\"\n";
    let moved = changed(&[(stream, ""), (rotate, &format!("{stream}{rotate}"))]);
    let found = lines(&moved, &[]);
    let stale = found.iter().find(|l| l.contains("`rotate` reads `moments`, which is out of date"));
    let stale = stale.unwrap_or_else(|| panic!("{found:#?}"));
    assert!(stale.starts_with("f.toml:40:8: error:"), "{stale}");
    assert!(stale.contains("`stream` has changed `particles`"), "{stale}");
    assert!(stale.contains("move `stream` above `cell-reduce`, or below `rotate`"), "{stale}");
}

#[test]
fn order_is_checked_before_anything_runs() {
    let ghosts = "[[stage]]\nkind = \"wall-ghosts\"\n";
    let reduce = "[[stage]]\nkind = \"cell-reduce\"\n";
    let found = lines(&changed(&[(ghosts, ""), (reduce, &format!("{ghosts}{reduce}"))]), &[]);
    let order = "f.toml:34:8: error: the stage `wall-ghosts` stands before `cell-reduce`, but must come after it";
    assert!(found.iter().any(|l| l.starts_with(order)), "{found:#?}");
}

#[test]
fn the_system_calls_for_its_stages() {
    let without = |kind: &str| changed(&[(&format!("[[stage]]\nkind = \"{kind}\"\n"), ""), ("angle = 130\n", "")]);
    let has = |text: &str, part: &str| {
        let found = lines(text, &[]);
        assert!(found.iter().any(|l| l.contains(part)), "expected {part:?}: {found:#?}");
    };
    has(&without("squirmer-move"), "error: there are squirmers, but no stage `squirmer-move`");
    has(&without("squirmer-collide"), "error: there are squirmers, but no stage `squirmer-collide`");
    has(&without("squirmer-fill"), "warning: there are squirmers, but no stage `squirmer-fill`");
    has(&without("wall-ghosts"), "warning: no-slip walls without ghosts");
    has(&without("stream"), "warning: no stage `stream`");
    has(&without("restore-thermostat"), "warning: no stage takes away the heat that squirmers put into the fluid");
    has(&without("restore-thermostat"), "warning: cells do not keep angular momentum");
    has(&without("rotate"), "error: `restore-thermostat` adds to `operators`, but no stage before it");
    let periodic = changed(&[("walls = { axis = \"y\", condition = \"no-slip\" }\n", "")]);
    has(&periodic, "f.toml:35:8: warning: the box has no walls to fill");
    let begin = GOOD.find("[[squirmers]]").unwrap();
    let bare = format!("{}{}", &GOOD[..begin], &GOOD[GOOD.find("[[stage]]").unwrap()..]);
    has(&bare, "f.toml:15:8: warning: `squirmer-move` has no effect");
}

#[test]
fn a_result_that_nobody_reads_is_a_warning() {
    let cut = &GOOD[..GOOD.find("[[stage]]\nkind = \"wall-ghosts\"").unwrap()];
    let found = lines(cut, &[]);
    let unread = "f.toml:34:8: warning: `cell-reduce` computes `moments`, but no stage uses it";
    assert!(found.iter().any(|l| l.starts_with(unread)), "{found:#?}");
}
