//! What of a model plays in a shot.

use std::{path::Path, sync::Arc};

use murano_animation::{Blend, Layer, played_time};
use murano_scene::{LoopMode, NodeIndex, Scene, Shot, ShotLayer};

use super::{StageError, find_clip, listed};

/// How often what plays is looked at to find what it sweeps.
const SAMPLES: usize = 16;

/// A clip that plays.
#[derive(Clone, Debug)]
struct Track {
    clip: usize,
    duration: f64,
    speed: f64,
    repeat: LoopMode,
}

impl Track {
    fn at(&self, start: f64, elapsed: f64) -> Layer {
        Layer::new(self.clip, played_time(self.repeat, self.speed, start, elapsed, self.duration))
    }
}

/// A clip laid over others.
#[derive(Clone, Debug)]
struct Laid {
    track: Track,
    shot: ShotLayer,
    mask: Option<Arc<[f32]>>,
}

/// The shot's clip and its layers.
#[derive(Clone, Debug)]
pub struct Playing {
    base: Option<Track>,
    laid: Vec<Laid>,
    hold: Option<f64>,
    /// Seconds that the base takes for one round; 0 without one.
    round: f64,
    /// Factor on the base's speed with which a round is a whole number of frames.
    tempo: f64,
}

impl Playing {
    /// Finds the clips and nodes that a shot names.
    pub fn new(shot: &Shot, scene: &Scene) -> Result<Self, StageError> {
        let track = |clip: usize, speed: f64, repeat: LoopMode| Track {
            clip,
            duration: scene.clips[clip].duration,
            speed,
            repeat,
        };
        let base = find_clip(scene, &shot.clip, &shot.model)?.map(|clip| track(clip, shot.speed, shot.repeat));
        let mut laid = Vec::new();
        for layer in &shot.layers {
            let Some(clip) = find_clip(scene, &layer.clip, &shot.model)? else { continue };
            let mask = mask_of(scene, &layer.mask, &shot.model)?;
            laid.push(Laid { track: track(clip, layer.speed, layer.repeat), shot: layer.clone(), mask });
        }
        let round = base.as_ref().map_or(0.0, |track| {
            let there_and_back = if track.repeat == LoopMode::PingPong { 2.0 } else { 1.0 };
            if track.speed == 0.0 { 0.0 } else { there_and_back * track.duration / track.speed.abs() }
        });
        let repeats = matches!(shot.repeat, LoopMode::Loop | LoopMode::PingPong);
        // One round as a film must meet its beginning: the frame behind the last is the first.
        let tempo = if shot.output.frames.is_none() && repeats && round > 0.0 {
            round * shot.output.fps / (round * shot.output.fps).round().max(1.0)
        } else {
            1.0
        };
        Ok(Self { base, laid, hold: shot.hold, round, tempo })
    }

    /// Index of the shot's own clip.
    pub fn clip(&self) -> Option<usize> {
        self.base.as_ref().map(|track| track.clip)
    }

    /// Seconds in which the shot's own clip comes back to where it began.
    pub fn round(&self) -> f64 {
        self.round
    }

    /// What plays at a moment, seconds after the shot's beginning; the shot's own clip begins at its time `start`.
    pub fn at(&self, elapsed: f64, start: f64) -> Vec<Layer> {
        let base = self.base.iter().map(|track| match self.hold {
            Some(time) => Layer::new(track.clip, time),
            None => track.at(start, elapsed * self.tempo),
        });
        let mut playing: Vec<Layer> = base.collect();
        // Where the pose is held, layers stand at the shot's beginning.
        let elapsed = if self.hold.is_some() { 0.0 } else { elapsed };
        for Laid { track, shot, mask } in &self.laid {
            let weight = shot.weight_at(elapsed);
            if weight != 0.0 {
                let blend = if shot.add { Blend::Add } else { Blend::Over };
                playing.push(Layer { weight, blend, mask: mask.clone(), ..track.at(0.0, elapsed - shot.from) });
            }
        }
        playing
    }

    /// Moments that together show what is swept.
    pub fn moments(&self, seconds: f64) -> Vec<Vec<Layer>> {
        let span = if self.laid.is_empty() { self.round } else { seconds };
        if self.hold.is_some() || span <= 0.0 {
            return vec![self.at(0.0, 0.0)];
        }
        // A round ends where it began; anything else is looked at to its end.
        let repeats = self.base.as_ref().is_some_and(|track| track.repeat == LoopMode::Loop) && self.laid.is_empty();
        let parts = if repeats { SAMPLES } else { SAMPLES - 1 } as f64;
        (0..SAMPLES).map(|k| self.at(span * k as f64 / parts, 0.0)).collect()
    }
}

/// 1 for the named nodes and all that hangs on them; `None` without names.
fn mask_of(scene: &Scene, names: &[String], model: &Path) -> Result<Option<Arc<[f32]>>, StageError> {
    if names.is_empty() {
        return Ok(None);
    }
    let mut mask = vec![0.0; scene.nodes.len()];
    for name in names {
        let mut stack: Vec<NodeIndex> =
            (0..scene.nodes.len()).filter(|&node| &scene.nodes[node].name == name).collect();
        if stack.is_empty() {
            return Err(StageError::NoNode {
                model: model.to_owned(),
                wanted: name.clone(),
                choices: listed(scene.nodes.iter().map(|node| node.name.as_str())),
            });
        }
        while let Some(node) = stack.pop() {
            if mask[node] == 0.0 {
                mask[node] = 1.0;
                stack.extend(&scene.nodes[node].children);
            }
        }
    }
    Ok(Some(mask.into()))
}
