//! Layouts of structs that Rust writes and a shader reads, and the checks that both mean the same bytes.
//!
//! Rust and WGSL each declare such a struct; the crate that owns it checks the two against each other in its tests, with
//! [`check_uniform_layout`](crate::check_uniform_layout) and [`check_storage_layout`](crate::check_storage_layout).

use std::collections::BTreeSet;

use encase::{ShaderType, StorageBuffer, internal::WriteInto};

use crate::Shader;

/// A struct as a shader lays it out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// Its name in WGSL.
    pub name: String,
    /// Bytes, a multiple of the alignment: the stride of an array of them.
    pub size: u32,
    /// Members in order, and the byte each begins at.
    pub members: Vec<(String, u32)>,
}

/// How Rust's idea of a struct differs from a shader's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("shader `{shader}`, struct `{name}`: {problem}; make the Rust and the WGSL declaration agree")]
pub struct LayoutError {
    /// Root module.
    pub shader: &'static str,
    /// The struct's name in WGSL.
    pub name: String,
    /// What differs.
    pub problem: String,
}

/// The bytes of a value in the storage address space, without padding at the end.
///
/// # Panics
/// Never: a growing list takes all that is written.
pub fn value_bytes<T: ShaderType + WriteInto>(value: &T) -> Vec<u8> {
    let mut buffer = StorageBuffer::new(Vec::new());
    buffer.write(value).expect("a Vec grows");
    buffer.into_inner()
}

impl Shader {
    /// Checks a uniform struct by value: `whole` holds its bytes, `members` those of each member alone. The members must
    /// hold values that tell them apart.
    ///
    /// # Errors
    /// [`LayoutError`] if the shader has no such struct, or one with other members, elsewhere or of another size.
    pub fn check_uniform(&self, name: &str, whole: &[u8], members: &[(&str, Vec<u8>)]) -> Result<(), LayoutError> {
        let layout = self.struct_of(name, members.iter().map(|(member, _)| *member))?;
        if whole.len() as u32 != layout.size {
            return Err(self.differs(name, format!("{} bytes in Rust, {} in WGSL", whole.len(), layout.size)));
        }
        for (member, bytes) in members {
            let places: Vec<usize> = (0..whole.len()).step_by(4).filter(|&at| whole[at..].starts_with(bytes)).collect();
            let wanted = layout.offset(member);
            if places.as_slice() != [wanted] {
                return Err(self.differs(name, format!("`{member}` at {places:?} in Rust, at {wanted} in WGSL")));
            }
        }
        Ok(())
    }

    /// Checks the struct of a storage buffer's array: Rust's `size_of` and `offset_of` each member.
    ///
    /// # Errors
    /// As [`Shader::check_uniform`].
    pub fn check_storage(&self, name: &str, size: usize, members: &[(&str, usize)]) -> Result<(), LayoutError> {
        let layout = self.struct_of(name, members.iter().map(|(member, _)| *member))?;
        if size as u32 != layout.size {
            return Err(self.differs(name, format!("{size} bytes in Rust, {} in WGSL", layout.size)));
        }
        for &(member, offset) in members {
            let wanted = layout.offset(member);
            if offset != wanted {
                return Err(self.differs(name, format!("`{member}` at {offset} in Rust, at {wanted} in WGSL")));
            }
        }
        Ok(())
    }

    fn struct_of<'a>(&self, name: &str, members: impl Iterator<Item = &'a str>) -> Result<&StructLayout, LayoutError> {
        let layout = self.structs.iter().find(|layout| layout.name == name);
        let layout = layout.ok_or_else(|| self.differs(name, "there is none".into()))?;
        let rust: BTreeSet<&str> = members.collect();
        let wgsl: BTreeSet<&str> = layout.members.iter().map(|(member, _)| member.as_str()).collect();
        if rust != wgsl {
            return Err(self.differs(name, format!("members {rust:?} in Rust, {wgsl:?} in WGSL")));
        }
        Ok(layout)
    }

    fn differs(&self, name: &str, problem: String) -> LayoutError {
        LayoutError { shader: self.name, name: name.into(), problem }
    }
}

impl StructLayout {
    /// Where a member begins that the struct is known to have.
    fn offset(&self, member: &str) -> usize {
        self.members.iter().find(|(name, _)| name == member).map_or(usize::MAX, |(_, offset)| *offset as usize)
    }
}

/// Checks a uniform's Rust struct against a shader's: `check_uniform_layout!(shader, "Params", Params { a: 1.0, b: 2.0 })`.
///
/// The value must name every member and give each its own value; a member is found by where its bytes come to lie.
/// Gives `Result<(), LayoutError>`.
#[macro_export]
macro_rules! check_uniform_layout {
    ($shader:expr, $wgsl:literal, $rust:ident { $($member:ident: $value:expr),+ $(,)? }) => {{
        let value = $rust { $($member: $value),+ };
        let members = [$((stringify!($member), $crate::value_bytes(&value.$member))),+];
        $shader.check_uniform($wgsl, &$crate::value_bytes(&value), &members)
    }};
}

/// Checks a `repr(C)` struct against the element of a shader's storage buffer:
/// `check_storage_layout!(shader, "Row", Row { a, b })`. Every member must be named. Gives `Result<(), LayoutError>`.
#[macro_export]
macro_rules! check_storage_layout {
    ($shader:expr, $wgsl:literal, $rust:ident { $($member:ident),+ $(,)? }) => {{
        // Does not compile unless every member is named.
        let _ = |$rust { $($member: _),+ }: $rust| ();
        let members = [$((stringify!($member), ::std::mem::offset_of!($rust, $member))),+];
        $shader.check_storage($wgsl, ::std::mem::size_of::<$rust>(), &members)
    }};
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShaderSpec;

    #[derive(ShaderType)]
    struct Swapped {
        size: glam::UVec2,
        sigma: f32,
        watts: f32,
    }

    #[repr(C)]
    struct Short {
        entry: u32,
    }

    #[repr(C)]
    struct Turned {
        weight: f32,
        entry: u32,
    }

    /// Each way to disagree is found, and named.
    #[test]
    fn a_planted_disagreement_is_found() {
        let filter = Shader::link(&ShaderSpec::new("caustics::filter")).unwrap();
        let found =
            check_uniform_layout!(filter, "Kernel", Swapped { size: glam::UVec2::new(1, 2), sigma: 3.0, watts: 4.0 });
        assert!(found.unwrap_err().problem.contains("`sigma` at [8] in Rust, at 12 in WGSL"));
        let deform = Shader::link(&ShaderSpec::new("animation::deform")).unwrap();
        assert!(check_storage_layout!(deform, "Influence", Short { entry }).unwrap_err().problem.contains("members"));
        let found = check_storage_layout!(deform, "Influence", Turned { weight, entry });
        assert!(found.unwrap_err().problem.contains("`weight` at 0 in Rust, at 4 in WGSL"));
        assert!(deform.check_storage("Influence", 12, &[("entry", 0), ("weight", 4)]).is_err());
        assert!(deform.check_storage("Absent", 4, &[]).is_err());
    }
}
