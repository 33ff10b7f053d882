//! Every frame in small on one sheet.

use std::path::{Path, PathBuf};

use anyhow::Result;
use image::{
    RgbaImage,
    imageops::{replace, thumbnail},
};
use murano_render::Frame;

use super::{destination::prepare_folder, writers::write_png};

/// Longest side of a frame on the sheet, pixels.
const LONGEST_SIDE: u32 = 192;
/// Most frames on a sheet; of longer sequences evenly spaced ones are shown.
const MOST_FRAMES: u32 = 144;

/// A sheet being filled, row by row.
pub struct ContactSheet {
    path: PathBuf,
    sheet: RgbaImage,
    cell: [u32; 2],
    columns: u32,
    shown: u32,
    added: u32,
    frames: u32,
}

impl ContactSheet {
    /// An empty sheet for `frames` frames of `size` pixels.
    ///
    /// # Errors
    /// When its folder cannot be written to.
    pub fn open(path: &Path, size: [u32; 2], frames: u32) -> Result<Self> {
        prepare_folder(path)?;
        let longest = size[0].max(size[1]);
        let cell = size.map(|side| (side * LONGEST_SIDE.min(longest)).div_ceil(longest).max(1));
        let shown = frames.min(MOST_FRAMES);
        let columns = f64::from(shown).sqrt().ceil() as u32;
        let sheet = RgbaImage::new(columns * cell[0], shown.div_ceil(columns) * cell[1]);
        Ok(Self { path: path.into(), sheet, cell, columns, shown, added: 0, frames })
    }

    /// The next frame.
    pub fn add(&mut self, frame: &Frame) {
        let place = |added: u32| u64::from(added) * u64::from(self.shown) / u64::from(self.frames);
        let (index, next) = (place(self.added), place(self.added + 1));
        self.added += 1;
        if index == next {
            return;
        }
        let Some(full) = RgbaImage::from_raw(frame.size[0], frame.size[1], frame.rgba.clone()) else { return };
        let small = thumbnail(&full, self.cell[0], self.cell[1]);
        let (column, row) = (index % u64::from(self.columns), index / u64::from(self.columns));
        replace(
            &mut self.sheet,
            &small,
            (column * u64::from(self.cell[0])) as i64,
            (row * u64::from(self.cell[1])) as i64,
        );
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(&self) -> Result<()> {
        write_png(&self.path, [self.sheet.width(), self.sheet.height()], self.sheet.as_raw())
    }
}
