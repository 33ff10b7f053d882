//! Executes a schedule: uploads leaves, records the passes that run, reads back what is asked for.

use std::collections::HashMap;

use murano_scheduler::{History, Output, PassIndex, Plan, PlanError, Schedule, Skipping, Stamp, Step};
use wgpu::util::DeviceExt;

use crate::{
    Gpu, GpuError, OutputChecks,
    finite::FiniteChecks,
    pass::{Dispatch, Leaf, Recording, Work},
    store::{Resource, Store},
};

/// GPU time of one executed step.
#[derive(Clone, Debug)]
pub struct StepTime {
    /// Pass name.
    pub name: &'static str,
    /// Round of the pass.
    pub round: u32,
    /// Pass instance.
    pub instance: u32,
    /// Milliseconds; `None` where the adapter has no timestamps.
    pub gpu_ms: Option<f64>,
}

/// What came of a plan.
pub struct Executed {
    /// Every pass and its decision.
    pub schedule: Schedule,
    /// Times of the passes that ran (verified ones too).
    pub times: Vec<StepTime>,
    /// Bytes of each target that was read back, in the order asked for.
    pub targets: Vec<Vec<u8>>,
}

/// A frame being recorded.
struct Recorder<'a> {
    plan: &'a Plan<Work>,
    encoder: wgpu::CommandEncoder,
    comparisons: Vec<Comparison>,
    checks: Option<FiniteChecks>,
    /// Buffers to recycle once the frame is done.
    temporary: Vec<Resource>,
}

struct Comparison {
    pass: String,
    output: &'static str,
    cached: wgpu::Buffer,
    again: wgpu::Buffer,
}

impl Gpu {
    /// Resolves a plan against the store, runs what has to run and reads back the targets. Plans of other threads wait.
    ///
    /// # Errors
    /// [`GpuError`] of any kind; [`GpuError::Stale`] if `skipping` is `Verify` and a rerun gave other bits;
    /// [`GpuError::NonFinite`] if outputs are checked and one is not finite.
    pub fn execute(
        &self,
        plan: &Plan<Work>,
        targets: &[Output],
        history: &mut History,
        skipping: Skipping,
    ) -> Result<Executed, GpuError> {
        let schedule = |store: &Store, history: &mut History| {
            plan.resolve(targets, |stamp| store.contains(stamp), history, skipping)
        };
        self.compute(plan, targets, schedule, history)
    }

    /// As [`Gpu::execute`] for one round of a plan after the other ([`Plan::resolve_round`]); reads the targets back or leaves them on
    /// the device for the rounds to come.
    ///
    /// # Errors
    /// As [`Gpu::execute`].
    pub fn execute_round(
        &self,
        plan: &Plan<Work>,
        (targets, read_back): (&[Output], bool),
        round: u32,
        history: &mut History,
        skipping: Skipping,
    ) -> Result<Executed, GpuError> {
        let schedule = |store: &Store, history: &mut History| {
            plan.resolve_round(targets, round, |stamp| store.contains(stamp), history, skipping)
        };
        self.compute(plan, if read_back { targets } else { &[] }, schedule, history)
    }

    /// Whether an output is on the device, computed.
    pub fn holds(&self, output: Output) -> bool {
        self.store().contains(output.stamp())
    }

    fn compute(
        &self,
        plan: &Plan<Work>,
        read_back: &[Output],
        schedule: impl FnOnce(&Store, &mut History) -> Result<Schedule, PlanError>,
        history: &mut History,
    ) -> Result<Executed, GpuError> {
        // While a plan is recorded, the store holds outputs that nothing has computed yet, and buffers that it gives away
        // again may still be meant by a recording: another plan must see neither.
        let Ok(_executing) = self.executing.lock() else {
            return Err(GpuError::device("another thread panicked while it used the device; open it anew"));
        };
        let schedule = schedule(&self.store(), history)?;
        for leaf in &schedule.leaves {
            if let Work::Leaf(content) = &plan.leaf_at(leaf.leaf).work {
                let resource = self.upload(content)?;
                self.store().insert(leaf.stamp, resource);
            }
        }
        let result = self.run(plan, &schedule, read_back);
        if result.is_err() {
            // Nothing says that what was recorded was also computed: later frames must not find it.
            let mut store = self.store();
            for (_, step) in schedule.executed().filter(|(_, step)| !step.verify) {
                step.outputs.iter().for_each(|stamp| store.forget(*stamp));
            }
            store.end_frame();
        }
        let (times, targets) = result?;
        Ok(Executed { schedule, times, targets })
    }

    /// Records, submits and reads back: the times of what ran, the bytes of the targets.
    fn run(
        &self,
        plan: &Plan<Work>,
        schedule: &Schedule,
        targets: &[Output],
    ) -> Result<(Vec<StepTime>, Vec<Vec<u8>>), GpuError> {
        let executed: Vec<(PassIndex, &Step)> = schedule.executed().collect();
        // A query set holds 4096 timestamps at most.
        let queries = (self.timestamps && (1..=2048).contains(&executed.len())).then(|| {
            self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * executed.len() as u32,
            })
        });
        let encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let checks = match self.output_checks {
            OutputChecks::Off => None,
            OutputChecks::NonFinite => {
                let outputs = executed.iter().map(|(_, step)| step.outputs.len()).sum();
                Some(FiniteChecks::new(self, outputs)?)
            }
        };
        let mut recorder = Recorder { plan, encoder, comparisons: Vec::new(), checks, temporary: Vec::new() };
        for (index, (pass, step)) in executed.iter().enumerate() {
            let writes = queries.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(2 * index as u32),
                end_of_pass_write_index: Some(2 * index as u32 + 1),
            });
            self.record(&mut recorder, *pass, step, writes)?;
        }
        let Recorder { mut encoder, comparisons, checks, temporary, .. } = recorder;
        let times = queries.as_ref().map(|set| {
            let bytes = 16 * executed.len() as u64;
            let resolved = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size: bytes,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            encoder.resolve_query_set(set, 0..2 * executed.len() as u32, &resolved, 0);
            self.stage(&mut encoder, &resolved)
        });
        let staged = targets
            .iter()
            .map(|target| match self.store().get(target.stamp()) {
                Some(Resource::Buffer(buffer)) => Ok(self.stage(&mut encoder, &buffer)),
                _ => Err(GpuError::device("a target of the plan was not computed")),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let compared: Vec<_> = comparisons
            .iter()
            .map(|pair| (self.stage(&mut encoder, &pair.cached), self.stage(&mut encoder, &pair.again)))
            .collect();
        let findings = checks.as_ref().map(|checks| self.stage(&mut encoder, &checks.findings));
        self.queue.submit([encoder.finish()]);
        let ticks = times.map(|buffer| self.read(&buffer)).transpose()?;
        let targets = staged.iter().map(|buffer| self.read(buffer)).collect::<Result<Vec<_>, _>>()?;
        for (pair, (cached, again)) in comparisons.iter().zip(&compared) {
            if self.read(cached)? != self.read(again)? {
                return Err(GpuError::Stale { pass: pair.pass.clone(), output: pair.output.into() });
            }
        }
        if let (Some(checks), Some(findings)) = (&checks, &findings)
            && let Some(found) = checks.first(&self.read(findings)?)
        {
            return Err(GpuError::NonFinite(found));
        }
        self.check()?;
        let times = executed
            .iter()
            .enumerate()
            .map(|(index, (_, step))| StepTime {
                name: step.name,
                round: step.round,
                instance: step.instance,
                gpu_ms: ticks.as_ref().map(|ticks| {
                    let at = |i: usize| bytemuck::pod_read_unaligned::<u64>(&ticks[8 * i..8 * i + 8]);
                    let period = f64::from(self.queue.get_timestamp_period());
                    at(2 * index + 1).saturating_sub(at(2 * index)) as f64 * period * 1e-6
                }),
            })
            .collect();
        let mut store = self.store();
        for resource in temporary {
            store.recycle(resource);
        }
        store.end_frame();
        drop(store);
        Ok((times, targets))
    }

    fn record(
        &self,
        recorder: &mut Recorder<'_>,
        pass: PassIndex,
        step: &Step,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> Result<(), GpuError> {
        let Recorder { plan, encoder, comparisons, checks, temporary } = recorder;
        let declared = plan.pass(pass);
        let Work::Compute(recording) = &declared.work else { return Ok(()) };
        let label = format!("{}:{}", step.name, step.instance);
        let mut named = HashMap::new();
        for (name, output) in &declared.inputs {
            let resource = self.store().get(output.stamp());
            let resource = resource.ok_or_else(|| GpuError::device(format!("pass `{label}` lacks input `{name}`")))?;
            named.insert(*name, resource);
        }
        let mut outputs: Vec<(Stamp, Resource)> = Vec::new();
        for (target, stamp) in recording.outputs.iter().zip(step.outputs.iter()) {
            let buffer = self.allocate(target.name, target.bytes)?;
            named.insert(target.name, Resource::Buffer(buffer.clone()));
            if target.cleared {
                encoder.clear_buffer(&buffer, 0, None);
            }
            if step.verify {
                if let Some(Resource::Buffer(cached)) = self.store().get(*stamp) {
                    comparisons.push(Comparison {
                        pass: label.clone(),
                        output: target.name,
                        cached,
                        again: buffer.clone(),
                    });
                }
                temporary.push(Resource::Buffer(buffer));
            } else {
                outputs.push((*stamp, Resource::Buffer(buffer)));
            }
        }
        self.add_temporaries(recording, &mut named, encoder, temporary)?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&label), timestamp_writes });
        for dispatch in &recording.dispatches {
            self.dispatch(&mut pass, &label, dispatch, &named)?;
        }
        drop(pass);
        // What is verified is compared with what was checked.
        if let (Some(checks), false) = (checks, step.verify) {
            checks.record(self, encoder, (step.name, step.instance), recording, &named)?;
        }
        let mut store = self.store();
        for (stamp, resource) in outputs {
            store.insert(stamp, resource);
        }
        Ok(())
    }

    /// Records one dispatch in a compute pass of its own, without timestamps.
    pub(crate) fn dispatch_alone(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        dispatch: &Dispatch,
        named: &HashMap<&'static str, Resource>,
    ) -> Result<(), GpuError> {
        let descriptor = wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None };
        self.dispatch(&mut encoder.begin_compute_pass(&descriptor), label, dispatch, named)
    }

    fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        label: &str,
        dispatch: &Dispatch,
        named: &HashMap<&'static str, Resource>,
    ) -> Result<(), GpuError> {
        let mut pipelines = self.pipelines.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let pipeline = pipelines.get(&self.device, dispatch);
        self.check()?;
        let group = pipelines.bind(&self.device, &pipeline, label, dispatch, named)?;
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        match dispatch.groups {
            crate::Groups::Direct([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            crate::Groups::Indirect(name, offset) => match named.get(name) {
                Some(Resource::Buffer(buffer)) => pass.dispatch_workgroups_indirect(buffer, offset),
                _ => return Err(GpuError::device(format!("pass `{label}` has no indirect buffer `{name}`"))),
            },
        }
        Ok(())
    }

    fn add_temporaries(
        &self,
        recording: &Recording,
        named: &mut HashMap<&'static str, Resource>,
        encoder: &mut wgpu::CommandEncoder,
        temporary: &mut Vec<Resource>,
    ) -> Result<(), GpuError> {
        for target in &recording.scratch {
            let buffer = self.allocate(target.name, target.bytes)?;
            if target.cleared {
                encoder.clear_buffer(&buffer, 0, None);
            }
            named.insert(target.name, Resource::Buffer(buffer.clone()));
            temporary.push(Resource::Buffer(buffer));
        }
        for (name, bytes) in &recording.values {
            let buffer = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(name),
                contents: bytes,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
            });
            named.insert(name, Resource::Value(buffer));
        }
        Ok(())
    }

    fn allocate(&self, name: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        let limits = self.device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > limit {
            return Err(GpuError::TooLarge { name: name.into(), bytes, limit });
        }
        Ok(self.store().buffer(&self.device, bytes))
    }

    fn upload(&self, leaf: &Leaf) -> Result<Resource, GpuError> {
        match leaf {
            Leaf::Buffer(bytes) => {
                let buffer = self.allocate("leaf", bytes.len() as u64)?;
                self.queue.write_buffer(&buffer, 0, bytes);
                Ok(Resource::Buffer(buffer))
            }
            Leaf::Texture(data) => {
                let texture = self.device.create_texture_with_data(
                    &self.queue,
                    &wgpu::TextureDescriptor {
                        label: Some("leaf"),
                        size: wgpu::Extent3d { width: data.size[0], height: data.size[1], depth_or_array_layers: 1 },
                        mip_level_count: data.levels.len() as u32,
                        sample_count: 1,
                        dimension: wgpu::TextureDimension::D2,
                        format: wgpu::TextureFormat::Rgba16Float,
                        usage: wgpu::TextureUsages::TEXTURE_BINDING,
                        view_formats: &[],
                    },
                    wgpu::util::TextureDataOrder::MipMajor,
                    bytemuck::cast_slice(&data.levels.concat()),
                );
                Ok(Resource::Texture(texture, data.levels.iter().map(|level| 2 * level.len() as u64).sum()))
            }
        }
    }

    fn stage(&self, encoder: &mut wgpu::CommandEncoder, from: &wgpu::Buffer) -> wgpu::Buffer {
        let staged = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: from.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(from, 0, &staged, 0, from.size());
        staged
    }

    fn read(&self, staged: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        staged.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver lives until the result is in; a closed channel means that nobody waits any more.
            sender.send(result).ok();
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(GpuError::device)?;
        self.check()?;
        receiver.recv().map_err(GpuError::device)?.map_err(GpuError::device)?;
        let bytes = staged.get_mapped_range(..).map_err(GpuError::device)?.to_vec();
        Ok(bytes)
    }
}
