//! What plays: clips laid over the rest pose and over one another.

use std::sync::Arc;

/// Weights beyond this mean nothing, and count as 0: products of what they weigh would leave f32.
const MOST_WEIGHT: f64 = 1e6;

/// How a layer joins what lies below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Blend {
    /// The layer's pose takes the place of what is below: all of it at weight 1, a mean of both in between. Rotations are
    /// blended by component on the hemisphere of what is below and normalised at the end.
    #[default]
    Over,
    /// What the clip changes since its time 0 is added: translations and morph weights by their difference, rotations by
    /// their difference behind what is below, scales by their quotient (not at all along an axis whose scale at time 0 is 0).
    Add,
}

/// A clip at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Index into `Scene::clips`.
    pub clip: usize,
    /// Time in the clip, seconds; before its first key and after its last, these hold.
    pub time: f64,
    /// Share of the layer, usually 0 to 1; beyond 10^6 it counts as 0.
    pub weight: f64,
    /// How it joins what is below.
    pub blend: Blend,
    /// A factor on `weight` for every node, by index, 0 to 1; `None` is 1 everywhere. Nodes beyond its end have 0.
    pub mask: Option<Arc<[f32]>>,
}

impl Layer {
    /// A clip at a time, in full.
    pub fn new(clip: usize, time: f64) -> Self {
        Self { clip, time, weight: 1.0, blend: Blend::Over, mask: None }
    }

    /// What a clip looks like by itself at a time; the rest pose for `None`.
    pub fn alone(clip: Option<usize>, time: f64) -> Vec<Self> {
        clip.map(|clip| Self::new(clip, time)).into_iter().collect()
    }

    /// Layers whose result is the mean of clips at times, weighted by what stands last in each; weights need not sum to 1.
    /// Weights that are not above zero leave their clip out.
    pub fn mean(parts: &[(usize, f64, f64)]) -> Vec<Self> {
        let mut total = 0.0;
        let counted = parts.iter().filter(|(.., weight)| *weight > 0.0 && weight.is_finite());
        counted
            .map(|&(clip, time, weight)| {
                total += weight;
                Self { weight: weight / total, ..Self::new(clip, time) }
            })
            .collect()
    }

    /// The layer's weight where no mask counts.
    pub(crate) fn whole_weight(&self) -> f64 {
        if self.weight.abs() <= MOST_WEIGHT { self.weight } else { 0.0 }
    }

    /// The layer's weight for a node.
    pub(crate) fn weight_of(&self, node: usize) -> f64 {
        let share = self.mask.as_ref().map_or(1.0, |mask| mask.get(node).map_or(0.0, |&share| f64::from(share)));
        let weight = self.whole_weight() * share;
        if weight.is_finite() { weight } else { 0.0 }
    }

    /// Whether nothing of what is below remains.
    pub(crate) fn hides_all(&self) -> bool {
        self.blend == Blend::Over && self.weight == 1.0 && self.mask.is_none()
    }
}
