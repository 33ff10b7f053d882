//! The `murano` command line.

mod adapters;
mod bench;
mod compare;
mod completions;
mod export;
mod failure;
mod inspect;
mod layer;
mod options;
mod pose;
mod terminal;
mod trial;
mod values;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Plays animated glTF characters as real glass: refraction through the deforming body, and the caustics it throws.
#[derive(Parser)]
#[command(name = "murano", version, arg_required_else_help = true, max_term_width = 120)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Export(Box<export::Arguments>),
    Compare(Box<compare::Arguments>),
    Pose(pose::Arguments),
    Bench(bench::Arguments),
    Inspect(inspect::Arguments),
    Adapters(adapters::Arguments),
    Completions(completions::Arguments),
}

fn main() -> ExitCode {
    let filter = tracing_subscriber::EnvFilter::try_from_env("MURANO_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).without_time().init();

    let result = match Arguments::parse().command {
        Command::Export(arguments) => export::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Pose(arguments) => pose::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Adapters(arguments) => adapters::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    /// Clap checks its declarations only when they are used, and then by panicking.
    #[test]
    fn the_command_line_is_well_formed() {
        super::Arguments::command().debug_assert();
    }
}
