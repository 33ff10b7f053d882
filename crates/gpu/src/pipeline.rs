//! Compute pipelines and bind groups by name.

use std::{borrow::Cow, collections::HashMap};

use murano_scheduler::Stamp;

use crate::{
    GpuError,
    hoist::read_first,
    pass::Dispatch,
    shader::{Global, GlobalKind},
    store::Resource,
};

pub(crate) struct Pipelines {
    compiled: HashMap<(Stamp, &'static str), wgpu::ComputePipeline>,
    sampler: wgpu::Sampler,
    /// Of a software adapter.
    software: bool,
}

impl Pipelines {
    pub(crate) fn new(device: &wgpu::Device, software: bool) -> Self {
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("linear, u repeats, v clamped"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::ClampToEdge,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Self { compiled: HashMap::new(), sampler, software }
    }

    pub(crate) fn get(&mut self, device: &wgpu::Device, dispatch: &Dispatch) -> wgpu::ComputePipeline {
        let shader = &dispatch.shader;
        self.compiled
            .entry((shader.stamp, dispatch.entry))
            .or_insert_with(|| {
                // Compilers for real GPUs know best what to hold, and where.
                let module = if self.software { read_first(shader, dispatch.entry) } else { shader.module.clone() };
                let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(shader.name),
                    source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
                });
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(shader.name),
                    layout: None,
                    module: &module,
                    entry_point: Some(dispatch.entry),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        // Outputs and scratch are cleared where a pass asks for it; workgroup memory is written first.
                        zero_initialize_workgroup_memory: false,
                        ..wgpu::PipelineCompilationOptions::default()
                    },
                    cache: None,
                })
            })
            .clone()
    }

    /// Binds every global that the entry point uses to the resource of its name.
    pub(crate) fn bind(
        &self,
        device: &wgpu::Device,
        pipeline: &wgpu::ComputePipeline,
        pass: &str,
        dispatch: &Dispatch,
        named: &HashMap<&'static str, Resource>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let wrong =
            |message: String| GpuError::Binding { pass: pass.into(), shader: dispatch.shader.name.into(), message };
        let globals = dispatch
            .shader
            .entries
            .get(dispatch.entry)
            .ok_or_else(|| wrong(format!("no entry point `{}`", dispatch.entry)))?;
        let mut views = Vec::new();
        for global in globals {
            if let Some(Resource::Texture(texture, _)) = named.get(global.name.as_str()) {
                views.push((global.binding, texture.create_view(&wgpu::TextureViewDescriptor::default())));
            }
        }
        let entries = globals
            .iter()
            .map(|global| {
                Ok(wgpu::BindGroupEntry {
                    binding: global.binding,
                    resource: self.resource(global, named, &views).map_err(&wrong)?,
                })
            })
            .collect::<Result<Vec<_>, GpuError>>()?;
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(dispatch.shader.name),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        }))
    }

    fn resource<'a>(
        &'a self,
        global: &Global,
        named: &'a HashMap<&'static str, Resource>,
        views: &'a [(u32, wgpu::TextureView)],
    ) -> Result<wgpu::BindingResource<'a>, String> {
        if global.kind == GlobalKind::Sampler {
            return Ok(wgpu::BindingResource::Sampler(&self.sampler));
        }
        let resource =
            named.get(global.name.as_str()).ok_or_else(|| format!("the pass has nothing named `{}`", global.name))?;
        match (resource, global.kind) {
            (Resource::Value(buffer), GlobalKind::Uniform { bytes } | GlobalKind::Storage { bytes })
                if buffer.size() != bytes.next_multiple_of(16) =>
            {
                Err(format!("value `{}` has {} bytes, the shader wants {bytes}", global.name, buffer.size()))
            }
            (Resource::Value(buffer), GlobalKind::Uniform { .. } | GlobalKind::Storage { .. })
            | (Resource::Buffer(buffer), GlobalKind::Storage { .. }) => Ok(buffer.as_entire_binding()),
            (Resource::Texture(..), GlobalKind::Texture) => views
                .iter()
                .find(|(binding, _)| *binding == global.binding)
                .map(|(_, view)| wgpu::BindingResource::TextureView(view))
                .ok_or_else(|| format!("texture `{}` has no view", global.name)),
            _ => Err(format!("`{}` is of another kind than the shader's", global.name)),
        }
    }
}
