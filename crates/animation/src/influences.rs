//! Which palette matrices move a vertex, and by how much.

use glam::{DMat4, DVec3};
use murano_scene::{NodeIndex, Primitive, Scene, Skin};

use crate::bounds::Bounds;
use crate::geometry::{Influence, PaletteEntry};
use crate::targets::displacement;

/// Binds the vertices of one instance to the palette. Only joints that influence a vertex get an entry, so that a joint
/// without vertices neither costs upload nor changes the palette's value when it moves.
pub(crate) struct Binding<'a> {
    primitive: &'a Primitive,
    skin: Option<&'a Skin>,
    node: NodeIndex,
    pivot: DVec3,
    /// Palette entry of each joint of the skin, and last that of the node itself.
    entries: Vec<Option<u32>>,
    /// Influences of the vertex at hand: slot in `entries`, weight.
    gathered: Vec<(usize, f64)>,
}

impl<'a> Binding<'a> {
    /// A primitive without JOINTS, or of a node without a skin, is rigid.
    pub fn new(scene: &'a Scene, node: NodeIndex, primitive: &'a Primitive, pivot: DVec3) -> Self {
        let skin = scene.nodes[node].skin.and_then(|skin| scene.skins.get(skin));
        let skin = skin.filter(|_| !primitive.joints.is_empty());
        let joints = skin.map_or(0, |skin| skin.joints.len());
        Self { primitive, skin, node, pivot, entries: vec![None; joints + 1], gathered: Vec::new() }
    }

    /// Appends the influences of the vertex copied from `source`, and lets their entries' bounds take in its `rest`
    /// position relative to the pivot and its displacements.
    pub fn push(
        &mut self,
        source: usize,
        rest: DVec3,
        palette: &mut Vec<PaletteEntry>,
        influences: &mut Vec<Influence>,
    ) {
        self.gather(source);
        let total: f64 = self.gathered.iter().map(|&(_, weight)| weight).sum();
        for position in 0..self.gathered.len() {
            let (slot, weight) = self.gathered[position];
            let weight = (weight / total) as f32;
            // Too small a part of the others to be a number.
            if weight == 0.0 {
                continue;
            }
            let entry = self.entry(slot, palette);
            influences.push(Influence { entry, weight });

            let entry = &mut palette[entry as usize];
            entry.rest.include(rest);
            for (target, bounds) in entry.displacements.iter_mut().enumerate() {
                if let Some([position, ..]) = displacement(self.primitive, target, source) {
                    bounds.include(position.as_dvec3());
                }
            }
        }
    }

    /// Fills `gathered` from all sets: joints that count, each once; at least one.
    fn gather(&mut self, source: usize) {
        self.gathered.clear();
        let rigid = self.entries.len() - 1;
        for (joints, weights) in self.primitive.joints.iter().zip(&self.primitive.weights) {
            let (Some(joints), Some(weights)) = (joints.get(source), weights.get(source)) else { continue };
            for (&joint, &weight) in joints.iter().zip(weights) {
                let slot = usize::from(joint);
                if slot >= rigid || !weight.is_finite() || weight <= 0.0 {
                    continue;
                }
                match self.gathered.iter_mut().find(|(known, _)| *known == slot) {
                    Some((_, sum)) => *sum += f64::from(weight),
                    None => self.gathered.push((slot, f64::from(weight))),
                }
            }
        }
        if self.gathered.is_empty() {
            let first = self.primitive.joints.first().and_then(|joints| joints.get(source));
            let slot = first.map_or(rigid, |joints| usize::from(joints[0])).min(rigid);
            self.gathered.push((slot, 1.0));
        }
    }

    /// The palette entry of a slot, made on first use.
    fn entry(&mut self, slot: usize, palette: &mut Vec<PaletteEntry>) -> u32 {
        if let Some(entry) = self.entries[slot] {
            return entry;
        }
        let joint = self.skin.and_then(|skin| {
            let node = *skin.joints.get(slot)?;
            Some((node, skin.inverse_bind.get(slot).copied().unwrap_or(DMat4::IDENTITY)))
        });
        let (node, node_from_mesh) = joint.unwrap_or((self.node, DMat4::IDENTITY));
        let entry = palette.len() as u32;
        palette.push(PaletteEntry {
            node,
            node_from_vertex: node_from_mesh * DMat4::from_translation(self.pivot),
            rest: Bounds::EMPTY,
            displacements: vec![Bounds::point(DVec3::ZERO); self.primitive.targets.len()],
        });
        self.entries[slot] = Some(entry);
        entry
    }
}
