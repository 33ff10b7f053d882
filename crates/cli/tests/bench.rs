//! `murano bench`: small runs of every kind, their JSON and their page.

mod common;

use common::{asset, folder, refuses, succeeds};
use serde_json::Value;

/// Runs a benchmark and gives its JSON and its page.
fn bench(arguments: &[&str]) -> (Value, String) {
    let (_guard, folder) = folder();
    succeeds(&folder, &[&["bench"], arguments, &["--json", "out/b.json", "--html", "out/b.html"]].concat());
    let json = std::fs::read(folder.join("out/b.json")).unwrap();
    let page = std::fs::read_to_string(folder.join("out/b.html")).unwrap();
    let json: Value = serde_json::from_slice(&json).unwrap();
    for fact in ["command", "version", "date", "adapter"] {
        let value = json[fact].as_str().unwrap();
        assert!(!value.is_empty(), "{fact}");
        // The page escapes what the command line may hold.
        assert!(fact == "command" || page.contains(value), "{fact}");
    }
    for loaded in ["src=\"http", "href=\"http", "<script", "@import"] {
        assert!(!page.contains(loaded), "the page is whole in one file: {loaded}");
    }
    (json, page)
}

#[test]
fn refraction_is_run_time_against_error() {
    let (sphere, swan) = (asset("sphere.glb"), asset("swan.glb"));
    let (json, page) = bench(&[
        "refraction",
        &sphere,
        &swan,
        "--times",
        "0,0.5",
        "--iors",
        "1.2,1.5",
        "--size",
        "64x64",
        "--runs",
        "1",
        "--methods",
        "dir:5,newton:5",
        "--no-growth",
    ]);
    let subjects = json["subjects"].as_array().unwrap();
    assert_eq!(subjects.len(), 8);
    for subject in subjects {
        let mean = |row: usize| subject["rows"][row]["mean_deg"].as_f64().unwrap();
        assert!(mean(1) < mean(0), "{subject:#}");
        assert!(subject["triangles"].as_u64() > Some(1000) && subject["covered"].as_u64() > Some(50), "{subject:#}");
    }
    assert_eq!(page.matches("<img").count(), 2 * 5, "a truth, two pictures and two maps a model");
    assert!(page.contains("newton:5") && page.contains("Pareto") && page.contains("<svg"));
}

/// Blocks of the page's small pictures are wider than such a picture is high.
#[test]
fn flat_pictures_have_pages_too() {
    let (json, page) = bench(&[
        "refraction",
        &asset("sphere.glb"),
        "--iors",
        "1.5",
        "--size",
        "599x2",
        "--runs",
        "1",
        "--methods",
        "newton:5",
        "--no-growth",
    ]);
    assert!(json["subjects"][0]["covered"].as_u64() > Some(0) && page.contains("<img"));
}

#[test]
fn caustics_are_run_time_against_error() {
    let sphere = asset("sphere.glb");
    let (json, page) = bench(&[
        "caustics",
        &sphere,
        "--lights",
        "directional",
        "--photons",
        "32,64,128",
        "--map-sizes",
        "128",
        "--truth-photons",
        "100000",
        "--runs",
        "1",
    ]);
    let subject = &json["subjects"][0];
    assert!(subject["flux"].as_f64() > Some(0.0));
    for method in ["splat", "shah", "beams", "footprint"] {
        let rows = subject["rows"].as_array().unwrap().iter().filter(|row| row["method"] == method);
        let errors: Vec<f64> = rows.map(|row| row["relative_l1"].as_f64().unwrap()).collect();
        let [few, more, many] = errors[..] else { panic!("three numbers of photons: {subject:#}") };
        assert!(many <= more + 0.02, "more photons are no worse: {method} {more}, then {many}");
        // So few splats lie in a finer detail than more of them.
        assert!(method == "splat" || many <= few + 0.02, "more photons are no worse: {method} {few}, then {many}");
    }
    assert!(page.contains("splat:128") && page.contains("<svg"));
}

#[test]
fn animation_is_exact_and_timed() {
    let (json, _) =
        bench(&["animation", &asset("dancer.glb"), "--samples", "3", "--runs", "1", "--crowd", "40", "--no-growth"]);
    let model = &json["models"][0];
    assert_eq!(model["poses"].as_u64(), Some(3 * model["clips"].as_u64().unwrap()));
    assert!(model["max_error"].as_f64().unwrap() < 1e-5, "{model:#}");
    assert!(model["max_normal_deg"].as_f64().unwrap() < 0.1, "{model:#}");
    assert!(model["sampling"]["forward"].as_f64().unwrap() > 0.0);
    let crowd = &json["crowds"][0];
    assert_eq!(crowd["characters"].as_u64(), Some(40));
    assert!(crowd["still_ms"].as_f64().unwrap() < crowd["moving_ms"].as_f64().unwrap(), "{crowd:#}");
}

#[test]
fn wrong_questions_are_refused_before_anything_is_measured() {
    let (_guard, folder) = folder();
    let sphere = asset("sphere.glb");
    refuses(&folder, &["bench", "refraction"], &["INPUT"]);
    refuses(&folder, &["bench", "refraction", &sphere, "--methods", "splat", "--size", "32x32"], &["bench caustics"]);
    refuses(&folder, &["bench", "caustics", &sphere, "--methods", "newton"], &["bench refraction"]);
    std::fs::copy(&sphere, folder.join("a.glb")).unwrap();
    refuses(&folder, &["bench", "refraction", "--json", "a.glb", "a.glb"], &["a.glb", ".json"]);
    assert_eq!(std::fs::read(folder.join("a.glb")).unwrap(), std::fs::read(&sphere).unwrap(), "the model is untouched");
    refuses(&folder, &["bench", "caustics", &sphere, "--lights", "sun"], &["sun", "spot"]);
    std::fs::write(folder.join("file"), "").unwrap();
    refuses(&folder, &["bench", "animation", &sphere, "--html", "file/page.html"], &["file/page.html"]);
}

#[test]
fn a_change_runs_what_depends_on_it_and_no_more() {
    let swan = asset("swan.glb");
    let small = ["--frames", "2", "--size", "48x48", "--photons", "24", "--caustic-size", "48"];
    let (json, page) = bench(&[&["cache", swan.as_str()][..], &small[..]].concat());
    let rows = json["rows"].as_array().unwrap();
    let row = |scenario: &str, cache: &str| {
        let fits = |row: &&Value| row["scenario"] == scenario && row["cache"] == cache && row["caustics"] == true;
        rows.iter().find(fits).unwrap_or_else(|| panic!("no row `{scenario}`, {cache}"))
    };
    let ran = |row: &Value, pass: &str| {
        let passes = row["passes"].as_array().unwrap();
        passes.iter().find(|found| found["name"] == pass).map_or(0.0, |found| found["ran"].as_f64().unwrap())
    };
    for repeated in ["static", "paused clip", "looped clip"] {
        assert_eq!(row(repeated, "on")["ran"], 0.0, "{repeated}");
    }
    for (scenario, emissions, deposits) in [
        ("camera only", 0.0, 0.0),
        ("light colour only", 0.0, 0.0),
        ("light only", 1.0, 1.0),
        ("receiver only", 0.0, 10.0),
        ("one of ten casters", 1.0, 1.0),
        ("everything", 1.0, 1.0),
    ] {
        let it = row(scenario, "on");
        assert_eq!((ran(it, "emit"), ran(it, "deposit")), (emissions, deposits), "{scenario}: {it:#}");
        assert_eq!(row(scenario, "off")["reused"], 0.0, "{scenario}");
    }
    assert!(json["static_ratio"].as_f64() > Some(0.0));
    assert!(page.contains("one of ten casters") && page.contains("No pass ran"));
}
