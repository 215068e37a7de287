//! Small kernels of the fused plan: runs of them over a few elements each become one kernel of a single workgroup, which does one after
//! the other. A launch costs more than what they compute.

use super::fused::{Item, Member, conflict};
use crate::buffers::{Extent, Sizes};
use crate::shader::{Module, Part, Phase, ShaderError, apart, one_workgroup};
use crate::stages::Entry;

/// Elements up to which a kernel is small: one for each invocation of the workgroup. With four (800 squirmers) a workgroup took twice as
/// long as kernels of their own on an H100.
pub const FEW: u64 = 256;

/// Parts of the search for partners up to which it is small: they do little each. With 800 of them for 100 squirmers a workgroup took longer than
/// kernels of their own for 64 each.
const FEW_PARTS: u64 = 1024;

/// Extents whose kernels may be small.
const SHORT: [Extent; 6] =
    [Extent::One, Extent::Squirmers, Extent::SquirmerParts, Extent::Bins, Extent::Binned, Extent::WallPatches];

/// Stages as [`super::fused::items`] has them.
pub type Stages<'a> = &'a [(&'static Entry, u32, bool)];

/// The member of an item that is small.
pub(super) fn small<'a>(item: &'a Item, sizes: &Sizes) -> Option<&'a Member> {
    let Item::Alone(m) = item else { return None };
    let few = if m.phase.over == Extent::SquirmerParts { FEW_PARTS } else { FEW };
    let short = SHORT.contains(&m.phase.over) && sizes.count(m.phase.over) <= few;
    (short && apart(m.wgsl, m.phase.entry)).then_some(m)
}

pub(super) fn conflicts(a: &[Member], b: &[Member]) -> bool {
    a.iter().any(|x| b.iter().any(|y| conflict(x, y)))
}

/// A dispatch tells all of its members the same step and repetition.
pub(super) fn same_time(group: &[Member], member: &Member) -> bool {
    let told = |m: &Member| (m.late, m.repetition);
    !member.now || group.iter().filter(|g| g.now).all(|g| told(g) == told(member))
}

/// Joins small kernels with later ones; kernels in between go before or after as far as their buffers allow.
pub(super) fn joined(items: Vec<Item>, sizes: &Sizes) -> Vec<Item> {
    let mut done = Vec::new();
    let mut rest = items;
    while let Some(first) = rest.iter().position(|i| small(i, sizes).is_some()) {
        let later = rest.split_off(first + 1);
        let mut group = rest.pop().expect("it was found").members().to_vec();
        done.append(&mut rest);
        let mut deferred: Vec<Item> = Vec::new();
        for item in later {
            let free = !deferred.iter().any(|d| conflicts(d.members(), item.members()));
            match small(&item, sizes) {
                Some(member) if free && same_time(&group, member) => group.push(member.clone()),
                _ if free && !conflicts(&group, item.members()) => done.push(item),
                _ => deferred.push(item),
            }
        }
        done.push(if group.len() == 1 { Item::Alone(group.remove(0)) } else { Item::Small(group) });
        rest = deferred;
    }
    done.append(&mut rest);
    done
}

/// A member as a part whose function is its entry point, with the text that has it.
pub(super) fn whole<'a>(m: &Member, wgsl: &'a str, stages: Stages<'_>) -> Part<'a> {
    let Entry { kind, uniform_wgsl: settings, .. } = *stages[m.stage].0;
    Part { kind, wgsl, settings, function: m.phase.entry, rare: None, late: false }
}

/// The kernel of small members.
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn module(members: &[Member], stages: Stages<'_>, sizes: &Sizes) -> Result<Module, ShaderError> {
    let texts: Vec<_> = members.iter().map(Member::text).collect();
    let mut phases: Vec<Phase<'_>> = Vec::new();
    // Where the members begin that run without a barrier between them.
    let mut since = 0;
    for (k, m) in members.iter().enumerate() {
        // An invocation finds what it wrote itself.
        let alike = |o: &Member| o.own && m.own && sizes.count(o.phase.over) == sizes.count(m.phase.over);
        let waits = members[since..k].iter().any(|o| !alike(o) && conflict(o, m));
        if waits {
            since = k;
        }
        phases.push(Phase { part: whole(m, &texts[k], stages), count: sizes.count(m.phase.over), waits });
    }
    one_workgroup(&phases)
}
