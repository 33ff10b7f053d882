//! `murano pose`, `inspect`, `adapters`, `completions` and the help.

mod common;

use std::fs;

use common::{asset, folder, json_lines, succeeds};

/// Largest distance from the f64 path over the body's diameter that the GPU may have.
const TOLERANCE: f64 = 1e-5;

#[test]
fn the_gpu_deforms_like_the_f64_path() {
    let (_guard, folder) = folder();
    for model in ["dancer.glb", "octopus.glb", "swan.glb", "sphere.glb"] {
        for time in ["0", "0.37", "1.9"] {
            let (stdout, _) = succeeds(&folder, &["pose", &asset(model), "--time", time, "--json"]);
            let report = &json_lines(&stdout)[0];
            let difference = report["max_difference_over_diameter"].as_f64().unwrap();
            assert!(difference <= TOLERANCE, "{model} at {time}: {report}");
            assert!(report["vertices"].as_u64().unwrap() > 0 && report["adapter"].is_string(), "{report}");
        }
    }
}

#[test]
fn a_pose_is_written_as_ply() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let (stdout, _) = succeeds(&folder, &["pose", &dancer, "--time", "0.5", "-o", "out/gpu.ply"]);
    assert!(stdout.contains("vertices") && stdout.contains("of the body's diameter"), "{stdout}");
    succeeds(&folder, &["pose", &dancer, "--time", "0.5", "-o", "out/cpu.ply", "--cpu"]);
    let [gpu, cpu] = ["gpu", "cpu"].map(|name| fs::read(folder.join("out").join(format!("{name}.ply"))).unwrap());
    assert!(gpu.starts_with(b"ply\n") && gpu.len() == cpu.len());
    assert_ne!(gpu, cpu, "f32 and f64 give the same bits: one of them was not used");
    succeeds(&folder, &["pose", &dancer, "--time", "0", "-o", "out/other.ply", "--cpu"]);
    assert_ne!(cpu, fs::read(folder.join("out/other.ply")).unwrap(), "the pose does not move");
}

#[test]
fn inspect_lists_what_there_is() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let (stdout, _) = succeeds(&folder, &["inspect", &dancer, "--json"]);
    let report = &json_lines(&stdout)[0];
    assert!(!report["nodes"].as_array().unwrap().is_empty());
    assert!(report["meshes"][0]["triangles"].as_u64().unwrap() > 1000);
    assert!(report["skins"][0]["joints"].as_u64().unwrap() > 1);
    assert!(report["clips"][0]["duration"].as_f64().unwrap() > 0.0);
    assert!(report["materials"].as_array().unwrap().iter().any(|material| material["glass"] == true));
    assert!(report["extensions_used"].as_array().unwrap().iter().any(|name| name == "KHR_materials_transmission"));
    assert!(report["extensions_ignored"].is_array() && report["warnings"].is_array());

    let (text, _) = succeeds(&folder, &["inspect", &dancer]);
    for section in ["Nodes", "Meshes", "Skins", "Clips", "Materials", "glass, n ="] {
        assert!(text.contains(section), "{section} in\n{text}");
    }
}

#[test]
fn adapters_says_which_is_used() {
    let (_guard, folder) = folder();
    let (stdout, _) = succeeds(&folder, &["adapters", "--json"]);
    let report = &json_lines(&stdout)[0];
    let used: Vec<_> =
        report["adapters"].as_array().unwrap().iter().filter(|adapter| adapter["used"] == true).collect();
    assert_eq!(used.len(), 1);
    assert!(!used[0]["name"].as_str().unwrap().is_empty());
    let (text, _) = succeeds(&folder, &["adapters"]);
    assert!(text.contains(used[0]["name"].as_str().unwrap()) && text.contains("lacks"));
}

#[test]
fn help_shows_examples() {
    let (_guard, folder) = folder();
    for command in ["export", "pose", "inspect", "adapters", "completions"] {
        let (text, _) = succeeds(&folder, &[command, "--help"]);
        assert!(text.contains("Example") && text.contains(&format!("murano {command}")), "{text}");
    }
    let (text, _) = succeeds(&folder, &["export", "--help"]);
    for name in ["sir", "dir", "newton", "splat", "reflect", "exit_direction"] {
        assert!(text.contains(name), "{name} in\n{text}");
    }
}

#[test]
fn completions_know_the_commands() {
    let (_guard, folder) = folder();
    for shell in ["bash", "zsh", "fish"] {
        let (script, _) = succeeds(&folder, &["completions", shell]);
        assert!(script.contains("export") && script.contains("inspect"), "{shell}");
    }
}
