//! A row of the comparison.

use serde::Serialize;

use crate::{
    bench::GrowthPoint,
    terminal::Table,
    trial::{CausticTrial, RefractionTrial},
};

/// One method, as `--json` writes it: angles in degrees, fractions in 0..1, times in milliseconds.
#[derive(Serialize)]
pub struct RefractionRow {
    method: &'static str,
    /// Words that tell this form of the method from others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    variant: Vec<&'static str>,
    steps: u32,
    /// Pixels over which the angles are taken: truth and method both left.
    compared: usize,
    mean_deg: f64,
    p50_deg: f64,
    p95_deg: f64,
    p99_deg: f64,
    max_deg: f64,
    /// Part of the compared pixels that are off by more than one degree.
    over_1_deg: f64,
    /// Over the body's diameter.
    p2_mean: f64,
    wrong_status: f64,
    invalid: f64,
    flip: Option<f64>,
    rmse: Option<f64>,
    ssim: Option<f64>,
    /// Texels, layers, squares and nodes of hierarchies that the search of a pixel of glass reads, in the mean.
    entries: f64,
    /// Triangles likewise.
    triangles: f64,
    /// Median of the passes that find and draw the glass: eye_map, refract, and refit and glass_surface where they are needed.
    gpu_ms: Option<f64>,
    /// Between the quartiles of the same.
    gpu_ms_spread: Option<f64>,
    /// Median wall-clock time of a whole frame with nothing reused.
    frame_ms: f64,
}

/// The passes that find and draw glass.
pub const GLASS_PASSES: [&str; 5] = ["refit", "eye_map", "glass_surface", "firsts", "refract"];

impl RefractionRow {
    /// The row of a measured method.
    pub fn new(trial: &RefractionTrial) -> Self {
        let paths = &trial.errors.paths;
        let gpu = trial.timing.of_passes(&GLASS_PASSES);
        Self {
            method: trial.refraction.method.name(),
            variant: trial.refraction.variant(),
            steps: trial.refraction.steps,
            compared: paths.compared,
            mean_deg: paths.mean_deg,
            p50_deg: paths.p50_deg,
            p95_deg: paths.p95_deg,
            p99_deg: paths.p99_deg,
            max_deg: paths.max_deg,
            over_1_deg: paths.over_1_deg,
            p2_mean: paths.p2_mean,
            wrong_status: paths.wrong_status,
            invalid: paths.invalid,
            flip: trial.errors.flip.as_ref().map(|flip| flip.mean),
            rmse: trial.errors.rmse,
            ssim: trial.errors.ssim,
            entries: trial.entries,
            triangles: trial.triangles,
            gpu_ms: gpu.map(|spread| spread.median),
            gpu_ms_spread: gpu.map(|spread| spread.interquartile()),
            frame_ms: trial.timing.frame.median,
        }
    }

    /// Mean angle between exit directions, degrees; NaN where no pixel could be compared.
    pub fn mean_deg(&self) -> f64 {
        self.mean_deg
    }

    /// Mean FLIP; `None` without a picture to compare.
    pub fn flip(&self) -> Option<f64> {
        self.flip
    }

    /// Median GPU time of the glass, milliseconds; `None` on an adapter without timestamps.
    pub fn gpu_ms(&self) -> Option<f64> {
        self.gpu_ms
    }

    /// Headings, and a line of cells a row.
    pub fn cells(rows: &[Self]) -> ([&'static str; 17], Vec<Vec<String>>) {
        let headings = [
            "method",
            "steps",
            "mean °",
            "p50 °",
            "p95 °",
            "max °",
            ">1° %",
            "p2/diam",
            "wrong %",
            "invalid %",
            "FLIP",
            "RMSE",
            "entries",
            "triangles",
            "GPU ms",
            "±",
            "frame ms",
        ];
        let small = |value: f64| format!("{value:.4}");
        let maybe =
            |value: Option<f64>, digits: usize| value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"));
        let line = |row: &Self| {
            vec![
                [&[row.method], &row.variant[..]].concat().join(" "),
                row.steps.to_string(),
                small(row.mean_deg),
                small(row.p50_deg),
                small(row.p95_deg),
                format!("{:.2}", row.max_deg),
                format!("{:.2}", 100.0 * row.over_1_deg),
                format!("{:.2e}", row.p2_mean),
                format!("{:.3}", 100.0 * row.wrong_status),
                format!("{:.3}", 100.0 * row.invalid),
                maybe(row.flip, 4),
                maybe(row.rmse, 4),
                format!("{:.1}", row.entries),
                format!("{:.1}", row.triangles),
                maybe(row.gpu_ms, 2),
                maybe(row.gpu_ms_spread, 2),
                format!("{:.1}", row.frame_ms),
            ]
        };
        (headings, rows.iter().map(line).collect())
    }

    /// Method, steps and variant, as `--methods` reads them.
    pub fn label(&self) -> String {
        label(self.method, self.steps, &self.variant)
    }
}

/// A method, its steps and its variant, as `--methods` reads them.
pub fn label(method: &str, steps: u32, variant: &[&str]) -> String {
    [&[method, &steps.to_string()], variant].concat().join(":")
}

/// The rows for people.
pub fn table(rows: &[RefractionRow]) -> Table {
    let (headings, cells) = RefractionRow::cells(rows);
    Table::new(&headings, cells)
}

/// One caustics method, as `--json` writes it: ratios to the truth, times in milliseconds.
#[derive(Serialize)]
pub struct CausticRow {
    method: &'static str,
    photons: u32,
    map_size: u32,
    energy_ratio: f64,
    relative_l1: f64,
    relative_l2: f64,
    /// Of the circle that holds half of the flux.
    radius_ratio: f64,
    /// Mean distance of the ridges that are there, texels of the compared map.
    ridge_texels: Option<f64>,
    /// Fraction of the truth's ridges that are not there at all.
    ridge_missed: Option<f64>,
    /// Expected relative L1 of the truth's own noise.
    truth_noise_l1: f64,
    /// Part of the range of fixed-point sums that the fullest texel takes.
    range_used: f32,
    /// Median of light_map, emit and deposit.
    gpu_ms: Option<f64>,
    /// Between the quartiles of the same.
    gpu_ms_spread: Option<f64>,
    /// Median wall-clock time of a whole frame with nothing reused.
    frame_ms: f64,
}

impl CausticRow {
    /// The row of a measured method; `noise` is the truth's.
    pub fn new(trial: &CausticTrial, noise: f64) -> Self {
        let gpu = trial.gpu_ms();
        Self {
            method: trial.caustics.method.name(),
            photons: trial.caustics.photons,
            map_size: trial.caustics.map_size,
            energy_ratio: trial.energy_ratio,
            relative_l1: trial.relative_l1,
            relative_l2: trial.relative_l2,
            radius_ratio: trial.radius_ratio,
            ridge_texels: trial.ridge.map(|ridge| ridge.mean).filter(|mean| mean.is_finite()),
            ridge_missed: trial.ridge.map(|ridge| ridge.missed),
            truth_noise_l1: noise,
            range_used: trial.account.range_used(),
            gpu_ms: gpu.map(|(median, _)| median),
            gpu_ms_spread: gpu.map(|(_, spread)| spread),
            frame_ms: trial.timing.frame.median,
        }
    }

    /// Sum of absolute differences over the truth's sum.
    pub fn relative_l1(&self) -> f64 {
        self.relative_l1
    }

    /// Median GPU time of the caustics, milliseconds.
    pub fn gpu_ms(&self) -> Option<f64> {
        self.gpu_ms
    }

    /// The method's name.
    pub fn method(&self) -> &'static str {
        self.method
    }

    /// Texels along a side of the caustic map.
    pub fn map_size(&self) -> u32 {
        self.map_size
    }

    /// GPU time over photons in all; `None` on an adapter without timestamps.
    pub fn growth_point(&self) -> Option<GrowthPoint> {
        let x = f64::from(self.photons).powi(2);
        Some(GrowthPoint { x, ms: self.gpu_ms?, spread_ms: self.gpu_ms_spread? })
    }

    /// Method, photons a side, and texels a side of the map.
    pub fn label(&self) -> String {
        format!("{}:{} into {}", self.method, self.photons, self.map_size)
    }

    /// Headings, and a line of cells a row.
    pub fn cells(rows: &[Self]) -> ([&'static str; 14], Vec<Vec<String>>) {
        let headings = [
            "method",
            "photons",
            "map",
            "energy",
            "rel. L1",
            "rel. L2",
            "r50",
            "ridge, texels",
            "missed",
            "truth noise",
            "range used",
            "GPU ms",
            "±",
            "frame ms",
        ];
        let maybe = |value: Option<f64>| value.map_or_else(|| "-".into(), |value| format!("{value:.2}"));
        let line = |row: &Self| {
            vec![
                row.method.into(),
                row.photons.to_string(),
                row.map_size.to_string(),
                format!("{:.4}", row.energy_ratio),
                format!("{:.4}", row.relative_l1),
                format!("{:.4}", row.relative_l2),
                format!("{:.3}", row.radius_ratio),
                maybe(row.ridge_texels),
                maybe(row.ridge_missed),
                format!("{:.4}", row.truth_noise_l1),
                format!("{:.4}", row.range_used),
                maybe(row.gpu_ms),
                maybe(row.gpu_ms_spread),
                format!("{:.1}", row.frame_ms),
            ]
        };
        (headings, rows.iter().map(line).collect())
    }
}

/// The rows of caustics for people.
pub fn caustic_table(rows: &[CausticRow]) -> Table {
    let (headings, cells) = CausticRow::cells(rows);
    Table::new(&headings, cells)
}
