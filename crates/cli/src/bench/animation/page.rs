//! The results of `bench animation` as a page.

use murano_metrics::report::{Block, Column, Report, Table};

use super::Results;
use crate::bench::growth;

/// The page.
pub fn page(results: &Results) -> Report {
    let mut blocks = vec![Block::Paragraph(
        "Sampling is a clip's curves and the world matrices of all nodes, the palette every joint's matrix in f64, rounded \
         once; both on one thread of the processor. Deformation is the GPU time of the deform passes that reuse nothing. \
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
