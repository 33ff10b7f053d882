//! What a measurement can be refused for.

/// Why two things could not be compared, or one not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricsError {
    /// Two things that belong together differ in size.
    #[error("{what} has {found} entries where {expected} are needed; compare maps of one size")]
    Length {
        /// The slice in question.
        what: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// Two pictures or maps differ in width or height.
    #[error(
        "{what} is {}x{} where {}x{} is needed; compare pictures of one size",
        found[0], found[1], expected[0], expected[1]
    )]
    Size {
        /// The picture or map in question.
        what: &'static str,
        /// Width and height needed.
        expected: [u32; 2],
        /// Width and height given.
        found: [u32; 2],
    },
    /// A picture or map too small, too large or indivisible for what is asked of it.
    #[error("{what} of {}x{} does not fit: {need}", size[0], size[1])]
    Unfit {
        /// The picture or map in question.
        what: &'static str,
        /// Its width and height.
        size: [u32; 2],
        /// What would fit.
        need: &'static str,
    },
    /// Nothing to measure.
    #[error("{what} is empty; give at least {least}")]
    Empty {
        /// The thing in question.
        what: &'static str,
        /// The fewest entries that can be measured.
        least: usize,
    },
    /// A number out of its range.
    #[error("{what} is {value}; give {need}")]
    Range {
        /// The quantity in question.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The range that is valid.
        need: &'static str,
    },
    /// An entry out of its range.
    #[error("entry {index} of {what} is {value}; every entry must be {need}")]
    Entry {
        /// The slice in question.
        what: &'static str,
        /// Index of the first such entry.
        index: usize,
        /// Its value.
        value: f64,
        /// The range that is valid.
        need: &'static str,
    },
    /// A ratio to nothing.
    #[error("{what} is dark everywhere, so nothing can be measured relative to it; check the light and the receiver")]
    Dark {
        /// The map in question.
        what: &'static str,
    },
    /// No ridge in the map of the truth.
    #[error("the map of the truth has no ridge at this scale; give a smaller scale or a larger share of the flux")]
    NoRidge,
    /// A picture that could not be written as PNG.
    #[error("a picture of {}x{} cannot be written as PNG: {reason}", size[0], size[1])]
    Png {
        /// Its width and height.
        size: [u32; 2],
        /// What the encoder says.
        reason: String,
    },
}

/// The number of entries of a map of `size`.
pub(crate) fn area(size: [u32; 2]) -> usize {
    size[0] as usize * size[1] as usize
}

/// Refuses a slice whose length is not `expected`.
pub(crate) fn expect_len(what: &'static str, found: usize, expected: usize) -> Result<(), MetricsError> {
    if found == expected { Ok(()) } else { Err(MetricsError::Length { what, expected, found }) }
}

/// Refuses a picture or map whose width or height is not `expected`.
pub(crate) fn expect_size(what: &'static str, found: [u32; 2], expected: [u32; 2]) -> Result<(), MetricsError> {
    if found == expected { Ok(()) } else { Err(MetricsError::Size { what, expected, found }) }
}

/// Refuses a number that is not finite and above zero.
pub(crate) fn expect_positive(what: &'static str, value: f64) -> Result<(), MetricsError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(MetricsError::Range { what, value, need: "a finite number above zero" })
    }
}
