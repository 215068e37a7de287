//! Shared memory set aside at the start: a page that first turns out to be missing at hour nine would kill the run.

use super::SinkError;
use super::publisher::Offer;
use crate::wire::domain::{self, Block};
use std::mem::MaybeUninit;
use std::path::PathBuf;

/// Bytes that a topic needs besides its samples: queues, connections, events, and the rest of the last page.
const MANAGEMENT: u64 = 1 << 18;

/// Whether there is room for what a new reader needs besides the samples. Where there is none, its first message would kill the run.
pub(super) fn room() -> bool {
    domain::free().is_none_or(|free| free >= MANAGEMENT)
}

/// Memory is only set aside when it is first written to, and a write that finds none kills the process: so it is asked for before.
pub(super) fn check_space(offers: &[Offer]) -> Result<(), SinkError> {
    let Some(free) = domain::free() else { return Ok(()) };
    let need = |o: &Offer| (o.max as u64).saturating_mul(o.samples() as u64).saturating_add(MANAGEMENT);
    let need = offers.iter().map(need).fold(0, u64::saturating_add);
    if need <= free { Ok(()) } else { Err(too_small(offers, need, free)) }
}

fn too_small(offers: &[Offer], need: u64, free: u64) -> SinkError {
    let topics = offers.iter().map(|o| o.kind.topic().to_owned()).collect();
    SinkError::SharedMemory { path: PathBuf::from(domain::MEMORY), topics, need, free }
}

/// Has the system set the pages of a sample aside now.
///
/// # Errors
/// If it has none left: something else took them since [`check_space`].
pub(super) fn set_aside(offer: &Offer, sample: &mut [MaybeUninit<Block>]) -> Result<(), SinkError> {
    if populate(sample) {
        return Ok(());
    }
    let need = offer.max as u64 * offer.samples() as u64;
    Err(too_small(&[*offer], need, domain::free().unwrap_or(0)))
}

/// Asks for the pages without writing to them, so that none left is an answer (EFAULT, ENOMEM) and not a signal.
#[cfg(target_os = "linux")]
fn populate(sample: &mut [MaybeUninit<Block>]) -> bool {
    // SAFETY: sysconf has no preconditions. The range lies in a mapping that `sample` borrows exclusively, but for the rest of its
    // first and last page, which this only makes present: no byte changes.
    #[allow(unsafe_code)]
    let answer = unsafe {
        let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096);
        let start = sample.as_mut_ptr().map_addr(|a| a & !(page - 1));
        let length = sample.as_ptr_range().end.addr() - start.addr();
        libc::madvise(start.cast(), length, libc::MADV_POPULATE_WRITE)
    };
    if answer != 0 && std::io::Error::last_os_error().raw_os_error() == Some(libc::EINVAL) {
        return write(sample);
    }
    answer == 0
}

#[cfg(not(target_os = "linux"))]
fn populate(sample: &mut [MaybeUninit<Block>]) -> bool {
    write(sample)
}

/// The way of systems without that question (Linux before 5.14): the check before must have been right.
fn write(sample: &mut [MaybeUninit<Block>]) -> bool {
    sample.fill(MaybeUninit::new(Block([0; 16])));
    true
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::os::fd::AsRawFd;

    /// Behind the end of a file there are no pages, as on a full disk: a write would be answered with SIGBUS.
    #[test]
    #[allow(unsafe_code)]
    fn pages_that_cannot_be_had_are_an_answer_and_no_signal() {
        let file = tempfile::tempfile().unwrap();
        let (page, pages) = (4096, 4);
        file.set_len(2 * page as u64).unwrap();
        let (rights, shared) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_SHARED);
        // SAFETY: a fresh mapping that nobody else has, unmapped at the end; the slices are never read or written here.
        unsafe {
            let map = libc::mmap(std::ptr::null_mut(), pages * page, rights, shared, file.as_raw_fd(), 0);
            assert_ne!(map, libc::MAP_FAILED);
            let sample = |n| std::slice::from_raw_parts_mut(map.cast::<MaybeUninit<Block>>(), n * page / 16);
            if libc::madvise(map, page, libc::MADV_POPULATE_WRITE) == 0 {
                assert!(populate(sample(2)));
                assert!(!populate(sample(3)));
            }
            libc::munmap(map, pages * page);
        }
    }
}
