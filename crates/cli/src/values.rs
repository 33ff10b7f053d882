//! Values on the command line, and how they are read.

use std::{fmt::Display, str::FromStr};

use clap::builder::{PathBufValueParser, PossibleValuesParser, StringValueParser, TypedValueParser};
use glam::DVec3;
use murano_caustics::Method as CausticsMethod;
use murano_refraction::{BackSurface, Method as RefractionMethod, NormalDistance, Refraction};
use murano_scene::{ClipChoice, EnvironmentChoice, FloorLevel, ShotLightKind, Skinning};

/// One of a table's names; the table's own parser makes the value of it.
pub fn one_of<T, const N: usize>(names: [&'static str; N]) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: std::error::Error + Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// `--caustics`: a method, or `off`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CausticsChoice(pub Option<CausticsMethod>);

impl CausticsChoice {
    /// Reads `off` or a name of the table.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        let names = std::iter::once("off").chain(CausticsMethod::ALL.map(CausticsMethod::name));
        PossibleValuesParser::new(names)
            .try_map(|name| if name == "off" { Ok(Self(None)) } else { name.parse().map(|method| Self(Some(method))) })
    }
}

/// A refraction method as `--methods` names it; what is not named is as usual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefractionChoice {
    method: RefractionMethod,
    steps: Option<u32>,
    normal_distance: Option<NormalDistance>,
    back_surface: Option<BackSurface>,
    uncorrected: bool,
}

impl RefractionChoice {
    /// Settings that differ from others by what is named.
    pub fn of(&self, usual: Refraction) -> Refraction {
        Refraction {
            method: self.method,
            steps: self.steps.unwrap_or(usual.steps),
            normal_distance: self.normal_distance.unwrap_or(usual.normal_distance),
            back_surface: self.back_surface.unwrap_or(usual.back_surface),
            uncorrected: self.uncorrected || usual.uncorrected,
            ..usual
        }
    }

    /// A method and the words after its name.
    fn read<'a>(method: RefractionMethod, words: impl Iterator<Item = &'a str>) -> Result<Self, String> {
        let mut choice = Self { method, steps: None, normal_distance: None, back_surface: None, uncorrected: false };
        for word in words {
            match method {
                RefractionMethod::Dir if word == "uncorrected" => choice.uncorrected = true,
                RefractionMethod::Isr if word.parse::<NormalDistance>().is_ok() => {
                    choice.normal_distance = word.parse().ok();
                }
                RefractionMethod::Isr if word.parse::<BackSurface>().is_ok() => choice.back_surface = word.parse().ok(),
                _ if choice.steps.is_some() => return Err(wrong_word(method, word)),
                _ => choice.steps = Some(count(word, 64).ok_or_else(|| wrong_word(method, word))?),
            }
        }
        Ok(choice)
    }
}

fn wrong_word(method: RefractionMethod, word: &str) -> String {
    let others = match method {
        RefractionMethod::Dir => ", or the word uncorrected",
        RefractionMethod::Isr => ", or the words baked, zero, view, nearest, farthest",
        _ => "",
    };
    format!("`{word}`: after {method}: come steps, a whole number from 1 to 64, as in {method}:12{others}")
}

/// A whole number from 1 to `most`.
fn count(text: &str, most: u32) -> Option<u32> {
    text.parse().ok().filter(|count| (1..=most).contains(count))
}

/// One entry of `--methods`: `newton`, `dir:12`, `isr:view:nearest`, `splat:256`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodChoice {
    /// A refraction method and what is named of its settings.
    Refraction(RefractionChoice),
    /// A caustics method, and its photons a side where they are given.
    Caustics(CausticsMethod, Option<u32>),
}

impl FromStr for MethodChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut words = text.split(':');
        let name = words.next().unwrap_or_default();
        if let Ok(method) = name.parse() {
            return RefractionChoice::read(method, words).map(Self::Refraction);
        }
        if let Ok(method) = name.parse() {
            let given: Vec<_> = words.map(|word| count(word, 8192)).collect();
            return match given[..] {
                [] => Ok(Self::Caustics(method, None)),
                [Some(photons)] => Ok(Self::Caustics(method, Some(photons))),
                _ => Err(format!("`{text}`: photons a side are a whole number from 1 to 8192, as in {name}:12")),
            };
        }
        let refraction = RefractionMethod::ALL.map(RefractionMethod::name);
        let caustics = CausticsMethod::ALL.map(CausticsMethod::name);
        let choices = [&refraction[..], &caustics[..]].concat().join(", ");
        Err(format!("there is no method `{name}`; choose from: {choices}"))
    }
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("`{text}` is not finite")) }
}

/// A number greater than zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = number(text)?;
    if number > 0.0 { Ok(number) } else { Err(format!("`{text}` must be greater than 0")) }
}

/// A number that is not below zero.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let number = number(text)?;
    if number >= 0.0 { Ok(number) } else { Err(format!("`{text}` must not be negative")) }
}

/// A number from 0 to 1.
pub fn fraction(text: &str) -> Result<f64, String> {
    let number = number(text)?;
    if (0.0..=1.0).contains(&number) { Ok(number) } else { Err(format!("`{text}` must be between 0 and 1")) }
}

/// An index of refraction.
pub fn index_of_refraction(text: &str) -> Result<f64, String> {
    let number = number(text)?;
    if number >= 1.0 { Ok(number) } else { Err(format!("`{text}` must be at least 1, the index of air")) }
}

/// `X,Y,Z`.
fn vector(text: &str) -> Result<DVec3, String> {
    let parts = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    let parts: [f64; 3] = parts.try_into().map_err(|_| format!("`{text}` should be three numbers, X,Y,Z"))?;
    Ok(DVec3::from_array(parts))
}

/// `WIDTHxHEIGHT` in pixels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    /// What every adapter can do, and the limit of shots.
    const LARGEST: u32 = 16384;
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (1..=LARGEST).contains(side));
    let (width, height) = text.split_once(['x', 'X']).ok_or("write it as WIDTHxHEIGHT, e.g. 512x512")?;
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok([width, height]),
        _ => Err(format!("each side is a whole number from 1 to {LARGEST}, e.g. 512x512")),
    }
}

/// A clip: a number is an index, anything else a name.
pub fn clip() -> impl TypedValueParser<Value = ClipChoice> {
    StringValueParser::new().map(|text| clip_choice(&text))
}

/// A clip by its number or name.
pub fn clip_choice(text: &str) -> ClipChoice {
    text.parse().map_or_else(|_| ClipChoice::Name(text.to_owned()), ClipChoice::Index)
}

/// How joints are blended.
pub fn skinning(text: &str) -> Result<Skinning, String> {
    match text {
        "linear" => Ok(Skinning::Linear),
        "dual-quaternion" => Ok(Skinning::DualQuaternion),
        _ => Err(format!("`{text}` is no way to blend joints; choose linear or dual-quaternion")),
    }
}

/// An environment: a file, or `none`.
pub fn environment() -> impl TypedValueParser<Value = EnvironmentChoice> {
    PathBufValueParser::new()
        .map(|path| if path.as_os_str() == "none" { EnvironmentChoice::Absent } else { EnvironmentChoice::File(path) })
}

/// A floor: a height in metres, or `none`.
pub fn floor(text: &str) -> Result<FloorLevel, String> {
    if text == "none" { Ok(FloorLevel::Absent) } else { number(text).map(FloorLevel::At) }
}

/// One word of `--camera`.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraWord {
    /// The model's own, by its name or that of its node; empty for the first.
    Model(String),
    /// World, metres.
    Eye(DVec3),
    /// World, metres.
    Target(DVec3),
    /// Full vertical angle, degrees.
    Fov(f64),
}

impl FromStr for CameraWord {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let expected = "expected eye=X,Y,Z, target=X,Y,Z, fov=DEG or model[=NAME] (INPUT goes before --camera)";
        if word == "model" {
            return Ok(Self::Model(String::new()));
        }
        match word.split_once('=').ok_or(expected)? {
            ("model", name) => Ok(Self::Model(name.to_owned())),
            ("eye", value) => vector(value).map(Self::Eye),
            ("target", value) => vector(value).map(Self::Target),
            ("fov", value) => match number(value)? {
                fov if fov > 0.0 && fov < 180.0 => Ok(Self::Fov(fov)),
                _ => Err("fov is between 0 and 180 degrees".into()),
            },
            _ => Err(expected.into()),
        }
    }
}

const LIGHT_KINDS: [(&str, ShotLightKind); 3] =
    [("spot", ShotLightKind::Spot), ("point", ShotLightKind::Point), ("directional", ShotLightKind::Directional)];

/// A kind of light by its name.
pub fn light_kind(text: &str) -> Result<ShotLightKind, String> {
    let kind = LIGHT_KINDS.iter().find(|(name, _)| *name == text).map(|(_, kind)| *kind);
    kind.ok_or_else(|| format!("`{text}` is no kind of light; choose spot, point or directional"))
}

/// The name of a kind of light.
pub fn light_name(kind: ShotLightKind) -> &'static str {
    LIGHT_KINDS.iter().find(|(_, other)| *other == kind).map_or("", |(name, _)| name)
}

/// One word of `--light`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightWord {
    /// The model's own lights.
    Model,
    /// Shape.
    Kind(ShotLightKind),
    /// World, metres.
    Position(DVec3),
    /// Where it shines to.
    Direction(DVec3),
    /// Candela, or lux for a directional light.
    Intensity(f64),
    /// Full angle of a spot's cone, degrees.
    Cone(f64),
}

impl FromStr for LightWord {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let expected = "expected spot, point, directional or model, pos=X,Y,Z, dir=X,Y,Z, intensity=I or cone=DEG \
                        (INPUT goes before --light)";
        if word == "model" {
            return Ok(Self::Model);
        }
        let Some((name, value)) = word.split_once('=') else {
            return light_kind(word).map(Self::Kind).map_err(|_| expected.into());
        };
        match name {
            "pos" => vector(value).map(Self::Position),
            "dir" => match vector(value)? {
                direction if direction.try_normalize().is_some() => Ok(Self::Direction(direction)),
                _ => Err("dir must not be zero".into()),
            },
            "intensity" => match number(value)? {
                intensity if intensity >= 0.0 => Ok(Self::Intensity(intensity)),
                _ => Err("intensity must not be negative".into()),
            },
            "cone" => match number(value)? {
                cone if cone > 0.0 && cone < 180.0 => Ok(Self::Cone(cone)),
                _ => Err("cone is between 0 and 180 degrees".into()),
            },
            _ => Err(expected.into()),
        }
    }
}

/// Frames, the last one excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// First.
    pub start: u32,
    /// One past the last; greater than `start`.
    pub end: u32,
}

impl FrameRange {
    /// How many.
    pub fn count(self) -> u32 {
        self.end - self.start
    }
}

impl FromStr for FrameRange {
    type Err = String;

    /// Reads `A..B` (B excluded), `A..=B` or a single frame.
    fn from_str(text: &str) -> Result<Self, String> {
        let frame = |text: &str| text.trim().parse::<u32>().map_err(|_| unreadable(text));
        let (start, end) = if let Some((start, last)) = text.split_once("..=") {
            (frame(start)?, frame(last)?.checked_add(1).ok_or_else(|| unreadable(last))?)
        } else if let Some((start, end)) = text.split_once("..") {
            (frame(start)?, frame(end)?)
        } else {
            (frame(text)?, frame(text)?.checked_add(1).ok_or_else(|| unreadable(text))?)
        };
        if start < end { Ok(Self { start, end }) } else { Err(format!("`{text}` holds no frame")) }
    }
}

fn unreadable(text: impl Display) -> String {
    format!("`{text}` is not a frame number; write A..B (B is not included), e.g. 0..48")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_ranges() {
        let range = |text: &str| text.parse::<FrameRange>().map(|range| (range.start, range.end)).ok();
        assert_eq!(range("0..48"), Some((0, 48)));
        assert_eq!(range("3..=5"), Some((3, 6)));
        assert_eq!(range("7"), Some((7, 8)));
        for wrong in ["", "..", "5..5", "6..5", "a..b", "-1..2", "0..4294967296", "4294967295"] {
            assert_eq!(range(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn methods() {
        let read = |text: &str| match text.parse() {
            Ok(MethodChoice::Refraction(choice)) => Some(choice.of(Refraction::default())),
            _ => None,
        };
        let usual = Refraction::default();
        let isr = Refraction { method: RefractionMethod::Isr, ..usual };
        assert_eq!(read("isr"), Some(isr));
        let view = Refraction { normal_distance: NormalDistance::View, back_surface: BackSurface::Nearest, ..isr };
        assert_eq!(read("isr:nearest:view"), Some(view));
        let printed = Refraction { method: RefractionMethod::Dir, steps: 12, uncorrected: true, ..usual };
        assert_eq!(read("dir:12:uncorrected"), Some(printed));
        for wrong in
            ["dir:0", "dir:view", "newton:uncorrected", "isr:deep", "dir:5:12", "splat:0", "splat:8:8", "magic", ""]
        {
            assert!(wrong.parse::<MethodChoice>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x5", "5x-1", "x", "99999x1", "4.5x4"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn camera_and_light_words() {
        assert_eq!("eye=1,2.5,-3".parse(), Ok(CameraWord::Eye(DVec3::new(1.0, 2.5, -3.0))));
        assert_eq!("fov=30".parse(), Ok(CameraWord::Fov(30.0)));
        for wrong in ["eye=1,2", "eye=1,2,nan", "fov=180", "fox.glb", "up=0,1,0"] {
            assert!(wrong.parse::<CameraWord>().is_err(), "{wrong}");
        }
        assert_eq!("cone=40".parse(), Ok(LightWord::Cone(40.0)));
        for wrong in ["sun", "dir=0,0,0", "intensity=-1", "cone=0", "color=1,1,1"] {
            assert!(wrong.parse::<LightWord>().is_err(), "{wrong}");
        }
    }
}
