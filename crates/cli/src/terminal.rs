//! What is said on stdout and stderr.

use std::{
    fmt::Display,
    io::{self, IsTerminal, Write},
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

/// How far a long command has come: a bar on a terminal, a line a second elsewhere; on stderr.
pub struct Progress {
    bar: Option<ProgressBar>,
    total: u64,
    done: u64,
    start: Instant,
    last_line: Instant,
}

impl Progress {
    /// Begins at none of `total` frames.
    pub fn new(total: u64) -> Self {
        let now = Instant::now();
        let bar = io::stderr().is_terminal().then(|| {
            let style = "{bar:40} {pos}/{len} frames  {elapsed} gone, {eta} left";
            let style = ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(total).with_style(style)
        });
        Self { bar, total, done: 0, start: now, last_line: now }
    }

    /// One more frame.
    pub fn advance(&mut self) {
        self.done += 1;
        if let Some(bar) = &self.bar {
            bar.inc(1);
        } else if self.last_line.elapsed() >= Duration::from_secs(1) || self.done == self.total {
            self.last_line = Instant::now();
            let seconds = self.start.elapsed().as_secs_f64();
            let left = seconds / self.done as f64 * (self.total - self.done) as f64;
            eprintln!("{}/{} frames, {seconds:.0} s gone, {left:.0} s left", self.done, self.total);
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
