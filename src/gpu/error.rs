//! Why there is no picture from a GPU.

use crate::frame::RenderError;
use crate::limits::LimitError;

/// Why the device did not do its work. Nothing is ever drawn elsewhere instead.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter at all: no driver, or no loader.
    #[error("no GPU adapter was found")]
    NoAdapter,
    /// Only adapters that compute on the processor, which were not asked for.
    #[error("the only GPU adapters are software ({names}); --allow-software-gpu draws with them")]
    SoftwareOnly {
        /// Their names.
        names: String,
    },
    /// No adapter of that name.
    #[error("no GPU adapter is called {wanted:?}; there are: {names}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// Those there are.
        names: String,
    },
    /// The device cannot be opened, or was lost.
    #[error("the GPU device failed: {reason}")]
    Device {
        /// What the driver says.
        reason: String,
    },
    /// The device has not got the memory.
    #[error("the GPU has not enough memory for {what}")]
    OutOfMemory {
        /// What for.
        what: &'static str,
    },
    /// Something that this backend does not draw.
    #[error("the GPU backend does not draw {what}")]
    Unsupported {
        /// What.
        what: &'static str,
    },
    /// A table that a face needs is missing: an error in this backend.
    #[error("the GPU backend has no {what}")]
    Missing {
        /// What is missing.
        what: &'static str,
    },
    /// A budget was reached.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The picture is impossible on any backend.
    #[error(transparent)]
    Render(#[from] RenderError),
}
