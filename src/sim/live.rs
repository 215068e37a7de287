//! How a run is seen from outside while it goes: the name under which it is known, and what its status says.

use super::frames::Frame;
use super::summary::Speed;
use super::{Options, RunError};
use crate::gpu::Session;
use crate::graph::Plan;
use crate::sink::{Beacon, Counters, Now};
use crate::wire::{Stamp, Status};
use std::sync::{Arc, OnceLock};
use std::time::{SystemTime, UNIX_EPOCH};

/// The outside view of one run; without one where the file or the system does not allow it.
#[derive(Default)]
pub struct Live {
    beacon: Option<Beacon>,
    counters: OnceLock<Arc<Counters>>,
}

impl Live {
    /// Takes a name and begins to tell how the run is.
    ///
    /// # Errors
    /// If shared memory cannot be used although outputs are to be published; otherwise that is only a warning.
    pub fn open(plan: &Plan, options: &Options, session: &Session, run_id: [u8; 16]) -> Result<Self, RunError> {
        if !plan.system.run.live {
            return Ok(Self::default());
        }
        let domain = &plan.system.domain;
        let stamp =
            Stamp { run_id, box_size: domain.size.map(f64::from), walls: domain.walls.is_some(), ..Stamp::default() };
        let status = Status {
            pid: std::process::id(),
            started: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64(),
            steps: plan.system.run.steps,
            particles: session.particles(),
            temperature: f64::NAN,
            swim_speed: f64::NAN,
            phase: Status::RUNNING.into(),
            adapter: session.adapter(),
            folder: std::path::absolute(&options.out).unwrap_or_else(|_| options.out.clone()).display().to_string(),
            ..Status::default()
        };
        match Beacon::light(&plan.name, Now { stamp, status }) {
            Ok(beacon) => Ok(Self { beacon: Some(beacon), ..Self::default() }),
            Err(error) if plan.outputs.iter().all(|o| o.publish.is_empty()) => {
                tracing::warn!("this run cannot be watched: {error}");
                Ok(Self::default())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The name under which the run can be watched, if it can.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.beacon.as_ref().map(Beacon::name)
    }

    /// Where published messages are counted.
    pub fn count(&self, counters: Arc<Counters>) {
        let _ = self.counters.set(counters);
    }

    /// So many steps are done; their mean times are these.
    pub fn progress(&self, step: u64, time: f64, speed: &Speed) {
        let Some(beacon) = &self.beacon else { return };
        let mut now = beacon.now();
        (now.stamp.step, now.stamp.time) = (step, time);
        now.status.stages.clear();
        now.status.stages.extend(speed.stages.iter().map(|s| (s.stage.clone(), s.nanoseconds)));
        if let Some(counters) = self.counters.get() {
            (now.status.published, now.status.dropped) = (counters.published(), counters.dropped());
            let longest = counters.take_longest().as_secs_f64();
            now.status.longest_publication = now.status.longest_publication.max(longest);
        }
    }

    /// A frame has arrived; `fluid` says whether it has the fluid's totals.
    pub fn frame(&self, frame: &Frame, fluid: bool) {
        let Some(beacon) = &self.beacon else { return };
        let mut now = beacon.now();
        if fluid && frame.totals.temperature > 0.0 {
            now.status.temperature = frame.totals.temperature;
        }
        if !frame.squirmers.is_empty() {
            now.status.swim_speed = frame.swim_speed();
        }
    }

    /// The run is over.
    pub fn end(self, error: Option<&RunError>) {
        if let Some(beacon) = &self.beacon {
            beacon.now().status.phase = error.map_or(Status::ENDED.into(), |e| format!("failed: {e}"));
        }
    }
}
