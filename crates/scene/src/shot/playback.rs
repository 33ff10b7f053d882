//! What plays and what is written.

use serde::{Deserialize, Serialize};

/// Which clip of the model plays.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "ClipName", into = "ClipName")]
pub enum ClipChoice {
    /// The first, or the rest pose if there is none.
    #[default]
    First,
    /// By index.
    Index(usize),
    /// By name.
    Name(String),
}

/// A clip as written: a number or a string, empty for the first.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum ClipName {
    Index(usize),
    Name(String),
}

impl From<ClipName> for ClipChoice {
    fn from(clip: ClipName) -> Self {
        match clip {
            ClipName::Index(index) => Self::Index(index),
            ClipName::Name(name) if name.is_empty() => Self::First,
            ClipName::Name(name) => Self::Name(name),
        }
    }
}

impl From<ClipChoice> for ClipName {
    fn from(clip: ClipChoice) -> Self {
        match clip {
            ClipChoice::First => Self::Name(String::new()),
            ClipChoice::Index(index) => Self::Index(index),
            ClipChoice::Name(name) => Self::Name(name),
        }
    }
}

/// What happens outside a clip's own time span.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LoopMode {
    /// The clip plays once; before and after it stands at its start.
    Once,
    /// The clip repeats; its end is its start.
    #[default]
    Loop,
    /// The clip plays forwards and backwards in turn.
    PingPong,
    /// The clip plays once; its first and last moments are held.
    Clamp,
}

/// A clip laid over what plays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotLayer {
    /// Which clip.
    pub clip: ClipChoice,
    /// Seconds of the clip that pass in a second; negative plays it backwards.
    pub speed: f64,
    /// Outside its span.
    pub repeat: LoopMode,
    /// Its weight, once faded in: 1 hides what is below.
    pub weight: f64,
    /// When it sets in, seconds after the shot's beginning. The clip begins then too.
    pub from: f64,
    /// When it is gone, seconds after the shot's beginning; `None` is never.
    pub until: Option<f64>,
    /// Seconds in which its weight rises after `from`, and falls before `until`.
    pub fade: f64,
    /// Whether what the clip changes since its time 0 is added, rather than laid over.
    pub add: bool,
    /// Names of the nodes it moves, each with all that hangs on it; empty for all.
    pub mask: Vec<String>,
}

impl Default for ShotLayer {
    fn default() -> Self {
        Self {
            clip: ClipChoice::First,
            speed: 1.0,
            repeat: LoopMode::Loop,
            weight: 1.0,
            from: 0.0,
            until: None,
            fade: 0.0,
            add: false,
            mask: Vec::new(),
        }
    }
}

impl ShotLayer {
    /// Its weight at a moment, seconds after the shot's beginning.
    pub fn weight_at(&self, elapsed: f64) -> f64 {
        let ramp = |passed: f64| {
            if self.fade > 0.0 { (passed / self.fade).clamp(0.0, 1.0) } else { f64::from(u8::from(passed >= 0.0)) }
        };
        let falling = self.until.map_or(1.0, |until| if elapsed >= until { 0.0 } else { ramp(until - elapsed) });
        self.weight * ramp(elapsed - self.from).min(falling)
    }
}

/// Picture size and frames of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotOutput {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frames per second.
    pub fps: f64,
    /// Number of frames; `None` is the clip once.
    pub frames: Option<u32>,
    /// Rays through each pixel, whose mean the picture shows.
    pub samples: u32,
}

impl Default for ShotOutput {
    fn default() -> Self {
        Self { size: [512, 512], fps: 24.0, frames: None, samples: 1 }
    }
}
