//! Implicit modelling: smooth signed fields (negative inside) from which the characters are carved.

use glam::{DMat3, DVec3};

/// Smooth minimum of two fields: equal to the smaller one where they differ by more than `radius`, and twice
/// differentiable across the blend, so that refraction shows no crease there.
pub fn smooth_union(a: f64, b: f64, radius: f64) -> f64 {
    let overlap = ((radius - (a - b).abs()) / radius).max(0.0);
    a.min(b) - overlap * overlap * overlap * radius / 6.0
}

/// Smooth maximum: the part common to both, with a rounded edge.
pub fn smooth_intersection(a: f64, b: f64, radius: f64) -> f64 {
    -smooth_union(-a, -b, radius)
}

/// Hermite step: 0 below `low`, 1 above `high`, twice differentiable.
pub fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// Gradient of `field` at `p` by central differences.
pub fn gradient(field: &dyn Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    const STEP: f64 = 1e-5;
    let slope = |axis: DVec3| (field(p + axis * STEP) - field(p - axis * STEP)) / (2.0 * STEP);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}

/// Newton's iteration along the gradient onto the zero set of `field`; no step is longer than `reach` metres.
pub fn project(field: &dyn Fn(DVec3) -> f64, mut p: DVec3, reach: f64) -> DVec3 {
    for _ in 0..5 {
        let value = field(p);
        if value.abs() < 1e-10 {
            break;
        }
        let slope = gradient(field, p);
        let step = slope * (value / slope.length_squared().max(1e-6));
        p -= step.clamp_length_max(reach);
    }
    p
}

/// Largest principal curvature (absolute, per metre) of the level set of `field` through `p`, seen over `reach` metres.
pub fn max_curvature(field: &dyn Fn(DVec3) -> f64, p: DVec3, reach: f64) -> f64 {
    let normal = gradient(field, p).normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let change = |axis: DVec3| {
        let normal_at = |q: DVec3| gradient(field, q).normalize();
        (normal_at(p + axis * reach) - normal_at(p - axis * reach)) / (2.0 * reach)
    };
    let (du, dv) = (change(u), change(v));
    // Eigenvalues of the symmetric part of the shape operator.
    let (a, b, c) = (du.dot(u), f64::midpoint(du.dot(v), dv.dot(u)), dv.dot(v));
    let (mean, spread) = (f64::midpoint(a, c), ((a - c) * (a - c) / 4.0 + b * b).sqrt());
    mean.abs() + spread
}

/// Distance to an ellipsoid about the origin, exact on its surface and to first order near it (Quilez).
pub fn ellipsoid(p: DVec3, radii: DVec3) -> f64 {
    let scaled = (p / radii).length();
    let slope = (p / (radii * radii)).length();
    if slope < 1e-12 { -radii.min_element() } else { scaled * (scaled - 1.0) / slope }
}

/// One cross-section of a [`Loft`]: an ellipse, metres.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Half axis along the loft's first transverse direction.
    pub half_u: f64,
    /// Half axis along the second.
    pub half_v: f64,
    /// Shift of the centre along the second.
    pub shift_v: f64,
}

/// Shorthand for a [`Section`].
pub fn section(half_u: f64, half_v: f64, shift_v: f64) -> Section {
    Section { half_u, half_v, shift_v }
}

/// A limb: elliptic cross-sections along a straight axis. The sections are the control values of a uniform cubic
/// B-spline, so the surface is twice differentiable between its ellipsoidal ends.
#[derive(Clone, Debug)]
pub struct Loft {
    /// Where the axis starts.
    pub start: DVec3,
    /// Axis, first and second transverse direction, orthonormal.
    pub frame: DMat3,
    /// Length of the axis, metres.
    pub length: f64,
    /// Evenly spaced cross-sections from start to end.
    pub sections: Vec<Section>,
    /// How far the rounded ends reach beyond start and end, metres.
    pub caps: [f64; 2],
}

impl Loft {
    /// Signed field: the distance to first order near the surface.
    pub fn field(&self, p: DVec3) -> f64 {
        let q = self.frame.transpose() * (p - self.start);
        let along = q.x.clamp(0.0, self.length);
        let cap = if q.x < 0.0 { self.caps[0] } else { self.caps[1] };
        let Section { half_u, half_v, shift_v } = self.section_at(along / self.length);
        ellipsoid(DVec3::new(q.x - along, q.y, q.z - shift_v), DVec3::new(cap, half_u, half_v))
    }

    /// Box that holds the limb, metres.
    pub fn bounds(&self) -> [DVec3; 2] {
        let widest = |width: fn(&Section) -> f64| self.sections.iter().map(width).fold(0.0, f64::max);
        let (u, v) = (widest(|s| s.half_u), widest(|s| s.half_v + s.shift_v.abs()));
        let across = self.frame.y_axis.abs() * u + self.frame.z_axis.abs() * v;
        let tips = [-self.caps[0], self.length + self.caps[1]].map(|x| self.start + self.frame.x_axis * x);
        [tips[0].min(tips[1]) - across, tips[0].max(tips[1]) + across]
    }

    /// Station along the axis at the foot of `p`, metres from the start.
    pub fn station(&self, p: DVec3) -> f64 {
        self.frame.x_axis.dot(p - self.start)
    }

    fn section_at(&self, t: f64) -> Section {
        let [half_u, half_v, shift_v] = b_spline(&self.sections, t, |s| [s.half_u, s.half_v, s.shift_v]);
        Section { half_u, half_v, shift_v }
    }
}

/// Uniform cubic B-spline through the end values of `controls` (end slopes zero by mirrored controls), at t in 0..1.
pub fn b_spline<T, const N: usize>(controls: &[T], t: f64, values: impl Fn(&T) -> [f64; N]) -> [f64; N] {
    let last = controls.len() as i64 - 1;
    let position = t.clamp(0.0, 1.0) * last as f64;
    let knot = (position.floor() as i64).min(last - 1);
    let f = position - knot as f64;
    let g = 1.0 - f;
    let basis = [
        g * g * g / 6.0,
        (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0,
        (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0,
        f * f * f / 6.0,
    ];
    let mut sum = [0.0; N];
    for (i, weight) in basis.into_iter().enumerate() {
        let index = knot + i as i64 - 1;
        let inner = values(&controls[index.clamp(0, last) as usize]);
        if (0..=last).contains(&index) {
            for (total, value) in sum.iter_mut().zip(inner) {
                *total += weight * value;
            }
        } else {
            // Reflected control: makes the spline pass through its end value.
            let neighbour = values(&controls[if index < 0 { 1 } else { last as usize - 1 }]);
            for ((total, end), next) in sum.iter_mut().zip(inner).zip(neighbour) {
                *total += weight * (2.0 * end - next);
            }
        }
    }
    sum
}
