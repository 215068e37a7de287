//! The only room that knows wgpu: adapters, buffers, kernels, and the encoding of steps.

pub mod adapter;
mod buffers;
mod copy;
mod demand;
mod fused;
pub mod kernel;
mod layout;
mod loose;
pub mod measure;
mod neighbours;
mod persistent;
pub mod session;

pub use adapter::{Gpu, adapters};
pub use copy::Copied;
pub use measure::{Measurement, Reading};
pub use session::{Form, Session};

/// What can go wrong on the GPU.
#[derive(Debug, Clone, thiserror::Error)]
pub enum GpuError {
    /// No adapter at all.
    #[error(
        "no Vulkan, Metal or DX12 adapter was found; a CPU does as well: install Mesa's lavapipe (Debian: `apt-get install libvulkan1 mesa-vulkan-drivers`)"
    )]
    NoAdapter,
    /// None that answers to the name asked for.
    #[error("no adapter is called or numbered `{wanted}`; there are: {present}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// What there is.
        present: String,
    },
    /// The adapter lacks something that every kernel needs.
    #[error("adapter `{adapter}` has no {feature}, which the kernels need")]
    Lacking {
        /// Its name.
        adapter: String,
        /// What it lacks.
        feature: &'static str,
    },
    /// The device could not be opened.
    #[error("adapter `{adapter}` could not be opened: {message}")]
    Open {
        /// Its name.
        adapter: String,
        /// The driver's message.
        message: String,
    },
    /// A kernel would have to bind more buffers than the adapter allows, since those of this run are in so many parts.
    #[error(
        "kernel `{kernel}` needs {needed} buffers of up to {part} bytes, but `{adapter}` binds {most} at most: make the box smaller or choose another adapter"
    )]
    TooLarge {
        /// The kernel's name.
        kernel: String,
        /// Buffers that it would have to bind.
        needed: u64,
        /// Bytes of the largest.
        part: u64,
        /// Buffers that the adapter binds.
        most: u32,
        /// The adapter's name.
        adapter: String,
    },
    /// A snapshot is larger than the adapter can copy to the host.
    #[error(
        "a snapshot of {bytes} bytes is larger than what `{adapter}` copies at a time, {most}: take a smaller `fraction`"
    )]
    LargeSnapshot {
        /// What it needs.
        bytes: u64,
        /// What the adapter has.
        most: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// Memory ran out while creating buffers.
    #[error(
        "`{adapter}` has no memory left for {bytes} bytes of buffers: make the box smaller or choose another adapter"
    )]
    OutOfMemory {
        /// What all buffers need.
        bytes: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// A checkpoint's buffer that does not belong to this plan.
    #[error("buffer `{buffer}` of the checkpoint has {found} bytes, but this program needs {expected}")]
    Foreign {
        /// The buffer's name.
        buffer: String,
        /// Bytes in the checkpoint.
        found: u64,
        /// Bytes that the catalogue says.
        expected: u64,
    },
    /// A shader does not compose or validate.
    #[error(transparent)]
    Shader(#[from] crate::shader::ShaderError),
    /// The device stopped answering.
    #[error("the GPU was lost or refused work: {0}")]
    Lost(String),
}
