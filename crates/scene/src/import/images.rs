//! Images that materials use, decoded once each.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use bytemuck::allocation::try_cast_vec;
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};

use super::accessors::Accessors;
use super::container::load_uri;
use super::document::{Document, get, label};
use super::error::ImportProblem;
use crate::Image;

/// Largest side accepted, texels; no GPU samples a larger one.
const MAX_SIDE: u32 = 16384;

/// Most texels of all images together: 2 GiB of RGBA.
const MAX_TEXELS: u64 = 1 << 29;

/// Most texels in a byte of a file: deflate writes up to 1032 bytes for one, of eight texels each.
const TEXELS_PER_BYTE: u64 = 8 * 1032;

/// Most texels in a byte of a JPEG: each block of 64 takes a bit at least.
const JPEG_TEXELS_PER_BYTE: u64 = 8 * 64;

/// Decodes images on first use and numbers them in that order.
pub(super) struct Images<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    directory: Option<&'a Path>,
    decoded: Vec<Image>,
    places: HashMap<usize, usize>,
}

impl<'a> Images<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>, directory: Option<&'a Path>) -> Self {
        Self { document, accessors, directory, decoded: Vec::new(), places: HashMap::new() }
    }

    /// Index into the imported images of the document's image `index`.
    pub(super) fn import(&mut self, index: usize, user: &str) -> Result<usize, ImportProblem> {
        if let Some(&place) = self.places.get(&index) {
            return Ok(place);
        }
        let image = self.decode(index, user)?;
        self.places.insert(index, self.decoded.len());
        self.decoded.push(image);
        Ok(self.decoded.len() - 1)
    }

    /// Every image imported.
    pub(super) fn into_decoded(self) -> Vec<Image> {
        self.decoded
    }

    fn decode(&self, index: usize, user: &str) -> Result<Image, ImportProblem> {
        let source = get(&self.document.images, index, "images", user)?;
        let file = source.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let name = source.name.as_deref().or(file).unwrap_or_default();
        let at = label("images", index, Some(name));
        let loaded;
        let bytes: &[u8] = match (&source.uri, source.buffer_view) {
            (Some(uri), _) => {
                loaded = load_uri(uri, self.directory, &at)?;
                &loaded
            }
            (None, Some(view)) => self.accessors.view(view, &at)?.0,
            (None, None) => {
                return Err(ImportProblem::Schema { at, problem: "neither uri nor bufferView".to_owned() });
            }
        };
        let failed = |problem: String| ImportProblem::Image { at: at.clone(), problem };
        let mut reader =
            ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| failed(error.to_string()))?;
        let jpeg = reader.format() == Some(ImageFormat::Jpeg);
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(|error| failed(error.to_string()))?;
        let (width, height) = decoder.dimensions();
        let texels = u64::from(width) * u64::from(height);
        let most = if jpeg { JPEG_TEXELS_PER_BYTE } else { TEXELS_PER_BYTE };
        if texels > most * bytes.len() as u64 {
            return Err(failed(format!("{} bytes cannot hold {width}x{height} texels, it is truncated", bytes.len())));
        }
        let held: u64 = self.decoded.iter().map(|image| image.rgba.len() as u64).sum();
        if width.max(height) > MAX_SIDE || held + texels > MAX_TEXELS {
            return Err(failed(format!("{width}x{height} texels are too many; scale it down")));
        }
        let decoded = DynamicImage::from_decoder(decoder).map_err(|error| failed(error.to_string()))?;
        let rgba = try_cast_vec(decoded.into_rgba8().into_raw())
            .unwrap_or_else(|(_, bytes)| bytes.as_chunks::<4>().0.to_vec());
        Ok(Image { name: name.to_owned(), width, height, rgba })
    }
}
