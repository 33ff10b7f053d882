//! The results of `bench animation` as a page.

use murano_metrics::report::{Block, Column, Report, Table};

use super::{CrowdResult, Results};
use crate::bench::growth;

/// The page.
pub fn page(results: &Results) -> Report {
    let mut blocks = vec![Block::Paragraph(
        "Joints a microsecond are curves evaluated on one thread of the processor, all of a clip's: as time goes on, at times that \
         jump, half and half of two clips, and with the world matrices and the palette of every joint. Deformation is the GPU time of the deform passes that reuse nothing. \
         The error is the largest distance of any vertex in any pose from the same deformation in f64."
            .into(),
    )];
    if !results.models.is_empty() {
        let mut columns: Vec<Column> = Results::headings().map(Column::number).into();
        columns[0] = Column::text("model");
        let caption = "Medians; the error is the worst of all poses".into();
        blocks.push(Block::Heading("Models".into()));
        blocks.push(Block::Table(Table { caption, columns, rows: results.cells() }));
    }
    if !results.crowds.is_empty() {
        let mut columns: Vec<Column> = CrowdResult::headings().map(Column::number).into();
        columns[0] = Column::text("model");
        let caption = "Poses and palettes on all cores, medians. Tracking: the part of that which asking who moves takes, measured by itself. By memory and by arithmetic: \
                       vertices a millisecond if nothing but the bytes that a deformation reads and writes at least had to move, and if \
                       nothing but its multiplications and additions had to be done"
            .into();
        let rows = results.crowds.iter().map(CrowdResult::cells).collect();
        blocks.push(Block::Heading("Crowds".into()));
        blocks.push(Block::Table(Table { caption, columns, rows }));
    }
    if !results.growth.is_empty() {
        blocks.push(Block::Heading("How cost grows".into()));
        blocks.extend(growth::plots(&results.growth).into_iter().map(Block::Plot));
    }
    Report {
        title: "Animation: what a pose costs".into(),
        summary: format!("{} models", results.models.len()),
        facts: results.facts.list(),
        blocks,
    }
}
