//! Indices that the import itself may never follow: a file in which they are wrong is damaged all the same.

use super::compression;
use super::document::{Document, get, label};
use super::error::ImportProblem;

/// Checks the references of accessors, buffer views, images and textures, used or not.
pub(super) fn check(document: &Document) -> Result<(), ImportProblem> {
    for (index, view) in document.buffer_views.iter().enumerate() {
        let at = format!("bufferViews[{index}]");
        let buffer = get(&document.buffers, view.buffer, "buffers", &at)?;
        let needed = view.byte_offset.saturating_add(view.byte_length);
        if needed > buffer.byte_length {
            return Err(ImportProblem::OutOfBounds { at, needed, available: buffer.byte_length });
        }
        if let Some(compression) = compression::of(view, &at)? {
            let buffer = get(&document.buffers, compression.buffer, "buffers", &at)?;
            let needed = compression.byte_offset.saturating_add(compression.byte_length);
            if needed > buffer.byte_length {
                return Err(ImportProblem::OutOfBounds { at, needed, available: buffer.byte_length });
            }
        }
    }
    for (index, accessor) in document.accessors.iter().enumerate() {
        let at = format!("accessors[{index}]");
        let sparse = accessor.sparse.as_ref();
        let sparse_views = sparse.map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
        for view in accessor.buffer_view.into_iter().chain(sparse_views.into_iter().flatten()) {
            get(&document.buffer_views, view, "bufferViews", &at)?;
        }
    }
    for (index, image) in document.images.iter().enumerate() {
        if let Some(view) = image.buffer_view {
            get(&document.buffer_views, view, "bufferViews", &label("images", index, image.name.as_deref()))?;
        }
    }
    for (index, texture) in document.textures.iter().enumerate() {
        let at = format!("textures[{index}]");
        if let Some(source) = texture.source {
            get(&document.images, source, "images", &at)?;
        }
        if let Some(sampler) = texture.sampler {
            get(&document.samplers, sampler, "samplers", &at)?;
        }
    }
    Ok(())
}
