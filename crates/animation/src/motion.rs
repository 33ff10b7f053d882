//! Dual-quaternion skinning: Kavan, Collins, Zara and O'Sullivan, "Geometric Skinning with Approximate Dual Quaternion Blending"
//! (2008). What is not rigid about a joint is blended linearly before: their section 4.2.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};

/// Below this squared length a sum of unit dual quaternions says nothing, and the first of them stands for all.
pub(crate) const LEAST_LENGTH_SQUARED: f64 = 0.01;

/// Steps of the polar decomposition; each at least doubles the digits once it is near.
const MOST_STEPS: u32 = 60;

/// A stretch about the origin, then a rigid motion: `x -> r (stretch x) r* + t`, with t = 2 `dual` r*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// r, unit.
    pub real: DQuat,
    /// t r / 2.
    pub dual: DQuat,
    /// Symmetric where the matrix is not singular; mirrors where the matrix does.
    pub stretch: DMat3,
}

impl Motion {
    /// An affine matrix as a stretch and a rigid motion.
    pub fn of(matrix: &DMat4) -> Self {
        let linear = DMat3::from_mat4(*matrix);
        let rotation = rotation_of(&linear);
        let real = DQuat::from_mat3(&rotation).normalize();
        let translation = matrix.w_axis.truncate();
        let dual = DQuat::from_xyzw(translation.x, translation.y, translation.z, 0.0) * real * 0.5;
        Self { real, dual, stretch: DMat3::from_quat(real).transpose() * linear }
    }

    /// The weighted mean of motions, on the hemisphere of the first; weights sum to 1. `None` without any.
    pub fn mean(parts: impl Iterator<Item = (f64, Self)>) -> Option<Self> {
        let mut first: Option<Self> = None;
        let (mut real, mut dual, mut stretch) = (DVec4::ZERO, DVec4::ZERO, DMat3::ZERO);
        for (weight, part) in parts {
            let leading = *first.get_or_insert(part);
            let signed = if leading.real.dot(part.real) < 0.0 { -weight } else { weight };
            real += DVec4::from(part.real) * signed;
            dual += DVec4::from(part.dual) * signed;
            stretch += part.stretch * weight;
        }
        let first = first?;
        let squared = real.length_squared();
        if squared < LEAST_LENGTH_SQUARED {
            return Some(Self { stretch, ..first });
        }
        let length = squared.sqrt();
        Some(Self { real: DQuat::from_vec4(real / length), dual: DQuat::from_vec4(dual / length), stretch })
    }

    /// The rigid part alone.
    pub fn carry(&self, stretched: DVec3) -> DVec3 {
        let translation = self.dual * self.real.conjugate() * 2.0;
        self.real * stretched + DVec3::new(translation.x, translation.y, translation.z)
    }

    /// All of it.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.carry(self.stretch * point)
    }
}

/// The rotation nearest a linear map (polar decomposition by Newton's iteration, scaled; Higham 1986), of its negative where
/// it mirrors. Of a singular map, some rotation.
fn rotation_of(linear: &DMat3) -> DMat3 {
    let size = linear.to_cols_array().into_iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
    let determinant = linear.determinant();
    if size.is_nan() || determinant.abs() <= 1e-12 * size.powi(3) {
        return frame_of(linear);
    }
    let mut current = if determinant < 0.0 { -*linear } else { *linear } * size.recip();
    for _ in 0..MOST_STEPS {
        let inverse = current.inverse().transpose();
        let norm = |matrix: &DMat3| matrix.to_cols_array().iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let scale = (norm(&inverse) / norm(&current)).sqrt();
        let next = (current * scale + inverse * scale.recip()) * 0.5;
        let change = norm(&(next - current));
        current = next;
        if change < 1e-15 {
            break;
        }
    }
    current
}

/// A rotation whose axes follow those of a singular map as far as it has any.
fn frame_of(linear: &DMat3) -> DMat3 {
    let x = linear.x_axis.try_normalize().or_else(|| linear.y_axis.cross(linear.z_axis).try_normalize());
    let x = x.unwrap_or(DVec3::X);
    let y = (linear.y_axis - x * x.dot(linear.y_axis)).try_normalize();
    let y = y.or_else(|| linear.z_axis.cross(x).try_normalize()).unwrap_or_else(|| x.any_orthonormal_vector());
    DMat3::from_cols(x, y, x.cross(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(scale: DVec3, angle: f64) -> DMat4 {
        let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), angle);
        DMat4::from_scale_rotation_translation(scale, rotation, DVec3::new(3.0, -1.0, 2.0))
    }

    #[test]
    fn a_motion_is_its_matrix() {
        let scales = [DVec3::ONE, DVec3::new(2.0, 0.5, 1.0), DVec3::new(-1.0, 1.0, 3.0), DVec3::new(1e-6, 1.0, 1e3)];
        let singular = [DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 0.0), DVec3::ZERO];
        for scale in scales.into_iter().chain(singular) {
            for angle in [0.0, 0.7, 3.0] {
                let mut matrix = matrix(scale, angle);
                // Not only scales along the axes.
                matrix.x_axis += 0.25 * matrix.y_axis;
                let motion = Motion::of(&matrix);
                assert!((motion.real.length() - 1.0).abs() < 1e-12);
                for point in [DVec3::ZERO, DVec3::ONE, DVec3::new(0.5, -2.0, 0.25)] {
                    let (found, wanted) = (motion.apply(point), matrix.transform_point3(point));
                    assert!(
                        found.distance(wanted) <= 1e-10 * wanted.length().max(1.0),
                        "{scale} {angle}: {found} {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn half_a_turn_keeps_the_radius_and_the_axis() {
        let turned = |degrees: f64| Motion::of(&DMat4::from_rotation_y(degrees.to_radians()));
        for degrees in [60.0, 120.0, 179.0] {
            let mean = Motion::mean([(0.5, turned(0.0)), (0.5, turned(degrees))].into_iter()).unwrap();
            let point = mean.apply(DVec3::new(1.0, 2.0, 0.0));
            let wanted = DQuat::from_rotation_y(0.5 * f64::to_radians(degrees)) * DVec3::new(1.0, 2.0, 0.0);
            assert!(point.distance(wanted) < 1e-12, "{degrees}: {point}");
        }
        assert!(Motion::mean(std::iter::empty()).is_none());
    }
}
