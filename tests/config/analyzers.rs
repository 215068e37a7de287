//! Analyzers of a pipeline file, and what outputs say about slow readers: what is wrong is said at its place.

use super::{changed, good, lines, says};

/// The end of the good file.
const END: &str = "record = [\"squirmers\", \"scalars\"]\nevery = 20\n";

/// The end with more keys in the output, and then analyzers.
fn end(output: &str, analyzers: &str) -> String {
    format!("{END}{output}{analyzers}")
}

#[test]
fn what_an_analyzer_reads_must_be_published() {
    let swim = "[[analyzer]]\nkind = \"swim\"\n";
    says(
        &[(END, &end("", swim))],
        "49:8",
        &[
            "the analyzer `swim` reads squirmers, but no output publishes",
            "add publish = [\"squirmers\"] to an [[output]]",
        ],
    );
    let plan = good(&changed(&[(END, &end("publish = [\"squirmers\"]\n", swim))])).plan;
    assert_eq!((plan.analyzers.len(), plan.analyzers[0].name(), plan.analyzers[0].folder()), (1, "swim", "swim"));
    assert!(plan.resolved.contains("\n[[analyzer]]\nkind = \"swim\"\n"), "{}", plan.resolved);
    assert_eq!(good(&plan.resolved).plan.analyzers, plan.analyzers);
}

#[test]
fn an_analyzer_is_one_thing_that_can_be_started() {
    let wrong = |analyzer: &str, place: &str, part: &str| says(&[(END, &end("", analyzer))], place, &[part]);
    wrong("[[analyzer]]\n", "48:1", "an analyzer needs a kind or a command");
    wrong("[[analyzer]]\nkind = \"swin\"\n", "49:8", "did you mean `swim`?");
    wrong("[[analyzer]]\nkind = \"swim\"\ncommand = [\"sh\"]\n", "50:11", "a kind or a command, not both");
    wrong("[[analyzer]]\ncommand = []\n", "49:11", "names no program");
    wrong("[[analyzer]]\ncommand = \"sh\"\n", "49:11", "must be a list of texts in quotes");
    wrong("[[analyzer]]\ncommand = [\"sh\", 3]\n", "49:18", "must be a list of texts in quotes");
    wrong(
        "[[analyzer]]\ncommand = [\"./no-such\"]\n",
        "49:11",
        "warning: the program `./no-such` cannot be found here",
    );
    wrong("[[analyzer]]\ncommand = [\"sh\"]\nout = \"\"\n", "50:7", "nowhere to write");
    wrong("[analyzer]\ncommand = [\"sh\"]\n", "48:1", "write [[analyzer]]");
}

#[test]
fn two_analyzers_have_two_folders() {
    let twice = "[[analyzer]]\ncommand = [\"sh\", \"a\"]\n[[analyzer]]\ncommand = [\"sh\", \"b\"]\n";
    says(&[(END, &end("", twice))], "50:1", &["two analyzers would write into the folder `sh`", "out ="]);
    let text = changed(&[(END, &end("", &format!("{twice}out = \"other\"\n")))]);
    assert_eq!(lines(&text, &[]), Vec::<String>::new());
}

#[test]
fn without_a_live_run_there_is_nothing_to_analyze() {
    let text = changed(&[(END, &end("publish = [\"squirmers\"]\n", "[[analyzer]]\nkind = \"swim\"\n"))]);
    let found = lines(&text, &["run.live=false"]);
    assert!(found.len() == 1 && found[0].contains("warning: this analyzer is not started"), "{found:#?}");
}

#[test]
fn slow_readers_are_treated_one_way_per_topic() {
    let more = "publish = [\"scalars\"]\non_slow = \"block\"\n[[output]]\npublish = [\"scalars\", \"fields\"]\n";
    says(&[(END, &end(more, ""))], "50:1", &["two outputs publish scalars, but treat its slow readers differently"]);
    let same = format!("{more}on_slow = \"block\"\n");
    assert_eq!(lines(&changed(&[(END, &end(&same, ""))]), &[]), Vec::<String>::new());
    says(&[(END, &end("on_slow = \"abort\"\n", ""))], "48:11", &["warning", "this output publishes nothing"]);
    says(&[(END, &end("slow_limit = 0\n", ""))], "48:14", &["a number from 0.1 to 3600: 0 is out of range", "in s"]);
}
