//! The project's own tasks, run as `cargo xtask TASK`.

mod assets;
mod cargo;
mod demo;
mod driver;
mod gpu;
mod test;

use std::{path::PathBuf, process::ExitCode};

use clap::{Parser, Subcommand};

/// Tasks of the Murano project.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Exports a looping clip of a glass character with its caustics to out/. Ends with where to look.
    Demo,
    /// Runs every test of the workspace. Arguments go to `cargo test`, e.g. `cargo xtask test -p murano-optics`.
    Test {
        /// Passed on to `cargo test`; without a package, `--workspace` is added.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Generates the characters, bodies and the environment of assets/ anew. The same bytes every time.
    Assets,
    /// Packs the benchmark battery into target/gpu, for a machine that has a GPU and no compiler.
    Gpu {
        /// Models (.glb) to measure beside the project's own.
        models: Vec<PathBuf>,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Demo => demo::run(),
        Task::Test { arguments } => test::run(&arguments),
        Task::Assets => assets::run(&cargo::root().join("assets")),
        Task::Gpu { models } => gpu::run(&models),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
