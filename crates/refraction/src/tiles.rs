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

/// Gives a pass the scratch that `package::lib::tiles` lists tiles in, one list.
#[must_use]
pub fn over_listed_tiles(pass: ComputePass, size: [u32; 2]) -> ComputePass {
    over_tile_lists(pass, size, 1)
}

/// Gives a pass the scratch of so many lists of tiles.
#[must_use]
pub fn over_tile_lists(pass: ComputePass, size: [u32; 2], lists: u64) -> ComputePass {
    // A row of workgroups may read past a list's last tile.
    pass.scratch("tile_arguments", TILE_ARGUMENTS * lists).scratch("tile_list", 4 * lists * (tiles(size) + 32))
}

/// Bytes of what `package::lib::tiles` knows of a list.
const TILE_ARGUMENTS: u64 = 16;

/// The dispatch that lists: one thread a tile, 64 a workgroup.
pub fn tile_threads(size: [u32; 2]) -> Groups {
    Groups::linear(tiles(size) as usize, 64)
}

/// The dispatch that runs over what was listed, 64 threads a workgroup.
pub const LISTED_TILES: Groups = listed_tiles(0);

/// The dispatch that runs over one of several lists.
pub const fn listed_tiles(list: u64) -> Groups {
    Groups::Indirect("tile_arguments", TILE_ARGUMENTS * list)
}
