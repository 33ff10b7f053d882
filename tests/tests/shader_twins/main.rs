//! Each function of the shaders' libraries on the GPU against the same law in f64, over ordinary and hostile inputs.
//!
//! Tolerances are rounding errors carried through each formula in f32, times [`SLACK`] for drivers that fuse,
//! reassociate and approximate.

mod environment;
mod fit;
mod harness;
mod optics;
mod photon;
mod shared_device;
mod tone_map;
mod triangle;
mod viewpoint;
mod watertight;

/// Half a unit in the last place of 1 in f32.
const U: f64 = 1.0 / (1 << 24) as f64;

/// WGSL lets division and square roots be several units off, and drivers fuse products into sums.
const SLACK: f64 = 4.0;
