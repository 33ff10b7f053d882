//! The results of `bench cache` as a page.

use murano_metrics::report::{Block, Column, Report, Table};

use super::{MODES, Results, Row};

/// The page.
pub fn page(results: &Results) -> Report {
    let mut columns: Vec<Column> = Results::HEADINGS.map(Column::number).into();
    for column in &mut columns[..3] {
        *column = Column::text(&column.title);
    }
    let caption = format!(
        "{} frames each, {}x{} pixels; passes are means a frame, times medians",
        results.frames, results.size[0], results.size[1]
    );
    let mut blocks = vec![
        Block::Paragraph(
            "What a frame runs when only a part of the scene has changed since the last one. Off: every pass is run. Verified: what \
             would be reused is run again, and every bit compared. A looped clip is measured in its second round."
                .into(),
        ),
        Block::Paragraph(results.summary()),
        Block::Table(Table { caption, columns, rows: results.cells() }),
        Block::Heading("By pass, cache on".into()),
    ];
    let lit = results.rows.iter().filter(|row| row.cache == MODES[0].0 && row.caustics);
    blocks.extend(lit.flat_map(passes));
    Report {
        title: "Reuse: what a change costs".into(),
        summary: results.input.clone(),
        facts: results.facts.list(),
        blocks,
    }
}

fn passes(row: &Row) -> Vec<Block> {
    let cells = row.passes.iter().filter(|pass| pass.ran > 0.0);
    let rows: Vec<_> =
        cells.map(|pass| vec![pass.name.clone(), format!("{:.2}", pass.ran), format!("{:.3}", pass.gpu_ms)]).collect();
    if rows.is_empty() {
        return vec![Block::Subheading(row.scenario.into()), Block::Paragraph("No pass ran.".into())];
    }
    let columns = vec![Column::text("pass"), Column::number("runs a frame"), Column::number("GPU ms a frame")];
    vec![
        Block::Subheading(row.scenario.into()),
        Block::Table(Table { caption: "Passes that ran".into(), columns, rows }),
    ]
}
