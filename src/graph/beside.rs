//! Kernels of the fused plan that have nothing to do with each other share a dispatch: with its barrier it costs more than what many of
//! them compute, and those that are too small for a GPU fill it together.

use super::fused::{Item, Member};
use super::small::{Stages, conflicts, same_time, small, whole};
use crate::buffers::{Gathering, Sizes};
use crate::shader::{Lanes, Module, ShaderError, Side, compatible, side_by_side, usual};
use std::borrow::Cow;

/// The member of an item that can share its dispatch.
fn single(item: &Item) -> Option<&Member> {
    let Item::Alone(m) = item else { return None };
    usual(m.wgsl, m.phase.entry).then_some(m)
}

/// The text of each member; what asks for no shift may have it as a neighbour of its stage does.
fn texts(members: &[&Member]) -> Vec<Cow<'static, str>> {
    let asks = |m: &Member| m.asks_for("shift") || m.asks_for("shift_before");
    let text = |m: &&Member| {
        let neighbour = members.iter().find(|other| other.wgsl == m.wgsl && asks(other));
        neighbour.filter(|_| !asks(m)).unwrap_or(m).text()
    };
    members.iter().map(text).collect()
}

/// Whether a kernel can be dispatched together with others.
fn fits(group: &[Member], member: &Member, sizes: &Sizes) -> bool {
    let lanes = |m: &Member| m.shared.then(|| Item::Alone(m.clone()).lanes(Lanes::Four, sizes));
    let lanes_differ = |g: &Member| lanes(g).is_some_and(|a| lanes(member).is_some_and(|b| a != b));
    let texts = texts(&group.iter().chain([member]).collect::<Vec<_>>());
    let (own, others) = texts.split_last().expect("there is one member at least");
    let compatible = others.iter().all(|text| text == own || compatible(text, own));
    compatible && !group.iter().any(lanes_differ) && same_time(group, member)
}

/// Whether an item and a neighbour in the list are so small that one workgroup can do both. Where sums lie in chains, what is small had better go
/// beside the kernels that walk them.
fn in_a_run(items: &[Item], at: usize, sizes: &Sizes) -> bool {
    let small = |k: usize| items.get(k).is_some_and(|item| small(item, sizes).is_some());
    sizes.gathering() == Gathering::Bricks && small(at) && (small(at + 1) || at > 0 && small(at - 1))
}

/// Joins kernels with later ones that use nothing of what they and those in between write, and the other way round.
pub(super) fn joined(items: Vec<Item>, sizes: &Sizes) -> Vec<Item> {
    let mut done = Vec::new();
    let mut rest = items;
    while let Some(first) = (0..rest.len()).find(|k| single(&rest[*k]).is_some() && !in_a_run(&rest, *k, sizes)) {
        let later = rest.split_off(first + 1);
        let mut group = rest.pop().expect("it was found").members().to_vec();
        done.append(&mut rest);
        for item in later {
            let free = !rest.iter().any(|d| conflicts(d.members(), item.members()));
            match single(&item) {
                Some(m) if free && !conflicts(&group, item.members()) && fits(&group, m, sizes) => {
                    group.push(m.clone());
                }
                _ => rest.push(item),
            }
        }
        done.push(if group.len() == 1 { Item::Alone(group.remove(0)) } else { Item::Beside(group) });
    }
    done.append(&mut rest);
    done
}

/// Workgroups of a member, with as many invocations for an element as suit it on an adapter.
fn groups(m: &Member, lanes: Lanes, sizes: &Sizes) -> u64 {
    let lanes = Item::Alone(m.clone()).lanes(lanes, sizes);
    (sizes.count(m.phase.over) * lanes.count()).div_ceil(64)
}

/// Workgroups of all.
#[must_use]
pub fn workgroups(members: &[Member], lanes: Lanes, sizes: &Sizes) -> u64 {
    members.iter().map(|m| groups(m, lanes, sizes)).sum()
}

/// The kernel of members side by side.
///
/// # Errors
/// If they do not fit together as WGSL.
pub fn module(members: &[Member], stages: Stages<'_>, lanes: Lanes, sizes: &Sizes) -> Result<Module, ShaderError> {
    let shared = members.iter().find(|m| m.shared).map(|m| Item::Alone(m.clone()).lanes(lanes, sizes));
    let chosen = |text: Cow<'static, str>| shared.unwrap_or(Lanes::One).chosen(&text);
    let texts: Vec<String> = texts(&members.iter().collect::<Vec<_>>()).into_iter().map(chosen).collect();
    let sides = members.iter().zip(&texts);
    let sides = sides.map(|(m, text)| Side { part: whole(m, text, stages), groups: groups(m, lanes, sizes) });
    side_by_side(&sides.collect::<Vec<_>>())
}
