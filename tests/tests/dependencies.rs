//! The rules of ARCHITECTURE.md about which crate may know which, held against `cargo metadata`.

use std::{
    collections::{BTreeMap, BTreeSet},
    env, fs,
    path::Path,
    process::Command,
};

/// Each crate and the crates of the project that it may depend on.
const MAY_KNOW: [(&str, &[&str]); 12] = [
    ("optics", &[]),
    ("scheduler", &[]),
    ("metrics", &[]),
    ("gpu", &["scheduler"]),
    ("scene", &["optics"]),
    ("animation", &["optics", "scheduler", "gpu", "scene"]),
    ("reference", &["optics", "scene", "animation"]),
    ("refraction", &["optics", "scheduler", "gpu", "scene", "animation"]),
    ("caustics", &["optics", "scheduler", "gpu", "scene", "animation", "refraction"]),
    ("render", &["optics", "scheduler", "gpu", "scene", "animation", "refraction", "caustics"]),
    ("viewer", &["optics", "scheduler", "gpu", "scene", "animation", "refraction", "caustics", "render"]),
    (
        "cli",
        &[
            "optics",
            "scheduler",
            "gpu",
            "scene",
            "animation",
            "refraction",
            "caustics",
            "render",
            "viewer",
            "reference",
            "metrics",
        ],
    ),
];

/// Crates of which two versions would mean types that do not fit each other.
const ONE_VERSION: [&str; 3] = ["wgpu", "naga", "glam"];

/// `a -> b` for every dependency between the project's crates that the rules do not allow.
fn forbidden(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let rules = BTreeMap::from(MAY_KNOW);
    let mut found = Vec::new();
    for (package, dependencies) in edges {
        match rules.get(package.as_str()) {
            Some(allowed) => found.extend(
                dependencies
                    .iter()
                    .filter(|dependency| !allowed.contains(&dependency.as_str()))
                    .map(|dependency| format!("{package} -> {dependency}")),
            ),
            None => found.push(format!("{package} (no rule says what it may know)")),
        }
    }
    found
}

/// The project's crates, without the prefix of their names, and what each depends on in any section.
fn edges() -> BTreeMap<String, BTreeSet<String>> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let name = |value: &serde_json::Value| {
        value["name"].as_str().and_then(|name| name.strip_prefix("murano-")).map(str::to_owned)
    };
    let packages = metadata["packages"].as_array().expect("there are packages");
    let library = packages.iter().filter_map(|package| Some((name(package)?, package)));
    library
        .filter(|(package, _)| package != "tests")
        .map(|(package, value)| {
            let dependencies = value["dependencies"].as_array().expect("a list of dependencies");
            (package, dependencies.iter().filter_map(name).collect())
        })
        .collect()
}

#[test]
fn dependencies_point_one_way() {
    let edges = edges();
    assert!(edges.len() >= 9, "{edges:?}");
    assert_eq!(forbidden(&edges), Vec::<String>::new());
}

/// The test itself would notice.
#[test]
fn a_forbidden_edge_is_found() {
    let edge = |from: &str, to: &str| BTreeMap::from([(from.to_owned(), BTreeSet::from([to.to_owned()]))]);
    assert_eq!(forbidden(&edge("gpu", "scene")), ["gpu -> scene"]);
    assert_eq!(forbidden(&edge("refraction", "caustics")), ["refraction -> caustics"]);
    assert_eq!(forbidden(&edge("nonsense", "optics")).len(), 1);
    assert!(forbidden(&edge("caustics", "refraction")).is_empty());
}

#[test]
fn there_is_one_version_of_what_crates_share() {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.lock");
    let lock = fs::read_to_string(lock).expect("Cargo.lock is committed");
    for shared in ONE_VERSION {
        let count = lock.lines().filter(|line| *line == format!("name = \"{shared}\"")).count();
        assert_eq!(count, 1, "{shared}: `cargo tree --invert {shared}` says who wants which");
    }
}
