//! `murano bench`: what the program says of itself when it is measured.

mod animation;
mod cache;
mod caustics;
mod growth;
mod output;
mod refraction;
mod stability;

use anyhow::Result;
use clap::{Args, Subcommand};

pub use growth::GrowthPoint;
pub use refraction::angle_map;

/// Measures the program: each kind is a table for people, and JSON for machines
#[derive(Args)]
pub struct Arguments {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(Subcommand)]
enum Kind {
    Refraction(refraction::Arguments),
    Caustics(caustics::Arguments),
    Animation(animation::Arguments),
    Cache(cache::Arguments),
    Stability(stability::Arguments),
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.kind {
        Kind::Caustics(arguments) => caustics::run(arguments),
        Kind::Animation(arguments) => animation::run(arguments),
        Kind::Cache(arguments) => cache::run(arguments),
        Kind::Refraction(arguments) => refraction::run(arguments),
        Kind::Stability(arguments) => stability::run(arguments),
    }
}
