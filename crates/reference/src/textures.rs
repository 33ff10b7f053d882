//! Colours out of images.

use glam::{DVec2, DVec4};
use murano_scene::{Image, TextureRef, Wrap};

/// How an image stores its first three channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Linear,
    Srgb,
}

/// Colour of a texture slot, bilinear, of the finest level: samples of a pixel filter what is smaller. `None` where the
/// slot names nothing that can be shown.
pub(crate) fn sample(
    images: &[Image],
    slot: Option<TextureRef>,
    sets: [DVec2; 2],
    encoding: Encoding,
) -> Option<DVec4> {
    let slot = slot?;
    let image = images.get(slot.image).filter(|image| image.width > 0 && image.height > 0)?;
    let at = transformed(&slot, *sets.get(slot.texcoord)?) * DVec2::new(image.width.into(), image.height.into()) - 0.5;
    let base = at.floor();
    let share = at - base;
    let texel = |dx: i64, dy: i64| {
        let x = wrapped(base.x as i64 + dx, i64::from(image.width), slot.wrap[0]);
        let y = wrapped(base.y as i64 + dy, i64::from(image.height), slot.wrap[1]);
        decoded(image, y * image.width as usize + x, encoding)
    };
    let top = texel(0, 0).lerp(texel(1, 0), share.x);
    let bottom = texel(0, 1).lerp(texel(1, 1), share.x);
    Some(top.lerp(bottom, share.y))
}

/// KHR_texture_transform: translation times rotation times scale.
fn transformed(slot: &TextureRef, uv: DVec2) -> DVec2 {
    let scaled = uv * slot.scale.as_dvec2();
    let (sin, cos) = f64::from(slot.rotation).sin_cos();
    DVec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x) + slot.offset.as_dvec2()
}

fn wrapped(index: i64, size: i64, wrap: Wrap) -> usize {
    let within = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
        Wrap::Mirror => {
            let folded = index.rem_euclid(2 * size);
            folded.min(2 * size - 1 - folded)
        }
    };
    within as usize
}

fn decoded(image: &Image, texel: usize, encoding: Encoding) -> DVec4 {
    let [r, g, b, a] = image.rgba.get(texel).copied().unwrap_or_default().map(|byte| f64::from(byte) / 255.0);
    let linear = |c: f64| match encoding {
        Encoding::Linear => c,
        Encoding::Srgb if c <= 0.04045 => c / 12.92,
        Encoding::Srgb => ((c + 0.055) / 1.055).powf(2.4),
    };
    DVec4::new(linear(r), linear(g), linear(b), a)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    fn images() -> Vec<Image> {
        let rgba = vec![[0, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [255, 255, 188, 0]];
        vec![Image { name: String::new(), width: 2, height: 2, rgba }]
    }

    fn slot(wrap: Wrap) -> TextureRef {
        TextureRef { image: 0, texcoord: 1, wrap: [wrap; 2], offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE }
    }

    #[test]
    fn texels_are_blended_and_wrapped() {
        let images = images();
        let at = |slot, x, y| {
            sample(&images, Some(slot), [DVec2::ZERO, DVec2::new(x, y)], Encoding::Linear).unwrap().truncate()
        };
        let repeat = slot(Wrap::Repeat);
        assert_eq!(at(repeat, 0.75, 0.25), glam::DVec3::X);
        assert_eq!(at(repeat, -0.25, 1.25), glam::DVec3::X);
        assert!(at(repeat, 0.5, 0.5).abs_diff_eq(glam::DVec3::new(0.5, 0.5, 188.0 / 1020.0), 1e-12));
        assert_eq!(at(slot(Wrap::Clamp), -3.0, 0.25), glam::DVec3::ZERO);
        assert_eq!(at(slot(Wrap::Mirror), -0.25, 0.25), glam::DVec3::ZERO);
        let turned = TextureRef { rotation: std::f32::consts::FRAC_PI_2, ..repeat };
        // A quarter turn takes v to u.
        assert!(at(turned, 0.25, 0.75).abs_diff_eq(glam::DVec3::new(1.0, 1.0, 188.0 / 255.0), 1e-6));
    }

    #[test]
    fn srgb_is_decoded_and_what_is_missing_is_none() {
        let images = images();
        let sets = [DVec2::ZERO, DVec2::splat(0.75)];
        let colour = sample(&images, Some(slot(Wrap::Repeat)), sets, Encoding::Srgb).unwrap();
        assert!((colour.z - 0.502_886).abs() < 1e-4 && colour.x == 1.0, "{colour}");
        for missing in [TextureRef { image: 1, ..slot(Wrap::Repeat) }, TextureRef { texcoord: 2, ..slot(Wrap::Repeat) }]
        {
            assert!(sample(&images, Some(missing), sets, Encoding::Linear).is_none());
        }
        assert!(sample(&images, None, sets, Encoding::Linear).is_none());
    }
}
