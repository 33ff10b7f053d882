//! Receivers.

use glam::DVec3;

use super::PhotonError;
use crate::Ray;

/// What light is received by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Receiver {
    /// The plane of a window, from the side of its normal. Light that meets it goes no further.
    Plane(Window),
    /// The opaque things of the world.
    Opaque,
}

/// A picture of a part of a plane. World, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its middle.
    pub centre: DVec3,
    /// From the middle to the edge of the last column.
    pub half_u: DVec3,
    /// From the middle to the edge of row 0. Light arrives from the side of `half_u x half_v`.
    pub half_v: DVec3,
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Window {
    /// A square of half-width `half` on a horizontal plane, seen from above: columns towards +x, row 0 at -z.
    pub fn horizontal(centre: DVec3, half: f64, size: u32) -> Self {
        Self { centre, half_u: half * DVec3::X, half_v: half * DVec3::NEG_Z, size: [size, size] }
    }

    /// Unit; the side that receives light.
    pub fn normal(&self) -> DVec3 {
        self.half_u.cross(self.half_v).normalize_or_zero()
    }

    /// Area of a texel, m^2.
    pub fn texel_area(&self) -> f64 {
        4.0 * self.half_u.cross(self.half_v).length() / self.texels() as f64
    }

    /// How many there are.
    pub fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Centre of texel `index`, counted row by row from row 0.
    pub fn texel_centre(&self, index: usize) -> DVec3 {
        let width = self.size[0] as usize;
        let [column, row] = [index % width, index / width].map(|place| place as f64 + 0.5);
        let [width, height] = self.size.map(f64::from);
        self.centre + (2.0 * column / width - 1.0) * self.half_u + (1.0 - 2.0 * row / height) * self.half_v
    }

    /// The texel that holds a point of the plane.
    pub fn texel(&self, point: DVec3) -> Option<usize> {
        let across = self.half_u.cross(self.half_v);
        let to = (point - self.centre) / across.length_squared();
        let (u, v) = (to.cross(self.half_v).dot(across), self.half_u.cross(to).dot(across));
        let [width, height] = self.size;
        let column = (0.5 * (1.0 + u) * f64::from(width)).floor();
        let row = (0.5 * (1.0 - v) * f64::from(height)).floor();
        let within = |place: f64, count: u32| (0.0..f64::from(count)).contains(&place);
        (within(column, width) && within(row, height)).then(|| row as usize * width as usize + column as usize)
    }

    /// How far along the ray the plane is met, from the side of its normal.
    pub(super) fn meets(&self, ray: &Ray) -> Option<f64> {
        let normal = self.half_u.cross(self.half_v);
        let speed = ray.direction.dot(normal);
        let t = (self.centre - ray.origin).dot(normal) / speed;
        (speed < 0.0 && t > 0.0).then_some(t)
    }

    pub(super) fn check(&self) -> Result<(), PhotonError> {
        let spans = self.centre.is_finite() && self.half_u.cross(self.half_v).is_finite() && self.texel_area() > 0.0;
        if spans && self.texels() > 0 { Ok(()) } else { Err(PhotonError::NoWindow) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_hold_their_centres_and_rows_go_down() {
        let window = Window {
            centre: DVec3::new(1.0, 2.0, 3.0),
            half_u: DVec3::new(1.0, 0.5, 0.0),
            half_v: DVec3::new(-0.2, 1.0, 2.0),
            size: [7, 5],
        };
        for index in 0..window.texels() {
            assert_eq!(window.texel(window.texel_centre(index)), Some(index));
        }
        assert!(window.texel_centre(0).distance(window.centre - window.half_u + window.half_v) < 0.6);
        assert_eq!(window.texel(window.centre + 1.01 * window.half_u), None);
        assert_eq!(window.texel(window.centre - 1.01 * window.half_v), None);
        let ray = Ray { origin: window.centre + 2.0 * window.normal(), direction: -window.normal() };
        assert!((window.meets(&ray).unwrap() - 2.0).abs() < 1e-15);
        let behind = Ray { origin: window.centre - 2.0 * window.normal(), direction: window.normal() };
        assert_eq!(window.meets(&behind), None);
    }
}
