//! Adapters and the device.

use std::sync::{Arc, Mutex, OnceLock};

use crate::{GpuError, OutputChecks, pipeline::Pipelines, shader::ShaderLibrary, store::Store};

/// Which adapter to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest kind there is: discrete, integrated, virtual, then software.
    #[default]
    Best,
    /// A software adapter (lavapipe, WARP).
    Software,
    /// The first adapter whose name contains this, case-insensitively.
    Named(String),
}

/// One adapter of this machine.
#[derive(Clone, Debug)]
pub struct AdapterReport {
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal or DX12.
    pub backend: String,
    /// Discrete, integrated, virtual, software.
    pub kind: String,
    /// Driver name and version.
    pub driver: String,
    /// Features or limits it lacks; empty if Murano runs on it in full.
    pub missing: Vec<String>,
    /// Whether it is a software adapter.
    pub software: bool,
}

/// A device with its shaders, pipelines and cached outputs.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) info: wgpu::AdapterInfo,
    pub(crate) timestamps: bool,
    pub(crate) shaders: ShaderLibrary,
    pub(crate) pipelines: Mutex<Pipelines>,
    pub(crate) store: Mutex<Store>,
    /// Held while a plan is executed.
    pub(crate) executing: Mutex<()>,
    pub(crate) output_checks: OutputChecks,
    failure: Arc<Mutex<Option<String>>>,
}

/// Storage buffers that a shader may use: what Metal leaves of its 31.
pub(crate) const STORAGE_BUFFERS: u32 = 29;

/// The process's one instance: drivers exist that find no adapter any more after some thirty.
fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        descriptor.flags = wgpu::InstanceFlags::empty();
        wgpu::Instance::new(descriptor)
    })
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Adapters, best first.
fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    adapters
}

fn missing(adapter: &wgpu::Adapter) -> Vec<String> {
    let mut missing = Vec::new();
    if adapter.limits().max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
        missing.push(format!("{STORAGE_BUFFERS} storage buffers in a shader"));
    }
    if !adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        missing.push("timestamp queries (no GPU times)".into());
    }
    missing
}

impl Gpu {
    /// Opens the chosen adapter.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] if none fits, [`GpuError::NoDevice`] if the driver refuses.
    pub fn new(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let all = adapters(instance());
        let found = all.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
        let adapter = all
            .into_iter()
            .find(|adapter| {
                let info = adapter.get_info();
                match choice {
                    AdapterChoice::Best => adapter.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS,
                    AdapterChoice::Software => info.device_type == wgpu::DeviceType::Cpu,
                    AdapterChoice::Named(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
                }
            })
            .ok_or_else(|| GpuError::NoAdapter {
                wanted: match choice {
                    AdapterChoice::Best => "at all".into(),
                    AdapterChoice::Software => "in software".into(),
                    AdapterChoice::Named(name) => format!("named `{name}`"),
                },
                found: if found.is_empty() { "none".into() } else { found },
            })?;
        Self::open(&adapter)
    }

    fn open(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        let timestamps = adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let offered = adapter.limits();
        let limits = wgpu::Limits {
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
            max_texture_dimension_2d: offered.max_texture_dimension_2d,
            ..wgpu::Limits::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("murano"),
            required_features: if timestamps { wgpu::Features::TIMESTAMP_QUERY } else { wgpu::Features::empty() },
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| GpuError::NoDevice { adapter: info.name.clone(), message: error.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        let sink = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        Ok(Self {
            pipelines: Mutex::new(Pipelines::new(&device, info.device_type == wgpu::DeviceType::Cpu)),
            store: Mutex::new(Store::default()),
            executing: Mutex::new(()),
            shaders: ShaderLibrary::default(),
            device,
            queue,
            info,
            timestamps,
            output_checks: OutputChecks::default(),
            failure,
        })
    }

    /// The same device, on which every pass is followed by these checks of what it wrote.
    #[must_use]
    pub fn with_output_checks(self, output_checks: OutputChecks) -> Self {
        Self { output_checks, ..self }
    }

    /// The same device, whose cache holds nothing.
    #[must_use]
    pub fn emptied(self) -> Self {
        *self.store() = Store::default();
        self
    }

    /// Every adapter of this machine, best first.
    pub fn adapters() -> Vec<AdapterReport> {
        adapters(instance())
            .iter()
            .map(|adapter| {
                let info = adapter.get_info();
                AdapterReport {
                    missing: missing(adapter),
                    name: info.name,
                    backend: info.backend.to_string(),
                    kind: match info.device_type {
                        wgpu::DeviceType::DiscreteGpu => "discrete",
                        wgpu::DeviceType::IntegratedGpu => "integrated",
                        wgpu::DeviceType::VirtualGpu => "virtual",
                        wgpu::DeviceType::Cpu => "software",
                        wgpu::DeviceType::Other => "other",
                    }
                    .into(),
                    driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
                    software: info.device_type == wgpu::DeviceType::Cpu,
                }
            })
            .collect()
    }

    /// The driver's name for the adapter in use.
    pub fn adapter_name(&self) -> String {
        self.info.name.clone()
    }

    /// Bytes of GPU memory that cached outputs and spare buffers hold.
    pub fn cache_bytes(&self) -> u64 {
        self.store().bytes()
    }

    pub(crate) fn store(&self) -> std::sync::MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// The first error the device reported since the last call.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        match self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take() {
            Some(message) => Err(GpuError::Device(message)),
            None => Ok(()),
        }
    }
}
