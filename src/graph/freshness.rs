//! Which kernels of a step would read values that are out of date, and which results nobody reads.

use super::kernels::Kernel;
use crate::buffers::{Buffer, Life};
use std::collections::HashMap;

/// Why a buffer has nothing valid to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cause {
    /// No kernel before has computed it in this step.
    NotComputed,
    /// It was computed, but then something it was computed from has changed.
    Spoiled {
        /// Index of the kernel that changed it.
        kernel: usize,
        /// What that kernel wrote.
        source: String,
    },
    /// It is computed, but not in every step.
    Occasional {
        /// Index of the kernel that computes it.
        kernel: usize,
    },
}

/// A kernel that would read a stale buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stale {
    /// Index of the reading kernel.
    pub kernel: usize,
    /// The buffer.
    pub buffer: String,
    /// Whether the kernel adds to the buffer rather than only reads it.
    pub adds: bool,
    /// Why it is stale.
    pub cause: Cause,
}

/// Every stale read of one step, at most one for each stage and buffer.
///
/// A derived buffer is stale at the beginning of the step. A kernel that writes it makes it fresh, if it runs in every step; a
/// kernel that writes one of its sources makes it stale again.
#[must_use]
pub fn stale_reads(kernels: &[Kernel], catalogue: &[Buffer]) -> Vec<Stale> {
    let mut causes: HashMap<&str, Cause> = HashMap::new();
    for buffer in catalogue {
        if matches!(buffer.life, Life::Derived(_)) {
            causes.insert(buffer.name, Cause::NotComputed);
        }
    }
    let mut found: Vec<Stale> = Vec::new();
    for (index, kernel) in kernels.iter().enumerate() {
        for used in kernel.uses.iter().filter(|u| u.read) {
            let Some(cause) = causes.get(used.buffer.as_str()) else { continue };
            let known = found.iter().any(|s| kernels[s.kernel].stage == kernel.stage && s.buffer == used.buffer);
            if !known {
                let (buffer, adds) = (used.buffer.clone(), used.write);
                found.push(Stale { kernel: index, buffer, adds, cause: cause.clone() });
            }
        }
        let written = || kernel.uses.iter().filter(|u| u.write).map(|u| u.buffer.as_str());
        for buffer in catalogue {
            let Life::Derived(sources) = buffer.life else { continue };
            if written().any(|name| name == buffer.name) {
                // A kernel that adds to something stale does not make it valid, but one complaint about it is enough.
                if kernel.every_step {
                    causes.remove(buffer.name);
                } else {
                    causes.insert(buffer.name, Cause::Occasional { kernel: index });
                }
            } else if let Some(source) = written().find(|name| sources.contains(name))
                && !causes.contains_key(buffer.name)
            {
                causes.insert(buffer.name, Cause::Spoiled { kernel: index, source: source.to_owned() });
            }
        }
    }
    found
}

/// Derived buffers that a step computes and no other stage reads, with the stage that computes them.
#[must_use]
pub fn unread(kernels: &[Kernel], catalogue: &[Buffer]) -> Vec<(usize, &'static str)> {
    let derived = catalogue.iter().filter(|b| matches!(b.life, Life::Derived(_)));
    let writer = |name: &str| {
        kernels.iter().find(|k| k.uses.iter().any(|u| u.write && !u.read && u.buffer == name)).map(|k| k.stage)
    };
    let read = |name: &str| kernels.iter().any(|k| k.uses.iter().any(|u| u.read && !u.write && u.buffer == name));
    derived.filter(|b| !read(b.name)).filter_map(|b| Some((writer(b.name)?, b.name))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::kernels::Use;
    use super::*;
    use crate::buffers::Extent;

    const fn buffer(name: &'static str, life: Life) -> Buffer {
        Buffer { name, doc: "", life, extent: Extent::One, words: 1 }
    }

    const CATALOGUE: &[Buffer] = &[
        buffer("v", Life::Persistent),
        buffer("shift", Life::Derived(&[])),
        buffer("sums", Life::Derived(&["v", "shift"])),
        buffer("map", Life::Derived(&["sums"])),
    ];

    /// A kernel of stage `stage`: `r:` reads, `w:` writes, `a:` adds to.
    fn kernel(stage: usize, text: &str) -> Kernel {
        let uses = text.split_whitespace().map(|word| {
            let (how, name) = word.split_once(':').expect("how:name");
            Use::whole(name, how != "w", how != "r")
        });
        Kernel { stage, kind: "k", entry: "e", receive: false, every_step: true, uses: uses.collect() }
    }

    fn step(texts: &[&str]) -> Vec<Kernel> {
        texts.iter().enumerate().map(|(i, t)| kernel(i, t)).collect()
    }

    #[test]
    fn a_step_in_order_is_fresh() {
        let k = step(&["a:v", "w:shift", "w:sums", "r:v r:shift a:sums", "r:sums w:map", "r:map a:v"]);
        assert_eq!(stale_reads(&k, CATALOGUE), []);
        assert_eq!(unread(&k, CATALOGUE), []);
    }

    #[test]
    fn what_was_never_computed_is_stale_even_for_adding() {
        let k = step(&["w:shift", "a:sums", "r:map"]);
        let stale = stale_reads(&k, CATALOGUE);
        assert_eq!(stale.len(), 2);
        assert_eq!(stale[0], Stale { kernel: 1, buffer: "sums".into(), adds: true, cause: Cause::NotComputed });
        assert_eq!(stale[1], Stale { kernel: 2, buffer: "map".into(), adds: false, cause: Cause::NotComputed });
    }

    #[test]
    fn who_writes_a_source_later_is_named() {
        let k = step(&["w:shift", "w:sums", "a:v", "r:sums w:map"]);
        let cause = Cause::Spoiled { kernel: 2, source: "v".into() };
        assert_eq!(stale_reads(&k, CATALOGUE), [Stale { kernel: 3, buffer: "sums".into(), adds: false, cause }]);
    }

    #[test]
    fn a_kernel_may_read_before_it_spoils_and_refresh_what_it_spoils() {
        assert_eq!(stale_reads(&step(&["w:sums", "r:sums w:v", "w:v w:sums", "r:sums"]), CATALOGUE), []);
    }

    #[test]
    fn what_is_not_computed_in_every_step_is_stale_in_the_others() {
        let mut k = step(&["w:shift", "r:shift"]);
        k[0].every_step = false;
        let cause = Cause::Occasional { kernel: 0 };
        assert_eq!(stale_reads(&k, CATALOGUE), [Stale { kernel: 1, buffer: "shift".into(), adds: false, cause }]);
    }

    #[test]
    fn one_stage_complains_once_about_a_buffer() {
        let k = [kernel(0, "r:map"), kernel(0, "r:map"), kernel(1, "r:map")];
        assert_eq!(stale_reads(&k, CATALOGUE).len(), 2);
    }

    #[test]
    fn results_that_nobody_reads_are_found() {
        assert_eq!(unread(&step(&["w:shift", "r:shift w:sums", "a:sums"]), CATALOGUE), [(1, "sums")]);
    }
}
