//! The legal ranges of a shot's fields.

use glam::DVec3;

use super::{FloorLevel, Shot};

/// Largest picture side, pixels.
const MAX_SIDE: u32 = 16384;
/// The most rays through a pixel.
const MAX_SAMPLES: u32 = 1024;

impl Shot {
    /// The first field that is out of range, and what it must be.
    pub(super) fn check(&self) -> Result<(), (String, &'static str)> {
        let finite = "must be finite";
        let rules = [
            ("model", !self.model.as_os_str().is_empty(), "must name a file"),
            ("speed", self.speed.is_finite(), finite),
            ("hold", self.hold.is_none_or(f64::is_finite), finite),
            ("exposure", positive(self.exposure.into()), "must be positive and finite"),
            ("camera.eye", self.camera.eye.is_none_or(all_finite), finite),
            ("camera.target", self.camera.target.is_none_or(all_finite), finite),
            ("camera.fov", valid_fov(self.camera.fov), "must be between 0 and 180 degrees"),
            ("camera.azimuth", self.camera.azimuth.is_finite(), finite),
            ("camera.elevation", self.camera.elevation.abs() <= 90.0, "must be between -90 and 90 degrees"),
            ("camera.orbit", self.camera.orbit.is_finite(), finite),
            ("light.position", self.light.position.is_none_or(all_finite), finite),
            ("light.direction", self.light.direction.is_none_or(points_somewhere), "must be finite and not zero"),
            ("light.color", self.light.color.iter().all(|&c| not_negative(c)), "must be finite and not negative"),
            ("light.intensity", self.light.intensity.is_none_or(not_negative), "must be finite and not negative"),
            ("light.cone", self.light.cone.is_none_or(valid_fov), "must be between 0 and 180 degrees"),
            ("light.orbit", self.light.orbit.is_finite(), finite),
            ("glass.ior", self.glass.ior.is_none_or(|n| n >= 1.0 && n.is_finite()), "must be at least 1"),
            ("glass.attenuation_color", self.glass.attenuation_color.is_none_or(fractions), "must be between 0 and 1"),
            ("glass.attenuation_distance", self.glass.attenuation_distance.is_none_or(|d| d > 0.0), "must be positive"),
            ("glass.dispersion", self.glass.dispersion.is_none_or(not_negative), "must be finite and not negative"),
            (
                "glass.roughness",
                self.glass.roughness.is_none_or(|r| (0.0..=1.0).contains(&r)),
                "must be between 0 and 1",
            ),
            ("floor.level", !matches!(self.floor.level, FloorLevel::At(y) if !y.is_finite()), finite),
            ("floor.albedo", fractions(self.floor.albedo), "must be between 0 and 1"),
            ("output.size", self.output.size.iter().all(|side| (1..=MAX_SIDE).contains(side)), "must be 1 to 16384"),
            ("output.fps", positive(self.output.fps), "must be positive and finite"),
            ("output.frames", self.output.frames != Some(0), "must be at least 1"),
            ("output.samples", (1..=MAX_SAMPLES).contains(&self.output.samples), "must be 1 to 1024"),
        ];
        match rules.iter().find(|(_, holds, _)| !holds) {
            Some(&(field, _, problem)) => Err((field.to_owned(), problem)),
            None => self.check_layers().and_then(|()| self.check_keys()),
        }
    }

    fn check_layers(&self) -> Result<(), (String, &'static str)> {
        for (index, layer) in self.layers.iter().enumerate() {
            let field = |name: &str| format!("layers[{index}].{name}");
            for (name, value) in [("speed", layer.speed), ("weight", layer.weight), ("from", layer.from)] {
                if !value.is_finite() {
                    return Err((field(name), "must be finite"));
                }
            }
            if !(layer.fade >= 0.0 && layer.fade.is_finite()) {
                return Err((field("fade"), "must be finite and not negative"));
            }
            if layer.until.is_some_and(|until| until.is_nan() || until <= layer.from) {
                return Err((field("until"), "must be later than `from`"));
            }
        }
        Ok(())
    }

    fn check_keys(&self) -> Result<(), (String, &'static str)> {
        let mut previous = f64::NEG_INFINITY;
        for (index, key) in self.camera.keys.iter().enumerate() {
            let field = |name: &str| format!("camera.keys[{index}].{name}");
            if !(key.time.is_finite() && key.time > previous) {
                return Err((field("time"), "must be finite and later than the key before"));
            }
            if !all_finite(key.eye) || !all_finite(key.target) {
                return Err((field("eye"), "and `target` must be finite"));
            }
            if !key.fov.is_none_or(valid_fov) {
                return Err((field("fov"), "must be between 0 and 180 degrees"));
            }
            previous = key.time;
        }
        Ok(())
    }
}

fn all_finite(vector: [f64; 3]) -> bool {
    vector.iter().all(|value| value.is_finite())
}

fn points_somewhere(vector: [f64; 3]) -> bool {
    DVec3::from_array(vector).try_normalize().is_some()
}

fn valid_fov(degrees: f64) -> bool {
    degrees > 0.0 && degrees < 180.0
}

fn positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn not_negative(value: f32) -> bool {
    value >= 0.0 && value.is_finite()
}

fn fractions(color: [f32; 3]) -> bool {
    color.iter().all(|value| (0.0..=1.0).contains(value))
}
