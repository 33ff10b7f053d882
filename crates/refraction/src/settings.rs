//! What a caller may choose about refraction: the table of methods and the policies they share.

use std::{fmt, str::FromStr};

/// How the second interface is found. The table every user-facing list is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Single interface: the first refracted direction indexes the environment (Oliveira & Brauwers, section 4).
    Sir,
    /// Conservative binary search against the farthest back surface (Oliveira & Brauwers, corrected).
    Dir,
    /// Bracketed tangent-plane Newton on the nearest back surface.
    Newton,
    /// `newton` seeds a triangle; a walk over the mesh's adjacency ends on the exact one.
    Walk,
    /// All layers under every texel, followed from texel to texel; walks over the mesh from the planes met.
    Layers,
}

impl Method {
    /// Every method there is, in the order of the table.
    pub const ALL: [Self; 5] = [Self::Sir, Self::Dir, Self::Newton, Self::Walk, Self::Layers];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sir => "sir",
            Self::Dir => "dir",
            Self::Newton => "newton",
            Self::Walk => "walk",
            Self::Layers => "layers",
        }
    }
}

/// What happens to a ray totally reflected at the second interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TirPolicy {
    /// It passes straight through (T2 = T1).
    Pass,
    /// It leaves along the surface, at the critical angle (Oliveira & Brauwers, section 5).
    Clamp,
    /// It is reflected once, then leaves.
    Reflect,
}

impl TirPolicy {
    /// Every policy.
    pub const ALL: [Self; 3] = [Self::Pass, Self::Clamp, Self::Reflect];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Clamp => "clamp",
            Self::Reflect => "reflect",
        }
    }
}

/// A name that stands in no table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no {what} `{name}`; choose one of: {choices}")]
pub struct UnknownName {
    /// The table, e.g. "refraction method".
    pub what: &'static str,
    /// What was asked for.
    pub name: String,
    /// The names there are, comma-separated.
    pub choices: String,
}

macro_rules! named {
    ($type:ty, $what:literal) => {
        impl FromStr for $type {
            type Err = UnknownName;

            fn from_str(name: &str) -> Result<Self, UnknownName> {
                Self::ALL.into_iter().find(|entry| entry.name() == name).ok_or_else(|| UnknownName {
                    what: $what,
                    name: name.into(),
                    choices: Self::ALL.map(Self::name).join(", "),
                })
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

named!(Method, "refraction method");
named!(TirPolicy, "TIR policy");

/// Everything about refraction that a frame may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Refraction {
    /// Search for the second interface.
    pub method: Method,
    /// Steps of the search: bisections for `dir`, Newton steps for `newton` and `walk`.
    pub steps: u32,
    /// Total internal reflection at the second interface.
    pub tir: TirPolicy,
    /// Whether the first interface also reflects, Fresnel-weighted.
    pub reflection: bool,
}

impl Default for Refraction {
    fn default() -> Self {
        Self { method: Method::Newton, steps: 5, tir: TirPolicy::Reflect, reflection: true }
    }
}
