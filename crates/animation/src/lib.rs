//! Animation: clips to poses, poses to deformed geometry.
//!
//! [`played_time`] turns playback time into clip time, and a [`Rig`] [`Layer`]s of clips at times into a [`Pose`]: local
//! transforms, morph weights and world matrices ([`Pose::sample`] is its truth in f64). [`Geometry`] holds mesh instances as flat arrays for the GPU; a pose reaches it as a
//! [palette](Geometry::palette) and [active targets](Geometry::push_active_targets). [`deform_f64`] is the same deformation on
//! the CPU in f64, from the scene's own data.
//!
//! Spaces: *vertex* (mesh space less the instance's pivot), *mesh*, *node* (a joint or the mesh's node), *world* (metres,
//! right-handed, +Y up), *render* (world less an origin near what is shown). Everything up to the palette is f64.

mod adjacency;
mod bounds;
mod companies;
mod crowd;
mod deform;
mod geometry;
mod influences;
mod layer;
mod motion;
mod palette;
mod playback;
mod ply;
mod pose;
mod properties;
mod rig;
mod sample;
mod targets;
mod tracks;
mod truth;

#[cfg(test)]
mod tests;

pub use bounds::Bounds;
pub use crowd::{BLOCK, Block, Character, Crowd};
pub use deform::{DeformedGeometry, GeometryLeaves};
pub use geometry::{Geometry, GeometryError, Influence, Instance, RestVertex, shown_primitives};
pub use layer::{Blend, Layer};
pub use palette::PaletteRow;
pub use playback::{clip_time, played_time};
pub use ply::write_ply;
pub use pose::Pose;
pub use properties::Properties;
pub use rig::{Rig, Workspace};
pub use sample::{sample_rotation, sample_vector, sample_weights};
pub use targets::{ActiveRange, ActiveTarget, MorphWord};
pub use truth::{Deformed, deform_f64};
