//! `cargo xtask gpu`: the benchmark battery, packed for a machine that has a GPU and no compiler.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};

use crate::cargo;

/// What runs every benchmark there.
const BATTERY: &str = include_str!("battery.sh");

/// Builds the program without symbols and lays it, the project's assets and shots, `models`, and the script that runs every
/// benchmark side by side in `target/gpu`.
///
/// # Errors
/// When the program does not compile, or a file cannot be read or written.
pub fn run(models: &[PathBuf]) -> Result<()> {
    let root = cargo::root();
    println!("building murano with all optimisations (the first time takes some minutes) ...");
    cargo::run(&["build", "--release", "--bin", "murano"])?;

    let folder = root.join("target/gpu");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} could not be emptied", folder.display()))?;
    }
    copy(&root.join("target/release/murano"), &folder.join("murano"))?;
    for kind in ["assets", "animations"] {
        let from = root.join(kind);
        let entries = fs::read_dir(&from).with_context(|| format!("{} could not be listed", from.display()))?;
        for entry in entries {
            let path = entry.with_context(|| format!("{} could not be listed", from.display()))?.path();
            copy(&path, &folder.join(kind).join(path.file_name().unwrap_or_default()))?;
        }
    }
    for model in models {
        copy(model, &folder.join("models").join(model.file_name().unwrap_or_default()))?;
    }
    let script = folder.join("battery.sh");
    fs::write(&script, BATTERY).with_context(|| format!("{} could not be written", script.display()))?;
    println!("\nCopy {} to the machine with the GPU and run there:\n  sh battery.sh RESULTS", folder.display());
    Ok(())
}

/// Copies a file, with the folders above it.
fn copy(from: &Path, to: &Path) -> Result<()> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).with_context(|| format!("{} could not be created", folder.display()))?;
    }
    fs::copy(from, to)
        .with_context(|| format!("{} could not be copied to {}", from.display(), to.display()))
        .map(|_| ())
}
