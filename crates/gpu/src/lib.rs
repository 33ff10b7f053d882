//! The GPU without the domain: adapters, the shader library, compute passes declared by name, a content-addressed store
//! of their outputs, and the executor of a scheduler's plan.
//!
//! Every pass is compute. A shader's global variables are bound *by name*: `positions` in WGSL is the pass's input,
//! output, scratch buffer or uniform called `positions`, so that a binding is defined once, in the shader.

mod adapter;
mod error;
mod executor;
mod finite;
mod hoist;
mod layout;
mod pass;
mod pipeline;
mod shader;
mod store;

pub use adapter::{AdapterChoice, AdapterReport, Gpu};
pub use error::GpuError;
pub use executor::{Executed, StepTime};
pub use finite::{NonFinite, OutputChecks};
pub use layout::{LayoutError, StructLayout, value_bytes};
pub use pass::{ComputePass, Groups, Leaf, TextureData, Work};
pub use shader::{Shader, ShaderSpec};
