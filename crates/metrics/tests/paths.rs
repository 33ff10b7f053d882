//! Path errors against values known by hand.

use glam::{Quat, Vec3};
use murano_metrics::{
    MetricsError,
    paths::{LEFT, NO_GLASS, NO_VALID_HIT, PathErrors, Paths, Silhouette, TOTALLY_REFLECTED, path_errors},
};
use proptest::prelude::*;

/// A picture of paths that owns its pixels.
#[derive(Clone)]
struct Picture {
    size: [u32; 2],
    exit: Vec<Vec3>,
    p2: Vec<Vec3>,
    status: Vec<u8>,
}

impl Picture {
    /// Glass in every pixel, with exits spread over the sphere, none of them near the poles of z.
    fn covered(size: [u32; 2]) -> Self {
        let pixels = (size[0] * size[1]) as usize;
        let exit = |i: usize| Quat::from_rotation_z(i as f32 * 2.4) * Vec3::new(0.8, 0.0, 0.6);
        Self {
            size,
            exit: (0..pixels).map(exit).collect(),
            p2: (0..pixels).map(|i| Vec3::new(i as f32, 0.0, -1.0)).collect(),
            status: vec![LEFT; pixels],
        }
    }

    fn paths(&self) -> Paths<'_> {
        Paths { exit: &self.exit, p2: &self.p2, status: &self.status }
    }

    fn against(&self, truth: &Self, ring: Silhouette) -> PathErrors {
        path_errors(truth.paths(), self.paths(), 2.0, truth.size, ring).expect("valid paths")
    }
}

/// Turns a direction away from itself by `degrees`, about an axis normal to it.
fn turned(v: Vec3, degrees: f32) -> Vec3 {
    Quat::from_axis_angle(v.cross(Vec3::Z).normalize(), degrees.to_radians()) * v
}

#[test]
fn exits_turned_by_a_degree_are_a_degree_off() {
    let truth = Picture::covered([16, 8]);
    let mut tested = truth.clone();
    for (exit, p2) in tested.exit.iter_mut().zip(&mut tested.p2) {
        *exit = turned(*exit, 1.0);
        *p2 += Vec3::new(0.0, 0.0, 0.5);
    }
    let errors = tested.against(&truth, Silhouette::Include);
    assert_eq!((errors.compared, errors.covered), (128, 128));
    // f32 directions hold an angle to about 1e-7 rad, 6e-6 degrees.
    for angle in [errors.mean_deg, errors.p50_deg, errors.p95_deg, errors.p99_deg, errors.max_deg] {
        assert!((angle - 1.0).abs() < 2e-5, "{angle}");
    }
    // Half a metre over a diameter of two.
    assert!((errors.p2_mean - 0.25).abs() < 1e-6 && (errors.p2_max - 0.25).abs() < 1e-6);
    assert_eq!((errors.wrong_status, errors.invalid), (0.0, 0.0));
}

#[test]
fn tiny_angles_keep_their_digits() {
    // An arc cosine of f32 or f64 dot products would give 0 or 1.2e-6 degrees here.
    let truth = Picture { exit: vec![Vec3::X], p2: vec![Vec3::ZERO], status: vec![LEFT], size: [1, 1] };
    let tested = Picture { exit: vec![Vec3::new(1.0, 1e-8, 0.0)], ..truth.clone() };
    let degrees = tested.against(&truth, Silhouette::Include).mean_deg;
    assert!((degrees / 1e-8_f64.to_degrees() - 1.0).abs() < 1e-6, "{degrees}");
}

#[test]
fn quantiles_of_known_angles() {
    // Angles of 0, 1, ... 100 degrees: every percentile is its own number.
    let size = [101, 1];
    let truth = Picture { exit: vec![Vec3::X; 101], ..Picture::covered(size) };
    let mut tested = truth.clone();
    for (i, exit) in tested.exit.iter_mut().enumerate() {
        *exit = turned(Vec3::X, i as f32);
    }
    let errors = tested.against(&truth, Silhouette::Include);
    // 99 of 101 are more, and the one of one degree may round to more.
    assert!((101.0 * errors.over_1_deg - 99.5).abs() < 0.51, "{}", errors.over_1_deg);
    for (found, expected) in [
        (errors.mean_deg, 50.0),
        (errors.p50_deg, 50.0),
        (errors.p95_deg, 95.0),
        (errors.p99_deg, 99.0),
        (errors.max_deg, 100.0),
    ] {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    assert!((errors.angles[37] - 37.0).abs() < 1e-4);
}

#[test]
fn statuses_and_invalid_paths_are_counted() {
    let size = [10, 1];
    let mut truth = Picture::covered(size);
    truth.status =
        vec![LEFT, LEFT, LEFT, LEFT, LEFT, LEFT, TOTALLY_REFLECTED, TOTALLY_REFLECTED, NO_VALID_HIT, NO_GLASS];
    let mut tested = truth.clone();
    tested.status[1] = TOTALLY_REFLECTED; // wrong
    tested.status[2] = NO_VALID_HIT; // wrong and invalid
    tested.exit[3] = Vec3::NAN; // invalid
    tested.exit[4] = Vec3::new(0.5, 0.0, 0.0); // invalid
    tested.p2[5] = Vec3::INFINITY; // invalid
    tested.status[6] = NO_GLASS; // wrong and invalid
    tested.status[7] = LEFT; // wrong
    tested.status[9] = LEFT; // not covered
    let errors = tested.against(&truth, Silhouette::Include);
    assert_eq!((errors.compared, errors.covered), (1, 9));
    assert!((errors.wrong_status - 4.0 / 9.0).abs() < 1e-12, "{}", errors.wrong_status);
    assert!((errors.invalid - 5.0 / 9.0).abs() < 1e-12, "{}", errors.invalid);
    assert_eq!(errors.max_deg, 0.0);
    let compared: Vec<_> = errors.angles.iter().map(|angle| !angle.is_nan()).collect();
    assert_eq!(compared, [true, false, false, false, false, false, false, false, false, false]);
}

#[test]
fn the_silhouette_is_left_out() {
    // A 4 x 4 block of glass in a 6 x 6 picture that touches its top border: the border is no silhouette.
    let mut truth = Picture::covered([6, 6]);
    for (i, status) in truth.status.iter_mut().enumerate() {
        let (x, y) = (i % 6, i / 6);
        *status = if (1..5).contains(&x) && y < 4 { LEFT } else { NO_GLASS };
    }
    let mut tested = truth.clone();
    tested.exit[1] = turned(tested.exit[1], 30.0);
    assert_eq!(tested.against(&truth, Silhouette::Include).covered, 16);
    let inner = tested.against(&truth, Silhouette::Exclude);
    assert_eq!((inner.covered, inner.compared), (6, 6));
    assert_eq!(inner.max_deg, 0.0);
}

#[test]
fn nothing_compared_is_not_a_number_and_no_error() {
    let truth = Picture { status: vec![NO_GLASS; 4], ..Picture::covered([2, 2]) };
    let errors = truth.against(&truth, Silhouette::Exclude);
    assert_eq!((errors.compared, errors.covered, errors.wrong_status, errors.invalid), (0, 0, 0.0, 0.0));
    assert!(errors.mean_deg.is_nan() && errors.p95_deg.is_nan() && errors.p2_max.is_nan());
}

#[test]
fn wrong_input_is_refused() {
    let truth = Picture::covered([3, 2]);
    let measure = |truth: &Picture, tested: &Picture, diameter| {
        path_errors(truth.paths(), tested.paths(), diameter, [3, 2], Silhouette::Include).unwrap_err()
    };
    let short = Picture::covered([5, 1]);
    assert!(matches!(measure(&truth, &short, 1.0), MetricsError::Length { expected: 6, found: 5, .. }));
    assert!(matches!(measure(&truth, &truth, 0.0), MetricsError::Range { .. }));
    assert!(matches!(measure(&truth, &truth, f64::NAN), MetricsError::Range { .. }));
    let mut broken = truth.clone();
    broken.exit[4] = Vec3::ZERO;
    assert!(matches!(measure(&broken, &truth, 1.0), MetricsError::Entry { index: 4, .. }));
}

proptest! {
    /// Hostile tested paths never poison the figures, and fractions stay fractions.
    #[test]
    fn figures_stay_in_range(
        statuses in prop::collection::vec((0_u8..4, 0_u8..6), 24),
        components in prop::collection::vec(any::<f32>(), 24),
    ) {
        let mut truth = Picture::covered([6, 4]);
        let mut tested = truth.clone();
        for i in 0..24 {
            truth.status[i] = statuses[i].0;
            tested.status[i] = statuses[i].1;
            if i % 3 == 0 {
                tested.exit[i].x = components[i];
                tested.p2[i].y = components[i];
            }
        }
        for ring in [Silhouette::Include, Silhouette::Exclude] {
            let errors = tested.against(&truth, ring);
            prop_assert!((0.0..=1.0).contains(&errors.wrong_status) && (0.0..=1.0).contains(&errors.invalid));
            prop_assert!(errors.compared <= errors.covered);
            if errors.compared > 0 {
                prop_assert!(errors.mean_deg.is_finite() && errors.p2_max.is_finite());
                prop_assert!(errors.p50_deg <= errors.p95_deg && errors.p95_deg <= errors.p99_deg);
                prop_assert!(errors.p99_deg <= errors.max_deg && errors.max_deg <= 180.0);
            }
        }
    }
}
