//! The results of `bench caustics` as a page.

use anyhow::Result;
use murano_metrics::{
    heat_map::HeatMap,
    irradiance::IrradianceMap,
    report::{Axis, Block, CaptionedPicture, Column, Gallery, Plot, Point, Report, Series, Table},
    scale::{Scale, Scaling},
};

use super::{Results, SubjectResult};
use crate::{
    bench::growth,
    compare::CausticRow,
    trial::{CausticTrial, CausticTruth},
};

/// A picture of a caustic.
pub struct Portrait {
    picture: CaptionedPicture,
}

impl Portrait {
    /// The traced irradiance.
    pub fn of_truth(truth: &CausticTruth) -> Result<Self> {
        Self::draw(truth.map(), truth, "traced".into(), "Irradiance of the floor, traced".into())
    }

    /// What a method draws.
    pub fn of_trial(row: &CausticRow, trial: &CausticTrial, truth: &CausticTruth) -> Result<Self> {
        let caption = format!("{}: relative L1 {:.3}", row.label(), row.relative_l1());
        let alt = format!("Irradiance of the floor by {}", row.label());
        Self::draw(&trial.map, truth, caption, alt)
    }

    /// All maps of a subject have the truth's scale.
    fn draw(map: &IrradianceMap, truth: &CausticTruth, caption: String, alt: String) -> Result<Self> {
        let narrow = |map: &IrradianceMap| map.values().iter().map(|&value| value as f32).collect::<Vec<f32>>();
        let scale = Scale::logarithmic_of(&narrow(truth.map()));
        let values = narrow(map);
        let drawn = HeatMap { title: "irradiance", unit: "W/m²", size: map.size(), values: &values, scale }.draw()?;
        Ok(Self { picture: CaptionedPicture { png: drawn.to_png()?, caption, alt } })
    }
}

/// The page.
pub fn page(results: &Results) -> Report {
    let mut blocks = vec![
        Block::Paragraph(
            "The irradiance that caustics add to the floor, within the square around 95 % of the light that was refracted in \
             and out, against photons traced in f64: light of two interfaces or of all, as above. `r50` is the radius of the circle that holds half of the flux, over \
             the truth's; the ridge is where the caustic's bright lines lie. The truth's own noise is a lower bound of \
             what relative L1 can show. GPU time is that of the passes light_map, emit and deposit."
                .into(),
        ),
        Block::Heading("Run time against error".into()),
        Block::Plot(time_against_error(results)),
        Block::Heading("Models".into()),
    ];
    blocks.extend(results.subjects.iter().flat_map(subject_blocks));
    if !results.growth.is_empty() {
        blocks.push(Block::Heading("How cost grows".into()));
        blocks.extend(growth::plots(&results.growth).into_iter().map(Block::Plot));
    }
    Report {
        title: "Caustics: run time against error".into(),
        summary: format!("{} models and lights", results.subjects.len()),
        facts: results.facts.list(),
        blocks,
    }
}

/// A point a method with its photons and map; a model and light is a series.
fn time_against_error(results: &Results) -> Plot {
    let series = results.subjects.iter().map(|subject| {
        let point = |row: &CausticRow| Some(Point { x: row.gpu_ms()?, y: row.relative_l1(), title: row.label() });
        Series {
            name: subject.title(),
            points: subject.rows.iter().filter_map(point).collect(),
            line: false,
            fit: None,
        }
    });
    Plot {
        title: "Relative L1 of the caustic map".into(),
        caption: "A point a number of photons and size of map; less is better on both axes.".into(),
        x: Axis { label: "GPU time of the caustics, ms".into(), scaling: Scaling::Logarithmic },
        y: Axis { label: "relative L1".into(), scaling: Scaling::Logarithmic },
        series: series.collect(),
        pareto_front: true,
    }
}

fn subject_blocks(subject: &SubjectResult) -> Vec<Block> {
    let (headings, cells) = CausticRow::cells(&subject.rows);
    let mut columns: Vec<Column> = headings.iter().map(|&heading| Column::number(heading)).collect();
    columns[0] = Column::text(headings[0]);
    let caption = format!("{} triangles, {:.4} W on the square", subject.triangles, subject.flux);
    let pictures = subject.pictures.iter().map(|portrait| portrait.picture.clone()).collect();
    vec![
        Block::Subheading(subject.title()),
        Block::Table(Table { caption, columns, rows: cells }),
        Block::Gallery(Gallery { caption: "Irradiance of the floor".into(), pictures }),
    ]
}
