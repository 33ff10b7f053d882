//! The shader library: WESL modules linked into WGSL, validated and reflected by naga, kept by specification.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex},
};

use murano_scheduler::Stamp;
use wesl::{CompileOptions, Feature, ManglerKind, ModulePath, VirtualResolver, Wesl};

use crate::{GpuError, StructLayout, adapter::STORAGE_BUFFERS, finite::float_words};

const SOURCES: &[(&str, &str)] = &include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// What to link: a root module, which module stands in for each alias, and which features are on.
///
/// An alias is how a method is chosen: `package::refraction::method` resolves to the module of the method asked for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ShaderSpec {
    /// Root module, e.g. `refraction::refract`.
    pub root: &'static str,
    /// Alias module and the module it stands for.
    pub aliases: Vec<(&'static str, &'static str)>,
    /// Features for `@if(...)` that are on.
    pub features: Vec<&'static str>,
}

impl ShaderSpec {
    /// A root module with no alias and no feature.
    pub fn new(root: &'static str) -> Self {
        Self { root, aliases: Vec::new(), features: Vec::new() }
    }

    /// Lets `alias` resolve to `module`.
    #[must_use]
    pub fn alias(mut self, alias: &'static str, module: &'static str) -> Self {
        self.aliases.push((alias, module));
        self
    }

    /// Switches a feature on or leaves it off.
    #[must_use]
    pub fn feature(mut self, feature: &'static str, on: bool) -> Self {
        if on {
            self.features.push(feature);
        }
        self
    }
}

/// How a global variable of a shader is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GlobalKind {
    Uniform {
        bytes: u64,
    },
    /// `bytes`: of the store type, for a runtime-sized array of one element.
    Storage {
        bytes: u64,
    },
    Texture,
    Sampler,
}

/// A global variable of a shader.
#[derive(Clone, Debug)]
pub(crate) struct Global {
    pub name: String,
    pub binding: u32,
    pub kind: GlobalKind,
    /// Whether the entry point writes to it.
    pub written: bool,
    /// Which words of it are floats (of an element, for a runtime-sized array).
    pub floats: Vec<bool>,
}

/// A linked shader: its stamp, its code and its interface.
pub struct Shader {
    /// Root module.
    pub name: &'static str,
    /// Hash of its linked WGSL.
    pub stamp: Stamp,
    /// Layout of every named struct.
    pub structs: Vec<StructLayout>,
    /// The linked WGSL, parsed.
    pub(crate) module: naga::Module,
    /// Globals that each entry point uses.
    pub(crate) entries: HashMap<String, Vec<Global>>,
}

/// Linked shaders by specification.
#[derive(Default)]
pub(crate) struct ShaderLibrary {
    linked: Mutex<HashMap<ShaderSpec, Arc<Shader>>>,
}

impl crate::Gpu {
    /// The shader of a specification, linked at first use.
    ///
    /// # Errors
    /// [`GpuError::Shader`] if it does not link or validate.
    pub fn shader(&self, spec: &ShaderSpec) -> Result<Arc<Shader>, GpuError> {
        let mut linked = self.shaders.linked.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(shader) = linked.get(spec) {
            return Ok(Arc::clone(shader));
        }
        let shader = Arc::new(Shader::link(spec)?);
        linked.insert(spec.clone(), Arc::clone(&shader));
        Ok(shader)
    }
}

impl Shader {
    /// Links and reflects a specification; needs no device.
    ///
    /// # Errors
    /// [`GpuError::Shader`] if it does not link or validate, or uses more buffers than there may be.
    pub fn link(spec: &ShaderSpec) -> Result<Self, GpuError> {
        let shader = reflect(spec.root, linked_wgsl(spec)?)?;
        for (entry, globals) in &shader.entries {
            let buffers = globals.iter().filter(|it| matches!(it.kind, GlobalKind::Storage { .. })).count();
            if buffers > STORAGE_BUFFERS as usize {
                let message = format!("`{entry}` uses {buffers} storage buffers; there may be {STORAGE_BUFFERS}");
                return Err(GpuError::Shader { shader: spec.root.into(), message });
            }
        }
        Ok(shader)
    }
}

fn linked_wgsl(spec: &ShaderSpec) -> Result<String, GpuError> {
    let failed = |message: String| GpuError::Shader { shader: spec.root.into(), message };
    let path = |module: &str| format!("package::{module}").parse::<ModulePath>().map_err(|e| failed(e.to_string()));
    let mut resolver = VirtualResolver::new();
    for (module, source) in SOURCES {
        resolver.add_module(path(module)?, (*source).into());
    }
    for (alias, module) in &spec.aliases {
        let (_, source) = SOURCES
            .iter()
            .find(|(name, _)| name == module)
            .ok_or_else(|| failed(format!("no module `{module}` for alias `{alias}`")))?;
        resolver.add_module(path(alias)?, (*source).into());
    }
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
    let mut options = CompileOptions { validate: false, ..CompileOptions::default() };
    options.features.default = Feature::Disable;
    for feature in &spec.features {
        options.features.flags.insert((*feature).into(), Feature::Enable);
    }
    compiler.set_options(options);
    // Globals keep their names, because passes bind them by name; naga refuses the duplicates this could let through.
    compiler.set_mangler(ManglerKind::None);
    Ok(compiler.compile(&path(spec.root)?).map_err(|error| failed(error.to_string()))?.to_string())
}

pub(crate) fn reflect(name: &'static str, wgsl: String) -> Result<Shader, GpuError> {
    let failed = |message: String| GpuError::Shader { shader: name.into(), message };
    let module = naga::front::wgsl::parse_str(&wgsl).map_err(|error| failed(error.emit_to_string(&wgsl)))?;
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default())
        .validate(&module)
        .map_err(|error| failed(error.emit_to_string(&wgsl)))?;
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|error| failed(error.to_string()))?;
    let mut entries = HashMap::new();
    for (index, entry) in module.entry_points.iter().enumerate() {
        let used = info.get_entry_point(index);
        let mut globals = Vec::new();
        for (handle, variable) in module.global_variables.iter() {
            let (Some(binding), false) = (&variable.binding, used[handle].is_empty()) else { continue };
            let kind = match (variable.space, &module.types[variable.ty].inner) {
                (naga::AddressSpace::Uniform, _) => {
                    GlobalKind::Uniform { bytes: u64::from(layouter[variable.ty].to_stride()) }
                }
                (naga::AddressSpace::Storage { .. }, _) => {
                    GlobalKind::Storage { bytes: u64::from(layouter[variable.ty].to_stride()) }
                }
                (_, naga::TypeInner::Sampler { .. }) => GlobalKind::Sampler,
                _ => GlobalKind::Texture,
            };
            let name = variable.name.clone().unwrap_or_default();
            let written = used[handle].contains(naga::valid::GlobalUse::WRITE);
            let floats = match float_words(&module, variable.ty) {
                Some(floats) => floats,
                None if written => {
                    return Err(failed(format!("`{name}` is written and ends in an array: make it one")));
                }
                None => Vec::new(),
            };
            globals.push(Global { name, binding: binding.binding, kind, written, floats });
        }
        entries.insert(entry.name.clone(), globals);
    }
    Ok(Shader { name, stamp: Stamp::of(wgsl.as_bytes()), structs: struct_layouts(&module), module, entries })
}

fn struct_layouts(module: &naga::Module) -> Vec<StructLayout> {
    let layout = |ty: &naga::Type| match (&ty.inner, &ty.name) {
        (naga::TypeInner::Struct { members, span }, Some(name)) => Some(StructLayout {
            name: name.clone(),
            size: *span,
            members: members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset)).collect(),
        }),
        _ => None,
    };
    module.types.iter().filter_map(|(_, ty)| layout(ty)).collect()
}
