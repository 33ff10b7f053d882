//! Multi-layer OpenEXR.

use std::path::Path;

use anyhow::{Result, bail};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use murano_render::Aov;

use super::whole_file::write_whole;

/// Writes the layers named, in f32, as one part whose channels are called `layer.suffix` ("Layers" in the `OpenEXR`
/// documentation); a layer of one channel gives it its own name.
///
/// # Errors
/// When a layer was not rendered, or the file cannot be written.
pub fn write(path: &Path, size: [u32; 2], mut aov: Aov, layers: &[String]) -> Result<()> {
    let mut channels = SmallVec::new();
    for name in layers {
        let Some(position) = aov.layers.iter().position(|layer| layer.name == name) else {
            bail!("the layer `{name}` was not rendered");
        };
        let layer = aov.layers.swap_remove(position);
        for (suffix, plane) in layer.channels.iter().zip(layer.planes) {
            let channel = if suffix.is_empty() { name.clone() } else { format!("{name}.{suffix}") };
            channels.push(AnyChannel::new(channel.as_str(), FlatSamples::F32(plane)));
        }
    }
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let size = (size[0] as usize, size[1] as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(channels));
    write_whole(path, |file| Ok(Image::from_layer(layer).write().to_buffered(file)?))
}
