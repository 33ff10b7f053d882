//! The room a body takes up over a clip.

use glam::DVec3;
use murano_animation::{Bounds, Geometry, GeometryError, Layer, Pose, deform_f64, shown_primitives};
use murano_scene::Scene;

/// What everything that a scene shows sweeps over a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Middle of the box around all vertices at all times, world, metres.
    pub center: DVec3,
    /// Farthest that a vertex ever is from `center`, metres; greater than zero.
    pub radius: f64,
    /// Lowest y of a vertex at any time, metres.
    pub lowest: f64,
}

impl Extent {
    /// Deforms the scene in f64 at several moments and measures the vertices. A scene that shows nothing, or a single point,
    /// gets the radius 1.
    ///
    /// # Errors
    /// [`GeometryError`] when the scene has more vertices than can be indexed.
    pub fn measure(scene: &Scene, moments: &[Vec<Layer>]) -> Result<Self, GeometryError> {
        let geometry = Geometry::build(scene, &shown_primitives(scene))?;
        let vertices = |playing: &Vec<Layer>| deform_f64(&geometry, scene, &Pose::sample(scene, playing)).positions;
        let swept: Vec<DVec3> = moments.iter().flat_map(vertices).filter(|vertex| vertex.is_finite()).collect();
        let bounds = Bounds::of(swept.iter().copied());
        let center = bounds.center();
        let radius = swept.iter().map(|vertex| vertex.distance(center)).fold(0.0, f64::max);
        Ok(Self {
            center,
            radius: if radius > 0.0 && radius.is_finite() { radius } else { 1.0 },
            lowest: if bounds.is_empty() { 0.0 } else { bounds.min.y },
        })
    }

    /// Diameter of the ball around the body, metres.
    pub fn diameter(&self) -> f64 {
        2.0 * self.radius
    }
}
