//! What can be wrong with a shot.

use std::path::PathBuf;

/// Why a shot could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum ShotError {
    /// The file does not exist or cannot be read.
    #[error("shot {} cannot be read: {source}; check the path", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The file is not RON, or has fields that a shot has not.
    #[error("shot {}: {source}; correct the file there", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, column and cause.
        source: Box<ron::error::SpannedError>,
    },
    /// A value outside its legal range.
    #[error("shot {}: `{field}` {problem}; correct the value", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The field, e.g. `camera.fov`.
        field: String,
        /// What it must be.
        problem: &'static str,
    },
    /// The shot cannot be written as RON.
    #[error("the shot cannot be written: {0}; paths must be valid UTF-8")]
    Unwritable(#[from] ron::Error),
}
