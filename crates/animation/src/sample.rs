//! The value of a curve at a time (glTF 2.0, appendix C), in f64 from the stored f32 keys.

use glam::{DQuat, DVec3, DVec4};
use murano_scene::{Interpolation, Sampler};

/// Where a time falls among the keys: at key `index` exactly, or between it and the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Moment {
    At(usize),
    Between {
        index: usize,
        /// Share of the way to the next key, inside (0, 1).
        share: f64,
        /// Seconds between the two keys.
        length: f64,
    },
}

/// Finds the keys around a time by binary search. Before the first key (and for a time that is not a number) that is the
/// first key, after the last the last. `None` without keys.
pub(crate) fn locate(times: &[f32], time: f64) -> Option<Moment> {
    let last = times.len().checked_sub(1)?;
    let passed = times.partition_point(|&key| f64::from(key) <= time);
    let Some(index) = passed.checked_sub(1) else { return Some(Moment::At(0)) };
    let start = f64::from(times[index]);
    if index == last || start == time {
        return Some(Moment::At(index));
    }
    let length = f64::from(times[index + 1]) - start;
    Some(Moment::Between { index, share: (time - start) / length, length })
}

/// A curve whose value list has been checked against its key count.
struct Curve<'a> {
    sampler: &'a Sampler,
    moment: Moment,
}

impl<'a> Curve<'a> {
    /// `None` for a sampler without keys, with too few values, or with fewer than `width` components a value.
    fn at(sampler: &'a Sampler, width: usize, time: f64) -> Option<Self> {
        let rows = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let needed = sampler.times.len().checked_mul(rows)?.checked_mul(sampler.width)?;
        let moment = locate(&sampler.times, time)?;
        (sampler.width >= width && sampler.values.len() >= needed).then_some(Self { sampler, moment })
    }

    /// One component of the value of a key.
    fn value(&self, key: usize, component: usize) -> f64 {
        let row = if self.sampler.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key };
        self.stored(row, component)
    }

    fn stored(&self, row: usize, component: usize) -> f64 {
        f64::from(self.sampler.values[row * self.sampler.width + component])
    }

    /// One component at the moment, interpolated by itself.
    fn component(&self, component: usize) -> f64 {
        match (self.moment, self.sampler.interpolation) {
            (Moment::At(key), _) | (Moment::Between { index: key, .. }, Interpolation::Step) => {
                self.value(key, component)
            }
            (Moment::Between { index, share, .. }, Interpolation::Linear) => {
                (1.0 - share) * self.value(index, component) + share * self.value(index + 1, component)
            }
            (Moment::Between { index, share, length }, Interpolation::CubicSpline) => {
                let out_tangent = self.stored(3 * index + 2, component);
                let in_tangent = self.stored(3 * (index + 1), component);
                let ends = [self.value(index, component), self.value(index + 1, component)];
                hermite(ends, [length * out_tangent, length * in_tangent], share)
            }
        }
    }
}

/// Cubic Hermite spline over the unit interval: values and derivatives at its ends (glTF 2.0, appendix C.5).
fn hermite(values: [f64; 2], derivatives: [f64; 2], t: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * values[0]
        + (t3 - 2.0 * t2 + t) * derivatives[0]
        + (3.0 * t2 - 2.0 * t3) * values[1]
        + (t3 - t2) * derivatives[1]
}

/// A translation (metres) or scale at a time in seconds. `None` if the sampler lacks keys, values or components.
pub fn sample_vector(sampler: &Sampler, time: f64) -> Option<DVec3> {
    let curve = Curve::at(sampler, 3, time)?;
    Some(DVec3::from_array([0, 1, 2].map(|axis| curve.component(axis))))
}

/// A rotation at a time in seconds, of unit length. Linear curves turn by the shortest path at constant speed; splines
/// are interpolated by component and normalised after. `None` if the sampler lacks keys, values or components.
pub fn sample_rotation(sampler: &Sampler, time: f64) -> Option<DQuat> {
    let curve = Curve::at(sampler, 4, time)?;
    if let (Moment::Between { index, share, .. }, Interpolation::Linear) = (curve.moment, sampler.interpolation) {
        let key = |index| unit([0, 1, 2, 3].map(|axis| curve.value(index, axis)));
        return Some(slerp(key(index), key(index + 1), share));
    }
    Some(unit([0, 1, 2, 3].map(|axis| curve.component(axis))))
}

/// Morph weights at a time in seconds, as many as a key of the sampler holds. `None` if the sampler lacks keys or values.
pub fn sample_weights(sampler: &Sampler, time: f64) -> Option<Vec<f64>> {
    let curve = Curve::at(sampler, 0, time)?;
    Some((0..sampler.width).map(|target| curve.component(target)).collect())
}

/// The unit quaternion along x, y, z, w; the identity if they are all zero.
fn unit(components: [f64; 4]) -> DQuat {
    DQuat::from_vec4(DVec4::from_array(components).normalize_or(DVec4::W))
}

/// Shortest-path spherical interpolation of unit quaternions. The angle comes from both chords, which keeps it exact
/// where the cosine is flat (W. Kahan, "How futile are mindless assessments of roundoff", section 12).
fn slerp(from: DQuat, to: DQuat, share: f64) -> DQuat {
    let from = DVec4::from(from);
    let to = if from.dot(to.into()) < 0.0 { -DVec4::from(to) } else { to.into() };
    let angle = 2.0 * (to - from).length().atan2((to + from).length());
    let sine = angle.sin();
    let blended = if sine > f64::MIN_POSITIVE {
        (from * ((1.0 - share) * angle).sin() + to * (share * angle).sin()) / sine
    } else {
        from
    };
    DQuat::from_vec4(blended.normalize_or(DVec4::W))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn sampler(interpolation: Interpolation, times: &[f32], width: usize, values: &[f32]) -> Sampler {
        Sampler { interpolation, times: times.to_vec(), width, values: values.to_vec() }
    }

    #[test]
    fn slerp_of_two_keys_draws_a_circle_at_constant_speed() {
        let half = 75.0f64.to_radians() as f32;
        let curve =
            sampler(Interpolation::Linear, &[1.0, 3.0], 4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()]);
        for step in 0..=200 {
            let share = f64::from(step) / 200.0;
            let point = sample_rotation(&curve, 1.0 + 2.0 * share).unwrap() * DVec3::X;
            let angle = share * 150.0f64.to_radians();
            assert!(point.distance(DVec3::new(angle.cos(), angle.sin(), 0.0)) < 2e-7, "at {share}: {point}");
            assert!((point.length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn slerp_takes_the_shortest_path() {
        let half = (PI / 8.0) as f32;
        // The second key is the quaternion -q of a turn by 45 degrees.
        let curve =
            sampler(Interpolation::Linear, &[0.0, 1.0], 4, &[0.0, 0.0, 0.0, 1.0, 0.0, -half.sin(), 0.0, -half.cos()]);
        let point = sample_rotation(&curve, 0.5).unwrap() * DVec3::Z;
        assert!(point.distance(DVec3::new((PI / 8.0).sin(), 0.0, (PI / 8.0).cos())) < 1e-7, "{point}");
    }

    #[test]
    fn slerp_survives_equal_opposite_and_zero_keys() {
        let q = [0.0, 0.6, 0.0, 0.8];
        for (a, b) in [(q, q), (q, q.map(|c| -c)), (q, [0.0; 4]), ([0.0; 4], [0.0; 4])] {
            let curve = sampler(Interpolation::Linear, &[0.0, 1.0], 4, &[a, b].concat());
            for time in [-1.0, 0.0, 1e-300, 0.5, 1.0, 2.0] {
                let rotation = sample_rotation(&curve, time).unwrap();
                assert!((rotation.length() - 1.0).abs() < 1e-14, "{a:?} {b:?} {time}: {rotation}");
            }
        }
    }

    #[test]
    fn cubic_spline_has_its_keys_and_tangents() {
        // x(t) = t^3 over keys at 1 and 3 is its own Hermite interpolant: x' = 3 t^2.
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 3.0, 0.0, 0.0, 27.0, 0.0, 0.0, 27.0, 7.0, 0.0, 0.0, 0.0, 0.0];
        let curve = sampler(Interpolation::CubicSpline, &[1.0, 3.0], 3, &values);
        for step in 0..=40 {
            let time = 1.0 + f64::from(step) / 20.0;
            let value = sample_vector(&curve, time).unwrap();
            assert!((value.x - time.powi(3)).abs() < 1e-12, "at {time}: {value}");
        }
        assert_eq!(sample_vector(&curve, 1.0), Some(DVec3::new(1.0, 0.0, 5.0)));
        assert_eq!(sample_vector(&curve, 3.0), Some(DVec3::new(27.0, 7.0, 0.0)));
        let slope = (sample_vector(&curve, 1.0 + 1e-6).unwrap() - sample_vector(&curve, 1.0).unwrap()) / 1e-6;
        assert!((slope.x - 3.0).abs() < 1e-4 && slope.y.abs() < 1e-4, "{slope}");
    }

    #[test]
    fn spline_rotations_are_normalised() {
        let rows = [
            [0.0; 4],
            [0.0, 0.0, 0.0, 1.0],
            [3.0, 1.0, 0.0, 0.0],
            [0.0, 2.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.0; 4],
        ];
        let curve = sampler(Interpolation::CubicSpline, &[0.0, 2.0], 4, &rows.concat());
        for step in 0..=20 {
            let rotation = sample_rotation(&curve, f64::from(step) / 10.0).unwrap();
            assert!((rotation.length() - 1.0).abs() < 1e-14);
        }
        assert_eq!(sample_rotation(&curve, 2.0).unwrap(), DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0));
    }

    #[test]
    fn a_step_holds_until_the_next_key_exactly() {
        let curve = sampler(Interpolation::Step, &[0.0, 0.1, 1.0], 3, &[1., 1., 1., 2., 2., 2., 3., 3., 3.]);
        let at = |time: f64| sample_vector(&curve, time).unwrap().x;
        let key = f64::from(0.1f32);
        assert_eq!([at(-1.0), at(0.0), at(key.next_down()), at(key), at(key.next_up())], [1.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!([at(1.0f64.next_down()), at(1.0), at(9.0), at(f64::NAN)], [2.0, 3.0, 3.0, 1.0]);
    }

    #[test]
    fn ends_are_held_and_keys_are_exact() {
        let times = [0.1, 0.3, 0.7];
        let curve = sampler(Interpolation::Linear, &times, 3, &[1., 2., 3., -4., 5., 0.1, 7., 8., 9.]);
        for (key, &time) in times.iter().enumerate() {
            let value = sample_vector(&curve, f64::from(time)).unwrap();
            assert_eq!(value.as_vec3().to_array(), curve.values[3 * key..3 * key + 3]);
        }
        assert_eq!(sample_vector(&curve, f64::NEG_INFINITY), sample_vector(&curve, 0.0));
        assert_eq!(sample_vector(&curve, f64::INFINITY), Some(DVec3::new(7.0, 8.0, 9.0)));
    }

    #[test]
    fn one_key_is_constant_in_every_mode() {
        for interpolation in [Interpolation::Step, Interpolation::Linear, Interpolation::CubicSpline] {
            let values = if interpolation == Interpolation::CubicSpline {
                vec![9., 9., 9., 1., 2., 3., 9., 9., 9.]
            } else {
                vec![1., 2., 3.]
            };
            let curve = sampler(interpolation, &[0.5], 3, &values);
            for time in [-1.0, 0.5, 7.0, f64::NAN] {
                assert_eq!(sample_vector(&curve, time), Some(DVec3::new(1.0, 2.0, 3.0)));
            }
        }
    }

    #[test]
    fn weights_come_in_groups_per_key() {
        let linear = sampler(Interpolation::Linear, &[0.0, 2.0], 2, &[0.0, 1.0, 1.0, 0.0]);
        assert_eq!(sample_weights(&linear, 0.5), Some(vec![0.25, 0.75]));
        // In-tangents, values and out-tangents of a key are each a group (glTF 2.0, 3.11).
        let spline =
            sampler(Interpolation::CubicSpline, &[0.0, 1.0], 2, &[9., 9., 0.0, 1.0, 0., 0., 0., 0., 1.0, 3.0, 9., 9.]);
        assert_eq!(sample_weights(&spline, 0.0), Some(vec![0.0, 1.0]));
        assert_eq!(sample_weights(&spline, 0.5), Some(vec![0.5, 2.0]));
        assert_eq!(sample_weights(&spline, 1.0), Some(vec![1.0, 3.0]));
    }

    #[test]
    fn what_is_missing_is_none() {
        assert_eq!(sample_vector(&sampler(Interpolation::Linear, &[], 3, &[]), 0.0), None);
        assert_eq!(sample_vector(&sampler(Interpolation::Linear, &[0.0], 3, &[1.0]), 0.0), None);
        assert_eq!(sample_vector(&sampler(Interpolation::CubicSpline, &[0.0], 3, &[1.0; 3]), 0.0), None);
        assert_eq!(sample_rotation(&sampler(Interpolation::Linear, &[0.0], 3, &[1.0; 3]), 0.0), None);
    }
}
