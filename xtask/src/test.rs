//! `cargo xtask test`: every test of the workspace, on whatever adapter there is.

use anyhow::Result;

use crate::{cargo, driver};

/// Sees to a Vulkan driver, then runs `cargo test` with `arguments` (of every package if none is named).
///
/// # Errors
/// When no driver can be had, or a test fails.
pub fn run(arguments: &[String]) -> Result<()> {
    driver::ensure()?;
    let names_packages = arguments.iter().any(|argument| argument == "--package" || argument.starts_with("-p"));
    let mut command = vec!["test"];
    if !names_packages {
        command.push("--workspace");
    }
    command.extend(arguments.iter().map(String::as_str));
    cargo::run(&command)
}
