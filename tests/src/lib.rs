//! Tests that span crates.

pub mod bench;
pub mod caustics;
pub mod ground_truth;
