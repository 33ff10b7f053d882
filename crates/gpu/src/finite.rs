//! The debug check after every pass: whether any number that it wrote is NaN or infinite, found on the device.
//!
//! Which words of a buffer are floats is what the shader that writes it says of the buffer's type; integers and atomics
//! may hold any bits.

use std::{collections::HashMap, fmt, sync::Arc};

use wgpu::util::DeviceExt;

use crate::{
    Gpu, GpuError, Groups, Shader, ShaderSpec,
    pass::{Dispatch, Recording},
    store::Resource,
};

/// Words that a workgroup of `gpu::non_finite` looks at.
const WORDS_A_GROUP: u32 = 64 * 16;

/// What is checked of the outputs of passes, beyond their sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputChecks {
    /// Nothing.
    #[default]
    Off,
    /// That every float in every output of every pass that runs is finite.
    NonFinite,
}

/// Numbers in an output that are NaN or infinite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NonFinite {
    /// Pass name.
    pub pass: &'static str,
    /// Pass instance.
    pub instance: u32,
    /// Output slot.
    pub output: &'static str,
    /// How many numbers.
    pub count: u32,
    /// Array element that holds the first of them.
    pub element: u32,
    /// Its word within the element.
    pub word: u32,
}

impl fmt::Display for NonFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pass, instance, output, count, element, word } = self;
        let numbers = if *count == 1 { "number that is" } else { "numbers that are" };
        write!(
            f,
            "pass `{pass}:{instance}`: output `{output}` holds {count} {numbers} NaN or infinite, \
             the first in element {element}, word {word}"
        )
    }
}

/// One output that is looked at.
struct Checked {
    pass: &'static str,
    instance: u32,
    output: &'static str,
    stride: u32,
}

/// The checks of one frame.
pub(crate) struct FiniteChecks {
    shader: Arc<Shader>,
    /// As `gpu::non_finite` describes it.
    pub(crate) findings: wgpu::Buffer,
    checked: Vec<Checked>,
}

impl FiniteChecks {
    /// Room for the findings of at most `outputs` outputs.
    pub(crate) fn new(gpu: &Gpu, outputs: usize) -> Result<Self, GpuError> {
        let findings = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("findings"),
            size: 8 * outputs.max(1) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Ok(Self { shader: gpu.shader(&ShaderSpec::new("gpu::non_finite"))?, findings, checked: Vec::new() })
    }

    /// Records the checks of what a pass wrote into the buffers `named`.
    pub(crate) fn record(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (name, instance): (&'static str, u32),
        recording: &Recording,
        named: &HashMap<&'static str, Resource>,
    ) -> Result<(), GpuError> {
        for target in &recording.outputs {
            let Some(floats) = recording.floats_of(target.name) else { continue };
            let Some(words @ Resource::Buffer(buffer)) = named.get(target.name) else { continue };
            let count = (buffer.size() / 4) as u32;
            let mut check = vec![self.checked.len() as u32, count, floats.len() as u32];
            check.extend(floats.iter().map(|is_float| u32::from(*is_float)));
            let check = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("check"),
                contents: bytemuck::cast_slice(&check),
                usage: wgpu::BufferUsages::STORAGE,
            });
            let bound = HashMap::from([
                ("check", Resource::Buffer(check)),
                ("words", words.clone()),
                ("findings", Resource::Buffer(self.findings.clone())),
            ]);
            let groups = Groups::linear(count as usize, WORDS_A_GROUP);
            let dispatch = Dispatch { shader: Arc::clone(&self.shader), entry: "main", groups };
            gpu.dispatch_alone(encoder, "check", &dispatch, &bound)?;
            self.checked.push(Checked { pass: name, instance, output: target.name, stride: floats.len() as u32 });
        }
        Ok(())
    }

    /// The first output with a number that is not finite, in the order in which passes ran.
    pub(crate) fn first(&self, findings: &[u8]) -> Option<NonFinite> {
        let found = findings.chunks_exact(8).map(bytemuck::pod_read_unaligned::<[u32; 2]>);
        self.checked.iter().zip(found).find(|(_, [count, _])| *count > 0).map(|(checked, [count, inverted])| {
            NonFinite {
                pass: checked.pass,
                instance: checked.instance,
                output: checked.output,
                count,
                element: !inverted / checked.stride,
                word: !inverted % checked.stride,
            }
        })
    }
}

impl Recording {
    /// Which words of an element of an output are floats, as the last dispatch that writes it has it; `None` if none are.
    fn floats_of(&self, output: &str) -> Option<&[bool]> {
        let globals = self.dispatches.iter().rev().filter_map(|dispatch| dispatch.shader.entries.get(dispatch.entry));
        let written = globals.flatten().find(|global| global.name == output && global.written)?;
        Some(written.floats.as_slice()).filter(|floats| floats.contains(&true))
    }
}

/// Which words of a type are floats: of an element, for a runtime-sized array; `None` for a struct that ends in one, whose
/// words follow no period.
pub(crate) fn float_words(module: &naga::Module, ty: naga::Handle<naga::Type>) -> Option<Vec<bool>> {
    use naga::TypeInner;
    let words = |scalar: naga::Scalar, count: usize| {
        vec![scalar.kind == naga::ScalarKind::Float; count * usize::from(scalar.width) / 4]
    };
    let mut floats = match &module.types[ty].inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => words(*scalar, 1),
        TypeInner::Vector { size, scalar } => words(*scalar, *size as usize),
        TypeInner::Matrix { columns, rows, scalar } => {
            let mut column = words(*scalar, *rows as usize);
            column.resize(if *rows == naga::VectorSize::Bi { 2 } else { 4 }, false);
            column.repeat(*columns as usize)
        }
        TypeInner::Array { base, size, stride } => {
            let mut element = float_words(module, *base)?;
            element.resize(*stride as usize / 4, false);
            match size {
                naga::ArraySize::Constant(count) => element.repeat(count.get() as usize),
                _ => element,
            }
        }
        TypeInner::Struct { members, span } => {
            let mut floats = vec![false; *span as usize / 4];
            for member in members {
                if matches!(&module.types[member.ty].inner, TypeInner::Array { size: naga::ArraySize::Dynamic, .. }) {
                    return None;
                }
                let of_member = float_words(module, member.ty)?;
                floats[member.offset as usize / 4..][..of_member.len()].copy_from_slice(&of_member);
            }
            floats
        }
        _ => Vec::new(),
    };
    floats.resize(floats.len().max(1), false);
    Some(floats)
}
