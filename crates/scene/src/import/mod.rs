//! glTF 2.0 import.
//!
//! Files are not trusted: every index, count, offset, stride and number is checked before it is used, the hierarchy is
//! walked without recursion, and memory is bounded by what the file holds. What is wrong is an [`ImportError`]; what is
//! merely odd is a warning in the [`ImportReport`].

mod accessors;
mod animations;
mod compression;
mod container;
mod document;
mod error;
mod extensions;
mod images;
mod instances;
mod materials;
mod meshes;
mod nodes;
mod normals;
mod pointers;
mod punctual;
mod references;
mod topology;
mod variants;

use std::path::{Path, PathBuf};

pub use error::{ImportError, ImportProblem};

use self::accessors::Accessors;
use self::container::{Buffers, Container, read_file};
use self::document::Document;
use self::images::Images;
use crate::{Scene, Skinning};

/// What an import had to say besides the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImportReport {
    /// `extensionsUsed` of the file.
    pub extensions_used: Vec<String>,
    /// `extensionsRequired` of the file.
    pub extensions_required: Vec<String>,
    /// Those used that have no effect here.
    pub extensions_ignored: Vec<String>,
    /// What was dropped or repaired, and where.
    pub warnings: Vec<String>,
}

/// Imports a `.glb` or `.gltf` with all it refers to.
///
/// # Errors
/// [`ImportError`] names the file, the element in it and what to do: a missing file, a damaged container, a bad index,
/// a cycle, a NaN, an unsupported required extension each have a variant of [`ImportProblem`].
pub fn import(path: &Path) -> Result<Scene, ImportError> {
    let directory = path.parent().unwrap_or(Path::new(""));
    read_file(path, "the model itself")
        .and_then(|bytes| import_model(&bytes, Some(directory)))
        .map_err(|problem| ImportError { file: path.to_owned(), problem })
}

/// Imports a `.glb` or `.gltf` from memory; `name` stands for it in errors. What it refers to are data URIs, as there
/// is no folder to find files in.
///
/// # Errors
/// As [`import`]; a reference to a file is an [`ImportProblem::Uri`].
pub fn import_bytes(bytes: &[u8], name: &str) -> Result<Scene, ImportError> {
    import_model(bytes, None).map_err(|problem| ImportError { file: PathBuf::from(name), problem })
}

/// Imports a model; the files that it refers to are in `directory`.
fn import_model(bytes: &[u8], directory: Option<&Path>) -> Result<Scene, ImportProblem> {
    let container = Container::split(bytes)?;
    let document = Document::parse(container.json)?;
    let mut report = extensions::check(&document)?;
    references::check(&document)?;
    let warnings = &mut report.warnings;
    let buffers = Buffers::load(&document, &container, directory)?;
    let accessors = Accessors::new(&document, &buffers);

    let meshes = meshes::import(&document, &accessors, warnings)?;
    let skins = nodes::import_skins(&document, &accessors, warnings)?;
    let mut nodes = nodes::import(&document, &accessors, &meshes, &skins, warnings)?;
    let roots = nodes::roots(&document, &nodes, warnings)?;
    instances::expand(&document, &accessors, &mut nodes, warnings)?;
    let clips = animations::import(&document, &accessors, &mut nodes, warnings)?;
    let mut images = Images::new(&document, &accessors, directory);
    let materials = materials::import(&document, &mut images, warnings)?;
    let images = images.into_decoded();
    Ok(Scene {
        nodes,
        roots,
        meshes,
        skins,
        materials,
        images,
        clips,
        skinning: Skinning::Linear,
        cameras: punctual::import_cameras(&document)?,
        lights: punctual::import_lights(&document)?,
        variants: document.variants.into_iter().map(|variant| variant.name).collect(),
        report,
    })
}
