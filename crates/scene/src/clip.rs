//! Animation clips as stored: samplers and the node properties they drive.

use crate::{NodeIndex, PropertyChannel};

/// How values between keys come about (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The earlier key holds.
    Step,
    /// Linear; shortest-path slerp for rotations.
    Linear,
    /// Cubic Hermite spline; a key stores in-tangent, value, out-tangent.
    CubicSpline,
}

/// The node property a channel drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Path {
    /// 3 values a key, metres.
    Translation,
    /// 4 values a key: quaternion x, y, z, w.
    Rotation,
    /// 3 values a key.
    Scale,
    /// One value a morph target and key.
    Weights,
}

/// Keys and values of one curve.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Interpolation between keys.
    pub interpolation: Interpolation,
    /// Key times in seconds, strictly increasing, at least one.
    pub times: Vec<f32>,
    /// Components of one value (3, 4, or the number of morph targets).
    pub width: usize,
    /// `times.len() * width` values, or three times as many for a cubic spline (in-tangents, values, out-tangents of a
    /// key in that order). Normalised integers are decoded.
    pub values: Vec<f32>,
}

/// One sampler applied to one property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The node driven.
    pub node: NodeIndex,
    /// Its property.
    pub path: Path,
    /// The curve.
    pub sampler: Sampler,
}

/// A named set of channels played together.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    /// Name in the file, or empty.
    pub name: String,
    /// Channels; no two drive the same property of the same node.
    pub channels: Vec<Channel>,
    /// Channels of what is no node's transform or list of weights; no two drive the same property.
    pub properties: Vec<PropertyChannel>,
    /// Time of the last key over all channels, seconds.
    pub duration: f64,
}
