//! Running cargo in this workspace.

use std::{
    env,
    ffi::OsString,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, bail};

/// The workspace's root folder: where the project stands now, even if it was moved since this was compiled.
pub fn root() -> PathBuf {
    let package = env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&package).parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Runs cargo with `arguments` in the root folder and waits for it; its output goes where ours goes.
///
/// # Errors
/// When cargo cannot be started, or ends with anything but success; the message repeats the command.
pub fn run(arguments: &[&str]) -> Result<()> {
    let program = env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let status = Command::new(program)
        .args(arguments)
        .current_dir(root())
        .status()
        .context("cargo could not be started; install Rust from https://rustup.rs")?;
    if !status.success() {
        bail!("`cargo {}` failed with {status}; what it said stands above", arguments.join(" "));
    }
    Ok(())
}
