//! The results of `bench refraction` as a page.

use anyhow::Result;
use murano_metrics::{
    heat_map::HeatMap,
    images::Picture,
    report::{Axis, Block, CaptionedPicture, Column, Gallery, Plot, Point, Report, Series, Table},
    scale::{Scale, Scaling},
};

use super::{Results, SubjectResult};
use crate::{compare::RefractionRow, trial::RefractionTrial};

/// Longer side of a picture on the page, pixels.
const PORTRAIT: u32 = 256;
/// Ends of the colours of all heat maps, degrees: one scale, so that maps can be compared.
const ANGLES: (f64, f64) = (1e-3, 1e2);

/// The angles of a picture on the scale that all heat maps share.
pub fn angle_map(size: [u32; 2], angles: &[f32]) -> Result<Picture> {
    let scale = Scale::new(Scaling::Logarithmic, ANGLES.0, ANGLES.1)?;
    Ok(HeatMap { title: "exit direction", unit: "degrees", size, values: angles, scale }.draw()?)
}

/// A picture for the page.
pub struct Portrait {
    picture: CaptionedPicture,
}

impl Portrait {
    /// What the truth shows.
    pub fn of_truth(picture: &Picture) -> Result<Self> {
        Ok(Self {
            picture: CaptionedPicture {
                png: smaller(picture)?.to_png()?,
                caption: "truth".into(),
                alt: "The environment through the body by exact paths".into(),
            },
        })
    }

    /// What a method shows, and a map of its errors.
    pub fn of_trial(row: &RefractionRow, trial: &RefractionTrial, size: [u32; 2]) -> Result<Vec<Self>> {
        let mut portraits = Vec::new();
        if let Some(picture) = &trial.picture {
            let caption = format!("{}: mean {:.3} degrees", row.label(), row.mean_deg());
            let alt = format!("The environment through the body by {}", row.label());
            portraits.push(CaptionedPicture { png: smaller(picture)?.to_png()?, caption, alt });
        }
        let (smaller_size, angles) = fewer(size, &trial.errors.paths.angles);
        portraits.push(CaptionedPicture {
            png: angle_map(smaller_size, &angles)?.to_png()?,
            caption: format!("{}: error", row.label()),
            alt: format!("Angle between the exit directions of {} and of the truth", row.label()),
        });
        Ok(portraits.into_iter().map(|picture| Self { picture }).collect())
    }
}

/// How many pixels become one.
fn factor(size: [u32; 2]) -> u32 {
    size[0].max(size[1]).div_ceil(PORTRAIT)
}

/// Columns and rows of the pixels that become one; fewer where the picture is narrower than a block.
fn pixels_of_block(size: [u32; 2], factor: u32, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> {
    let range = move |place: u32, side: u32| place * factor..((place + 1) * factor).min(side);
    range(y, size[1]).flat_map(move |row| range(x, size[0]).map(move |column| (column, row)))
}

fn smaller(picture: &Picture) -> Result<Picture> {
    let factor = factor(picture.size());
    let size = picture.size().map(|side| (side / factor).max(1));
    let width = picture.size()[0];
    let block = |x: u32, y: u32, channel: usize| {
        let (sum, count) = pixels_of_block(picture.size(), factor, x, y)
            .map(|(column, row)| u32::from(picture.rgb()[(row * width + column) as usize][channel]))
            .fold((0, 0), |(sum, count), value| (sum + value, count + 1));
        (sum / count.max(1)) as u8
    };
    let rgb = (0..size[0] * size[1]).map(|i| [0, 1, 2].map(|channel| block(i % size[0], i / size[0], channel)));
    Ok(Picture::new(size, rgb.collect())?)
}

/// The worst of every block of a map.
fn fewer(size: [u32; 2], values: &[f32]) -> ([u32; 2], Vec<f32>) {
    let factor = factor(size);
    let smaller = size.map(|side| (side / factor).max(1));
    let worst = |x: u32, y: u32| {
        let value = |(column, row): (u32, u32)| values[(row * size[0] + column) as usize];
        pixels_of_block(size, factor, x, y).map(value).fold(f32::NAN, f32::max)
    };
    (smaller, (0..smaller[0] * smaller[1]).map(|i| worst(i % smaller[0], i / smaller[0])).collect())
}

/// The page.
pub fn page(results: &Results) -> Report {
    let mut blocks = vec![Block::Paragraph(
        "Every pixel of every model is compared with the path through the same pose and the same triangles, traced in f64 \
         through two interfaces. The outermost ring of covered pixels is left out. GPU time is that of the passes that find \
         the interfaces and draw the glass (refit, eye_map, glass_surface, refract): the median of frames that reuse nothing."
            .into(),
    )];
    if !results.subjects.is_empty() {
        blocks.push(Block::Heading("Run time against error".into()));
        let iors = distinct(results.subjects.iter().map(|subject| subject.ior));
        blocks.extend(iors.iter().map(|&ior| Block::Plot(time_against_error(results, ior))));
        blocks.push(Block::Heading("Models".into()));
        blocks.extend(results.subjects.iter().flat_map(subject_blocks));
    }
    if !results.growth.is_empty() {
        blocks.push(Block::Heading("How cost grows".into()));
        blocks.extend(super::super::growth::plots(&results.growth).into_iter().map(Block::Plot));
    }
    Report {
        title: "Refraction: run time against error".into(),
        summary: format!(
            "{} models, times and indices; {}x{} pixels",
            results.subjects.len(),
            results.size[0],
            results.size[1]
        ),
        facts: results.facts.list(),
        blocks,
    }
}

fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut list: Vec<f64> = values.collect();
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}

/// A point a model and method; a method is a series.
fn time_against_error(results: &Results, ior: f64) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    for subject in results.subjects.iter().filter(|subject| subject.ior == ior) {
        for row in &subject.rows {
            let Some(gpu_ms) = row.gpu_ms() else { continue };
            let point = Point { x: gpu_ms, y: row.mean_deg(), title: format!("{}: {}", row.label(), subject.title()) };
            match series.iter_mut().find(|series| series.name == row.label()) {
                Some(series) => series.points.push(point),
                None => series.push(Series { name: row.label(), points: vec![point], line: false, fit: None }),
            }
        }
    }
    Plot {
        title: format!("n = {ior}"),
        caption: "A point a model and method; less is better on both axes. The front is over all models together."
            .into(),
        x: Axis { label: "GPU time of the glass, ms".into(), scaling: Scaling::Logarithmic },
        y: Axis { label: "mean error of the exit direction, degrees".into(), scaling: Scaling::Logarithmic },
        series,
        pareto_front: true,
    }
}

fn subject_blocks(subject: &SubjectResult) -> Vec<Block> {
    let caption = format!("{} triangles, {} pixels of glass", subject.triangles, subject.covered);
    let (headings, cells) = RefractionRow::cells(&subject.rows);
    let mut columns: Vec<Column> = headings.iter().map(|&heading| Column::number(heading)).collect();
    columns[0] = Column::text(headings[0]);
    let mut blocks = vec![Block::Subheading(subject.title()), Block::Table(Table { caption, columns, rows: cells })];
    if !subject.pictures.is_empty() {
        let pictures = subject.pictures.iter().map(|portrait| portrait.picture.clone()).collect();
        let caption =
            "The environment through the body, and how far each pixel's exit direction lies from the truth".into();
        blocks.push(Block::Gallery(Gallery { caption, pictures }));
    }
    blocks
}
