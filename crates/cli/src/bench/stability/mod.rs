//! `murano bench stability`: hostile inputs, rendered by every method with every pass's outputs checked, and held against
//! the truth.

pub mod bodies;
mod case;
mod cases;
mod imports;
mod loops;
mod measure;
mod table;
mod truth;

use std::time::Instant;

use anyhow::Result;
use clap::Args;
use murano_gpu::OutputChecks;
use murano_metrics::report::{Block, Report};
use serde::Serialize;

use super::output::{Facts, Output};
use crate::{
    failure::OverThreshold,
    options::AdapterOption,
    terminal::{Progress, say},
};
use table::Row;

/// Renders hostile inputs with every method: nothing may be NaN or infinite, errors are bounded or flagged
#[derive(Args)]
#[command(after_help = "Ends with status 1 if any line breaks its limits.\n\nExamples:\n  \
    murano bench stability\n  \
    murano bench stability --quick --json")]
pub struct Arguments {
    #[command(flatten)]
    adapter: AdapterOption,
    /// Few steps of each sweep
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    output: Output,
}

/// Everything measured.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    facts: Facts,
    rows: Vec<Row>,
    /// Lines that break their limits.
    broken: usize,
    seconds: f64,
}

impl Results {
    fn page(&self) -> Report {
        let about = "Inputs that break renderers, each rendered by every method with every pass's output checked for NaN and \
                     infinity, and held against the same triangles traced in f64. What has no right answer must be flagged.";
        Report {
            title: "Stability: hostile inputs".into(),
            summary: format!("{} lines, {} broken, {:.0} s", self.rows.len(), self.broken, self.seconds),
            facts: self.facts.list(),
            blocks: vec![Block::Paragraph(about.into()), Block::Table(table::block(&self.rows))],
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.output.prepare()?;
    let start = Instant::now();
    let mut gpu = arguments.adapter.open()?.with_output_checks(OutputChecks::NonFinite);
    let facts = Facts::gather(&gpu);
    let groups = cases::groups(arguments.quick);
    let mut progress = Progress::new("cases", groups.iter().map(|group| group.cases.len() as u64).sum());
    let mut rows: Vec<Row> = Vec::new();
    for group in &groups {
        let first = rows.len();
        rows.extend(Row::of_group(group));
        for case in &group.cases {
            let (device, outcomes) = measure::measure(gpu, case)?;
            gpu = device;
            for (row, (_, outcome)) in rows[first..].iter_mut().zip(outcomes) {
                row.add(outcome);
            }
            progress.advance();
        }
    }
    progress.finish();
    rows.push(loops::thousand_frames(gpu, if arguments.quick { 100 } else { 1000 })?);
    rows.push(imports::refusals()?);

    let broken = rows.iter().filter(|row| !row.holds()).count();
    let results = Results { facts, rows, broken, seconds: start.elapsed().as_secs_f64() };
    let summary = format!("{} lines, {broken} broken, {:.0} s", results.rows.len(), results.seconds);
    if !arguments.output.json_on_stdout() {
        say(table::text(&results.rows))?;
        say(format!("{summary}, {}", results.facts.adapter))?;
    }
    arguments.output.write(&results, || results.page())?;
    if broken > 0 {
        return Err(OverThreshold(format!(
            "{broken} of {} lines of the stability table break their limits",
            results.rows.len()
        ))
        .into());
    }
    Ok(())
}
