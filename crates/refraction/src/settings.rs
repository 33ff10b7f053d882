//! What a caller may choose about refraction: the table of methods and the policies they share.

use std::{fmt, str::FromStr};

use crate::{Hierarchy, Layers};

/// How the second interface is found. The table every user-facing list is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Single interface: the first refracted direction indexes the environment (Oliveira & Brauwers, section 4).
    Sir,
    /// What the picture shows behind the glass, looked up aside by the normal where the glass's mask allows it (Sousa, GPU Gems 2,
    /// chapter 19).
    Screen,
    /// The distance to the second interface guessed from two others ([`NormalDistance`]; Wyman, eq. 6.3.1).
    Isr,
    /// Conservative binary search against the farthest back surface (Oliveira & Brauwers, corrected).
    Dir,
    /// Bracketed tangent-plane Newton on the nearest back surface.
    Newton,
    /// All layers under every texel, followed from texel to texel; walks over the mesh from the planes met end on the exact
    /// triangle.
    Walk,
    /// `walk` that can also follow light which enters the body again ([`Interfaces::All`]).
    Layers,
    /// Ray traced on the deformed triangles, through a hierarchy of boxes that is refitted to every pose; only where the
    /// eye's rays begin comes from a map.
    Exact,
}

impl Method {
    /// Every method there is, in the order of the table.
    pub const ALL: [Self; 8] =
        [Self::Sir, Self::Screen, Self::Isr, Self::Dir, Self::Newton, Self::Walk, Self::Layers, Self::Exact];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sir => "sir",
            Self::Screen => "screen",
            Self::Isr => "isr",
            Self::Dir => "dir",
            Self::Newton => "newton",
            Self::Walk => "walk",
            Self::Layers => "layers",
            Self::Exact => "exact",
        }
    }
}

impl Method {
    /// Whether light that enters the body again can be followed.
    pub fn follows_all(self) -> bool {
        matches!(self, Self::Layers | Self::Exact)
    }

    /// Whether it ends on triangles of the deformed body, not on texels of a map.
    pub fn knows_triangles(self) -> bool {
        matches!(self, Self::Walk | Self::Layers | Self::Exact)
    }

    /// Whether it traces rays through the body's [`crate::TriangleTree`].
    pub fn traces(self) -> bool {
        self == Self::Exact
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
    /// It is followed until it leaves, over at most 6 reflections.
    Trace,
}

impl TirPolicy {
    /// Every policy.
    pub const ALL: [Self; 4] = [Self::Pass, Self::Clamp, Self::Reflect, Self::Trace];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Clamp => "clamp",
            Self::Reflect => "reflect",
            Self::Trace => "trace",
        }
    }
}

/// How many interfaces a refracted ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Interfaces {
    /// The first two; where it is totally reflected at the second, [`TirPolicy`] says what becomes of it.
    Two,
    /// All ahead of it, as many as [`Refraction::most_interfaces`] says: total reflection is followed, and so is light that enters the
    /// body again. Only
    /// [`Method::follows_all`] methods can; the others follow total reflection alone.
    All,
}

impl Interfaces {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Two, Self::All];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Two => "two",
            Self::All => "all",
        }
    }
}

/// What [`Method::Isr`] takes for d_N, the way from the first interface along its inward normal to the second (Wyman, eq. 6.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NormalDistance {
    /// Traced from every vertex of the rest pose, once; 0 for a body that deforms.
    Baked,
    /// 0.
    Zero,
    /// Nothing: the way along the viewer's ray, d_V, is all there is.
    View,
}

impl NormalDistance {
    /// All there are.
    pub const ALL: [Self; 3] = [Self::Baked, Self::Zero, Self::View];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baked => "baked",
            Self::Zero => "zero",
            Self::View => "view",
        }
    }
}

/// Which back surface [`Method::Isr`] takes for the second interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BackSurface {
    /// The next one behind the front.
    Nearest,
    /// The last.
    Farthest,
}

impl BackSurface {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Nearest, Self::Farthest];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Farthest => "farthest",
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
named!(Interfaces, "number of interfaces");
named!(NormalDistance, "distance along the normal");
named!(BackSurface, "back surface");

/// Everything about refraction that a frame may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Refraction {
    /// Search for the second interface.
    pub method: Method,
    /// Steps of the search: bisections for `dir`, Newton steps for `newton`; the others search until they have met
    /// something.
    pub steps: u32,
    /// Total internal reflection at the second interface, where only two are met.
    pub tir: TirPolicy,
    /// How far rays are followed.
    pub interfaces: Interfaces,
    /// Whether the first interface also reflects, Fresnel-weighted.
    pub reflection: bool,
    /// Paths through the glass that a pixel follows where they are followed on ([`TirPolicy::Trace`], [`Interfaces::All`]), 1 to
    /// [`MOST_BRANCHES`]: first the transmitted one, then always the heaviest part that the last one left aside as its
    /// interfaces reflected or transmitted it. Without `reflection` the first alone. Of several that a photon follows, or
    /// a pixel with more than one sample, the last carries all light that is left, and goes one way at each interface, by chance.
    pub branches: u32,
    /// Interfaces that each of these paths meets, 2 to [`MOST_INTERFACES`]: light that is still inside then is taken to leave the way it
    /// goes. Photons go on for longer, whatever this says.
    pub most_interfaces: u32,
    /// Of `isr`.
    pub normal_distance: NormalDistance,
    /// Of `isr`.
    pub back_surface: BackSurface,
    /// `dir` as its paper prints it: the start of the search is neither tested nor held behind the first interface, and the
    /// normal is that of the last texel probed, not of the point arrived at.
    pub uncorrected: bool,
    /// Wavelengths in which a body that disperses is seen, 1 to [`MOST_WAVELENGTHS`]; 1 disperses nothing.
    pub wavelengths: u32,
}

/// The most paths through the glass that a pixel follows.
pub const MOST_BRANCHES: u32 = 4;

/// The most interfaces that the eye's paths meet.
pub const MOST_INTERFACES: u32 = 64;

/// The most wavelengths that the eye follows.
pub const MOST_WAVELENGTHS: u32 = 16;

impl Refraction {
    /// Whether paths are followed on from the second interface.
    pub(crate) fn follows(self) -> bool {
        !matches!(self.method, Method::Sir | Method::Screen)
            && (self.tir == TirPolicy::Trace || self.interfaces == Interfaces::All)
    }

    /// These settings for light that is followed as far as the method can.
    #[must_use]
    pub fn followed(self) -> Self {
        Self { interfaces: Interfaces::All, ..self }
    }

    /// Paths that a pixel, or a photon of each wavelength, follows.
    pub fn branches_followed(self) -> u32 {
        if self.follows() && self.reflection { self.branches.clamp(1, MOST_BRANCHES) } else { 1 }
    }

    /// Whether light is followed that enters the body again.
    pub fn reenters(self) -> bool {
        self.interfaces == Interfaces::All && self.method.follows_all()
    }

    /// What is left of these settings for a sheet of glass around nothing, through which light goes straight on.
    #[must_use]
    pub fn through_walls(self) -> Self {
        Self { method: Method::Sir, tir: TirPolicy::Pass, interfaces: Interfaces::Two, ..self }
    }

    /// Whether it asks for the body's baked thickness.
    pub fn bakes(self) -> bool {
        self.method == Method::Isr && self.normal_distance == NormalDistance::Baked
    }

    /// What tells this form of its method from others, in words of the command line; empty for methods of one form.
    pub fn variant(self) -> Vec<&'static str> {
        match self.method {
            Method::Isr => vec![self.normal_distance.name(), self.back_surface.name()],
            Method::Dir if self.uncorrected => vec!["uncorrected"],
            _ => Vec::new(),
        }
    }

    /// The layers that the maps of bodies need.
    pub fn layers(&self) -> Layers {
        match self.method {
            Method::Sir | Method::Screen | Method::Newton | Method::Exact => Layers::NearestBack,
            Method::Isr => match self.back_surface {
                BackSurface::Nearest => Layers::NearestBack,
                BackSurface::Farthest => Layers::FarthestBack { depth_range: false },
            },
            Method::Dir => Layers::FarthestBack { depth_range: true },
            Method::Layers if self.reenters() => Layers::All(Hierarchy::CoresAndHulls),
            Method::Walk | Method::Layers => Layers::All(Hierarchy::Cores),
        }
    }
}

impl Default for Refraction {
    fn default() -> Self {
        Self {
            method: Method::Layers,
            steps: 5,
            tir: TirPolicy::Reflect,
            interfaces: Interfaces::Two,
            reflection: true,
            branches: 2,
            normal_distance: NormalDistance::Baked,
            back_surface: BackSurface::Farthest,
            uncorrected: false,
            most_interfaces: 8,
            wavelengths: 8,
        }
    }
}
