//! Refraction by a table instead of a square root (Horie, "Optimizing Refraction for Raytracing").

use glam::DVec3;

use crate::snell::cos_t_squared;

/// The factor a of the normal in T = eta I + a N, tabled over the cosine of incidence, for one eta.
///
/// Entry k of n stands for cosines from (k - 1/2) / n to (k + 1/2) / n: the error grows with the spacing of the cosines,
/// and without bounds towards the critical angle, where a has a vertical tangent. [`crate::snell`] is what it approximates.
#[derive(Clone, Debug, PartialEq)]
pub struct RefractionTable {
    eta: f64,
    /// `None` where light is totally reflected.
    factors: Vec<Option<f64>>,
}

impl RefractionTable {
    /// A table of `entries` steps (0 counts as 1) for eta = n_incident / n_transmitted.
    pub fn new(eta: f64, entries: usize) -> Self {
        let entries = entries.max(1);
        let factor = |entry: usize| {
            let cosine = entry as f64 / entries as f64;
            let k = cos_t_squared(cosine, eta);
            (k >= 0.0).then(|| eta * cosine - k.sqrt())
        };
        Self { eta, factors: (0..=entries).map(factor).collect() }
    }

    /// Steps from grazing to normal incidence.
    pub fn entries(&self) -> usize {
        self.factors.len() - 1
    }

    /// The factor of a cosine of incidence; cosines outside of 0 to 1 count as its ends, NaN as 0.
    fn factor(&self, cosine: f64) -> Option<f64> {
        let last = self.entries();
        self.factors[((cosine * last as f64 + 0.5) as usize).min(last)]
    }

    /// The refracted direction: unit but for the error of its entry; `None` under total internal reflection. `i` unit and
    /// towards the surface, `n` unit and against it.
    pub fn refract(&self, i: DVec3, n: DVec3) -> Option<DVec3> {
        self.factor(-i.dot(n)).map(|a| self.eta * i + a * n)
    }

    /// The refracted direction over eta, which spares a product of a scalar and a vector: of any length.
    pub fn refract_raw(&self, i: DVec3, n: DVec3) -> Option<DVec3> {
        self.factor(-i.dot(n)).map(|a| i + a / self.eta * n)
    }

    /// As [`Self::refract`], between two entries; next to total reflection, the nearer entry alone.
    pub fn refract_interpolated(&self, i: DVec3, n: DVec3) -> Option<DVec3> {
        let last = self.entries();
        let at = (-i.dot(n)).clamp(0.0, 1.0) * last as f64;
        let low = (at as usize).min(last);
        let high = (low + 1).min(last);
        match (self.factors[low], self.factors[high]) {
            (Some(a), Some(b)) => Some(self.eta * i + (a + (at - low as f64) * (b - a)) * n),
            _ => self.refract(i, n),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snell;

    /// Directions of incidence at cosines from 0 to 1.
    fn incident(cosine: f64) -> DVec3 {
        DVec3::new((1.0 - cosine * cosine).sqrt(), -cosine, 0.0)
    }

    #[test]
    fn entries_are_exact() {
        for eta in [1.0 / 1.5, 1.0, 1.5] {
            let table = RefractionTable::new(eta, 64);
            for entry in 0..=64 {
                let i = incident(f64::from(entry) / 64.0);
                let exact = snell(i, DVec3::Y, eta);
                for found in [table.refract(i, DVec3::Y), table.refract_interpolated(i, DVec3::Y)] {
                    assert_eq!(found.is_none(), exact.tir, "{eta}, entry {entry}");
                    let off = found.map_or(0.0, |direction| direction.distance(exact.direction));
                    assert!(off < 1e-12, "{eta}, entry {entry}: {off}");
                }
                let raw = table.refract_raw(i, DVec3::Y).map(DVec3::normalize);
                assert!(raw.is_none_or(|raw| raw.distance(exact.direction) < 1e-12));
            }
        }
    }

    #[test]
    fn finer_tables_are_nearer() {
        let worst = |entries: usize, interpolated: bool| {
            let table = RefractionTable::new(1.0 / 1.5, entries);
            let error = |step: i32| {
                let i = incident(f64::from(step) / 1000.0);
                let found =
                    if interpolated { table.refract_interpolated(i, DVec3::Y) } else { table.refract(i, DVec3::Y) };
                found.map_or(f64::NAN, |direction| direction.distance(snell(i, DVec3::Y, 1.0 / 1.5).direction))
            };
            (0..=1000).map(error).fold(0.0, f64::max)
        };
        assert!(worst(16, false) > 10.0 * worst(256, false) && worst(256, false) > 10.0 * worst(4096, false));
        assert!(worst(16, true) > 100.0 * worst(256, true) && worst(256, true) < worst(256, false));
    }

    #[test]
    fn hostile_numbers_find_an_entry() {
        for eta in [1.0, f64::NAN, 0.0, f64::INFINITY] {
            let table = RefractionTable::new(eta, 0);
            assert_eq!(table.entries(), 1);
            for cosine in [f64::NAN, f64::INFINITY, -2.0, 2.0] {
                table.refract_interpolated(DVec3::splat(cosine), DVec3::Y);
                table.refract(DVec3::splat(cosine), DVec3::Y);
            }
        }
    }
}
