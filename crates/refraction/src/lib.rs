//! Refraction in image space: interface maps of a viewpoint, the methods that search them, the refract pass.
//!
//! To add a method: its row in [`Method`], its module in `shaders/refraction/methods/` with `find_interface`; that
//! module and the layers that it reads stand in `Method::module` and `Refraction::layers`.

mod interface_map;
mod refract;
mod settings;
mod tiles;
mod tree;
mod viewpoint;

pub use interface_map::{Hierarchy, InterfaceMap, LayerLists, Layers, Mapped, Media, Relief, interface_map, rasterise};
pub use refract::{
    Firsts, Glass, Layered, MapFeatures, PATH_ROWS, RefractRequest, Spectrum, Turn, first_interfaces, refract, traced,
    with_maps,
};
pub use settings::{
    BackSurface, Interfaces, MOST_BRANCHES, MOST_INTERFACES, MOST_WAVELENGTHS, Method, NormalDistance, Refraction,
    TirPolicy, UnknownName,
};
pub use tiles::{LISTED_TILES, listed_tiles, over_listed_tiles, over_tile_lists, texels, tile_threads};
pub use tree::{RefittedTree, TriangleTree, thickness};
pub use viewpoint::{FrameViewpoint, Viewpoint, ViewpointUniform};
