//! The room a body takes up over a clip.

use glam::DVec3;
use murano_animation::{Bounds, Geometry, GeometryError, Pose, deform_f64, shown_primitives};
use murano_scene::Scene;

/// How often a clip is looked at to find what it sweeps.
const SAMPLES: usize = 16;

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
    /// Deforms the scene in f64 at several times of the clip and measures the vertices. A scene that shows nothing, or a
    /// single point, gets the radius 1.
    ///
    /// `held` is the only time looked at, seconds, where the pose does not change.
    ///
    /// # Errors
    /// [`GeometryError`] when the scene has more vertices than can be indexed.
    pub fn measure(scene: &Scene, clip: Option<usize>, held: Option<f64>) -> Result<Self, GeometryError> {
        let geometry = Geometry::build(scene, &shown_primitives(scene))?;
        let duration = clip.and_then(|clip| scene.clips.get(clip)).map_or(0.0, |clip| clip.duration);
        let times: Vec<f64> = match held {
            Some(time) => vec![time],
            None if duration > 0.0 => (0..SAMPLES).map(|k| duration * k as f64 / SAMPLES as f64).collect(),
            None => vec![0.0],
        };
        let vertices = |&time: &f64| deform_f64(&geometry, scene, &Pose::sample(scene, clip, time)).positions;
        let swept: Vec<DVec3> = times.iter().flat_map(vertices).filter(|vertex| vertex.is_finite()).collect();
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
