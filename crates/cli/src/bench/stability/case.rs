//! A case: one picture that could go wrong, and the group whose worst it may be.

use glam::DVec3;
use murano_animation::Layer;
use murano_refraction::Method;
use murano_render::View;
use murano_scene::{PlacedLight, Projection, Scene, look_along};
use serde::Serialize;

/// Side of most pictures, pixels.
pub const SIDE: u32 = 96;

/// What is known of the right answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// The two-interface path through the same triangles, traced in f64. A ray that first meets the body from behind
    /// begins inside it.
    Closed,
    /// As [`Truth::Closed`], but the body is open or turned inside out: a ray that first meets it from behind has no
    /// answer, and must be flagged where there is no front behind.
    Open,
    /// A sheet without thickness, or glass with thin walls: light goes on as it came.
    Sheet,
    /// Nothing but that all numbers must be finite.
    Unknown,
}

/// One picture, for every method.
pub struct Case {
    pub label: String,
    pub scene: Scene,
    /// A clip of the scene and the time in it, seconds.
    pub clip: Option<(usize, f64)>,
    pub view: View,
    pub size: [u32; 2],
    pub truth: Truth,
    /// Lamps over a floor, for one more picture with shadows and caustics.
    pub lamps: Vec<PlacedLight>,
}

impl Case {
    /// A square picture without lamps.
    pub fn new(label: impl Into<String>, scene: Scene, view: View, truth: Truth) -> Self {
        Self { label: label.into(), scene, clip: None, view, size: [SIDE, SIDE], truth, lamps: Vec::new() }
    }

    /// What plays.
    pub fn playing(&self) -> Vec<Layer> {
        self.clip.map(|(clip, time)| Layer::new(clip, time)).into_iter().collect()
    }

    /// With lamps over a floor.
    pub fn lit(mut self, lamps: Vec<PlacedLight>) -> Self {
        self.lamps = lamps;
        self
    }

    /// A picture of another size.
    pub fn sized(mut self, size: [u32; 2]) -> Self {
        self.size = size;
        self
    }

    /// At a time of the scene's first clip, seconds.
    pub fn at_time(mut self, time: f64) -> Self {
        self.clip = Some((0, time));
        self
    }
}

/// How far a method may be off. Shares are of the pixels inside the true silhouette, 0 to 1.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Limits {
    /// Mean angle between exit directions over pixels that left in truth and in the picture, degrees.
    pub mean_degrees: f64,
    /// Share of pixels of another status than in truth that do not say so (status 3).
    pub wrong: f64,
    /// Share of pixels that are flagged (status 3) where the truth is not.
    pub flagged: f64,
}

impl Limits {
    /// Nothing is bounded, because nothing is known.
    pub const NONE: Self = Self { mean_degrees: 180.0, wrong: 1.0, flagged: 1.0 };
    /// The first interface is exact: what is left is the rounding of f32, and pixels that it decides.
    const FIRST_INTERFACE: Self = Self { mean_degrees: 1e-3, wrong: 1e-3, flagged: 1e-3 };

    /// Every interface is: what is left of an exact search is the same, passed on by the second interface. A hundredfold,
    /// where the picture is the outermost ten-thousandth of a ball.
    const EXACT: Self = Self { mean_degrees: 2e-3, wrong: 1e-3, flagged: 1e-3 };

    fn of([mean_degrees, wrong, flagged]: [f64; 3]) -> Self {
        Self { mean_degrees, wrong, flagged }
    }
}

/// The limits of every method.
#[derive(Clone, Copy, Debug)]
pub struct MethodLimits {
    pub sir: Limits,
    pub dir: Limits,
    pub newton: Limits,
}

impl MethodLimits {
    /// Mean degrees, share wrong and share flagged of the methods that search a second interface.
    pub fn new(dir: [f64; 3], newton: [f64; 3]) -> Self {
        Self { sir: Limits::FIRST_INTERFACE, dir: Limits::of(dir), newton: Limits::of(newton) }
    }

    /// Those of one method.
    pub fn of(&self, method: Method) -> Limits {
        match method {
            Method::Sir => self.sir,
            // Guesses have no bounds on their angles; but they must be numbers.
            Method::Screen | Method::Isr => Limits::NONE,
            Method::Dir => self.dir,
            Method::Newton | Method::Walk | Method::Layers => self.newton,
            Method::Exact => Limits::EXACT,
        }
    }
}

/// Cases that are one line a method in the table.
pub struct Group {
    pub name: &'static str,
    pub limits: MethodLimits,
    pub cases: Vec<Case>,
}

/// A perspective view with the usual near plane; `yfov` in degrees.
pub fn looking(eye: DVec3, target: DVec3, yfov: f64) -> View {
    View::look_at(eye, target, yfov.to_radians())
}

/// A view with a near plane of its own, metres.
pub fn looking_past(eye: DVec3, target: DVec3, yfov: f64, near: f64) -> View {
    View { near, ..looking(eye, target, yfov) }
}

/// A parallel view; heights in metres.
pub fn parallel(eye: DVec3, target: DVec3, half_height: f64) -> View {
    View {
        world_from_view: look_along(eye, target - eye),
        projection: Projection::Orthographic { half_height },
        near: 1e-3 * eye.distance(target),
    }
}
