//! What a caller may choose about caustics.

use murano_refraction::{Interfaces, UnknownName};

/// How landed photons become irradiance. The table every user-facing list is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Fixed-size Gaussian splats (Wyman), as a deposit of B-splines followed by one separable Gaussian.
    Splat,
    /// Points, each shared out to the four texels next to it, on receivers found by iteration over what the light sees (Shah, Konttinen and
    /// Pattanaik 2007).
    Shah,
    /// The cells between photons as triangles where those land (Ernst, Akenine-Möller and Jensen 2005; Umenhoffer, Patow and
    /// Szirmay-Kalos 2008).
    Beams,
    /// Every photon lays the parallelogram that its cell covers on the receiver, by the ray's differential, with the area it shares
    /// with each texel (Igehy 1999 for the differential).
    Footprint,
}

impl Method {
    /// Every method there is.
    pub const ALL: [Self; 4] = [Self::Splat, Self::Shah, Self::Beams, Self::Footprint];

    /// Whether photons land on what the lamp does not see, too.
    pub fn follows_hidden(self) -> bool {
        // Its iteration knows one surface.
        self != Self::Shah
    }

    /// Whether its photons tell where they came from and how their rays differ from cell to cell.
    pub(crate) fn wants_differentials(self) -> bool {
        matches!(self, Self::Beams | Self::Footprint)
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Splat => "splat",
            Self::Shah => "shah",
            Self::Beams => "beams",
            Self::Footprint => "footprint",
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Method {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|entry| entry.name() == name).ok_or_else(|| UnknownName {
            what: "caustics method",
            name: name.into(),
            choices: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Everything about caustics that a frame may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Caustics {
    /// Reconstruction.
    pub method: Method,
    /// Photons along each side of a caster's grid.
    pub photons: u32,
    /// Texels along each side of the caustic map.
    pub map_size: u32,
    /// Which light lands: only what is refracted in and out and meets the body no more, or also what is mirrored off the body, totally
    /// reflected inside or enters again, as far as the refraction method can follow it ([`Interfaces::All`]).
    pub interfaces: Interfaces,
}

impl Default for Caustics {
    fn default() -> Self {
        Self { method: Method::Footprint, photons: 256, map_size: 512, interfaces: Interfaces::All }
    }
}
