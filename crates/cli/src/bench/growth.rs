//! How cost grows: one quantity is doubled again and again, everything else stays.

use std::fmt;

use murano_metrics::{
    report::{Axis, Plot, Point, Series},
    scale::Scaling,
    spread::{PowerLaw, Spread, fit_power_law},
};
use serde::Serialize;

/// A curve of GPU time over one quantity.
#[derive(Clone, Debug, Serialize)]
pub struct Growth {
    /// What grows, e.g. "triangles".
    pub quantity: &'static str,
    /// What is measured, e.g. "newton: eye_map + refract".
    pub measured: String,
    /// Points in order of the quantity.
    pub points: Vec<GrowthPoint>,
    /// y = coefficient x^exponent through the points; `None` where there are fewer than two, or times of zero.
    pub law: Option<PowerLaw>,
}

/// One point of a curve.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct GrowthPoint {
    /// The quantity.
    pub x: f64,
    /// Median, milliseconds.
    pub ms: f64,
    /// Between the quartiles, milliseconds.
    pub spread_ms: f64,
}

impl Growth {
    /// A curve through measured points.
    pub fn new(quantity: &'static str, measured: impl Into<String>, points: Vec<GrowthPoint>) -> Self {
        let [x, y]: [Vec<f64>; 2] =
            [points.iter().map(|point| point.x).collect(), points.iter().map(|point| point.ms).collect()];
        Self { quantity, measured: measured.into(), points, law: fit_power_law(&x, &y).ok() }
    }
}

impl GrowthPoint {
    /// A measured point.
    pub fn new(x: f64, time: Spread) -> Self {
        Self { x, ms: time.median, spread_ms: time.interquartile() }
    }
}

impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} by {}:", self.measured, self.quantity)?;
        for point in &self.points {
            write!(f, "  {}: {:.2} ms", point.x, point.ms)?;
        }
        match &self.law {
            Some(law) => write!(f, "  (exponent {:.2}, r2 {:.3})", law.exponent, law.r2),
            None => Ok(()),
        }
    }
}

/// A plot a quantity, with a curve for everything measured over it.
pub fn plots(curves: &[Growth]) -> Vec<Plot> {
    let mut plots: Vec<Plot> = Vec::new();
    for curve in curves {
        let points = curve.points.iter().map(|point| Point {
            x: point.x,
            y: point.ms,
            title: format!("± {:.2} ms", point.spread_ms),
        });
        let series = Series { name: curve.measured.clone(), points: points.collect(), line: true, fit: curve.law };
        let title = format!("Time over {}", curve.quantity);
        match plots.iter_mut().find(|plot| plot.title == title) {
            Some(plot) => plot.series.push(series),
            None => plots.push(Plot {
                title,
                caption: String::new(),
                x: Axis { label: curve.quantity.into(), scaling: Scaling::Logarithmic },
                y: Axis { label: "time, ms".into(), scaling: Scaling::Logarithmic },
                series: vec![series],
                pareto_front: false,
            }),
        }
    }
    plots
}
