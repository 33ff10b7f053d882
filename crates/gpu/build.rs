//! Embeds every file under `shaders/` so that a built binary stands alone.

use std::{
    env,
    fmt::Write as _,
    fs::{self, DirEntry},
    path::Path,
};

fn collect(folder: &Path, module: &str, table: &mut String) {
    let mut entries: Vec<_> = fs::read_dir(folder).expect("shaders/ is part of the repository").flatten().collect();
    entries.sort_by_key(DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let name = entry.file_name().into_string().expect("shader file names are ASCII");
        if path.is_dir() {
            collect(&path, &format!("{module}{name}::"), table);
        } else if let Some(stem) = name.strip_suffix(".wesl") {
            let (module, file) = (format!("{module}{stem}"), path.to_str().expect("the repository's path is UTF-8"));
            writeln!(table, "    ({module:?}, include_str!({file:?})),").expect("a String grows");
        }
    }
}

fn main() {
    let root = Path::new(&env::var("CARGO_MANIFEST_DIR").expect("set by cargo")).join("../../shaders");
    println!("cargo::rerun-if-changed={}", root.display());
    let mut table = String::from("[\n");
    collect(&root, "", &mut table);
    table.push_str("]\n");
    let out = Path::new(&env::var("OUT_DIR").expect("set by cargo")).join("shaders.rs");
    fs::write(out, table).expect("OUT_DIR is writable");
}
