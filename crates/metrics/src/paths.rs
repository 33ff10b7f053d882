//! Errors of two-interface paths: where rays that met glass left it, and which way they went.

use glam::{DVec3, Vec3};
use serde::Serialize;

use crate::{
    MetricsError,
    error::{area, expect_len, expect_positive},
    spread::quantile_of_sorted,
};

/// `status` of a pixel whose ray met no glass.
pub const NO_GLASS: u8 = 0;
/// `status` of a pixel whose ray left glass through the second interface.
pub const LEFT: u8 = 1;
/// `status` of a pixel whose ray was totally reflected at the second interface.
pub const TOTALLY_REFLECTED: u8 = 2;
/// `status` of a pixel for whose ray no second interface was found.
pub const NO_VALID_HIT: u8 = 3;

/// How far the length of an exit direction may lie from one.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The two-interface paths of a picture, one entry a pixel, row 0 at the top; world space.
#[derive(Clone, Copy, Debug)]
pub struct Paths<'a> {
    /// Unit direction in which the ray left the glass. Read where the status is [`LEFT`].
    pub exit: &'a [Vec3],
    /// Point of the second interface, metres. Read where the status is [`LEFT`].
    pub p2: &'a [Vec3],
    /// [`NO_GLASS`], [`LEFT`], [`TOTALLY_REFLECTED`] or [`NO_VALID_HIT`].
    pub status: &'a [u8],
}

/// Whether the outermost ring of covered pixels counts.
///
/// On the silhouette a pixel centre may hit glass in one method and miss it in the other without either being wrong:
/// that is a matter of rasterisation rules, not of refraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Silhouette {
    /// All pixels count.
    Include,
    /// Pixels that the truth covers and that touch, by side or corner, one that it does not cover do not count.
    /// The border of the picture is no silhouette.
    Exclude,
}

/// How far the paths of one method lie from the truth's.
///
/// Means, quantiles and maxima are taken over the compared pixels, and are NaN where there are none. A quantile lies
/// between two entries of the sorted angles by linear interpolation (Hyndman and Fan 1996, type 7).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathErrors {
    /// Pixels compared: both statuses are [`LEFT`] and the tested exit and second hit are valid.
    pub compared: usize,
    /// Pixels that the truth covers with glass (its status is not [`NO_GLASS`]), less the silhouette if excluded.
    pub covered: usize,
    /// Mean angle between the exit directions, degrees.
    pub mean_deg: f64,
    /// Median angle, degrees.
    pub p50_deg: f64,
    /// Angle that 95 % of the compared pixels do not exceed, degrees.
    pub p95_deg: f64,
    /// Angle that 99 % of the compared pixels do not exceed, degrees.
    pub p99_deg: f64,
    /// Largest angle, degrees.
    pub max_deg: f64,
    /// Part of the compared pixels whose angle is more than one degree, 0..1; NaN where there are none.
    pub over_1_deg: f64,
    /// Mean distance of the second hits over the body's diameter.
    pub p2_mean: f64,
    /// Largest distance of the second hits over the body's diameter.
    pub p2_max: f64,
    /// Fraction of the covered pixels whose status differs from the truth's; zero if nothing is covered.
    pub wrong_status: f64,
    /// Fraction of the covered pixels without a usable path; zero if nothing is covered: the tested status is [`LEFT`],
    /// but the exit is no finite unit vector or the second hit is not finite, or it is none of [`LEFT`] and
    /// [`TOTALLY_REFLECTED`] where the truth's is one of these.
    pub invalid: f64,
    /// The angle of each pixel of the picture, degrees; NaN where not compared.
    #[serde(skip)]
    pub angles: Vec<f32>,
}

/// Measures the paths of one method against the truth's.
///
/// `diameter` is that of the body, metres; `size` the width and height of the picture. Angles are
/// atan2(|a x b|, a . b) in f64, which keeps its digits at small angles, where the arc cosine loses half of them.
///
/// # Errors
/// [`MetricsError::Length`] if a slice has not one entry a pixel, [`MetricsError::Range`] if the diameter is not
/// finite and above zero, [`MetricsError::Entry`] if the truth itself has a path that left glass without a unit exit
/// direction or a finite second hit, or a status above [`NO_VALID_HIT`].
pub fn path_errors(
    truth: Paths,
    tested: Paths,
    diameter: f64,
    size: [u32; 2],
    ring: Silhouette,
) -> Result<PathErrors, MetricsError> {
    expect_one_entry_a_pixel(&truth, &tested, area(size))?;
    expect_positive("the diameter", diameter)?;
    expect_truth(&truth)?;

    let mut tally = Tally { angles: vec![f32::NAN; area(size)], ..Tally::default() };
    for index in 0..area(size) {
        let excluded = ring == Silhouette::Exclude && on_silhouette(truth.status, size, index);
        if truth.status[index] != NO_GLASS && !excluded {
            tally.add(&truth, &tested, index);
        }
    }
    Ok(tally.finish(diameter))
}

fn expect_one_entry_a_pixel(truth: &Paths, tested: &Paths, pixels: usize) -> Result<(), MetricsError> {
    expect_len("the truth's exit directions", truth.exit.len(), pixels)?;
    expect_len("the truth's second hits", truth.p2.len(), pixels)?;
    expect_len("the truth's statuses", truth.status.len(), pixels)?;
    expect_len("the tested exit directions", tested.exit.len(), pixels)?;
    expect_len("the tested second hits", tested.p2.len(), pixels)?;
    expect_len("the tested statuses", tested.status.len(), pixels)
}

/// Refuses a truth that is none: everything is measured by it.
fn expect_truth(truth: &Paths) -> Result<(), MetricsError> {
    for (index, &status) in truth.status.iter().enumerate() {
        let refuse = |what, value, need| Err(MetricsError::Entry { what, index, value, need });
        if status > NO_VALID_HIT {
            return refuse("the truth's statuses", f64::from(status), "0, 1, 2 or 3");
        }
        if status == LEFT && !is_unit(truth.exit[index]) {
            let length = truth.exit[index].as_dvec3().length();
            return refuse("the lengths of the truth's exit directions", length, "1 where the ray left the glass");
        }
        if status == LEFT && !truth.p2[index].is_finite() {
            return refuse("the truth's second hits", f64::NAN, "finite where the ray left the glass");
        }
    }
    Ok(())
}

fn is_unit(v: Vec3) -> bool {
    // A comparison with NaN is false, and an infinite component makes the length infinite.
    (v.as_dvec3().length() - 1.0).abs() < UNIT_TOLERANCE
}

/// Whether one of the up to eight neighbours of a pixel is not covered.
fn on_silhouette(status: &[u8], size: [u32; 2], index: usize) -> bool {
    let [width, height] = size.map(|n| n as usize);
    let (x, y) = (index % width, index / width);
    (y.saturating_sub(1)..(y + 2).min(height))
        .any(|v| (x.saturating_sub(1)..(x + 2).min(width)).any(|u| status[v * width + u] == NO_GLASS))
}

/// The angle between two directions, radians.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[derive(Default)]
struct Tally {
    angles: Vec<f32>,
    degrees: Vec<f64>,
    distances: Vec<f64>,
    covered: usize,
    wrong_status: usize,
    invalid: usize,
}

impl Tally {
    /// Counts a covered pixel.
    fn add(&mut self, truth: &Paths, tested: &Paths, index: usize) {
        let (expected, found) = (truth.status[index], tested.status[index]);
        let usable = match found {
            LEFT => is_unit(tested.exit[index]) && tested.p2[index].is_finite(),
            TOTALLY_REFLECTED => true,
            _ => expected == NO_VALID_HIT,
        };
        self.covered += 1;
        self.wrong_status += usize::from(expected != found);
        self.invalid += usize::from(!usable);
        if expected == LEFT && found == LEFT && usable {
            let angle = angle_between(truth.exit[index].as_dvec3(), tested.exit[index].as_dvec3()).to_degrees();
            self.angles[index] = angle as f32;
            self.degrees.push(angle);
            self.distances.push(truth.p2[index].as_dvec3().distance(tested.p2[index].as_dvec3()));
        }
    }

    fn finish(mut self, diameter: f64) -> PathErrors {
        self.degrees.sort_by(f64::total_cmp);
        let compared = self.degrees.len();
        let of_compared = |sum: f64| sum / compared as f64;
        let of_covered = |count: usize| count as f64 / self.covered.max(1) as f64;
        let quantile = |q| quantile_of_sorted(&self.degrees, q);
        PathErrors {
            compared,
            covered: self.covered,
            mean_deg: of_compared(self.degrees.iter().sum()),
            p50_deg: quantile(0.5),
            p95_deg: quantile(0.95),
            p99_deg: quantile(0.99),
            max_deg: quantile(1.0),
            over_1_deg: of_compared(self.degrees.iter().filter(|angle| **angle > 1.0).count() as f64),
            p2_mean: of_compared(self.distances.iter().sum()) / diameter,
            p2_max: self.distances.iter().copied().reduce(f64::max).unwrap_or(f64::NAN) / diameter,
            wrong_status: of_covered(self.wrong_status),
            invalid: of_covered(self.invalid),
            angles: self.angles,
        }
    }
}
