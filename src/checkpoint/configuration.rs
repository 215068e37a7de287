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

/// What differs between two results of [`decisive`], a line for each key, as `--set` takes it.
#[must_use]
pub fn differences(before: &BTreeMap<String, String>, now: &BTreeMap<String, String>) -> Vec<String> {
    let [before, now] = [before, now].map(shown);
    let keys: std::collections::BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let line = |key: &String| {
        let (old, new) = (before.get(key), now.get(key));
        let value = |v: Option<&Shown>| v.map_or("absent".to_owned(), |v| v.value.clone());
        let owner = old.and_then(|v| v.owner.as_ref());
        let of = owner.filter(|owner| new.and_then(|v| v.owner.as_ref()).is_none_or(|new| new == *owner));
        let of = of.map_or(String::new(), |owner| format!(" ({owner})"));
        (old.map(|v| &v.value) != new.map(|v| &v.value))
            .then(|| format!("{key}{of} was {}, now it is {}", value(old), value(new)))
    };
    keys.into_iter().filter_map(line).collect()
}

/// A value, and the name or kind of the element of a list that has it.
struct Shown {
    value: String,
    owner: Option<String>,
}

/// Values by the keys that `--set` takes: `squirmers.0.beta` for what [`decisive`] calls `squirmers.1.puller.beta`.
fn shown(values: &BTreeMap<String, String>) -> BTreeMap<String, Shown> {
    let show = |(key, value): (&String, &String)| {
        let listed = || {
            let (section, rest) = key.split_once('.')?;
            let (number, rest) = rest.split_once('.')?;
            let position = number.parse::<usize>().ok()?.checked_sub(1)?;
            // A name may hold points, too: what it is tells its own entry.
            let prefix = format!("{section}.{number}.");
            let own = |(key, value): (&String, &String)| {
                let name = key.strip_prefix(&prefix)?;
                let name = name.strip_suffix(".kind").or_else(|| name.strip_suffix(".name"))?;
                (*value == toml::Value::from(name).to_string()).then(|| name.to_owned())
            };
            let owner = values.iter().find_map(own)?;
            let field = rest.strip_prefix(&owner)?.strip_prefix('.')?;
            Some((format!("{section}.{position}.{field}"), Some(owner)))
        };
        let (key, owner) = listed().unwrap_or_else(|| (key.clone(), None));
        (key, Shown { value: value.clone(), owner })
    };
    values.iter().map(show).collect()
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
        assert_eq!(differing("angle = 130.0", "angle = 90.0"), ["stage.1.angle (rotate) was 130.0, now it is 90.0"]);
        assert_eq!(differing("axis = \"y\"", ""), ["box.walls.axis was \"y\", now it is absent"]);
        let moved = differing("[[stage]]\nkind = \"stream\"\n", "");
        let lines = [
            "stage.0.angle was absent, now it is 130.0",
            "stage.0.kind was \"stream\", now it is \"rotate\"",
            "stage.1.angle (rotate) was 130.0, now it is absent",
            "stage.1.kind (rotate) was \"rotate\", now it is absent",
        ];
        assert_eq!(moved, lines);
        assert_eq!(decisive("a = "), None);
    }

    #[test]
    fn keys_are_those_of_overrides() {
        let species = |name: &str, beta: f64| {
            let file = format!("[[squirmers]]\nname = \"a\"\n[[squirmers]]\nname = \"{name}\"\nbeta = {beta:?}\n");
            decisive(&file).expect("TOML")
        };
        let lines = differences(&species("b.name", 1.0), &species("b.name", 2.0));
        assert_eq!(lines, ["squirmers.1.beta (b.name) was 1.0, now it is 2.0"]);
        let renamed = differences(&species("b", 1.0), &species("c", 1.0));
        assert_eq!(renamed, ["squirmers.1.name was \"b\", now it is \"c\""]);
    }
}
