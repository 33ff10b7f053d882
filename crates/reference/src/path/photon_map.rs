//! Light that photons brought to opaque surfaces, looked up by place (Jensen 1996, with a fixed radius).

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DVec3, I64Vec3};

use crate::Landing;

/// Photons on opaque surfaces, ready to be gathered: what [`crate::trace_photons`] lands on [`crate::Receiver::Opaque`].
///
/// The density at a point is that of the photons within `radius`, weighed by Epanechnikov's kernel: features narrower than
/// about the radius are blurred, and light fades within a radius of a surface's border. The noise of a lookup falls with
/// the square root of the photons in reach.
pub struct PhotonMap {
    radius: f64,
    /// Ordered by cell.
    photons: Vec<Photon>,
    cells: HashMap<I64Vec3, std::ops::Range<usize>>,
}

struct Photon {
    position: DVec3,
    direction: DVec3,
    flux: DVec3,
}

impl PhotonMap {
    /// Sorts photons for lookups of `radius`, metres, positive.
    pub fn new(landings: impl IntoIterator<Item = Landing>, radius: f64) -> Self {
        let radius = radius.max(f64::MIN_POSITIVE.sqrt());
        let mut filed: Vec<(I64Vec3, Photon)> = landings
            .into_iter()
            .map(|Landing { position, direction, flux, .. }| {
                (cell(position, radius), Photon { position, direction, flux })
            })
            .collect();
        // Stable, so that sums do not depend on anything but the order of the landings.
        filed.sort_by_key(|(cell, _)| cell.to_array());
        let mut cells: HashMap<I64Vec3, std::ops::Range<usize>> = HashMap::new();
        for (index, (cell, _)) in filed.iter().enumerate() {
            cells.entry(*cell).or_insert(index..index).end = index + 1;
        }
        Self { radius, photons: filed.into_iter().map(|(_, photon)| photon).collect(), cells }
    }

    /// Photons held.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Calls `add` for every photon that counts at a point of a surface of this unit normal, with the direction that the
    /// light came from and its irradiance.
    pub(super) fn gather(&self, position: DVec3, normal: DVec3, mut add: impl FnMut(DVec3, DVec3)) {
        if self.photons.is_empty() {
            return;
        }
        let squared = self.radius * self.radius;
        let middle = cell(position, self.radius);
        for neighbour in 0..27 {
            let step = I64Vec3::new(neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1);
            let Some(range) = self.cells.get(&(middle + step)) else { continue };
            for photon in &self.photons[range.clone()] {
                let to = photon.position - position;
                let share = 1.0 - to.length_squared() / squared;
                // Of the same surface: it lies in this one's plane, and its light comes from the same side.
                let same = to.dot(normal).abs() <= 0.25 * self.radius && photon.direction.dot(normal) < 0.0;
                if share > 0.0 && same {
                    add(-photon.direction, photon.flux * (2.0 * share / (PI * squared)));
                }
            }
        }
    }
}

fn cell(position: DVec3, radius: f64) -> I64Vec3 {
    (position / radius).floor().as_i64vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PhotonClass;

    #[test]
    fn even_light_is_even_and_other_surfaces_do_not_count() {
        let side = 200;
        let landings = (0..2 * side * side).map(|i| {
            let [column, row] = [i % side, i / side % side].map(|place| (f64::from(place) + 0.5) / f64::from(side));
            // The second layer lies beneath and is lit from below.
            let below = f64::from(i / (side * side));
            Landing {
                position: DVec3::new(column, -1e-3 * below, row),
                direction: (2.0 * below - 1.0) * DVec3::Y,
                flux: DVec3::new(3.0, 2.0, 1.0) / f64::from(side * side),
                class: PhotonClass::ALL[0],
                triangle: None,
                half: 0,
            }
        });
        let map = PhotonMap::new(landings, 0.05);
        assert_eq!(map.len(), 80_000);
        let mut irradiance = DVec3::ZERO;
        map.gather(DVec3::new(0.4321, 0.0, 0.61), DVec3::Y, |towards, light| {
            assert_eq!(towards, DVec3::Y);
            irradiance += light;
        });
        // 314 photons of a grid: the kernel is zero at its border, so that their number hardly matters.
        assert!(irradiance.abs_diff_eq(DVec3::new(3.0, 2.0, 1.0), 0.01), "{irradiance}");
        let mut found = 0;
        map.gather(DVec3::new(0.5, 1.0, 0.5), DVec3::Y, |_, _| found += 1);
        assert_eq!(found, 0);
    }
}
