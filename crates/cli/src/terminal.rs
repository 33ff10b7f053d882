//! What is said on stdout and stderr.

use std::{
    fmt::{self, Display},
    io::{self, IsTerminal, Write},
    sync::Mutex,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Writes a line to stdout.
pub fn say(text: impl Display) -> Result<()> {
    writeln!(io::stdout().lock(), "{text}").context("stdout cannot be written to")
}

/// Writes a value to stdout as one line of JSON.
pub fn say_json(value: &impl Serialize) -> Result<()> {
    say(serde_json::to_string(value)?)
}

/// A table for people: the first column to the left, all others to the right.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with a line of headings, and a cell for each of them in every row.
    pub fn new(headings: &[&str], cells: Vec<Vec<String>>) -> Self {
        let headings = headings.iter().map(|&heading| heading.to_owned()).collect();
        Self { rows: [vec![headings], cells].concat() }
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows[0].len();
        let width =
            |column: usize| self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
        let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
        for (index, row) in self.rows.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                match column {
                    0 => write!(f, "{cell:<width$}")?,
                    _ => write!(f, "  {cell:>width$}")?,
                }
            }
        }
        Ok(())
    }
}

/// How far a long command has come: a bar on a terminal, a line a second elsewhere; on stderr.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: &'static str,
    total: u64,
    done: u64,
    start: Instant,
    last_line: Instant,
}

impl Progress {
    /// Begins at none of `total` things, `what` they are called.
    pub fn new(what: &'static str, total: u64) -> Self {
        let now = Instant::now();
        let bar = io::stderr().is_terminal().then(|| {
            let style = format!("{{bar:40}} {{pos}}/{{len}} {what}  {{elapsed}} gone, {{eta}} left");
            let style = ProgressStyle::with_template(&style).unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(total).with_style(style)
        });
        Self { bar, what, total, done: 0, start: now, last_line: now }
    }

    /// One more is done.
    pub fn advance(&mut self) {
        self.reach(self.done + 1);
    }

    /// So many are done in all.
    pub fn reach(&mut self, done: u64) {
        self.done = done;
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        } else if self.last_line.elapsed() >= Duration::from_secs(1) || self.done == self.total {
            self.last_line = Instant::now();
            let seconds = self.start.elapsed().as_secs_f64();
            let left = seconds / self.done.max(1) as f64 * (self.total - self.done) as f64;
            eprintln!("{}/{} {}, {seconds:.0} s gone, {left:.0} s left", self.done, self.total, self.what);
        }
    }

    /// Writes lines to stderr without disturbing the bar.
    pub fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }

    /// Seconds since the beginning.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Ends; the bar goes.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Runs something long that tells how far it is: (done, total), from any thread.
pub fn watched<T>(what: &'static str, run: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> T) -> T {
    let progress: Mutex<Option<Progress>> = Mutex::new(None);
    let result = run(&|done, total| {
        // A poisoned lock means that a tracer panicked: there is no progress to show.
        let Ok(mut progress) = progress.lock() else { return };
        let progress = progress.get_or_insert_with(|| Progress::new(what, total as u64));
        if done as u64 > progress.done {
            progress.reach(done as u64);
        }
    });
    if let Ok(Some(progress)) = progress.into_inner() {
        progress.finish();
    }
    result
}
