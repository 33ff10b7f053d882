//! Tests that span crates.

pub mod bench;
