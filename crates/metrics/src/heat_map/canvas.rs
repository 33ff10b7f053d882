//! Rectangles and text on a picture.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::{MetricsError, error::area, images::Picture};

/// A picture that is being drawn.
pub(super) struct Canvas {
    size: [u32; 2],
    rgb: Vec<[u8; 3]>,
    lettering: Lettering,
}

/// A fount, and by how much its pixels are magnified.
#[derive(Clone, Copy)]
pub(super) struct Lettering {
    font: RasterHeight,
    magnification: u32,
}

impl Lettering {
    /// Text that stays readable when a picture of `width` pixels is shown a third of a page wide.
    pub(super) fn for_width(width: u32) -> Self {
        // The width of a picture with the largest font as it is.
        const WIDEST: u32 = 960;
        let (font, magnification) = match width {
            0..440 => (RasterHeight::Size16, 1),
            440..560 => (RasterHeight::Size20, 1),
            560..720 => (RasterHeight::Size24, 1),
            _ => (RasterHeight::Size32, width.div_ceil(WIDEST)),
        };
        Self { font, magnification }
    }

    /// The height of a line, pixels.
    pub(super) fn height(self) -> u32 {
        self.font.val() as u32 * self.magnification
    }

    /// The distance from one character to the next, pixels.
    pub(super) fn advance(self) -> u32 {
        get_raster_width(FontWeight::Regular, self.font) as u32 * self.magnification
    }
}

impl Canvas {
    /// A canvas of one colour, for text of one size.
    pub(super) fn new(size: [u32; 2], paper: [u8; 3], lettering: Lettering) -> Self {
        Self { size, rgb: vec![paper; area(size)], lettering }
    }

    /// Fills a rectangle, as far as it lies on the canvas.
    pub(super) fn rectangle(&mut self, [left, top]: [u32; 2], [width, height]: [u32; 2], colour: [u8; 3]) {
        let columns = left.min(self.size[0]) as usize..left.saturating_add(width).min(self.size[0]) as usize;
        for y in top.min(self.size[1])..top.saturating_add(height).min(self.size[1]) {
            let row = y as usize * self.size[0] as usize;
            self.rgb[row + columns.start..row + columns.end].fill(colour);
        }
    }

    /// Writes a line of text whose first character has its upper left corner at (`left`, `top`).
    pub(super) fn text(&mut self, left: u32, top: u32, text: &str, colour: [u8; 3]) {
        let Lettering { font, magnification } = self.lettering;
        let raster = |character| get_raster(character, FontWeight::Regular, font);
        for (column, character) in text.chars().enumerate() {
            let Some(glyph) = raster(character).or_else(|| raster('?')) else { continue };
            let corner = left + column as u32 * self.lettering.advance();
            for (row, coverages) in glyph.rows().enumerate() {
                for (x, &coverage) in coverages.iter().enumerate() {
                    let [x, y] = [corner + x as u32 * magnification, top + row as u32 * magnification];
                    self.blend([x, y], magnification, colour, coverage);
                }
            }
        }
    }

    /// Covers a square in part, in 255ths.
    fn blend(&mut self, [left, top]: [u32; 2], side: u32, colour: [u8; 3], coverage: u8) {
        let part = u32::from(coverage);
        for y in top..(top + side).min(self.size[1]) {
            for x in left..(left + side).min(self.size[0]) {
                let pixel = &mut self.rgb[y as usize * self.size[0] as usize + x as usize];
                for (channel, ink) in pixel.iter_mut().zip(colour) {
                    *channel = ((u32::from(*channel) * (255 - part) + u32::from(ink) * part + 127) / 255) as u8;
                }
            }
        }
    }

    /// The finished picture.
    pub(super) fn into_picture(self) -> Result<Picture, MetricsError> {
        Picture::new(self.size, self.rgb)
    }
}
