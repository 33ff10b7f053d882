//! Frame after frame: what changes between them in the truth's pictures and in a method's.

use anyhow::{Context, Result};
use murano_metrics::{
    images::{DEFAULT_PIXELS_PER_DEGREE, Picture, flicker_against},
    paths::Silhouette,
};
use murano_refraction::Refraction;
use murano_render::{Settings, Stage};
use serde::Serialize;

use super::row::label;
use crate::{
    terminal::{Progress, Table},
    trial::{Subject, Truth},
    values::FrameRange,
};

/// One method over a sequence, as `--json` writes it. FLIP is of the environment seen through the glass, of each frame against
/// the next.
#[derive(Serialize)]
pub struct SequenceRow {
    method: &'static str,
    /// Words that tell this form of the method from others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    variant: Vec<&'static str>,
    steps: u32,
    /// Mean over the frames of the mean angle between exit directions, degrees.
    mean_deg: f64,
    /// Mean FLIP from frame to frame of the truth: motion.
    truth_change: f64,
    /// Likewise of the method: motion and flicker.
    change: f64,
    /// The one over the other.
    ratio: f64,
    /// The largest such ratio of one pair of frames.
    worst_ratio: f64,
    /// Change of pixels that the truth's do not show.
    excess: f64,
}

impl SequenceRow {
    /// Method, steps and variant, as `--methods` reads them.
    pub fn label(&self) -> String {
        label(self.method, self.steps, &self.variant)
    }

    /// Change from frame to frame over the truth's.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }
}

/// The rows for people.
pub fn table(rows: &[SequenceRow]) -> Table {
    let headings =
        ["method", "steps", "mean °", "change, truth", "change, method", "ratio", "worst pair", "change, excess"];
    let line = |row: &SequenceRow| {
        vec![
            [&[row.method], &row.variant[..]].concat().join(" "),
            row.steps.to_string(),
            format!("{:.4}", row.mean_deg),
            format!("{:.4}", row.truth_change),
            format!("{:.4}", row.change),
            format!("{:.3}", row.ratio),
            format!("{:.3}", row.worst_ratio),
            format!("{:.4}", row.excess),
        ]
    };
    Table::new(&headings, rows.iter().map(line).collect())
}

/// Renders and traces the frames of a range.
///
/// # Errors
/// The tracer's, the device's and those of measuring; a range of one frame; a shot without an environment.
pub fn compare(
    subject: &mut Subject,
    stage: &Stage,
    settings: &Settings,
    range: FrameRange,
    refractions: &[Refraction],
    ring: Silhouette,
) -> Result<Vec<SequenceRow>> {
    anyhow::ensure!(range.count() > 1, "one frame changes into nothing; give --frames two or more, e.g. 0..48");
    let fps = stage.shot().output.fps;
    let mut progress = Progress::new("frames", u64::from(range.count()));
    let mut truths: Vec<Picture> = Vec::new();
    let mut shown: Vec<Vec<Picture>> = refractions.iter().map(|_| Vec::new()).collect();
    let mut degrees = vec![0.0; refractions.len()];
    for number in range.start..range.end {
        subject.request = stage.request(f64::from(number) / fps, settings);
        let truth = Truth::trace(subject).with_context(|| format!("frame {number}"))?;
        let no_picture = "there is no environment to be seen through the glass; leave --env none out";
        truths.push(truth.picture().context(no_picture)?.clone());
        for ((&refraction, pictures), degrees) in refractions.iter().zip(&mut shown).zip(&mut degrees) {
            let shown = truth.measure(subject, refraction, ring)?;
            pictures.push(shown.picture.context(no_picture)?);
            *degrees += shown.paths.mean_deg / f64::from(range.count());
        }
        progress.advance();
    }
    progress.finish();
    let rows = refractions.iter().zip(shown).zip(degrees).map(|((refraction, pictures), mean_deg)| {
        let flicker = flicker_against(&truths, &pictures, DEFAULT_PIXELS_PER_DEGREE)?;
        anyhow::ensure!(
            flicker.truth.mean > 0.0,
            "nothing moves in these frames; leave --hold out, play a --clip or let the camera --orbit"
        );
        // Pairs that show no motion have no ratio.
        let pairs = flicker.tested.pairs.iter().zip(&flicker.truth.pairs).filter(|(_, truth)| **truth > 0.0);
        Ok(SequenceRow {
            method: refraction.method.name(),
            variant: refraction.variant(),
            steps: refraction.steps,
            mean_deg,
            truth_change: flicker.truth.mean,
            change: flicker.tested.mean,
            ratio: flicker.tested.mean / flicker.truth.mean,
            worst_ratio: pairs.map(|(tested, truth)| tested / truth).fold(0.0, f64::max),
            excess: flicker.excess.mean,
        })
    });
    rows.collect()
}
