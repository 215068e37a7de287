//! Snapshots of two topics, brought together by their step whatever the order in which they come.

use std::collections::BTreeMap;

/// Snapshots of one topic that may wait for their partners. A run sends the topics of one step together, so that few
/// ever wait; where one topic comes from another file, or does not come at all, this bounds the memory.
const WAITING: usize = 16;

/// What waits for its partner, by step. Within a topic the steps rise.
#[derive(Debug)]
pub struct Pairs<A, B> {
    first: BTreeMap<u64, A>,
    second: BTreeMap<u64, B>,
}

impl<A, B> Default for Pairs<A, B> {
    fn default() -> Self {
        Self { first: BTreeMap::new(), second: BTreeMap::new() }
    }
}

impl<A, B> Pairs<A, B> {
    /// Takes a snapshot of the first topic; returns its pair if the partner is here.
    pub fn first(&mut self, step: u64, item: A) -> Option<(A, B)> {
        join(&mut self.first, &mut self.second, step, item)
    }

    /// Takes a snapshot of the second topic; returns its pair if the partner is here.
    pub fn second(&mut self, step: u64, item: B) -> Option<(A, B)> {
        join(&mut self.second, &mut self.first, step, item).map(|(b, a)| (a, b))
    }
}

fn join<S, T>(own: &mut BTreeMap<u64, S>, other: &mut BTreeMap<u64, T>, step: u64, item: S) -> Option<(S, T)> {
    // What is older on the other side has missed its partner.
    *other = other.split_off(&step);
    if let Some(partner) = other.remove(&step) {
        return Some((item, partner));
    }
    own.insert(step, item);
    if own.len() > WAITING {
        own.pop_first();
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps at which both topics have something, whatever the order.
    #[test]
    fn pairs_do_not_depend_on_the_order_of_topics() {
        let run = |order: &[(bool, u64)]| {
            let mut pairs = Pairs::default();
            order
                .iter()
                .filter_map(|(first, step)| if *first { pairs.first(*step, *step) } else { pairs.second(*step, *step) })
                .collect::<Vec<(u64, u64)>>()
        };
        let expected = vec![(0, 0), (20, 20), (60, 60)];
        let (a, b) = ([0, 10, 20, 30, 60].map(|s| (true, s)), [0, 20, 40, 60].map(|s| (false, s)));
        assert_eq!(run(&[a.as_slice(), &b].concat()), expected);
        assert_eq!(run(&[b.as_slice(), &a].concat()), expected);
        assert_eq!(run(&[&a[..2], &b[..2], &a[2..4], &b[2..], &a[4..]].concat()), expected);
        assert_eq!(run(&a), vec![]);
    }

    #[test]
    fn a_topic_without_a_partner_does_not_pile_up() {
        let mut pairs: Pairs<u64, u64> = Pairs::default();
        (0..1000).for_each(|step| assert!(pairs.first(step, step).is_none()));
        assert_eq!(pairs.first.len(), WAITING);
        assert_eq!(pairs.second(990, 0), Some((990, 0)));
    }
}
