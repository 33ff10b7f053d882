//! Arbitrary output variables: gathered from the passes' buffers into named planes.

use glam::{DVec3, DVec4, Vec4};
use murano_refraction::PATH_ROWS;

use crate::{AOV_LAYERS, Aov, AovLayer, lighting::LIGHT_ROWS};

/// The buffers that the layers come from.
pub(crate) struct Layers<'a> {
    pub(crate) origin: DVec3,
    pub(crate) pixels: usize,
    pub(crate) colour: &'a [u8],
    /// One buffer each time that a body is drawn.
    pub(crate) paths: &'a [Vec<u8>],
    /// One buffer a lamp.
    pub(crate) lights: &'a [Vec<u8>],
    /// One buffer for the opaque scene, then one a body; none where no frame before is known.
    pub(crate) motions: &'a [Vec<u8>],
}

/// The first `count` rows of a buffer of `vec4f`.
pub(crate) fn rows(bytes: &[u8], count: usize) -> impl Iterator<Item = DVec4> {
    bytes.chunks_exact(16).take(count).map(|row| bytemuck::pod_read_unaligned::<[f32; 4]>(row).map(f64::from).into())
}

fn row(bytes: &[u8], index: usize) -> Vec4 {
    bytemuck::pod_read_unaligned::<[f32; 4]>(&bytes[16 * index..16 * index + 16]).into()
}

const XYZ: &[&str] = &["X", "Y", "Z"];
const XY: &[&str] = &["X", "Y"];
const RGB: &[&str] = &["R", "G", "B"];
const SINGLE: &[&str] = &[""];

/// One pixel's values, in the order of [`AOV_LAYERS`].
struct Pixel {
    path: [Vec4; PATH_ROWS],
    colour: Vec4,
    caustic: DVec3,
    shadow: DVec3,
    motion: Vec4,
}

impl Layers<'_> {
    pub(crate) fn gather(&self) -> Aov {
        let mut layers: Vec<AovLayer> = AOV_LAYERS
            .iter()
            .map(|&name| {
                let channels = match name {
                    "radiance" | "caustic" | "shadow" => RGB,
                    "path_length" | "bounces" | "status" | "depth" | "entries" | "triangles" | "guessed" => SINGLE,
                    "motion" => XY,
                    _ => XYZ,
                };
                AovLayer { name, channels, planes: vec![vec![0.0; self.pixels]; channels.len()] }
            })
            .collect();
        for index in 0..self.pixels {
            let pixel = self.pixel(index);
            for layer in &mut layers {
                let value = self.value(layer.name, &pixel);
                for (channel, plane) in layer.planes.iter_mut().enumerate() {
                    plane[index] = value[channel] as f32;
                }
            }
        }
        Aov { layers }
    }

    fn pixel(&self, index: usize) -> Pixel {
        let read = |bytes: &[u8]| std::array::from_fn(|r| row(bytes, PATH_ROWS * index + r));
        // The nearest body that drew here; a pixel without status was not drawn by that body.
        let path = self
            .paths
            .iter()
            .map(|bytes| read(bytes))
            .filter(|path: &[Vec4; PATH_ROWS]| path[0].w > 0.0)
            .min_by(|a, b| a[3].w.total_cmp(&b[3].w))
            .unwrap_or([Vec4::ZERO; PATH_ROWS]);
        let mut caustic = DVec3::ZERO;
        let mut direct = DVec3::ZERO;
        let mut arrived = DVec3::ZERO;
        for light in self.lights {
            let [thrown, unshadowed, share] =
                std::array::from_fn(|r| row(light, LIGHT_ROWS * index + r).truncate().as_dvec3());
            caustic += thrown;
            direct += unshadowed;
            arrived += unshadowed * share;
        }
        // Of what is nearest; of the surroundings, which are in the first buffer, where there is nothing.
        let moving = self.motions.iter().map(|bytes| row(bytes, index));
        let nearest = moving.clone().filter(|motion| motion.z > 0.0).min_by(|a, b| a.z.total_cmp(&b.z));
        let motion = nearest.or_else(|| moving.clone().next()).unwrap_or(Vec4::ZERO);
        let share = |c: usize| if direct[c] > 0.0 { arrived[c] / direct[c] } else { 1.0 };
        Pixel {
            path,
            colour: row(self.colour, index),
            caustic,
            shadow: DVec3::new(share(0), share(1), share(2)),
            motion,
        }
    }

    fn value(&self, layer: &str, pixel: &Pixel) -> DVec3 {
        let path = &pixel.path;
        let covered = path[0].w > 0.0;
        let vector = |r: usize| path[r].truncate().as_dvec3();
        let place = |r: usize| if covered { vector(r) + self.origin } else { DVec3::ZERO };
        let single = |value: f32| DVec3::splat(f64::from(value));
        match layer {
            "p1" => place(0),
            "n1" => vector(1),
            "t1" => vector(2),
            "p2" => place(3),
            "n2" => vector(4),
            "exit_direction" => vector(5),
            "path_length" => single(path[2].w),
            "bounces" => single(path[1].w),
            "status" => single(path[0].w),
            "depth" => single(pixel.colour.w),
            "radiance" => pixel.colour.truncate().as_dvec3(),
            "caustic" => pixel.caustic,
            "entries" => single(path[4].w),
            "triangles" => single(path[5].w),
            "guessed" => single(path[6].x),
            "motion" => DVec3::new(pixel.motion.x.into(), pixel.motion.y.into(), 0.0),
            _ => pixel.shadow,
        }
    }
}
