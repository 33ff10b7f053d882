//! `murano export`, on whatever adapter this machine has.

mod common;

use common::{asset, folder, json_lines, murano, names, succeeds};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};

const SMALL: [&str; 2] = ["--size", "64x48"];

#[test]
fn frames_are_written_and_numbered() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    for (pattern, expected) in
        [("a/f_####.png", ["f_0003.png", "f_0004.png"]), ("b/{frame:02}x.png", ["03x.png", "04x.png"])]
    {
        succeeds(&folder, &[&["export", &dancer, "-o", pattern, "--frames", "3..5"], &SMALL[..]].concat());
        let written = folder.join(pattern).parent().unwrap().to_owned();
        assert_eq!(names(&written), expected);
        for name in expected {
            let picture = image::open(written.join(name)).unwrap().into_rgba8();
            assert_eq!(picture.dimensions(), (64, 48));
            assert!(picture.pixels().all(|pixel| pixel[3] == 255));
            let first = *picture.get_pixel(0, 0);
            assert!(picture.pixels().any(|pixel| *pixel != first), "{name} is of one colour");
        }
    }
}

#[test]
fn json_says_what_every_frame_did() {
    let (_guard, folder) = folder();
    let (stdout, _) = succeeds(
        &folder,
        &[&["export", &asset("dancer.glb"), "-o", "#.png", "--frames", "0..2", "--fps", "10", "--json"], &SMALL[..]]
            .concat(),
    );
    let lines = json_lines(&stdout);
    assert_eq!(lines.len(), 3);
    for (number, line) in lines[..2].iter().enumerate() {
        assert_eq!(line["frame"], number);
        assert!((line["time"].as_f64().unwrap() - number as f64 / 10.0).abs() < 1e-9);
        assert!(line["cpu_ms"].as_f64().unwrap() > 0.0);
        assert!(line["gpu_ms"].is_number());
        let passes = line["passes"].as_array().unwrap();
        assert!(!passes.is_empty());
        for pass in passes {
            assert!(pass["name"].is_string() && pass["reason"].is_string(), "{pass}");
            assert!(["ran", "reused", "culled"].contains(&pass["decision"].as_str().unwrap()), "{pass}");
        }
    }
    assert_eq!(lines[2]["frames"], 2);
    assert!(lines[2]["seconds"].as_f64().unwrap() > 0.0 && lines[2]["fps"].as_f64().unwrap() > 0.0);
}

/// Decision of the passes called `name`, in one frame of `--json`.
fn decisions<'a>(line: &'a serde_json::Value, name: &str) -> Vec<&'a str> {
    let passes = line["passes"].as_array().unwrap().iter();
    let named = passes.filter(|pass| pass["name"].as_str().unwrap().split(':').next() == Some(name));
    named.map(|pass| pass["decision"].as_str().unwrap()).collect()
}

#[test]
fn a_held_pose_runs_nothing_twice() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let export = |extra: &[&str]| {
        let still = ["export", &dancer, "-o", "#.png", "--frames", "0..2", "--hold", "--json"];
        json_lines(&succeeds(&folder, &[&still[..], &SMALL[..], extra].concat()).0)
    };
    let still = export(&[]);
    let passes = still[1]["passes"].as_array().unwrap();
    assert!(passes.iter().all(|pass| pass["decision"] != "ran"), "{passes:?}");

    let orbiting = export(&["--orbit", "90"]);
    for kept in ["deform", "emit", "deposit"] {
        let decisions = decisions(&orbiting[1], kept);
        assert!(
            !decisions.is_empty() && decisions.iter().all(|decision| *decision == "reused"),
            "{kept}: {decisions:?}"
        );
    }
    assert!(decisions(&orbiting[1], "composite").contains(&"ran"));
}

#[test]
fn skipping_does_not_show() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let export = |name: &str, extra: &[&str]| {
        let moving = ["export", &dancer, "-o", name, "--frames", "0..3", "--light-orbit", "120", "--hold"];
        succeeds(&folder, &[&moving[..], &SMALL[..], extra].concat())
    };
    export("warm_#.png", &[]);
    export("cold_#.png", &["--no-skip"]);
    export("verified_#.png", &["--verify-skips"]);
    for frame in 0..3 {
        let read = |name: &str| std::fs::read(folder.join(format!("{name}_{frame}.png"))).unwrap();
        assert_eq!(read("warm"), read("cold"), "frame {frame}");
        assert_eq!(read("warm"), read("verified"), "frame {frame}");
    }
}

#[test]
fn explain_gives_reasons_on_stderr() {
    let (_guard, folder) = folder();
    let (stdout, stderr) = succeeds(
        &folder,
        &[&["export", &asset("dancer.glb"), "-o", "#.png", "--frames", "0..2", "--explain"], &SMALL[..]].concat(),
    );
    assert_eq!(stdout, "");
    let passes: Vec<_> = stderr.lines().filter(|line| line.trim_start().starts_with("deform:1")).collect();
    assert_eq!(passes.len(), 2, "{stderr}");
    assert!(passes[1].contains("ran") && passes[1].contains("palette"), "{stderr}");
}

#[test]
fn layers_read_back() {
    let (_guard, folder) = folder();
    succeeds(
        &folder,
        &[
            &["export", &asset("sphere.glb"), "-o", "s_##.png", "--frames", "0", "--aov"],
            &["p1,exit_direction,status,depth,radiance"][..],
            &SMALL[..],
        ]
        .concat(),
    );
    assert_eq!(names(&folder), ["s_00.exr", "s_00.png"]);
    let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = image.from_file(folder.join("s_00.exr")).unwrap();
    assert_eq!(image.layer_data.len(), 1);
    let layer = &image.layer_data[0];
    assert_eq!((layer.size.x(), layer.size.y()), (64, 48));
    let channels: Vec<_> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(
        channels,
        [
            "depth",
            "exit_direction.X",
            "exit_direction.Y",
            "exit_direction.Z",
            "p1.X",
            "p1.Y",
            "p1.Z",
            "radiance.B",
            "radiance.G",
            "radiance.R",
            "status",
        ]
    );
    let plane = |name: &str| -> Vec<f32> {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name)).unwrap();
        let FlatSamples::F32(plane) = &channel.sample_data else { panic!("{name} is not f32") };
        plane.clone()
    };
    let (status, x, y, z) =
        (plane("status"), plane("exit_direction.X"), plane("exit_direction.Y"), plane("exit_direction.Z"));
    let glass = status.iter().filter(|status| **status != 0.0).count();
    assert!(glass > 200, "{glass} pixels of glass");
    for pixel in (0..status.len()).filter(|pixel| status[*pixel] == 1.0) {
        let length = (x[pixel].powi(2) + y[pixel].powi(2) + z[pixel].powi(2)).sqrt();
        assert!((length - 1.0).abs() < 1e-3, "pixel {pixel}: {length}");
    }
    assert!(plane("radiance.G").iter().chain(&plane("depth")).all(|value| value.is_finite()));
}

#[test]
fn an_exr_frame_is_linear_radiance() {
    let (_guard, folder) = folder();
    succeeds(&folder, &[&["export", &asset("sphere.glb"), "-o", "s.exr", "--frames", "0"], &SMALL[..]].concat());
    assert_eq!(names(&folder), ["s.exr"]);
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(folder.join("s.exr")).unwrap();
    let channels: Vec<_> = image.layer_data.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(channels, ["radiance.B", "radiance.G", "radiance.R"]);
}

#[test]
fn a_contact_sheet_holds_every_frame() {
    let (_guard, folder) = folder();
    succeeds(
        &folder,
        &[&["export", &asset("dancer.glb"), "--contact-sheet", "out/sheet.png", "--frames", "0..5"], &SMALL[..]]
            .concat(),
    );
    assert_eq!(names(&folder.join("out")), ["sheet.png"]);
    let sheet = image::open(folder.join("out/sheet.png")).unwrap().into_rgba8();
    assert_eq!(sheet.dimensions(), (3 * 64, 2 * 48));
    let lit = |x: u32, y: u32| sheet.get_pixel(x, y)[3] == 255;
    assert!(lit(130, 10) && lit(70, 60), "the first five cells are filled");
    assert!(!lit(130, 60), "the sixth is empty");
}

#[test]
fn a_shot_runs_like_a_model() {
    let (_guard, folder) = folder();
    let shot = format!(
        "(model: {:?}, hold: 0.5, camera: (orbit: 45), output: (size: (40, 30), frames: 2))",
        asset("dancer.glb")
    );
    std::fs::write(folder.join("shot.ron"), shot).unwrap();
    let (stdout, _) = succeeds(&folder, &["export", "shot.ron", "-o", "f#.png", "--json"]);
    let lines = json_lines(&stdout);
    assert_eq!(lines.len(), 3);
    assert_eq!((&lines[0]["time"], &lines[1]["time"]), (&0.5.into(), &0.5.into()));
    assert_eq!(image::image_dimensions(folder.join("f1.png")).unwrap(), (40, 30));
}

#[test]
fn a_film_needs_ffmpeg() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let output = murano(&folder, &[&["export", &dancer, "--video", "a.mp4", "--frames", "0..2"], &SMALL[..]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let installed = std::process::Command::new("ffmpeg").arg("-version").output().is_ok();
    if installed {
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        assert_eq!(names(&folder), ["a.mp4"]);
    } else {
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains("ffmpeg") && stderr.contains("install"), "{stderr}");
        assert!(names(&folder).is_empty());
    }
}
