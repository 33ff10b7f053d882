//! The built binary, run as a user runs it.

// Each test file is a program of its own and uses its part of this.
#![allow(dead_code)]

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

/// A committed model.
pub fn asset(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name).display().to_string()
}

/// Runs `murano` in a folder. Everything that passes write for an export, a comparison or a benchmark is checked to be
/// finite (`bench stability` always is).
pub fn murano(folder: &Path, arguments: &[&str]) -> Output {
    let checked = match arguments {
        ["bench", kind, ..] => *kind != "stability",
        [command, ..] => ["export", "compare"].contains(command),
        [] => false,
    };
    Command::new(env!("CARGO_BIN_EXE_murano"))
        .args(arguments)
        .args(checked.then_some("--check-outputs"))
        .current_dir(folder)
        .output()
        .expect("the binary was built for this test")
}

/// Runs `murano`, which must succeed, and gives what it wrote to stdout and stderr.
pub fn succeeds(folder: &Path, arguments: &[&str]) -> (String, String) {
    let output = murano(folder, arguments);
    let (stdout, stderr) = texts(&output);
    assert_eq!(output.status.code(), Some(0), "murano {}\n{stderr}", arguments.join(" "));
    (stdout, stderr)
}

/// Runs `murano`, which must end with status 2 and a message that holds every one of `words`.
pub fn refuses(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = murano(folder, arguments);
    let (_, stderr) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "murano {}\n{stderr}", arguments.join(" "));
    assert!(!stderr.contains("panicked"), "{stderr}");
    for word in words {
        assert!(stderr.contains(word), "murano {}: no `{word}` in\n{stderr}", arguments.join(" "));
    }
}

fn texts(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

/// Every line as JSON.
pub fn json_lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

/// Names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A fresh folder.
pub fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().to_owned();
    (folder, path)
}
