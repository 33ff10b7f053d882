//! Joints that move vertices together, and the room that such vertices may take up when their motions are blended as dual
//! quaternions: unlike a mean of matrices, that leaves the hull of what each joint alone would do.

use std::collections::BTreeMap;

use glam::DVec3;
use murano_scene::Primitive;

use crate::bounds::Bounds;
use crate::motion::{LEAST_LENGTH_SQUARED, Motion};
use crate::targets::displacement;

/// Entries up to which all points are looked at for every pair of them.
const FEW: usize = 8;

/// Vertices that the same palette entries move.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Company {
    /// Palette entries, in order.
    pub entries: Vec<u32>,
    /// Bounds of the rest positions, relative to the pivot.
    pub rest: Bounds,
    /// Bounds of their displacements and zero, per morph target.
    pub displacements: Vec<Bounds>,
}

/// Sorts the vertices of an instance by the entries that move them.
pub(crate) fn companies(primitive: &Primitive, sources: &[usize], entries: &[Vec<u32>], pivot: DVec3) -> Vec<Company> {
    let mut sorted: BTreeMap<Vec<u32>, Company> = BTreeMap::new();
    for (&source, entries) in sources.iter().zip(entries) {
        let mut key = entries.clone();
        key.sort_unstable();
        let company = sorted.entry(key.clone()).or_insert_with(|| Company {
            entries: key,
            rest: Bounds::EMPTY,
            displacements: vec![Bounds::point(DVec3::ZERO); primitive.targets.len()],
        });
        company.rest.include(primitive.positions[source].as_dvec3() - pivot);
        for (target, bounds) in company.displacements.iter_mut().enumerate() {
            if let Some([position, ..]) = displacement(primitive, target, source) {
                bounds.include(position.as_dvec3());
            }
        }
    }
    sorted.into_values().collect()
}

impl Company {
    /// World bounds of its vertices under any mean of its entries' motions.
    ///
    /// With the stretched point as origin, a mean of motions of weights w carries it to
    /// `sum w_i w_j (c_ij t_i + (t_i - t_j) x v_ij / 2) / sum w_i w_j c_ij`, where t are where the motions alone carry it, and
    /// c and v the scalar and vector part of `r_i r_j*`: a mean of the t, and less than `(1 - 1/k) max|t_i - t_j| max|v| / (2 min c)`
    /// aside.
    pub fn posed_bounds(&self, motions: &[Motion], weights: &[f64]) -> Bounds {
        let morphed = self.rest.morphed(&self.displacements, weights);
        let own: Vec<&Motion> = self.entries.iter().map(|&entry| &motions[entry as usize]).collect();
        let stretched: Vec<DVec3> =
            own.iter().flat_map(|motion| morphed.corners().map(|corner| motion.stretch * corner)).collect();
        let bounds = Bounds::of(own.iter().flat_map(|motion| stretched.iter().map(|&point| motion.carry(point))));
        if own.len() < 2 {
            return bounds;
        }
        // Two motions are farthest apart at a corner of any box around the points.
        let points = if own.len() > FEW { Bounds::of(stretched.iter().copied()).corners().to_vec() } else { stretched };
        let (mut apart, mut turned, mut alike) = (0.0_f64, 0.0_f64, 1.0_f64);
        for (index, a) in own.iter().enumerate() {
            // Quaternions on the hemisphere of the first; where others are not on one another's, sums may be short.
            let sign = |motion: &Motion| if own[0].real.dot(motion.real) < 0.0 { -1.0 } else { 1.0 };
            for b in &own[index + 1..] {
                let cosine = sign(a) * sign(b) * a.real.dot(b.real);
                alike = alike.min(cosine);
                turned = turned.max((1.0 - cosine * cosine).max(0.0).sqrt());
                let distances = points.iter().map(|&point| a.carry(point).distance(b.carry(point)));
                apart = distances.fold(apart, f64::max);
            }
        }
        let aside = (1.0 - 1.0 / own.len() as f64) * apart * turned / (2.0 * alike.max(LEAST_LENGTH_SQUARED));
        bounds.widened(aside)
    }
}
