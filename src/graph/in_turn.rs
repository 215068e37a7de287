//! Kernels of the fused plan that follow each other over the same elements, each using only what belongs to its own element, become one: a
//! dispatch with its barrier costs more than what they compute.

use super::fused::{Item, Member};
use super::small::{self, Stages, same_time, whole};
use crate::buffers::Sizes;
use crate::shader::{Module, ShaderError, apart, in_turn};

/// The member of an item that may share its invocations. What is small shares a workgroup with more.
fn single<'a>(item: &'a Item, sizes: &Sizes) -> Option<&'a Member> {
    let Item::Alone(m) = item else { return None };
    (m.own && apart(m.wgsl, m.phase.entry) && small::small(item, sizes).is_none()).then_some(m)
}

/// Joins kernels with those right after them.
pub(super) fn joined(items: Vec<Item>, sizes: &Sizes) -> Vec<Item> {
    let mut done: Vec<Item> = Vec::new();
    for item in items {
        let group = done.last().filter(|last| matches!(last, Item::InTurn(_)) || single(last, sizes).is_some());
        let joint = group.zip(single(&item, sizes)).and_then(|(group, m)| {
            let members = group.members();
            let alike = sizes.count(members[0].phase.over) == sizes.count(m.phase.over);
            (alike && same_time(members, m)).then(|| Item::InTurn([members, std::slice::from_ref(m)].concat()))
        });
        if joint.is_some() {
            done.pop();
        }
        done.push(joint.unwrap_or(item));
    }
    done
}

/// The kernel of members in turn.
///
/// # Errors
/// If they do not fit together as WGSL.
pub fn module(members: &[Member], stages: Stages<'_>) -> Result<Module, ShaderError> {
    let texts: Vec<_> = members.iter().map(Member::text).collect();
    in_turn(&members.iter().zip(&texts).map(|(m, text)| whole(m, text, stages)).collect::<Vec<_>>())
}
