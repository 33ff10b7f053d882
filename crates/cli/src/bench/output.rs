//! Where a benchmark's results go, and what is said about their circumstances.

use std::{
    io::Write,
    path::{Path, PathBuf},
    time::SystemTime,
};

use anyhow::Result;
use clap::Args;
use murano_gpu::Gpu;
use murano_metrics::report::{Fact, Report};
use serde::Serialize;

use crate::{
    export::{prepare_folder, write_whole},
    terminal::say_json,
};

/// Files of a benchmark.
#[derive(Args)]
pub struct Output {
    /// Writes all figures as JSON; on stdout without FILE
    #[arg(
        long, value_name = "FILE.json", num_args = 0..=1, default_missing_value = "-", value_parser = json_file,
        help_heading = "Output"
    )]
    json: Option<PathBuf>,
    /// Writes a page with tables and plots, whole in one file
    #[arg(long, value_name = "FILE.html", value_parser = html_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

/// `-`, or a file named as JSON: a model that follows a bare `--json` must not be taken for the place to write to.
fn json_file(text: &str) -> Result<PathBuf, String> {
    if text == "-" { Ok(text.into()) } else { named(text, "json") }
}

fn html_file(text: &str) -> Result<PathBuf, String> {
    named(text, "html")
}

fn named(text: &str, extension: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let fits = path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if fits { Ok(path) } else { Err(format!("`{text}` does not end in .{extension}, so it is not written to")) }
}

impl Output {
    /// Tries the files' folders, so that a wrong path shows before anything is measured.
    ///
    /// # Errors
    /// If one cannot be written to.
    pub fn prepare(&self) -> Result<()> {
        let files = self.json.iter().chain(&self.html).filter(|path| path.as_os_str() != "-");
        files.map(PathBuf::as_path).try_for_each(prepare_folder)
    }

    /// Writes what was asked for.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, results: &impl Serialize, page: impl FnOnce() -> Report) -> Result<()> {
        match &self.json {
            Some(path) if path.as_os_str() == "-" => say_json(results)?,
            Some(path) => write_file(path, &serde_json::to_vec_pretty(results)?)?,
            None => {}
        }
        if let Some(path) = &self.html {
            write_file(path, page().to_html().as_bytes())?;
        }
        Ok(())
    }

    /// Whether a page is wanted.
    pub fn page(&self) -> bool {
        self.html.is_some()
    }

    /// Whether stdout is taken by JSON.
    pub fn json_on_stdout(&self) -> bool {
        self.json.as_ref().is_some_and(|path| path.as_os_str() == "-")
    }
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    write_whole(path, |file| Ok(file.write_all(bytes)?))
}

/// The circumstances of a benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    /// As typed.
    pub command: String,
    /// Of the program.
    pub version: &'static str,
    /// UTC, RFC 3339.
    pub date: String,
    /// The adapter that rendered.
    pub adapter: String,
    /// Threads of the processor, which also traces the truth.
    pub threads: usize,
}

impl Facts {
    /// The circumstances of this run.
    pub fn gather(gpu: &Gpu) -> Self {
        let words: Vec<String> = std::env::args().skip(1).map(|word| shell_word(&word)).collect();
        Self {
            command: format!("murano {}", words.join(" ")),
            version: env!("CARGO_PKG_VERSION"),
            date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
            adapter: gpu.adapter_name(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }

    /// For the head of a page.
    pub fn list(&self) -> Vec<Fact> {
        let fact = |name: &str, value: &str| Fact { name: name.into(), value: value.into() };
        vec![
            fact("Adapter", &self.adapter),
            fact("Processor threads", &self.threads.to_string()),
            fact("Date", &self.date),
            fact("Version", self.version),
            fact("Command", &self.command),
        ]
    }
}

/// A model's name on a page.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A word as a shell would need it.
fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+%@#".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn commands_can_be_pasted() {
        let words = ["bench", "a b.glb", "it's", ""].map(super::shell_word);
        assert_eq!(words, ["bench", "'a b.glb'", r"'it'\''s'", "''"]);
    }
}
