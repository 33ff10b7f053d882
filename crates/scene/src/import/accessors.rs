//! Accessors to lists of numbers: every component type, strides, sparse substitution, zeros without a buffer view, and
//! compressed buffer views, which are decoded once.
//!
//! Nothing is allocated for a count before the bytes behind it were seen, except zeros, and all decoding together is
//! bounded by what the file holds.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

use super::compression::{self, Compression, Decoded};
use super::container::Buffers;
use super::document::{Accessor, ComponentType, Document, ElementType, Sparse, get};
use super::error::ImportProblem;

/// Decoded bytes that any file may take.
const ALLOWANCE: u64 = 256 << 20;
/// Decoded bytes per byte of buffer beyond that: accessors are shared, and a byte becomes a float.
const ALLOWANCE_PER_BYTE: u64 = 256;

/// What an integer component stands for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Integers {
    /// As `normalized` says.
    AsFlagged,
    /// A fraction of the type's range: colours, weights and animation have no other integer form.
    Fractions,
}

/// Reads accessors of one document.
pub(super) struct Accessors<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    limit: u64,
    spent: Cell<u64>,
    /// Content of each compressed buffer view, once it was asked for.
    decoded: Vec<OnceCell<Decoded>>,
}

/// One accessor's elements in memory, bounds checked.
struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    stride: usize,
    count: usize,
    width: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(document: &'a Document, buffers: &'a Buffers<'a>) -> Self {
        let limit = ALLOWANCE.saturating_add(buffers.total().saturating_mul(ALLOWANCE_PER_BYTE));
        let decoded = document.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Self { document, buffers, limit, spent: Cell::new(0), decoded }
    }

    /// Element count as declared; the index and the count are checked.
    pub(super) fn count(&self, index: usize, user: &str) -> Result<u64, ImportProblem> {
        Ok(get(&self.document.accessors, index, "accessors", user)?.count)
    }

    /// Element type as declared.
    pub(super) fn element_type(&self, index: usize, user: &str) -> Result<ElementType, ImportProblem> {
        Ok(get(&self.document.accessors, index, "accessors", user)?.element_type)
    }

    /// Finite floats, `N` to an element. Integers are decoded as glTF 2.0, section 3.11 says.
    pub(super) fn floats<const N: usize>(
        &self,
        index: usize,
        integers: Integers,
        user: &str,
    ) -> Result<Vec<[f32; N]>, ImportProblem> {
        let elements = self.elements(index, N, user)?;
        if elements.component == ComponentType::U32 {
            return Err(wrong(index, user, "32-bit integers where floats are needed"));
        }
        let fractions = elements.normalized || integers == Integers::Fractions;
        let values = elements.decode(|bytes, component| float(bytes, component, fractions));
        match values.iter().position(|element: &[f32; N]| element.iter().any(|value| !value.is_finite())) {
            Some(element) => Err(ImportProblem::NonFinite { at: at(index, user), element }),
            None => Ok(values),
        }
    }

    /// Unsigned integers, `N` to an element.
    pub(super) fn unsigned<const N: usize>(&self, index: usize, user: &str) -> Result<Vec<[u32; N]>, ImportProblem> {
        let elements = self.elements(index, N, user)?;
        match elements.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => Ok(elements.decode(unsigned)),
            _ => Err(wrong(index, user, "signed or floating-point components where unsigned integers are needed")),
        }
    }

    /// Bytes of a buffer view, decoded if it is compressed, and its stride.
    pub(super) fn view(&self, index: usize, user: &str) -> Result<(&[u8], Option<u64>), ImportProblem> {
        let view = get(&self.document.buffer_views, index, "bufferViews", user)?;
        if let Some(decoded) = self.decoded[index].get() {
            return Ok((decoded.bytes(), view.byte_stride));
        }
        let at = format!("bufferViews[{index}] ({user})");
        let bytes = match compression::of(view, &at)? {
            Some(compression) => {
                let decoded = self.decompress(&compression, view.byte_length, &at)?;
                self.decoded[index].get_or_init(|| decoded).bytes()
            }
            None => self.range(view.buffer, view.byte_offset, view.byte_length, &at)?,
        };
        Ok((bytes, view.byte_stride))
    }

    fn decompress(&self, compression: &Compression, length: u64, at: &str) -> Result<Decoded, ImportProblem> {
        let encoded = self.range(compression.buffer, compression.byte_offset, compression.byte_length, at)?;
        let needed = compression.least_length();
        if needed > encoded.len() as u64 {
            return Err(ImportProblem::OutOfBounds { at: at.to_owned(), needed, available: encoded.len() as u64 });
        }
        self.reserve(length, || at.to_owned())?;
        compression.decode(encoded, at)
    }

    /// Bytes of a buffer.
    fn range(&self, buffer: usize, offset: u64, length: u64, at: &str) -> Result<&'a [u8], ImportProblem> {
        get(&self.document.buffers, buffer, "buffers", at)?;
        let bytes =
            self.buffers.get(buffer).ok_or_else(|| ImportProblem::MissingBuffer { at: at.to_owned(), buffer })?;
        let needed = offset.saturating_add(length);
        if needed > bytes.len() as u64 {
            return Err(ImportProblem::OutOfBounds { at: at.to_owned(), needed, available: bytes.len() as u64 });
        }
        Ok(&bytes[offset as usize..needed as usize])
    }

    fn elements(&self, index: usize, width: usize, user: &str) -> Result<Elements<'_>, ImportProblem> {
        let accessor = get(&self.document.accessors, index, "accessors", user)?;
        let element_type = accessor.element_type;
        if element_type.width() != width || element_type == ElementType::Mat2 {
            return Err(wrong(
                index,
                user,
                &format!("its type is {element_type:?} where {width} components are needed"),
            ));
        }
        if accessor.count == 0 {
            return Err(wrong(index, user, "its count is 0, at least 1 is needed"));
        }
        let base = match accessor.buffer_view {
            Some(view) => self.stored(accessor, view, index, user)?,
            None => self.zeros(accessor, index, user)?,
        };
        match &accessor.sparse {
            Some(sparse) => self.substitute(base, sparse, index, user),
            None => Ok(base),
        }
    }

    fn stored(
        &self,
        accessor: &Accessor,
        view: usize,
        index: usize,
        user: &str,
    ) -> Result<Elements<'_>, ImportProblem> {
        let (bytes, stride) = self.view(view, user)?;
        let size = element_size(accessor);
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(wrong(
                index,
                user,
                &format!("its stride of {stride} bytes is below its element size of {size}"),
            ));
        }
        let needed = (accessor.count - 1)
            .checked_mul(stride)
            .and_then(|bytes| bytes.checked_add(size))
            .and_then(|bytes| bytes.checked_add(accessor.byte_offset))
            .unwrap_or(u64::MAX);
        if needed > bytes.len() as u64 {
            return Err(ImportProblem::OutOfBounds { at: at(index, user), needed, available: bytes.len() as u64 });
        }
        self.charge(accessor, index, user)?;
        Ok(Elements {
            bytes: Cow::Borrowed(&bytes[accessor.byte_offset as usize..needed as usize]),
            stride: stride as usize,
            ..layout(accessor)
        })
    }

    fn zeros(&self, accessor: &Accessor, index: usize, user: &str) -> Result<Elements<'static>, ImportProblem> {
        self.charge(accessor, index, user)?;
        let size = element_size(accessor) as usize;
        Ok(Elements { bytes: Cow::Owned(vec![0; accessor.count as usize * size]), stride: size, ..layout(accessor) })
    }

    fn charge(&self, accessor: &Accessor, index: usize, user: &str) -> Result<(), ImportProblem> {
        let decoded = accessor.count.saturating_mul(4 * accessor.element_type.width() as u64);
        self.reserve(decoded, || at(index, user))
    }

    /// Counts bytes against the limit, before they are allocated.
    pub(super) fn reserve(&self, bytes: u64, at: impl FnOnce() -> String) -> Result<(), ImportProblem> {
        let spent = self.spent.get().saturating_add(bytes);
        if spent > self.limit {
            return Err(ImportProblem::TooLarge { at: at(), limit: self.limit });
        }
        self.spent.set(spent);
        Ok(())
    }

    /// Replaces the elements that a sparse accessor lists (glTF 2.0, section 3.6.2.3).
    fn substitute<'s>(
        &'s self,
        base: Elements<'s>,
        sparse: &Sparse,
        index: usize,
        user: &str,
    ) -> Result<Elements<'s>, ImportProblem> {
        let size = base.width * base.component.size();
        let indices = &sparse.indices;
        if matches!(indices.component_type, ComponentType::I8 | ComponentType::I16 | ComponentType::F32) {
            return Err(wrong(index, user, "its sparse indices are not unsigned integers"));
        }
        let index_size = indices.component_type.size();
        let places = self.packed(indices.buffer_view, indices.byte_offset, sparse.count, index_size, index, user)?;
        let values =
            self.packed(sparse.values.buffer_view, sparse.values.byte_offset, sparse.count, size, index, user)?;
        if sparse.count > base.count as u64 {
            let problem = format!("it replaces {} of its {} elements", sparse.count, base.count);
            return Err(wrong(index, user, &problem));
        }
        let mut packed = base.packed(size);
        for (place, value) in places.chunks_exact(index_size).zip(values.chunks_exact(size)) {
            let place = unsigned(place, indices.component_type);
            if place as usize >= base.count {
                return Err(ImportProblem::BadIndex {
                    at: format!("{} sparse indices", at(index, user)),
                    list: "elements".to_owned(),
                    index: u64::from(place),
                    count: base.count,
                });
            }
            packed[place as usize * size..][..size].copy_from_slice(value);
        }
        Ok(Elements { bytes: Cow::Owned(packed), stride: size, ..base })
    }

    fn packed(
        &self,
        view: usize,
        offset: u64,
        count: u64,
        size: usize,
        index: usize,
        user: &str,
    ) -> Result<&[u8], ImportProblem> {
        let (bytes, _) = self.view(view, user)?;
        let needed = count.saturating_mul(size as u64).saturating_add(offset);
        if needed > bytes.len() as u64 {
            let at = format!("{} sparse", at(index, user));
            return Err(ImportProblem::OutOfBounds { at, needed, available: bytes.len() as u64 });
        }
        Ok(&bytes[offset as usize..needed as usize])
    }
}

impl Elements<'_> {
    fn decode<T: Copy + Default, const N: usize>(&self, component: impl Fn(&[u8], ComponentType) -> T) -> Vec<[T; N]> {
        let size = self.component.size();
        (0..self.count)
            .map(|element| {
                let bytes = &self.bytes[element * self.stride..][..N * size];
                std::array::from_fn(|k| component(&bytes[k * size..][..size], self.component))
            })
            .collect()
    }

    fn packed(&self, size: usize) -> Vec<u8> {
        (0..self.count).flat_map(|element| &self.bytes[element * self.stride..][..size]).copied().collect()
    }
}

/// Everything but the bytes.
fn layout(accessor: &Accessor) -> Elements<'static> {
    Elements {
        bytes: Cow::Borrowed(&[]),
        stride: 0,
        count: accessor.count as usize,
        width: accessor.element_type.width(),
        component: accessor.component_type,
        normalized: accessor.normalized,
    }
}

/// Bytes of one element. The only matrices read are 4x4, whose columns need no padding.
fn element_size(accessor: &Accessor) -> u64 {
    (accessor.element_type.width() * accessor.component_type.size()) as u64
}

fn at(index: usize, user: &str) -> String {
    format!("accessors[{index}] ({user})")
}

fn wrong(index: usize, user: &str, problem: &str) -> ImportProblem {
    ImportProblem::Accessor { at: at(index, user), problem: problem.to_owned() }
}

/// One component as a float; `fractions` maps integers to 0..1 or -1..1.
fn float(bytes: &[u8], component: ComponentType, fractions: bool) -> f32 {
    let (value, full) = match component {
        ComponentType::I8 => (f32::from(bytes[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        ComponentType::U32 => (unsigned(bytes, component) as f32, u32::MAX as f32),
        ComponentType::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    };
    if fractions { (value / full).max(-1.0) } else { value }
}

/// One unsigned component; signed and floating-point ones are refused before.
fn unsigned(bytes: &[u8], component: ComponentType) -> u32 {
    match component.size() {
        1 => u32::from(bytes[0]),
        2 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}
