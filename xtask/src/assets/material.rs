//! Glass, as the glTF extensions say it.

use serde_json::json;

use super::glb::Document;

/// A clear or tinted glass.
#[derive(Clone, Copy, Debug)]
pub struct Glass {
    /// Material name.
    pub name: &'static str,
    /// Index of refraction.
    pub ior: f64,
    /// How thick the body is, typically, metres (for renderers that do not trace it).
    pub thickness: f64,
    /// Linear RGB left of white light after `attenuation_distance` metres, and that distance; `None` for clear glass.
    pub attenuation: Option<([f64; 3], f64)>,
}

impl Glass {
    /// Adds the material to `document` and returns its index.
    pub fn add_to(self, document: &mut Document) -> usize {
        for extension in ["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_volume"] {
            document.use_extension(extension);
        }
        let mut volume = json!({ "thicknessFactor": self.thickness });
        if let Some((color, distance)) = self.attenuation {
            volume["attenuationColor"] = json!(color);
            volume["attenuationDistance"] = json!(distance);
        }
        document.push(
            "materials",
            json!({
                "name": self.name,
                "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
                "extensions": {
                    "KHR_materials_transmission": { "transmissionFactor": 1.0 },
                    "KHR_materials_ior": { "ior": self.ior },
                    "KHR_materials_volume": volume,
                },
            }),
        )
    }
}
