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
}

impl Default for ShotOutput {
    fn default() -> Self {
        Self { size: [512, 512], fps: 24.0, frames: None }
    }
}
