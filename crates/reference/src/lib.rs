//! Ground truth on the CPU, in f64: what the image-space methods and the caustic maps of the renderer are measured by.
//!
//! It shares the laws of optics and the scene with the renderer, and no search, map, rasteriser or projection.
//!
//! | function | truth |
//! |---|---|
//! | [`two_interfaces`] | the path that the two-interface methods approximate: first front face, refract, first exit, refract |
//! | [`all_interfaces`] | every interface, total reflection and re-entry up to a limit; no reflection at entry |
//! | [`until_out`] | the same without re-entry |
//! | [`path_picture`] | the whole picture: reflections, environment, opaque things that reflect one another, lamps |
//! | [`caustic_map`], [`trace_photons`] | light on a plane or on opaque things, by class, every watt accounted for |
//!
//! A [`World`] is made of [`GlassBody`]s and opaque things, of any [`Shape`]: deformed triangle meshes with interpolated
//! normals, or solids with a closed form. World space: metres, +Y up. Surfaces' normals point outward. Around the bodies is
//! air; where bodies overlap, or one is within another, the one of the least volume displaces the others.

mod camera;
mod chain;
mod hit;
mod mesh;
mod path;
mod photons;
mod sampler;
mod shape;
mod surface_data;
mod textures;
mod two;
mod within;
mod world;

pub use camera::Camera;
pub use chain::{Chain, all_interfaces, trace_all, until_out};
pub use hit::{Departure, Facing, Hit, Ray};
pub use mesh::{InvalidMesh, TriangleMesh};
pub use path::{Fade, PathPicture, PathScene, PathSettings, PhotonMap, path_picture};
pub use photons::{
    Ball, CausticMap, Landing, Noise, PhotonAccount, PhotonClass, PhotonError, PhotonTracing, Receiver, Window,
    caustic_map, direct_irradiance, trace_photons,
};
pub use shape::{Convex, Ellipsoid, Plane, Shape};
pub use surface_data::{GlassSurface, SurfaceData};
pub use two::{Status, TwoInterfaces, trace_two, two_interfaces};
pub use within::Within;
pub use world::{Contact, GlassBody, Opaque, World, WorldError};
