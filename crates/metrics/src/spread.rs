//! Timings and trends: quartiles, power laws, Pareto fronts.

use serde::Serialize;

use crate::{MetricsError, error::expect_len};

/// The middle and the spread of a sample, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the sample lies below.
    pub median: f64,
    /// A quarter of the sample lies below.
    pub lower_quartile: f64,
    /// Three quarters of the sample lie below.
    pub upper_quartile: f64,
}

impl Spread {
    /// The width of the middle half of the sample, which a few disturbed timings do not move.
    pub fn interquartile(&self) -> f64 {
        self.upper_quartile - self.lower_quartile
    }
}

/// Median and quartiles of a sample in any order, by linear interpolation between the sorted entries.
///
/// # Errors
/// [`MetricsError::Empty`] without an entry, [`MetricsError::Entry`] if one is not finite.
pub fn spread(sample: &[f64]) -> Result<Spread, MetricsError> {
    const WHAT: &str = "the sample";
    if sample.is_empty() {
        return Err(MetricsError::Empty { what: WHAT, least: 1 });
    }
    expect_entries(WHAT, sample, "finite", f64::is_finite)?;
    let mut sorted = sample.to_vec();
    sorted.sort_by(f64::total_cmp);
    Ok(Spread {
        median: quantile_of_sorted(&sorted, 0.5),
        lower_quartile: quantile_of_sorted(&sorted, 0.25),
        upper_quartile: quantile_of_sorted(&sorted, 0.75),
    })
}

/// The `q` quantile of ascending entries by linear interpolation between the two entries around rank q (n - 1)
/// (Hyndman and Fan 1996, type 7). NaN without an entry.
pub(crate) fn quantile_of_sorted(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let rank = q * last as f64;
    let below = sorted[rank.floor() as usize];
    let above = sorted[(rank.ceil() as usize).min(last)];
    below + (above - below) * rank.fract()
}

/// y = `coefficient` x^`exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// How y grows: 1 in proportion to x, 0 not at all.
    pub exponent: f64,
    /// y at x = 1.
    pub coefficient: f64,
    /// Share of the variance of log y that the law explains, at most 1; 1 also for a constant y.
    pub r2: f64,
}

impl PowerLaw {
    /// The value of the law at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.coefficient * x.powf(self.exponent)
    }
}

/// The power law through points, by least squares of the logarithms.
///
/// # Errors
/// [`MetricsError::Length`] if there are not as many y as x, [`MetricsError::Empty`] with fewer than two different
/// x, [`MetricsError::Entry`] if a coordinate is not finite and above zero.
pub fn fit_power_law(x: &[f64], y: &[f64]) -> Result<PowerLaw, MetricsError> {
    expect_len("y", y.len(), x.len())?;
    for (what, entries) in [("x", x), ("y", y)] {
        expect_entries(what, entries, "finite and above zero", |value| value.is_finite() && value > 0.0)?;
    }
    let logs = |entries: &[f64]| entries.iter().map(|value| value.ln()).collect::<Vec<_>>();
    let (u, v) = (logs(x), logs(y));
    let mean = |entries: &[f64]| entries.iter().sum::<f64>() / entries.len() as f64;
    let (mean_u, mean_v) = (mean(&u), mean(&v));
    let sum = |f: &dyn Fn(f64, f64) -> f64| u.iter().zip(&v).map(|(u, v)| f(u - mean_u, v - mean_v)).sum::<f64>();
    let (uu, uv, vv) = (sum(&|u, _| u * u), sum(&|u, v| u * v), sum(&|_, v| v * v));
    if x.iter().all(|value| *value == x[0]) {
        return Err(MetricsError::Empty { what: "the set of different x", least: 2 });
    }
    let exponent = uv / uu;
    let residual = sum(&|u, v| (v - exponent * u).powi(2));
    let r2 = if vv > 0.0 { 1.0 - residual / vv } else { 1.0 };
    Ok(PowerLaw { exponent, coefficient: (mean_v - exponent * mean_u).exp(), r2 })
}

/// The indices of the points that no other point beats in both coordinates (less is better), by ascending first
/// coordinate.
///
/// Of equal points the first is kept; points with a coordinate that is not finite are never on the front.
pub fn pareto_front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    order.sort_by(|&i, &j| points[i][0].total_cmp(&points[j][0]).then(points[i][1].total_cmp(&points[j][1])));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i][1] < least;
        least = least.min(points[i][1]);
        better
    });
    order
}

/// Refuses the first entry that is not `valid`.
pub(crate) fn expect_entries(
    what: &'static str,
    entries: &[f64],
    need: &'static str,
    valid: impl Fn(f64) -> bool,
) -> Result<(), MetricsError> {
    match entries.iter().position(|&value| !valid(value)) {
        Some(index) => Err(MetricsError::Entry { what, index, value: entries[index], need }),
        None => Ok(()),
    }
}
