//! Which values of a pipeline file decide a run's trajectory, and in which of them two files differ.

use std::collections::BTreeMap;

/// What may change between the parts of a run: how far it goes, what it leaves behind, and who watches it.
const FREE: [&str; 5] = ["run.steps", "run.live", "output", "analyzer", "checkpoint"];

/// Every value that decides the trajectory, by its key, as in `squirmers.puller.beta`; of a pipeline file with all its defaults.
/// `None` if the text is no TOML.
#[must_use]
pub fn decisive(resolved: &str) -> Option<BTreeMap<String, String>> {
    let mut values = BTreeMap::new();
    flatten("", &toml::Value::Table(resolved.parse().ok()?), &mut values);
    let free = |key: &str| FREE.iter().any(|f| key.strip_prefix(f).is_some_and(|r| r.is_empty() || r.starts_with('.')));
    values.retain(|key, _| !free(key));
    Some(values)
}

/// What differs between two results of [`decisive`], a line for each key.
#[must_use]
pub fn differences(before: &BTreeMap<String, String>, now: &BTreeMap<String, String>) -> Vec<String> {
    let keys: std::collections::BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let line = |key: &String| match (before.get(key), now.get(key)) {
        (Some(a), Some(b)) if a == b => None,
        (Some(a), Some(b)) => Some(format!("{key} was {a}, now it is {b}")),
        (Some(a), None) => Some(format!("{key} was {a}, now it is absent")),
        (None, b) => Some(format!("{key} was absent, now it is {}", b.map_or("", String::as_str))),
    };
    keys.into_iter().filter_map(line).collect()
}

fn flatten(key: &str, value: &toml::Value, into: &mut BTreeMap<String, String>) {
    let under = |part: &str| if key.is_empty() { part.to_owned() } else { format!("{key}.{part}") };
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(part, value)| flatten(&under(part), value, into)),
        // Tables of a list go by their number, since their order matters, and by their name.
        toml::Value::Array(list) if list.first().is_some_and(toml::Value::is_table) => {
            for (number, value) in list.iter().enumerate() {
                let named = ["kind", "name"].iter().find_map(|k| value.get(k)?.as_str());
                flatten(&under(&format!("{}.{}", number + 1, named.unwrap_or(""))), value, into);
            }
        }
        value => {
            into.insert(key.to_owned(), value.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[run]\nseed = 7\nsteps = 10\n[box]\nwalls = { axis = \"y\" }\n[[stage]]\nkind = \"stream\"\n\
        [[stage]]\nkind = \"rotate\"\nangle = 130.0\n[[output]]\nevery = 5\n[[analyzer]]\nkind = \"swim\"\n[checkpoint]\nminutes = 1.0\n";

    fn differing(from: &str, to: &str) -> Vec<String> {
        let read = |text: &str| decisive(text).expect("TOML");
        differences(&read(FILE), &read(&FILE.replace(from, to)))
    }

    #[test]
    fn what_does_not_decide_the_trajectory_may_change() {
        assert_eq!(differing("steps = 10", "steps = 20"), [""; 0]);
        assert_eq!(differing("every = 5", "every = 7"), [""; 0]);
        assert_eq!(differing("minutes = 1.0", "minutes = 2.0"), [""; 0]);
        assert_eq!(differing("steps = 10", "steps = 10\nlive = false"), [""; 0]);
        assert_eq!(differing("[[analyzer]]\nkind = \"swim\"\n", ""), [""; 0]);
    }

    #[test]
    fn what_decides_it_is_named() {
        assert_eq!(differing("seed = 7", "seed = 8"), ["run.seed was 7, now it is 8"]);
        assert_eq!(differing("angle = 130.0", "angle = 90.0"), ["stage.2.rotate.angle was 130.0, now it is 90.0"]);
        assert_eq!(differing("axis = \"y\"", ""), ["box.walls.axis was \"y\", now it is absent"]);
        let moved = differing("[[stage]]\nkind = \"stream\"\n", "");
        assert!(moved.iter().any(|line| line.starts_with("stage.1.rotate.kind was absent")), "{moved:?}");
        assert_eq!(decisive("a = "), None);
    }
}
