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
use serde_json::json;

use crate::{
    failure::OverThreshold,
    options::AdapterOption,
    terminal::{Progress, say, say_json},
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
    /// One line of JSON on stdout
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let mut gpu = arguments.adapter.open()?.with_output_checks(OutputChecks::NonFinite);
    let adapter = gpu.adapter_name();
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
    let seconds = start.elapsed().as_secs_f64();
    if arguments.json {
        say_json(&json!({ "adapter": adapter, "rows": rows, "broken": broken, "seconds": seconds }))?;
    } else {
        say(table::text(&rows))?;
        say(format!("{} lines, {broken} broken, {seconds:.0} s, {adapter}", rows.len()))?;
    }
    if broken > 0 {
        return Err(OverThreshold(format!(
            "{broken} of {} lines of the stability table break their limits",
            rows.len()
        ))
        .into());
    }
    Ok(())
}
