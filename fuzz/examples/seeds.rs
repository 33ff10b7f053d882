//! Writes the models that fuzzing begins with into a folder: the smaller of `assets/`, and those that the import's
//! tests begin with, also with only a NUL between their JSON and their binary chunk.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

use common::Model;

#[path = "../../crates/scene/tests/common/mod.rs"]
mod common;

/// Longest seed, bytes; larger ones would be cut.
const MAX_LENGTH: u64 = 65536;

fn main() -> io::Result<()> {
    let folder = env::args().nth(1).map_or_else(|| PathBuf::from("fuzz/corpus/import"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    for (name, model) in [("triangle", Model::triangle()), ("rich", Model::rich())] {
        fs::write(folder.join(format!("{name}.gltf")), model.gltf())?;
        fs::write(folder.join(format!("{name}.glb")), model.glb())?;
        let mut json = model.json;
        json["buffers"] = serde_json::json!([{ "byteLength": model.bytes.len() }]);
        fs::write(folder.join(name), [json.to_string().as_bytes(), &[0], &model.bytes].concat())?;
    }
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "glb") && path.metadata()?.len() <= MAX_LENGTH {
            fs::copy(&path, folder.join(path.file_name().unwrap_or_default()))?;
        }
    }
    Ok(())
}
