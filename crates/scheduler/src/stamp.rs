//! Content-derived identities.

use std::fmt;

use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Identity of a piece of content: equal stamps mean equal content.
///
/// 128 bits of XXH3. Not cryptographic: among 2^40 different contents the chance of any collision is below 2^-48, but
/// content can be forged by someone who wants to.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stamp(u128);

impl Stamp {
    /// The stamp of plain bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(xxh3_128(bytes))
    }

    /// The 128 bits themselves, for storage and for mixing into other hashes.
    pub fn bits(self) -> u128 {
        self.0
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl fmt::Debug for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Stamp({self})")
    }
}

/// Stamps a sequence of fields.
///
/// Every field is preceded by its length, so different sequences never hash the same bytes: `"ab", "c"` is not
/// `"a", "bc"`. A list inside a sequence has to be preceded by its number of elements.
///
/// ```
/// use murano_scheduler::StampBuilder;
///
/// let mut a = StampBuilder::new("material");
/// a.text("glass").number(3);
/// let mut b = StampBuilder::new("material");
/// b.text("glas").text("s").number(3);
/// assert_ne!(a.finish(), b.finish());
/// ```
#[derive(Clone)]
pub struct StampBuilder(Xxh3);

impl StampBuilder {
    /// Starts a sequence. `kind` keeps sequences of different meaning apart.
    pub fn new(kind: &str) -> Self {
        let mut builder = Self(Xxh3::new());
        builder.text(kind);
        builder
    }

    /// Appends bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Appends a text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Appends an integer.
    pub fn number(&mut self, number: u64) -> &mut Self {
        self.bytes(&number.to_le_bytes())
    }

    /// Appends another stamp.
    pub fn stamp(&mut self, stamp: Stamp) -> &mut Self {
        self.bytes(&stamp.0.to_le_bytes())
    }

    /// The stamp of everything appended so far.
    pub fn finish(&self) -> Stamp {
        Stamp(self.0.digest128())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(fields: &[&[u8]]) -> Stamp {
        let mut builder = StampBuilder::new("test");
        for field in fields {
            builder.bytes(field);
        }
        builder.finish()
    }

    #[test]
    fn field_boundaries_count() {
        assert_ne!(sequence(&[b"ab", b"c"]), sequence(&[b"a", b"bc"]));
        assert_ne!(sequence(&[b"", b"a"]), sequence(&[b"a", b""]));
        assert_ne!(sequence(&[b"a"]), sequence(&[b"a", b""]));
        assert_eq!(sequence(&[b"a", b"bc"]), sequence(&[b"a", b"bc"]));
    }

    #[test]
    fn kinds_are_kept_apart() {
        assert_ne!(StampBuilder::new("leaf").finish(), StampBuilder::new("pass").finish());
    }

    #[test]
    fn display_is_the_whole_stamp_in_hexadecimal() {
        let stamp = Stamp::of(b"glass");
        assert_eq!(u128::from_str_radix(&stamp.to_string(), 16), Ok(stamp.bits()));
    }
}
