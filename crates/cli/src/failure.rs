//! How a command ends that did not end well.

use std::process::ExitCode;

/// Exit status of a comparison over its threshold.
const OVER_THRESHOLD: u8 = 1;
/// Exit status for bad input or a bad environment.
const BAD_INPUT: u8 = 2;
/// Exit status after Ctrl-C: 128 + SIGINT.
pub const INTERRUPTED: u8 = 130;

/// The user pressed Ctrl-C.
#[derive(Debug, thiserror::Error)]
#[error("interrupted; the files written so far are whole")]
pub struct Interrupted;

/// A measured value is over the limit that the user set.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct OverThreshold(pub String);

/// Says what went wrong and picks the exit status.
pub fn report(error: &anyhow::Error) -> ExitCode {
    eprintln!("error: {}", message(error));
    ExitCode::from(if error.is::<Interrupted>() {
        INTERRUPTED
    } else if error.is::<OverThreshold>() {
        OVER_THRESHOLD
    } else {
        BAD_INPUT
    })
}

/// The chain of causes as one sentence. Many messages repeat their cause already; those are not said twice.
fn message(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use anyhow::{Context, anyhow};

    #[test]
    fn causes_are_named_once() {
        let error =
            Err::<(), _>(anyhow!("disk full")).context("a.png: disk full").context("export failed").unwrap_err();
        assert_eq!(super::message(&error), "export failed: a.png: disk full");
    }
}
