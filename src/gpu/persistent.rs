//! What a run on a GPU needs to go on: the buffers that carry state from step to step, read back and put in place again.

use super::session::{Form, Session};
use super::{Gpu, GpuError};
use crate::buffers::{Buffer, CATALOGUE, Life};
use crate::graph::Plan;

impl Session {
    fn carried(&self) -> impl Iterator<Item = (&'static Buffer, usize)> + '_ {
        let there = CATALOGUE.iter().filter(|b| b.life == Life::Persistent && self.buffers.has(b.name));
        there.map(|b| (b, usize::try_from(self.sizes.bytes(b)).expect("a buffer fits in memory")))
    }

    /// Names and contents of the buffers that carry state from step to step; waits for the GPU.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn persistent(&self) -> Result<Vec<(&'static str, Vec<u8>)>, GpuError> {
        let read = |(buffer, bytes): (&'static Buffer, usize)| {
            let mut content = self.read::<u8>(buffer.name)?;
            // A buffer is rounded up.
            content.truncate(bytes);
            Ok((buffer.name, content))
        };
        self.carried().map(read).collect()
    }

    /// A session of so many particles that goes on where another was when [`Session::persistent`] was read, after `step` steps. The
    /// state will be that of the other in every bit.
    ///
    /// # Errors
    /// If the buffers are not those of this plan in this form, or as for [`Session::new`].
    pub fn resumed(
        gpu: &Gpu,
        plan: &Plan,
        (particles, step): (u64, u64),
        form: Form,
        buffers: &[(&str, &[u8])],
    ) -> Result<Self, GpuError> {
        let length = |name: &str| buffers.iter().find(|(n, _)| *n == name).map_or(0, |(_, bytes)| bytes.len() as u64);
        let found = buffers.iter().find(|(n, _)| *n == "particles").map_or(&[][..], |(_, bytes)| bytes);
        let expected = particles * 16;
        if found.len() as u64 != expected {
            return Err(GpuError::Foreign { buffer: "particles".into(), found: found.len() as u64, expected });
        }
        let row: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(found);
        let session = Self::empty(gpu, plan, (&row, step), (form, 0))?;
        for (buffer, bytes) in session.carried() {
            let (found, expected) = (length(buffer.name), bytes as u64);
            if found != expected {
                return Err(GpuError::Foreign { buffer: buffer.name.into(), found, expected });
            }
        }
        for (name, content) in buffers {
            if !session.carried().any(|(b, _)| b.name == *name) {
                return Err(GpuError::Foreign { buffer: (*name).into(), found: content.len() as u64, expected: 0 });
            }
            session.write(name, content);
        }
        gpu.healthy()?;
        Ok(session)
    }

    /// Loses the device, as a crashed driver does: what tests of such a loss need.
    pub fn lose(&self) {
        self.gpu.device.destroy();
    }
}
