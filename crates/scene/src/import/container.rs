//! From the file system to bytes: the GLB container, external files and data URIs.

use std::borrow::Cow;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::Path;

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::compression::is_fallback;
use super::document::Document;
use super::error::ImportProblem;

const GLB_MAGIC: &[u8; 4] = b"glTF";
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// A model file in memory, split into its JSON and its binary chunk (glTF 2.0, section 4.4).
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    /// Takes a `.glb` or a `.gltf` apart; which one it is is decided by its first bytes.
    pub(super) fn split(bytes: &'a [u8]) -> Result<Self, ImportProblem> {
        if bytes.starts_with(GLB_MAGIC) {
            let (json, binary) = split_glb(bytes)?;
            Ok(Self { json: &bytes[json], binary: binary.map(|range| &bytes[range]) })
        } else {
            Ok(Self { json: bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes), binary: None })
        }
    }
}

fn glb(problem: impl Into<String>) -> ImportProblem {
    ImportProblem::Glb { problem: problem.into() }
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..offset.checked_add(4)?)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

/// The JSON chunk and the binary chunk, as ranges of `bytes`.
fn split_glb(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), ImportProblem> {
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(glb(format!("{} bytes, shorter than the {GLB_HEADER}-byte header", bytes.len())));
    };
    if version != 2 {
        return Err(ImportProblem::Version { version: format!("{version} (container version)") });
    }
    let length = length as usize;
    if length < GLB_HEADER + CHUNK_HEADER || length > bytes.len() {
        return Err(glb(format!("its header says {length} bytes, the file has {}", bytes.len())));
    }
    let (kind, json) = chunk(&bytes[..length], GLB_HEADER)?;
    if kind != CHUNK_JSON {
        return Err(glb("its first chunk is not JSON"));
    }
    let mut next = json.end;
    while length - next >= CHUNK_HEADER {
        let (kind, range) = chunk(&bytes[..length], next)?;
        if kind == CHUNK_BIN {
            return Ok((json, Some(range)));
        }
        next = range.end;
    }
    Ok((json, None))
}

/// Type and content of the chunk whose header is at `offset`; `offset` lies within `bytes`.
fn chunk(bytes: &[u8], offset: usize) -> Result<(u32, Range<usize>), ImportProblem> {
    let start = offset + CHUNK_HEADER;
    let (Some(length), Some(kind)) = (u32_at(bytes, offset), u32_at(bytes, offset + 4)) else {
        return Err(glb(format!("the chunk at byte {offset} has no header")));
    };
    let length = length as usize;
    if length > bytes.len() - start {
        return Err(glb(format!("the chunk at byte {offset} says {length} bytes, {} are left", bytes.len() - start)));
    }
    Ok((kind, start..start + length))
}

/// Contents of a regular file; a device or a pipe would never end, so they are refused.
pub(super) fn read_file(path: &Path, wanted_by: &str) -> Result<Vec<u8>, ImportProblem> {
    let failed = |source: io::Error| {
        let path = path.to_owned();
        let wanted_by = wanted_by.to_owned();
        if source.kind() == io::ErrorKind::NotFound {
            ImportProblem::MissingFile { path, wanted_by }
        } else {
            ImportProblem::Unreadable { path, wanted_by, source }
        }
    };
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(io::Error::other("not a regular file")));
    }
    fs::read(path).map_err(failed)
}

/// Bytes behind a URI: a data URI, or a file relative to `directory`, if there is one.
pub(super) fn load_uri(uri: &str, directory: Option<&Path>, at: &str) -> Result<Vec<u8>, ImportProblem> {
    let wrong = |problem: String| ImportProblem::Uri { at: at.to_owned(), problem };
    if let Some(rest) = uri.strip_prefix("data:") {
        let (kind, payload) = rest.split_once(',').ok_or_else(|| wrong("the data URI has no comma".to_owned()))?;
        if !kind.ends_with(";base64") {
            return Ok(percent_encoding::percent_decode_str(payload).collect());
        }
        let tolerant = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        return GeneralPurpose::new(&STANDARD, tolerant)
            .decode(payload)
            .map_err(|error| wrong(format!("the data URI does not decode: {error}")));
    }
    if uri.contains("://") {
        return Err(wrong(format!("\"{uri}\" is not a local file")));
    }
    let Some(directory) = directory else {
        return Err(wrong(format!("\"{uri}\" is a file, and the model, which is none, has no folder to find it in")));
    };
    let name = percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| wrong(format!("\"{uri}\" is not UTF-8")))?;
    if name.contains('\0') {
        return Err(wrong("the file name contains a NUL".to_owned()));
    }
    read_file(&directory.join(name.as_ref()), at)
}

/// The document's buffers; `None` where one holds no data or stands in for compressed data.
pub(super) struct Buffers<'a>(Vec<Option<Cow<'a, [u8]>>>);

impl<'a> Buffers<'a> {
    /// Loads every buffer and checks its length.
    pub(super) fn load(
        document: &Document,
        container: &Container<'a>,
        directory: Option<&Path>,
    ) -> Result<Self, ImportProblem> {
        let mut buffers = Vec::with_capacity(document.buffers.len());
        for (index, buffer) in document.buffers.iter().enumerate() {
            let at = format!("buffers[{index}]");
            let bytes = match (&buffer.uri, container.binary) {
                _ if is_fallback(buffer) => None,
                (Some(uri), _) => Some(Cow::Owned(load_uri(uri, directory, &at)?)),
                (None, Some(binary)) if index == 0 => Some(Cow::Borrowed(binary)),
                (None, _) => None,
            };
            if let Some(bytes) = &bytes
                && (bytes.len() as u64) < buffer.byte_length
            {
                return Err(ImportProblem::OutOfBounds {
                    at,
                    needed: buffer.byte_length,
                    available: bytes.len() as u64,
                });
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    /// Bytes of one buffer; `None` where it holds none. The index has been checked against the document.
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        self.0.get(index)?.as_deref()
    }

    /// Bytes present in all buffers together.
    pub(super) fn total(&self) -> u64 {
        self.0.iter().flatten().map(|bytes| bytes.len() as u64).sum()
    }
}
