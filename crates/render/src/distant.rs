//! The environment as the GPU samples it.

use std::sync::Arc;

use bytemuck::cast_slice;
use glam::Vec4;
use half::f16;
use murano_gpu::{Leaf, TextureData};
use murano_scene::Environment;
use murano_scheduler::{Stamp, StampBuilder};

/// Texture and diffuse light of an environment, hashed once.
pub(crate) struct Distant {
    pub(crate) stamp: Stamp,
    pub(crate) leaf: Leaf,
    /// Cosine-convolved spherical harmonics over pi.
    pub(crate) ambient: [Vec4; 9],
}

impl Distant {
    /// Of an environment, or black for none.
    pub(crate) fn new(environment: Option<&Environment>) -> Self {
        let (size, levels, ambient) = match environment {
            Some(environment) => {
                let levels = environment.mip_chain();
                let ambient = environment.irradiance_sh().map(|[r, g, b]| Vec4::new(r as f32, g as f32, b as f32, 0.0));
                let size = [environment.width, environment.height];
                (size, levels.iter().map(|(_, _, texels)| half_floats(texels)).collect(), ambient)
            }
            None => ([1, 1], vec![half_floats(&[[0.0; 3]])], [Vec4::ZERO; 9]),
        };
        let mut stamp = StampBuilder::new("environment");
        stamp.number(u64::from(size[0])).number(u64::from(size[1]));
        for level in &levels {
            stamp.bytes(cast_slice::<u16, u8>(level));
        }
        Self { stamp: stamp.finish(), leaf: Leaf::Texture(Arc::new(TextureData { size, levels })), ambient }
    }
}

/// RGBA half-float bits; what exceeds the format is clamped to its largest value.
fn half_floats(texels: &[[f32; 3]]) -> Vec<u16> {
    let largest = f16::MAX.to_f32();
    texels
        .iter()
        .flat_map(|&[r, g, b]| [r, g, b, 1.0].map(|value| f16::from_f32(value.min(largest)).to_bits()))
        .collect()
}
