//! `murano compare`: what is measured, how it is said, and what the exit status means.

mod common;

use common::{asset, folder, json_lines, murano, names, refuses, succeeds};
use serde_json::Value;

const SMALL: [&str; 6] = ["--size", "96x96", "--runs", "1", "--ior", "1.5"];

fn compare(folder: &std::path::Path, arguments: &[&str]) -> Value {
    let (stdout, _) = succeeds(folder, &[&["compare"], arguments, &SMALL, &["--json"]].concat());
    json_lines(&stdout).remove(0)
}

fn number(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or_else(|| panic!("`{name}` is no number in {row:#}"))
}

#[test]
fn methods_stand_in_the_order_of_their_errors() {
    let (_guard, folder) = folder();
    let comparison = compare(&folder, &[&asset("sphere.glb"), "--methods", "sir,dir:5,newton:5"]);
    assert!((number(&comparison, "ior") - 1.5).abs() < 1e-9);
    assert!(comparison["input"].as_str().unwrap().ends_with("sphere.glb"));
    assert!(!comparison["adapter"].as_str().unwrap().is_empty());
    let rows = comparison["rows"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["method"].as_str().unwrap()).collect::<Vec<_>>(), ["sir", "dir", "newton"]);
    let column = |name: &str| rows.iter().map(|row| number(row, name)).collect::<Vec<f64>>();
    for name in ["mean_deg", "p50_deg", "p95_deg", "flip", "rmse", "p2_mean"] {
        let values = column(name);
        assert!(values[0] > values[1] && values[1] > values[2], "{name}: {values:?}");
    }
    // A single interface of n = 1.5 is off by about 19 degrees (a half of the ball's deviation, over its disc); the map of
    // 96 x 96 texels bounds the others.
    let mean = column("mean_deg");
    assert!((15.0..25.0).contains(&mean[0]) && mean[1] < 1.5 && mean[2] < 0.05, "{mean:?}");
    let ssim = column("ssim");
    assert!(ssim[0] < ssim[1] && ssim[1] < ssim[2] && ssim[2] <= 1.0, "{ssim:?}");
    // One interface is no search; five steps read five texels, and the last one again.
    let entries = column("entries");
    assert!(entries[0] == 0.0 && (5.0..10.0).contains(&entries[1]) && entries[2] < 20.0, "{entries:?}");
    for row in rows {
        for name in ["wrong_status", "invalid"] {
            assert!((0.0..=1.0).contains(&number(row, name)), "{row:#}");
        }
        assert!(number(row, "frame_ms") > 0.0 && row["steps"].is_u64(), "{row:#}");
    }
}

#[test]
fn the_threshold_decides_the_exit_status() {
    let (_guard, folder) = folder();
    let sphere = asset("sphere.glb");
    let run = |method: &str, threshold: &str| {
        let arguments = [&["compare", &sphere, "--methods", method, "--threshold", threshold], &SMALL[..]].concat();
        murano(&folder, &arguments)
    };
    assert_eq!(run("newton", "0.5").status.code(), Some(0));
    let over = run("sir", "0.5");
    assert_eq!(over.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&over.stderr).into_owned();
    assert!(stderr.contains("sir") && stderr.contains("threshold"), "{stderr}");
    assert!(String::from_utf8_lossy(&over.stdout).contains("mean"), "the table is shown all the same");
}

#[test]
fn what_each_idea_is_worth() {
    let (_guard, folder) = folder();
    let methods = "screen,sir,isr:zero,isr:view,isr:baked,dir:5:uncorrected,dir:5,newton:5,layers,exact";
    let told = compare(&folder, &[&asset("bumpy.glb"), "--methods", methods]);
    let rows = told["rows"].as_array().unwrap();
    let mean = |name: &str, word: &str| {
        let is = |row: &&Value| {
            let words = row["variant"].as_array();
            row["method"] == name && words.map_or(word.is_empty(), |words| words.iter().any(|given| given == word))
        };
        number(rows.iter().find(is).unwrap_or_else(|| panic!("{name} {word}: {told}")), "mean_deg")
    };
    // Each knows more than the one before it: one interface, the way along the view, that along the normal as well, the surface
    // itself, its tangent planes, its triangles.
    let known = [
        mean("screen", ""),
        mean("sir", ""),
        mean("isr", "view"),
        mean("isr", "baked"),
        mean("dir", ""),
        mean("newton", ""),
        mean("layers", ""),
    ];
    assert!(known.is_sorted_by(|a, b| a > b), "{known:?}");
    assert!(mean("isr", "zero") > mean("isr", "baked"), "half of the guess left out: {told}");
    assert!(mean("dir", "uncorrected") != mean("dir", ""), "{told}");
    assert!(mean("exact", "") < 1e-3, "{told}");
}

/// Through total reflection and what enters the body again, against a truth that follows both.
#[test]
fn layers_follows_all_interfaces() {
    let (_guard, folder) = folder();
    let told = compare(&folder, &[&asset("bumpy.glb"), "--interfaces", "all", "--methods", "walk,layers,exact"]);
    let of = |row: usize, column: &str| number(&told["rows"][row], column);
    assert!(of(1, "mean_deg") < 0.01 && of(1, "wrong_status") < 0.005, "{told}");
    assert!(of(2, "mean_deg") < 0.01 && of(2, "wrong_status") < 0.005, "{told}");
    assert!(of(0, "wrong_status") > 0.05, "what enters again is not met by walk: {told}");
}

/// What is totally reflected is judged by what it shows: its paths have no exit at the second interface.
#[test]
fn total_reflection_is_followed_as_the_truth_does() {
    let (_guard, folder) = folder();
    let told = compare(&folder, &[&asset("bumpy.glb"), "--tir", "trace", "--methods", "dir:5,newton:5,layers,exact"]);
    let flip = [0, 1, 2, 3].map(|row| number(&told["rows"][row], "flip"));
    assert!(flip[0] < 0.06 && flip[1] < 0.035 && flip[2] < 0.002 && flip[3] < 0.002, "{flip:?}");
}

#[test]
fn heat_maps_are_written() {
    let (_guard, folder) = folder();
    compare(
        &folder,
        &[&asset("torus.glb"), "--methods", "newton:3,splat:32", "--truth-photons", "20000", "--heatmap", "a/b"],
    );
    let expected = [
        "caustic_truth.png",
        "newton_3.png",
        "newton_3_angle.png",
        "newton_3_flip.png",
        "splat_32.png",
        "splat_32_error.png",
        "splat_32_range.png",
        "truth.png",
    ];
    assert_eq!(names(&folder.join("a/b")), expected);
    for name in expected {
        let picture = image::open(folder.join("a/b").join(name)).unwrap().into_rgb8();
        let first = *picture.get_pixel(picture.width() / 2, picture.height() / 2);
        assert!(picture.pixels().any(|pixel| *pixel != first), "{name} is of one colour");
    }
}

#[test]
fn caustics_are_compared_as_irradiance_on_the_floor() {
    let (_guard, folder) = folder();
    let comparison =
        compare(&folder, &[&asset("sphere.glb"), "--methods", "splat:64,splat:256", "--truth-photons", "400000"]);
    let rows = comparison["rows"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["photons"].as_u64().unwrap()).collect::<Vec<_>>(), [64, 256]);
    for row in rows {
        assert_eq!(row["method"], "splat");
        // Noise of the truth's flux is its jitter within cells, far below a percent.
        assert!((number(row, "energy_ratio") - 1.0).abs() < 0.02, "{row:#}");
        assert!((number(row, "radius_ratio") - 1.0).abs() < 0.2, "{row:#}");
        assert!(number(row, "relative_l1") < 1.0 && number(row, "truth_noise_l1") < 0.5, "{row:#}");
    }
}

#[test]
fn whole_frames_are_compared_with_a_path_traced_picture() {
    let (_guard, folder) = folder();
    let sphere = asset("sphere.glb");
    let arguments = [
        &sphere,
        "--methods",
        "sir,newton",
        "--reference",
        "path",
        "--noise",
        "1",
        "--size",
        "48x48",
        "--floor",
        "none",
    ];
    let (stdout, _) = succeeds(&folder, &[&["compare"], &arguments[..], &["--runs", "1", "--json"]].concat());
    let comparison = json_lines(&stdout).remove(0);
    let noise = number(&comparison, "noise");
    assert!(noise > 0.0 && noise <= 1.0, "{noise}");
    let flip: Vec<f64> = comparison["rows"].as_array().unwrap().iter().map(|row| number(row, "flip")).collect();
    assert!(flip[0] > 1.2 * flip[1] && flip[1] < 0.25, "{flip:?}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let (_guard, folder) = folder();
    let sphere = asset("sphere.glb");
    refuses(&folder, &["compare", &sphere, "--methods", "magic"], &["magic", "newton", "splat"]);
    refuses(&folder, &["compare", &sphere, "--methods", "dir:0"], &["dir:0", "1 to 64"]);
    refuses(&folder, &["compare", &sphere, "--ior", "1", "--size", "32x32"], &["index 1"]);
    let away = ["compare", &sphere, "--camera", "eye=0,0,9", "target=0,0,20"];
    refuses(&folder, &away, &["no glass", "--camera"]);
    let bare = ["compare", &sphere, "--methods", "splat", "--floor", "none", "--size", "32x32"];
    refuses(&folder, &bare, &["--floor"]);
}

/// Exact paths change from frame to frame as the truth does; a lone frame changes into nothing.
#[test]
fn a_sequence_is_judged_by_what_changes_in_it() {
    let (_guard, folder) = folder();
    let octopus = asset("octopus.glb");
    let input = ["compare", &octopus, "--caustics", "off", "--methods", "layers"];
    let sequence =
        [&input[..], &["--frames", "3..6", "--fps", "12", "--threshold", "1.1", "--json"], &SMALL[..2]].concat();
    let (stdout, _) = succeeds(&folder, &sequence);
    let comparison = json_lines(&stdout).remove(0);
    let row = &comparison["rows"][0];
    assert!(number(row, "truth_change") > 1e-3 && number(row, "mean_deg") < 0.1, "{row:#}");
    assert!((number(row, "ratio") - 1.0).abs() < 0.05 && number(row, "excess") < 0.002, "{row:#}");
    refuses(&folder, &[&input[..], &["--frames", "3"], &SMALL[..2]].concat(), &["two or more"]);
}

/// The light that the back of a ball mirrors is most of what one branch leaves out.
#[test]
fn a_second_branch_comes_nearer_to_the_whole_light() {
    let (_guard, folder) = folder();
    let sphere = asset("sphere.glb");
    let options = ["--interfaces", "all", "--reference", "path", "--floor", "none", "--caustics", "off"];
    let flip = |branches: &str| {
        let method = ["--methods", "layers", "--branches", branches];
        number(&compare(&folder, &[&[&sphere[..]], &method[..], &options[..]].concat())["rows"][0], "flip")
    };
    let (one, two) = (flip("1"), flip("2"));
    // Half of what is left is the noise of the truth.
    assert!(two < 0.06 && two < 0.7 * one, "{one}, then {two}");
}
