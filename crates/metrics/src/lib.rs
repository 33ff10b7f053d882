//! How far a result lies from the truth, and how that is shown.
//!
//! * [`paths`]: exit directions, second hits and statuses of a picture's rays against the truth's.
//! * [`images`]: RMSE, SSIM and FLIP of pictures as they are displayed, and flicker of sequences.
//! * [`irradiance`]: energy, relative L1 and L2, encircled energy and ridge position of caustic maps.
//! * [`heat_map`]: a scalar map as a picture, with the scale of its colours printed in.
//! * [`report`]: tables, plots and pictures as one self-contained HTML page.
//! * [`scale`]: linear and logarithmic scales, shared by both.
//! * [`spread`]: median and quartiles of timings, power laws, Pareto fronts.
//!
//! The crate knows no other crate of the project: it is given slices and pictures, and neither traces, renders nor
//! reads a clock. Maps are row-major with row 0 at the top; pixel and texel coordinates have their centres at
//! half-integers.

pub mod heat_map;
pub mod images;
pub mod irradiance;
pub mod paths;
pub mod report;
pub mod scale;
pub mod spread;

mod error;

pub use error::MetricsError;
