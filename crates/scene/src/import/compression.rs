//! Buffer views compressed by EXT_meshopt_compression, or by KHR_meshopt_compression, which has the same layout.
//!
//! The decoder is a C library that checks the bytes it reads. What it takes for granted, strides and counts, is checked
//! here, and so is whether so many elements fit into so few bytes at all, before anything is allocated.

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut, cast_vec};
use meshopt::{decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat};
use meshopt::{decode_index_buffer, decode_index_sequence, decode_vertex_buffer};
use serde::Deserialize;
use serde_json::Value;

use super::document::{Buffer, BufferView, extension};
use super::error::ImportProblem;

/// Both names of the extension, the newer one first.
const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Where a buffer view's compressed bytes are and what they hold.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compression {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// A buffer view's content, decoded.
pub(super) enum Decoded {
    Halves(Vec<u16>),
    Words(Vec<u32>),
}

impl Decoded {
    pub(super) fn bytes(&self) -> &[u8] {
        match self {
            Self::Halves(halves) => cast_slice(halves),
            Self::Words(words) => cast_slice(words),
        }
    }
}

/// Whether a buffer stands in for data that are only there compressed; it is never read.
pub(super) fn is_fallback(buffer: &Buffer) -> bool {
    let marks = NAMES.iter().filter_map(|name| buffer.extensions.get(*name)?.get("fallback"));
    marks.into_iter().any(|mark| *mark == Value::Bool(true))
}

/// The compression of a buffer view, if it has one, its mode, filter, stride and count checked.
pub(super) fn of(view: &BufferView, at: &str) -> Result<Option<Compression>, ImportProblem> {
    for name in NAMES {
        if let Some(compression) = extension::<Compression>(&view.extensions, name, at)? {
            return match compression.problem(view.byte_length) {
                Some(problem) => Err(ImportProblem::Value { at: format!("{at}.extensions.{name}"), problem }),
                None => Ok(Some(compression)),
            };
        }
    }
    Ok(None)
}

impl Compression {
    fn problem(&self, decoded_length: u64) -> Option<String> {
        let &Self { byte_stride: stride, count, mode, filter, .. } = self;
        let legal = match (mode, filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => attribute_decoder(stride).is_some(),
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Triangles | Mode::Indices, Filter::None) => stride == 2 || stride == 4,
            (Mode::Triangles | Mode::Indices, _) => false,
        };
        if !legal {
            return Some(format!("a byteStride of {stride} does not go with mode {mode:?} and filter {filter:?}"));
        }
        if count == 0 || count.checked_mul(stride) != Some(decoded_length) {
            return Some(format!("{count} elements of {stride} bytes do not fill a byteLength of {decoded_length}"));
        }
        (matches!(mode, Mode::Triangles) && !count.is_multiple_of(3))
            .then(|| format!("a count of {count} is not a multiple of 3"))
    }

    /// Fewest bytes into which so many elements can be encoded, whatever they are: header, what each element or block
    /// of elements takes at least, tail.
    pub(super) fn least_length(&self) -> u64 {
        match self.mode {
            Mode::Attributes => {
                let block = ((8192 / self.byte_stride) & !15).min(256);
                1 + self.count.div_ceil(block) * (self.byte_stride / 4) + self.byte_stride.max(24)
            }
            Mode::Triangles => 1 + self.count / 3 + 16,
            Mode::Indices => 1 + self.count + 4,
        }
    }

    /// Decodes the compressed bytes; what comes out has the length of the buffer view.
    pub(super) fn decode(&self, encoded: &[u8], at: &str) -> Result<Decoded, ImportProblem> {
        let count = self.count as usize;
        let decoded = match (self.mode, self.byte_stride) {
            (Mode::Attributes, stride) => attribute_decoder(stride).and_then(|decode| {
                let mut words = decode(encoded, count)?;
                self.filter.undo(&mut words, stride);
                Some(Decoded::Words(words))
            }),
            (Mode::Triangles, 2) => decode_index_buffer(encoded, count).ok().map(Decoded::Halves),
            (Mode::Triangles, _) => decode_index_buffer(encoded, count).ok().map(Decoded::Words),
            (Mode::Indices, 2) => decode_index_sequence(encoded, count).ok().map(Decoded::Halves),
            (Mode::Indices, _) => decode_index_sequence(encoded, count).ok().map(Decoded::Words),
        };
        decoded.ok_or_else(|| ImportProblem::Compressed { at: at.to_owned(), content: self.mode.content() })
    }
}

impl Mode {
    fn content(self) -> &'static str {
        match self {
            Self::Attributes => "attributes",
            Self::Triangles => "triangles",
            Self::Indices => "indices",
        }
    }
}

impl Filter {
    /// Turns filtered elements of `stride` bytes back, in place.
    fn undo(self, words: &mut [u32], stride: u64) {
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => decode_filter_oct::<i8>(cast_slice_mut(words)),
            (Self::Octahedral, _) => decode_filter_oct::<i16>(cast_slice_mut(words)),
            (Self::Color, 4) => decode_filter_color::<u8>(cast_slice_mut(words)),
            (Self::Color, _) => decode_filter_color::<u16>(cast_slice_mut(words)),
            (Self::Quaternion, _) => decode_filter_quat(cast_slice_mut(words)),
            (Self::Exponential, _) => decode_filter_exp(words.as_chunks_mut::<1>().0),
        }
    }
}

/// An element of `N` words, as the decoder takes its stride from a type.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
struct Element<const N: usize>([u32; N]);

impl<const N: usize> Default for Element<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn attributes<const N: usize>(encoded: &[u8], count: usize) -> Option<Vec<u32>> {
    decode_vertex_buffer::<Element<N>>(encoded, count).ok().map(cast_vec)
}

/// From encoded bytes and the count of elements to their words.
type AttributeDecoder = fn(&[u8], usize) -> Option<Vec<u32>>;

/// The decoder of attributes of a stride, which is a multiple of 4 up to 256 bytes.
fn attribute_decoder(stride: u64) -> Option<AttributeDecoder> {
    macro_rules! of_words {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => Some(attributes::<$words>),)*
                _ => None,
            }
        };
    }
    if !stride.is_multiple_of(4) {
        return None;
    }
    of_words!(
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
    )
}
