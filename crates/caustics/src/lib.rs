//! Caustics: photons emitted through glass or off mirrors, landed on receivers, deposited into a caustic map.
//!
//! The camera enters no pass before [`receive`]: a caustic map is a picture of the lamp's view. The light's colour and
//! intensity multiply where the map is shown.

mod caster;
mod lamp;
mod photons;
mod receive;
mod settings;
mod shield;

pub use caster::{Caster, Mirror};
pub use lamp::{Emission, Lamp, Lamps, cone_cosines};
pub use photons::{Cast, CausticMap, Photons, Receivers, Surfaces, deposit, emit, level_texels, light_map_size};
pub use receive::{gather, receive};
pub use settings::{Caustics, Method};
pub use shield::{SeenCaster, shield};
