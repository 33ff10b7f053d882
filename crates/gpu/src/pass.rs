//! Compute passes as values: what they read, what they write, and the dispatches in between.

use std::sync::Arc;

use encase::{ShaderType, internal::WriteInto};
use murano_scheduler::{Output, Pass, Plan, PlanError, Stamp, StampBuilder};

use crate::{Shader, value_bytes};

/// A 2D texture of half floats with its mip chain, sampled linearly; repeats along u, is clamped along v.
#[derive(Clone, Debug)]
pub struct TextureData {
    /// Width and height of level 0.
    pub size: [u32; 2],
    /// RGBA half-float bits of each level, tightly packed, level 0 first.
    pub levels: Vec<Vec<u16>>,
}

/// Data that enters a plan by value.
#[derive(Clone, Debug)]
pub enum Leaf {
    /// Bytes of a storage buffer.
    Buffer(Arc<[u8]>),
    /// A sampled texture.
    Texture(Arc<TextureData>),
}

/// What the scheduler carries for the executor.
#[derive(Clone)]
pub enum Work {
    /// Upload on first use.
    Leaf(Leaf),
    /// Dispatches to record.
    Compute(Recording),
}

/// Number of workgroups of a dispatch.
#[derive(Clone, Copy, Debug)]
pub enum Groups {
    /// Known on the CPU.
    Direct([u32; 3]),
    /// Three u32 at a byte offset of the named buffer (an input, an output or scratch).
    Indirect(&'static str, u64),
}

impl Groups {
    /// Enough workgroups of `size` threads for `threads` threads, in rows of at most 32768 workgroups; shaders compute
    /// their index as `id.x + id.y * 32768 * size`.
    pub fn linear(threads: usize, size: u32) -> Self {
        const ROW: u32 = 32_768;
        let groups = (threads as u64).div_ceil(u64::from(size)).max(1) as u32;
        Self::Direct([groups.min(ROW), groups.div_ceil(ROW), 1])
    }

    /// Workgroups of 8x8 threads that cover an image.
    pub fn tiles(size: [u32; 2]) -> Self {
        Self::Direct([size[0].div_ceil(8).max(1), size[1].div_ceil(8).max(1), 1])
    }
}

#[derive(Clone)]
pub(crate) struct Dispatch {
    pub shader: Arc<Shader>,
    pub entry: &'static str,
    pub groups: Groups,
}

/// A buffer that the pass writes.
#[derive(Clone)]
pub(crate) struct Target {
    pub name: &'static str,
    pub bytes: u64,
    pub cleared: bool,
}

/// The dispatches of one pass and the buffers they need besides its inputs.
#[derive(Clone, Default)]
pub struct Recording {
    pub(crate) values: Vec<(&'static str, Vec<u8>)>,
    pub(crate) outputs: Vec<Target>,
    pub(crate) scratch: Vec<Target>,
    pub(crate) dispatches: Vec<Dispatch>,
}

/// Declares one pass of a plan.
///
/// ```text
/// ComputePass::new("deform", 0).value("params", &params).input("palette", palette)
///     .output("positions", bytes).dispatch(&shader, "main", Groups::linear(n, 64)).add_to(&mut plan)?
/// ```
pub struct ComputePass {
    name: &'static str,
    instance: u32,
    subject: u32,
    inputs: Vec<(&'static str, Output)>,
    recording: Recording,
}

impl ComputePass {
    /// A pass; `instance` tells passes of one name apart.
    pub fn new(name: &'static str, instance: u32) -> Self {
        Self { name, instance, subject: instance, inputs: Vec::new(), recording: Recording::default() }
    }

    /// The pass does at another moment what the pass of that instance does now: what one has left, the other finds.
    #[must_use]
    pub fn about(mut self, subject: u32) -> Self {
        self.subject = subject;
        self
    }

    /// Parameters by value; they enter the key.
    ///
    /// Shaders declare them `var<storage, read>`: lavapipe compiles a shader anew whenever a uniform that its control
    /// flow depends on may have changed, which costs more than most passes.
    #[must_use]
    pub fn value<T: ShaderType + WriteInto>(mut self, name: &'static str, value: &T) -> Self {
        let mut bytes = value_bytes(value);
        bytes.resize(bytes.len().next_multiple_of(16), 0);
        self.recording.values.push((name, bytes));
        self
    }

    /// A buffer or texture that another pass or a leaf provides.
    #[must_use]
    pub fn input(mut self, name: &'static str, output: Output) -> Self {
        self.inputs.push((name, output));
        self
    }

    /// A buffer that this pass provides; every byte that others read must be written.
    #[must_use]
    pub fn output(mut self, name: &'static str, bytes: u64) -> Self {
        // What pads it is compared with the rest when a pass is verified.
        let stored = padded(bytes);
        self.recording.outputs.push(Target { name, bytes: stored, cleared: stored != bytes });
        self
    }

    /// A buffer that this pass provides, zero before its first dispatch.
    #[must_use]
    pub fn cleared_output(mut self, name: &'static str, bytes: u64) -> Self {
        self.recording.outputs.push(Target { name, bytes: padded(bytes), cleared: true });
        self
    }

    /// A buffer that lives for this pass only, zero before its first dispatch.
    #[must_use]
    pub fn scratch(mut self, name: &'static str, bytes: u64) -> Self {
        self.recording.scratch.push(Target { name, bytes: padded(bytes), cleared: true });
        self
    }

    /// A buffer that lives for this pass only and holds anything before its first dispatch.
    #[must_use]
    pub fn workspace(mut self, name: &'static str, bytes: u64) -> Self {
        self.recording.scratch.push(Target { name, bytes: padded(bytes), cleared: false });
        self
    }

    /// A dispatch of an entry point; dispatches run in order and see each other's writes.
    #[must_use]
    pub fn dispatch(mut self, shader: &Arc<Shader>, entry: &'static str, groups: Groups) -> Self {
        self.recording.dispatches.push(Dispatch { shader: Arc::clone(shader), entry, groups });
        self
    }

    /// Adds the pass to a plan and returns its outputs in the order of their declaration.
    ///
    /// # Errors
    /// [`PlanError`] if the plan has a pass of this name and instance.
    pub fn add_to(self, plan: &mut Plan<Work>) -> Result<Vec<Output>, PlanError> {
        let mut code = StampBuilder::new("compute");
        for dispatch in &self.recording.dispatches {
            code.stamp(dispatch.shader.stamp).text(dispatch.entry);
            match dispatch.groups {
                Groups::Direct(groups) => code.bytes(bytemuck::bytes_of(&groups)),
                Groups::Indirect(name, offset) => code.text(name).number(offset),
            };
        }
        plan.add(Pass {
            name: self.name,
            instance: self.instance,
            subject: self.subject,
            code: code.finish(),
            params: self.recording.values.clone(),
            inputs: self.inputs,
            outputs: self
                .recording
                .outputs
                .iter()
                .map(|target| (target.name, target.bytes.to_le_bytes().to_vec()))
                .collect(),
            work: Work::Compute(self.recording),
        })
    }
}

impl Leaf {
    /// A storage buffer of plain values, hashed now.
    pub fn of<T: bytemuck::NoUninit>(values: &[T]) -> (Stamp, Self) {
        let mut bytes = bytemuck::cast_slice::<T, u8>(values).to_vec();
        bytes.resize(padded(bytes.len() as u64) as usize, 0);
        (Stamp::of(&bytes), Self::Buffer(bytes.into()))
    }
}

/// Storage buffers hold whole vec4s and at least one element of any struct, so that empty lists bind too.
fn padded(bytes: u64) -> u64 {
    bytes.max(64).next_multiple_of(16)
}
