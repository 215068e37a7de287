//! Waiting for those who want to see a replay from its beginning.

use super::{Command, Control, NAP, ReplayError, SETTLED};
use crate::wire::domain::{self, Block};
use crate::wire::{Header, Kind};
use iceoryx2::prelude::{CallbackProgression, Node, NodeBuilder, PortFactory as _, SignalHandlingMode, ipc};
use std::time::Instant;

type Service = ipc::Service;

/// Waits until `count` processes have subscribed to any of the topics; says whether to begin.
pub(super) fn wait(name: &str, kinds: &[Kind], count: usize, control: &mut dyn Control) -> Result<bool, ReplayError> {
    if count == 0 {
        return Ok(true);
    }
    let failed = |e: &dyn std::fmt::Debug| ReplayError::Readers(format!("{e:?}"));
    let config = domain::config().map_err(|e| failed(&e))?;
    let node = NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Service>()
        .map_err(|e| failed(&e))?;
    let (mut before, mut since) = (Vec::new(), Instant::now());
    loop {
        let there = subscribers(&node, name, kinds);
        let mut processes: Vec<u128> = there.iter().map(|s| s.0).collect();
        processes.dedup();
        if there != before {
            (before, since) = (there, Instant::now());
        } else if processes.len() >= count && since.elapsed() >= SETTLED {
            return Ok(true);
        }
        if control.command() == Some(Command::Quit) {
            return Ok(false);
        }
        std::thread::sleep(NAP);
    }
}

/// Processes and their subscriptions, in order.
fn subscribers(node: &Node<Service>, name: &str, kinds: &[Kind]) -> Vec<(u128, u128)> {
    let mut there = Vec::new();
    for kind in kinds {
        let Ok(service) = domain::service(name, kind.topic()) else { continue };
        let Ok(topic) = node.service_builder(&service).publish_subscribe::<[Block]>().user_header::<Header>().open()
        else {
            continue;
        };
        topic.dynamic_config().list_subscribers(|s| {
            there.push((s.node_id.value(), s.subscriber_id.value()));
            CallbackProgression::Continue
        });
    }
    there.sort_unstable();
    there
}
