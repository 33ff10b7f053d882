//! What can go wrong with a GPU.

use std::fmt;

use crate::NonFinite;

/// A GPU error; the message says what to do next.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter fits the choice.
    #[error(
        "no graphics adapter {wanted}; found: {found}. Install a Vulkan, Metal or DirectX 12 driver \
         (Debian/Ubuntu without a GPU: apt-get install mesa-vulkan-drivers libvulkan1), or see `murano adapters`"
    )]
    NoAdapter {
        /// What was asked for.
        wanted: String,
        /// Names of the adapters there are.
        found: String,
    },
    /// The adapter refused a device.
    #[error("adapter `{adapter}` gave no device: {message}; try another one (`murano adapters`)")]
    NoDevice {
        /// Adapter name.
        adapter: String,
        /// The driver's words.
        message: String,
    },
    /// A shader does not compile: a defect of the program, not of its input.
    #[error("shader `{shader}`: {message}")]
    Shader {
        /// Root module.
        shader: String,
        /// Compiler's words.
        message: String,
    },
    /// A shader's global has no counterpart in its pass, or one of another size.
    #[error("pass `{pass}`, shader `{shader}`: {message}")]
    Binding {
        /// Pass name.
        pass: String,
        /// Root module.
        shader: String,
        /// Which global and what is wrong.
        message: String,
    },
    /// A buffer is larger than the adapter allows.
    #[error(
        "`{name}` needs {bytes} bytes, the adapter allows {limit}; use a smaller picture or map, or fewer triangles"
    )]
    TooLarge {
        /// Buffer name.
        name: String,
        /// Bytes asked for.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// A pass computed other bits than the cache holds: a key lacks an input.
    #[error("pass `{pass}`: output `{output}` differs from the cached one; an input is missing in its key")]
    Stale {
        /// Pass name and instance.
        pass: String,
        /// Output slot.
        output: String,
    },
    /// A pass wrote a NaN or an infinity ([`crate::OutputChecks::NonFinite`]).
    #[error("{0}; no input may lead to this: please report it with the command and the files")]
    NonFinite(NonFinite),
    /// The plan contradicts itself: a defect of the program.
    #[error(transparent)]
    Plan(#[from] murano_scheduler::PlanError),
    /// The device reported an error or was lost.
    #[error("the graphics device failed: {0}; try a smaller picture, or `--adapter software`")]
    Device(String),
}

impl GpuError {
    pub(crate) fn device(error: impl fmt::Display) -> Self {
        Self::Device(error.to_string())
    }
}
