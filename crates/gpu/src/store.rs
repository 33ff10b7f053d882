//! Outputs by content stamp, and spare buffers by size.

use std::collections::HashMap;

use murano_scheduler::Stamp;

/// Bytes of outputs kept before the least recently used go.
const BUDGET: u64 = 2 << 30;
/// Bytes of spare buffers kept for reuse.
const SPARE_BUDGET: u64 = 512 << 20;

/// A GPU resource.
#[derive(Clone, Debug)]
pub(crate) enum Resource {
    Buffer(wgpu::Buffer),
    /// Parameters by value, alive for one pass.
    Value(wgpu::Buffer),
    Texture(wgpu::Texture, u64),
}

impl Resource {
    fn bytes(&self) -> u64 {
        match self {
            Self::Buffer(buffer) | Self::Value(buffer) => buffer.size(),
            Self::Texture(_, bytes) => *bytes,
        }
    }
}

/// The content-addressed store. An entry leaves when its allocation does, so that a recycled buffer never matches.
#[derive(Default)]
pub(crate) struct Store {
    entries: HashMap<Stamp, (Resource, u64)>,
    spare: HashMap<u64, Vec<wgpu::Buffer>>,
    spare_bytes: u64,
    held: u64,
    clock: u64,
}

impl Store {
    pub(crate) fn contains(&self, stamp: Stamp) -> bool {
        self.entries.contains_key(&stamp)
    }

    /// The resource of a stamp, marked as used in this frame.
    pub(crate) fn get(&mut self, stamp: Stamp) -> Option<Resource> {
        let clock = self.clock;
        self.entries.get_mut(&stamp).map(|(resource, used)| {
            *used = clock;
            resource.clone()
        })
    }

    pub(crate) fn insert(&mut self, stamp: Stamp, resource: Resource) {
        self.held += resource.bytes();
        if let Some((old, _)) = self.entries.insert(stamp, (resource, self.clock)) {
            self.held -= old.bytes();
            self.recycle(old);
        }
    }

    /// Drops an entry whose content was never computed.
    pub(crate) fn forget(&mut self, stamp: Stamp) {
        if let Some((resource, _)) = self.entries.remove(&stamp) {
            self.held -= resource.bytes();
        }
    }

    /// A buffer of exactly this size with arbitrary content.
    pub(crate) fn buffer(&mut self, device: &wgpu::Device, bytes: u64) -> wgpu::Buffer {
        if let Some(buffer) = self.spare.get_mut(&bytes).and_then(Vec::pop) {
            self.spare_bytes -= bytes;
            return buffer;
        }
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Takes back a resource that nothing refers to any more.
    pub(crate) fn recycle(&mut self, resource: Resource) {
        if let Resource::Buffer(buffer) = resource
            && self.spare_bytes + buffer.size() <= SPARE_BUDGET
        {
            self.spare_bytes += buffer.size();
            self.spare.entry(buffer.size()).or_default().push(buffer);
        }
    }

    /// Ends a frame: evicts the least recently used entries beyond the budget, never one of this frame.
    pub(crate) fn end_frame(&mut self) {
        if self.held > BUDGET {
            let mut by_age: Vec<_> = self
                .entries
                .iter()
                .filter(|(_, (_, used))| *used < self.clock)
                .map(|(stamp, (_, used))| (*used, *stamp))
                .collect();
            by_age.sort_unstable();
            for (_, stamp) in by_age {
                if self.held <= BUDGET {
                    break;
                }
                if let Some((resource, _)) = self.entries.remove(&stamp) {
                    self.held -= resource.bytes();
                    self.recycle(resource);
                }
            }
        }
        self.clock += 1;
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.held + self.spare_bytes
    }
}
