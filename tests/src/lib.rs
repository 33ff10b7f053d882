//! Tests that span crates.

pub mod bench;
pub mod ground_truth;
