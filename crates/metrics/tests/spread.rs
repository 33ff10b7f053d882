//! Quartiles, power laws and Pareto fronts of known sets.

use murano_metrics::{
    MetricsError,
    spread::{fit_power_law, pareto_front, spread},
};
use proptest::prelude::*;

#[test]
fn quartiles_by_hand() {
    let found = spread(&[7.0, 1.0, 3.0, 5.0, 9.0]).unwrap();
    assert_eq!((found.lower_quartile, found.median, found.upper_quartile), (3.0, 5.0, 7.0));
    assert_eq!(found.interquartile(), 4.0);
    // Between the entries of an even sample, and of one.
    let found = spread(&[4.0, 1.0, 2.0, 3.0]).unwrap();
    assert_eq!((found.lower_quartile, found.median, found.upper_quartile), (1.75, 2.5, 3.25));
    assert_eq!(spread(&[2.5]).unwrap().interquartile(), 0.0);
    assert!(matches!(spread(&[]), Err(MetricsError::Empty { .. })));
    assert!(matches!(spread(&[1.0, f64::NAN]), Err(MetricsError::Entry { index: 1, .. })));
}

#[test]
fn one_disturbed_timing_moves_no_median() {
    let mut timings = vec![2.0; 20];
    timings[3] = 500.0;
    let found = spread(&timings).unwrap();
    assert_eq!((found.median, found.interquartile()), (2.0, 0.0));
}

#[test]
fn a_power_law_is_recovered() {
    let x: Vec<f64> = (0..7).map(|i| 1000.0 * 3.0_f64.powi(i)).collect();
    let y: Vec<f64> = x.iter().map(|x| 0.02 * x.powf(0.75)).collect();
    let law = fit_power_law(&x, &y).unwrap();
    assert!((law.exponent - 0.75).abs() < 1e-12 && (law.coefficient - 0.02).abs() < 1e-12, "{law:?}");
    assert!((law.r2 - 1.0).abs() < 1e-12);
    assert!((law.at(5000.0) - 0.02 * 5000.0_f64.powf(0.75)).abs() < 1e-9);
}

#[test]
fn the_fit_is_that_of_least_squares() {
    // log2 y = 0, 2, 1 at log2 x = 0, 1, 2: slope 1/2, and 1 - (3/2) / 2 of the variance is explained.
    let law = fit_power_law(&[1.0, 2.0, 4.0], &[1.0, 4.0, 2.0]).unwrap();
    assert!((law.exponent - 0.5).abs() < 1e-12);
    assert!((law.coefficient - 2.0_f64.sqrt()).abs() < 1e-12);
    assert!((law.r2 - 0.25).abs() < 1e-12, "{law:?}");
    let level = fit_power_law(&[1.0, 10.0], &[3.0, 3.0]).unwrap();
    assert_eq!((level.exponent, level.r2), (0.0, 1.0));
}

#[test]
fn no_law_through_too_little() {
    assert!(matches!(fit_power_law(&[1.0, 2.0], &[1.0]), Err(MetricsError::Length { .. })));
    assert!(matches!(fit_power_law(&[], &[]), Err(MetricsError::Empty { .. })));
    assert!(matches!(fit_power_law(&[2.0, 2.0], &[1.0, 3.0]), Err(MetricsError::Empty { .. })));
    assert!(matches!(fit_power_law(&[0.0, 2.0], &[1.0, 3.0]), Err(MetricsError::Entry { index: 0, .. })));
    assert!(matches!(fit_power_law(&[1.0, 2.0], &[1.0, -3.0]), Err(MetricsError::Entry { index: 1, .. })));
}

#[test]
fn the_front_of_a_known_set() {
    let points = [
        [5.0, 1.0],
        [1.0, 9.0],
        [2.0, 4.0],
        [2.0, 3.0],           // beats the one before
        [3.0, 3.0],           // beaten: slower, no better
        [6.0, 2.0],           // beaten
        [0.5, f64::NAN],      // nothing known
        [f64::INFINITY, 0.0], // never ends
        [2.0, 3.0],           // equal to an earlier one
    ];
    assert_eq!(pareto_front(&points), [1, 3, 0]);
    assert!(pareto_front(&[]).is_empty());
}

proptest! {
    /// A point is on the front, or one on the front is as good; none on the front beats another there.
    #[test]
    fn the_front_is_what_no_point_beats(raw in prop::collection::vec((0_u8..12, 0_u8..12), 0..40)) {
        let points: Vec<[f64; 2]> = raw.iter().map(|&(t, e)| [f64::from(t), f64::from(e)]).collect();
        let front = pareto_front(&points);
        let covers = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] && a[1] <= b[1];
        for point in &points {
            prop_assert!(front.iter().any(|&i| covers(points[i], *point)));
        }
        for (rank, &i) in front.iter().enumerate() {
            for &j in &front[rank + 1..] {
                prop_assert!(points[i][0] < points[j][0] && points[i][1] > points[j][1]);
            }
        }
    }

    /// Least squares in logarithms does not depend on units.
    #[test]
    fn exponents_do_not_depend_on_units(
        y in prop::collection::vec(0.1_f64..50.0, 3..12),
        unit in 1e-3_f64..1e3,
    ) {
        let x: Vec<f64> = (1..=y.len()).map(|i| i as f64).collect();
        let law = fit_power_law(&x, &y).unwrap();
        let scaled = fit_power_law(&x, &y.iter().map(|y| y * unit).collect::<Vec<_>>()).unwrap();
        prop_assert!((law.exponent - scaled.exponent).abs() < 1e-9);
        prop_assert!((scaled.coefficient / law.coefficient / unit - 1.0).abs() < 1e-9);
        prop_assert!(law.r2 <= 1.0 + 1e-12);
    }
}
