//! The camera of a shot and its path.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Where the camera is and looks, metres, and its vertical field of view, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Position.
    pub eye: DVec3,
    /// Point looked at.
    pub target: DVec3,
    /// Full vertical angle, degrees.
    pub fov: f64,
}

/// The camera of a shot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotCamera {
    /// The model's own camera, by its name or that of its node (empty for the first), with whatever its clip makes of it;
    /// everything else here is then without effect.
    pub model: Option<String>,
    /// Position, metres; `None` frames the model from `azimuth` and `elevation`.
    pub eye: Option<[f64; 3]>,
    /// Point looked at, metres; `None` is the model's centre.
    pub target: Option<[f64; 3]>,
    /// Full vertical angle, degrees.
    pub fov: f64,
    /// Side from which a framed model is seen, degrees about +Y from +Z towards +X.
    pub azimuth: f64,
    /// Height from which a framed model is seen, degrees above the horizon.
    pub elevation: f64,
    /// Turn about +Y through the target, degrees per second, counter-clockwise seen from above.
    pub orbit: f64,
    /// A path; replaces `eye`, `target` and `fov` where given.
    pub keys: Vec<CameraKey>,
}

impl Default for ShotCamera {
    fn default() -> Self {
        Self {
            model: None,
            eye: None,
            target: None,
            fov: 40.0,
            azimuth: 25.0,
            elevation: 15.0,
            orbit: 0.0,
            keys: Vec::new(),
        }
    }
}

/// One key of a camera path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds.
    pub time: f64,
    /// Position, metres.
    pub eye: [f64; 3],
    /// Point looked at, metres.
    pub target: [f64; 3],
    /// Full vertical angle, degrees; `None` is the camera's.
    #[serde(default)]
    pub fov: Option<f64>,
}

impl ShotCamera {
    /// The camera at a time in seconds. `framed` is the stage's choice, which the shot overrides as far as it says.
    pub fn at(&self, time: f64, framed: Aim) -> Aim {
        let placed = Aim {
            eye: self.eye.map_or(framed.eye, DVec3::from_array),
            target: self.target.map_or(framed.target, DVec3::from_array),
            fov: self.fov,
        };
        let aim = self.on_path(time).unwrap_or(placed);
        Aim { eye: turned(aim.eye, aim.target, self.orbit * time), ..aim }
    }

    /// The keyed path: Catmull-Rom through the keys with their times, held before the first and after the last.
    fn on_path(&self, time: f64) -> Option<Aim> {
        let keys = &self.keys;
        let aim = |key: &CameraKey| Aim {
            eye: DVec3::from_array(key.eye),
            target: DVec3::from_array(key.target),
            fov: key.fov.unwrap_or(self.fov),
        };
        let (first, last) = (keys.first()?, keys.last()?);
        let next = keys.partition_point(|key| key.time <= time);
        if next == 0 {
            return Some(aim(first));
        }
        if next == keys.len() {
            return Some(aim(last));
        }
        let (from, to) = (&keys[next - 1], &keys[next]);
        let (before, after) = (&keys[next.saturating_sub(2)], &keys[(next + 1).min(keys.len() - 1)]);
        let span = to.time - from.time;
        let s = (time - from.time) / span;
        let curve = |value: &dyn Fn(&CameraKey) -> DVec3| {
            let slope = |a: &CameraKey, b: &CameraKey| (value(b) - value(a)) / (b.time - a.time);
            let (m0, m1) = (slope(before, to) * span, slope(from, after) * span);
            let (s2, s3) = (s * s, s * s * s);
            value(from) * (2.0 * s3 - 3.0 * s2 + 1.0)
                + m0 * (s3 - 2.0 * s2 + s)
                + value(to) * (3.0 * s2 - 2.0 * s3)
                + m1 * (s3 - s2)
        };
        let (start, end) = (aim(from), aim(to));
        Some(Aim {
            eye: curve(&|key| aim(key).eye),
            target: curve(&|key| aim(key).target),
            fov: start.fov + (end.fov - start.fov) * s,
        })
    }
}

/// Turns a point about the vertical through a centre, degrees counter-clockwise seen from above.
pub(super) fn turned(point: DVec3, center: DVec3, degrees: f64) -> DVec3 {
    center + DQuat::from_rotation_y(degrees.to_radians()) * (point - center)
}
