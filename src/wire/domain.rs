//! Where publishers and subscribers of one user meet: payload type, service names and the shared-memory domain.

use super::Header;
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::{Config, FileName, Path, SemanticString, SemanticStringError, ServiceName, ZeroCopySend};
use iceoryx2::service::service_name::ServiceNameError;

/// Element of a payload. Elements of 16 bytes give payloads an alignment of 16; asking for the alignment of a payload
/// of single bytes would multiply its size instead.
#[repr(C, align(16))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Block(pub [u8; 16]);

// SAFETY: plain bytes without references; every bit pattern is a value; the name fixes the layout across languages.
#[allow(unsafe_code)]
unsafe impl ZeroCopySend for Block {
    unsafe fn type_name() -> &'static str {
        "squirm::Block"
    }
}

// SAFETY: `repr(C)` numbers and arrays without padding or references; every bit pattern is a value.
#[allow(unsafe_code)]
unsafe impl ZeroCopySend for Header {
    unsafe fn type_name() -> &'static str {
        "squirm::SnapshotHeader"
    }
}

/// Event id that wakes subscribers when a snapshot was sent.
pub const EVENT_SENT: usize = 1;
/// Event id that tells subscribers that the publisher has closed.
pub const EVENT_CLOSED: usize = 2;
/// Event id that tells subscribers that the publisher was killed.
pub const EVENT_DIED: usize = 3;

/// Subscribers that one topic can have at a time; the status has [`MAX_WATCHERS`].
pub const MAX_SUBSCRIBERS: usize = 4;
/// Subscribers that the status of a run can have at a time: people look at it from several terminals.
pub const MAX_WATCHERS: usize = 16;
/// Samples that one subscriber may hold at a time.
pub const MAX_BORROWED: usize = 2;
/// Snapshots that wait for a subscriber; the oldest gives way.
pub const BUFFER: usize = 2;
/// Samples for which memory is set aside: what the subscribers hold, the newest that wait (the same ones for all,
/// the history among them), and the one being written.
pub const SAMPLES: usize = MAX_SUBSCRIBERS * MAX_BORROWED + BUFFER + 2;
/// The same where a run waits for slow subscribers: those that wait may then be others for each of them.
pub const SAMPLES_WAITING: usize = MAX_SUBSCRIBERS * (MAX_BORROWED + BUFFER) + 2;
/// The same for the status.
pub const SAMPLES_STATUS: usize = MAX_WATCHERS * MAX_BORROWED + BUFFER + 2;
/// Where shared memory lives on Linux.
pub const MEMORY: &str = "/dev/shm";

/// The shared-memory domain of the current user. It is built here, since a configuration file that happens to lie in
/// the working directory would otherwise redirect it, and since the default domain belongs to whoever came first.
///
/// # Errors
/// If the directory for temporary files has a name that the domain cannot have.
pub fn config() -> Result<Config, SemanticStringError> {
    let uid = user();
    let mut config = Config::default();
    let root = std::env::temp_dir().join(format!("iceoryx2-{uid}"));
    config.global.set_root_path(&Path::new(root.to_string_lossy().as_bytes())?);
    config.global.prefix = FileName::new(format!("squirm{uid}_").as_bytes())?;
    Ok(config)
}

/// Name of the service for one topic of one run.
///
/// # Errors
/// If the run's name is too long.
pub fn service(run: &str, topic: &str) -> Result<ServiceName, ServiceNameError> {
    ServiceName::new(&format!("squirm/{run}/{topic}"))
}

/// The run's name in a service name that [`service`] made for `topic`.
#[must_use]
pub fn run_of<'a>(service: &'a str, topic: &str) -> Option<&'a str> {
    service.strip_prefix("squirm/")?.strip_suffix(topic)?.strip_suffix('/')
}

/// Bytes of shared memory that are free; `None` where the system keeps it elsewhere.
#[must_use]
pub fn free() -> Option<u64> {
    free_in(std::path::Path::new(MEMORY))
}

/// Bytes that are free for this user in the file system of a folder; `None` where the system does not tell.
#[cfg(unix)]
#[must_use]
pub fn free_in(folder: &std::path::Path) -> Option<u64> {
    let path = std::ffi::CString::new(folder.as_os_str().as_encoded_bytes()).ok()?;
    // SAFETY: `path` ends with a zero byte, and `stat` is a plain structure that statvfs fills.
    #[allow(unsafe_code)]
    let (status, stat) = unsafe {
        let mut stat: libc::statvfs = std::mem::zeroed();
        (libc::statvfs(path.as_ptr(), &raw mut stat), stat)
    };
    #[allow(clippy::unnecessary_cast)]
    (status == 0).then(|| (stat.f_bavail as u64).saturating_mul(stat.f_frsize as u64))
}

/// Bytes that are free for this user in the file system of a folder; `None` where the system does not tell.
#[cfg(not(unix))]
#[must_use]
pub fn free_in(_folder: &std::path::Path) -> Option<u64> {
    None
}

#[cfg(unix)]
fn user() -> u32 {
    // SAFETY: getuid has no preconditions and cannot fail.
    #[allow(unsafe_code)]
    unsafe {
        libc::getuid()
    }
}

#[cfg(not(unix))]
fn user() -> u32 {
    0
}
