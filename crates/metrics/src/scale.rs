//! Scales of values: where a value lies between two ends, and which round values to name on the way.

use serde::Serialize;

use crate::MetricsError;

/// How values are spread over a scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scaling {
    /// Equal differences take equal lengths.
    #[default]
    Linear,
    /// Equal ratios take equal lengths; only values above zero have a place.
    Logarithmic,
}

/// A range of values and how they are spread over it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scale {
    scaling: Scaling,
    from: f64,
    to: f64,
}

impl Scale {
    /// A scale between two values.
    ///
    /// # Errors
    /// [`MetricsError::Range`] if an end is not finite, the ends do not ascend, or a logarithmic scale does not begin
    /// above zero.
    pub fn new(scaling: Scaling, from: f64, to: f64) -> Result<Self, MetricsError> {
        let refuse = |what, value, need| Err(MetricsError::Range { what, value, need });
        if !from.is_finite() || (scaling == Scaling::Logarithmic && from <= 0.0) {
            return refuse("the lower end of a scale", from, "a finite number, above zero if the scale is logarithmic");
        }
        if !to.is_finite() || to <= from || !(to - from).is_finite() {
            return refuse("the upper end of a scale", to, "a finite number above the lower end");
        }
        Ok(Self { scaling, from, to })
    }

    /// The linear scale from zero to the largest of the values; to one if none is above zero.
    pub fn linear_of(values: &[f32]) -> Self {
        let to = finite(values).fold(0.0, f64::max);
        Self { scaling: Scaling::Linear, from: 0.0, to: if to > 0.0 { to } else { 1.0 } }
    }

    /// The logarithmic scale over the powers of ten that enclose the values above zero, at most five of them down from
    /// the largest value; from 0.001 to 1 if none is above zero.
    pub fn logarithmic_of(values: &[f32]) -> Self {
        let positive = || finite(values).filter(|value| *value > 0.0);
        let Some(largest) = positive().reduce(f64::max) else {
            return Self { scaling: Scaling::Logarithmic, from: 1e-3, to: 1.0 };
        };
        let top = largest.log10().ceil();
        let smallest = positive().fold(largest, f64::min).log10().floor();
        let bottom = smallest.clamp(top - 5.0, top - 1.0);
        Self { scaling: Scaling::Logarithmic, from: 10_f64.powf(bottom), to: 10_f64.powf(top) }
    }

    /// The scale that shows all of the values that it can with a margin at both ends; a linear one begins at zero if
    /// the values come near. None if it can show no value.
    pub(crate) fn around(scaling: Scaling, values: impl Iterator<Item = f64>) -> Option<Self> {
        let shown = values.filter(|value| Self::can_show(scaling, *value));
        let ends = shown.map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (from, to) = ends?;
        let (from, to) = match scaling {
            Scaling::Logarithmic => {
                let margin = (to / from).powf(0.07).max(1.25);
                (from / margin, to * margin)
            }
            Scaling::Linear if from >= 0.0 && from <= 0.4 * to && to > 0.0 => (0.0, to * 1.07),
            Scaling::Linear => {
                let margin = if from < to { 0.07 * (to - from) } else { 0.05 * to.abs() };
                let margin = if margin > 0.0 { margin } else { 1.0 };
                (from - margin, to + margin)
            }
        };
        Self::new(scaling, from, to).ok()
    }

    /// Whether a value has a place on a scale of this kind.
    pub(crate) fn can_show(scaling: Scaling, value: f64) -> bool {
        value.is_finite() && (scaling == Scaling::Linear || value > 0.0)
    }

    /// The value at the lower end.
    pub fn from(&self) -> f64 {
        self.from
    }

    /// The value at the upper end.
    pub fn to(&self) -> f64 {
        self.to
    }

    /// Where a value lies: 0 at the lower end, 1 at the upper, below 0 or above 1 outside; NaN if the value is. On a
    /// logarithmic scale zero and less lie infinitely far below.
    pub fn position(&self, value: f64) -> f64 {
        match self.scaling {
            Scaling::Linear => (value - self.from) / (self.to - self.from),
            Scaling::Logarithmic if value <= 0.0 => f64::NEG_INFINITY,
            Scaling::Logarithmic => (value / self.from).ln() / (self.to / self.from).ln(),
        }
    }

    /// About `at_most` round values on the scale, ascending.
    pub(crate) fn ticks(&self, at_most: usize) -> Vec<f64> {
        match self.scaling {
            Scaling::Linear => self.linear_ticks(at_most),
            Scaling::Logarithmic => self.logarithmic_ticks(at_most),
        }
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn linear_ticks(&self, at_most: usize) -> Vec<f64> {
        let least = (self.to - self.from) / at_most.max(1) as f64;
        let power = 10_f64.powf(least.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least * (1.0 - 1e-9));
        let step = step.unwrap_or(10.0 * power);
        let inside = |k: f64| k * step;
        let (first, last) = ((self.from / step - 1e-9).ceil(), (self.to / step + 1e-9).floor());
        (0..=(last - first).max(0.0) as usize).map(|k| inside(first + k as f64)).collect()
    }

    /// Powers of ten, thinned out if there are many; with 2 and 5 times them if there are few.
    fn logarithmic_ticks(&self, at_most: usize) -> Vec<f64> {
        let decades = self.decades();
        let stride = decades.clone().count().div_ceil(at_most.max(1)).max(1);
        if decades.clone().count() > 2 {
            return decades.step_by(stride).map(|d| 10_f64.powi(d)).collect();
        }
        let finer = self.multiples_of_decades(&[1.0, 2.0, 5.0]);
        if finer.len() > 1 { finer } else { self.linear_ticks(at_most.min(3)) }
    }

    /// The values between the ticks that show a logarithmic scale: multiples of powers of ten.
    pub(crate) fn minor_ticks(&self) -> Vec<f64> {
        const MOST_DECADES: usize = 5;
        if self.scaling == Scaling::Linear || self.decades().count() > MOST_DECADES {
            return Vec::new();
        }
        self.multiples_of_decades(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    }

    /// The exponents of the powers of ten on the scale.
    fn decades(&self) -> std::ops::RangeInclusive<i32> {
        (self.from.log10() - 1e-9).ceil() as i32..=(self.to.log10() + 1e-9).floor() as i32
    }

    fn multiples_of_decades(&self, multiples: &[f64]) -> Vec<f64> {
        let decades = self.from.log10().floor() as i32..=self.to.log10().floor() as i32;
        let all = decades.flat_map(|d| multiples.iter().map(move |m| m * 10_f64.powi(d)));
        all.filter(|value| (-1e-9..=1.0 + 1e-9).contains(&self.position(*value))).collect()
    }
}

fn finite(values: &[f32]) -> impl Iterator<Item = f64> {
    values.iter().filter(|value| value.is_finite()).copied().map(f64::from)
}

/// A number with at most `digits` significant digits and no idle zeros: `0.025`, `1500`, `2e-5`, `1e6`.
pub fn significant(value: f64, digits: usize) -> String {
    let scientific = scientific(value, digits);
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match (exponent, scientific.parse::<f64>()) {
        (Some(_), Ok(0.0)) => "0".to_owned(),
        // The exponent is that of the rounded number: rounding may carry into the next power of ten.
        (Some(exponent @ -3..6), Ok(rounded)) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            without_idle_zeros(&format!("{rounded:.decimals$}")).to_owned()
        }
        _ => scientific,
    }
}

/// A number with at most `digits` significant digits, no idle zeros, and its power of ten: `2.5e-2`.
pub(crate) fn scientific(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits.max(1) - 1);
    match rounded.split_once('e') {
        Some((mantissa, exponent)) => format!("{}e{exponent}", without_idle_zeros(mantissa)),
        None => rounded, // NaN and infinities
    }
}

fn without_idle_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(scaling: Scaling, from: f64, to: f64, at_most: usize) -> Vec<String> {
        let scale = Scale::new(scaling, from, to).unwrap();
        scale.ticks(at_most).into_iter().map(|value| significant(value, 5)).collect()
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(Scaling::Linear, 0.0, 1.0, 5), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(Scaling::Linear, 3.1, 47.0, 5), ["10", "20", "30", "40"]);
        assert_eq!(ticks(Scaling::Logarithmic, 0.001, 10.0, 6), ["0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(ticks(Scaling::Logarithmic, 1e-9, 1.0, 5), ["1e-9", "1e-7", "1e-5", "0.001", "0.1"]);
        assert_eq!(ticks(Scaling::Logarithmic, 3.0, 70.0, 5), ["5", "10", "20", "50"]);
        assert_eq!(ticks(Scaling::Logarithmic, 2.1, 4.9, 5), ["3", "4"]);
    }

    #[test]
    fn values_have_their_place() {
        let log = Scale::new(Scaling::Logarithmic, 0.01, 100.0).unwrap();
        for (value, place) in [(0.01, 0.0), (1.0, 0.5), (100.0, 1.0), (10000.0, 1.5), (0.0, f64::NEG_INFINITY)] {
            assert!((log.position(value) - place).abs() < 1e-12 || log.position(value) == place);
        }
        assert_eq!(Scale::new(Scaling::Linear, 2.0, 6.0).unwrap().position(5.0), 0.75);
        assert!(Scale::new(Scaling::Linear, 1.0, 1.0).is_err());
        assert!(Scale::new(Scaling::Logarithmic, 0.0, 1.0).is_err());
        assert!(Scale::new(Scaling::Linear, 0.0, f64::INFINITY).is_err());
    }

    #[test]
    fn scales_cover_their_values() {
        let values = [0.0, 0.02, 3.0, f32::NAN];
        assert_eq!(Scale::linear_of(&values).to(), 3.0);
        let log = Scale::logarithmic_of(&values);
        assert!((log.from() - 0.01).abs() < 1e-12 && (log.to() - 10.0).abs() < 1e-12);
        assert_eq!(Scale::linear_of(&[f32::NAN]).to(), 1.0);
        assert_eq!(Scale::logarithmic_of(&[0.0]).to(), 1.0);
        assert!(Scale::around(Scaling::Logarithmic, [0.0, f64::NAN].into_iter()).is_none());
        for scaling in [Scaling::Linear, Scaling::Logarithmic] {
            let one = Scale::around(scaling, [5.0].into_iter()).unwrap();
            assert!(one.from() < 5.0 && one.to() > 5.0 && !one.ticks(5).is_empty());
        }
        let zero = Scale::around(Scaling::Linear, [0.0, 0.0].into_iter()).unwrap();
        assert_eq!((zero.from(), zero.to()), (-1.0, 1.0));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1234.5678, "1235"),
            (0.02500001, "0.025"),
            (9.9996, "10"),
            (-0.5, "-0.5"),
            (2e-5, "2e-5"),
            (1.23456e9, "1.235e9"),
            (120000.0, "120000"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
            (-0.0, "0"),
        ] {
            assert_eq!(significant(value, 4), text);
        }
    }
}
