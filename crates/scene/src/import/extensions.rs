//! Which extensions are understood, and what to tell about those that are not.

use super::ImportReport;
use super::document::Document;
use super::error::ImportProblem;

/// Extensions whose content is imported.
const SUPPORTED: [&str; 13] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

/// Mesh compression by Draco, which may stand beside uncompressed accessors.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Refuses a version or a required extension that is not understood; else lists what is used and what is ignored.
pub(super) fn check(document: &Document) -> Result<ImportReport, ImportProblem> {
    check_version(document)?;
    if let Some(name) = document.extensions_required.iter().find(|name| !is_supported(name)) {
        return Err(unsupported(name));
    }
    Ok(ImportReport {
        extensions_used: document.extensions_used.clone(),
        extensions_required: document.extensions_required.clone(),
        extensions_ignored: document.extensions_used.iter().filter(|name| !is_supported(name)).cloned().collect(),
        warnings: Vec::new(),
    })
}

/// The error for an extension without which the file means nothing.
pub(super) fn unsupported(name: &str) -> ImportProblem {
    ImportProblem::UnsupportedExtension { name: name.to_owned(), remedy: remedy(name) }
}

fn is_supported(name: &str) -> bool {
    SUPPORTED.contains(&name)
}

fn remedy(name: &str) -> &'static str {
    match name {
        DRACO => "decompress it with `gltf-transform copy in.glb out.glb`",
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => {
            "convert its textures with `gltf-transform png in.glb out.glb`"
        }
        _ => "export it without the extension, or make it optional by removing it from `extensionsRequired`",
    }
}

/// A reader of 2.0 reads every 2.x file whose `minVersion` allows it (glTF 2.0, section 3.2).
fn check_version(document: &Document) -> Result<(), ImportProblem> {
    let asset = &document.asset;
    let readable = match &asset.min_version {
        Some(minimum) => minimum == "2.0",
        None => asset.version.starts_with("2."),
    };
    if readable {
        return Ok(());
    }
    Err(ImportProblem::Version { version: asset.min_version.as_ref().unwrap_or(&asset.version).clone() })
}
