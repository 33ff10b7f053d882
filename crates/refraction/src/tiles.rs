//! Work that follows coverage: a pass lists the tiles of 8x8 texels that have any, then runs over those (`lib::tiles`).

use murano_gpu::{ComputePass, Groups};

/// Texels of a picture.
pub fn texels(size: [u32; 2]) -> u64 {
    u64::from(size[0]) * u64::from(size[1])
}

/// Tiles of a picture.
pub(crate) fn tiles(size: [u32; 2]) -> u64 {
    u64::from(size[0].div_ceil(8)) * u64::from(size[1].div_ceil(8))
}

/// Gives a pass the scratch that `package::lib::tiles` lists tiles in.
#[must_use]
pub fn over_listed_tiles(pass: ComputePass, size: [u32; 2]) -> ComputePass {
    // The listing side may read one row of workgroups past the last tile.
    pass.scratch("tile_arguments", 16).scratch("tile_list", 4 * (tiles(size) + 32))
}

/// The dispatch that lists: one thread a tile, 64 a workgroup.
pub fn tile_threads(size: [u32; 2]) -> Groups {
    Groups::linear(tiles(size) as usize, 64)
}

/// The dispatch that runs over what was listed, 64 threads a workgroup.
pub const LISTED_TILES: Groups = Groups::Indirect("tile_arguments", 0);
