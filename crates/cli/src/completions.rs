//! `murano completions`: what a shell needs to complete command lines.

use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Prints shell completions
#[derive(Args)]
#[command(after_help = "Example:\n  murano completions bash > ~/.local/share/bash-completion/completions/murano")]
pub struct Arguments {
    /// Shell
    shell: Shell,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    // Generated into memory first: the generator panics where stdout is closed early.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "murano", &mut script);
    std::io::Write::write_all(&mut std::io::stdout().lock(), &script).context("stdout cannot be written to")
}
