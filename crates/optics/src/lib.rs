//! Light at an interface between two media, and in between: the f64 truth behind every shader.
//!
//! Free functions ([`snell`], [`fresnel_dielectric`], [`beer_lambert`], [`octahedral_pack`], ...) are the twins of the
//! WGSL functions of the same name and argument order in `shaders/lib/optics.wesl`. [`analytic`] holds bodies whose
//! refraction and caustics are known in closed form.
//!
//! Conventions: directions are unit vectors in any one space; an incident direction `i` travels towards the surface,
//! and the normal `n` points to the side that `i` comes from, so `dot(i, n) <= 0`. eta = n_incident / n_transmitted.
//! Angles are radians, lengths metres, wavelengths nanometres. Every function gives a defined, finite result for every
//! finite input, unless its documentation says otherwise.
//!
//! ```text
//!            n
//!            ^   theta_i
//!         \  |  /             sin(theta_t) = eta sin(theta_i)
//!        i \ | / reflected
//!           \|/
//!   ---------+----------  interface
//!            |\
//!            | \ T        T = eta i + (eta c - cos(theta_t)) n,   c = -dot(i, n)
//!          theta_t
//! ```

pub mod analytic;

mod absorption;
mod dispersion;
mod fresnel;
mod ior;
mod octahedral;
mod snell;
mod spectrum;
mod table;

pub use absorption::{absorption_coefficient, beer_lambert};
pub use dispersion::{FRAUNHOFER_C, FRAUNHOFER_D, FRAUNHOFER_F, abbe_number, dispersed_ior};
pub use fresnel::{fresnel_dielectric, fresnel_unpolarised, pair_transmittance};
pub use ior::{InvalidIor, Ior};
pub use octahedral::{octahedral_decode, octahedral_encode, octahedral_pack, octahedral_unpack};
pub use snell::{Refracted, critical_clamp, reflected, snell};
pub use spectrum::{SpectralSample, visible_spectrum};
pub use table::RefractionTable;
