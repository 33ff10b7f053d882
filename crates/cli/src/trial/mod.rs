//! What `compare` and `bench` measure: one moment of a shot, rendered by any method, beside its ground truth and its time.

mod caustics;
mod layers;
mod look;
mod paths;
mod subject;
mod timing;

pub use caustics::{CausticTrial, CausticTruth};
pub use paths::{RefractionTrial, Truth};
pub use subject::Subject;
pub use timing::{Timing, time_deformation, time_frames};
