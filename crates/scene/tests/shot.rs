//! Shots: written, read, refused.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use murano_scene::{
    Aim, CameraKey, ClipChoice, EnvironmentChoice, FloorLevel, GlassBodies, LoopMode, Shot, ShotCamera, ShotError,
    ShotFloor, ShotGlass, ShotLayer, ShotLight, ShotLightKind, ShotOutput, Skinning, ToneMapChoice,
};

fn load(text: &str) -> Result<Shot, ShotError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("shot.ron");
    fs::write(&path, text).expect("a temporary file");
    let mut shot = Shot::load(&path)?;
    // The folder's name is random.
    shot.model = shot.model.strip_prefix(folder.path()).expect("relative to the shot").to_owned();
    if let EnvironmentChoice::File(file) = &mut shot.environment {
        *file = file.strip_prefix(folder.path()).expect("relative to the shot").to_owned();
    }
    Ok(shot)
}

#[test]
fn one_line_is_a_shot() {
    assert_eq!(load("(model: \"fox.glb\")").expect("a shot"), Shot::for_model(Path::new("fox.glb")));
}

#[test]
fn a_short_shot_says_what_it_means() {
    let shot = load(
        "(
            model: \"../assets/dancer.glb\",
            clip: \"spin\",
            camera: (azimuth: 30, orbit: 20),
            light: (kind: Point, position: (0, 3, 0), orbit: -10),
            glass: (bodies: All, ior: 1.33),
            floor: (level: At(-1)),
            environment: Absent,
        )",
    )
    .expect("a shot");
    assert_eq!(shot.model, PathBuf::from("../assets/dancer.glb"));
    assert_eq!(shot.clip, ClipChoice::Name("spin".into()));
    assert_eq!(shot.camera, ShotCamera { azimuth: 30.0, orbit: 20.0, ..ShotCamera::default() });
    assert_eq!(shot.light.position, Some([0.0, 3.0, 0.0]));
    assert_eq!(shot.glass, ShotGlass { bodies: GlassBodies::All, ior: Some(1.33), ..ShotGlass::default() });
    assert_eq!(shot.floor.level, FloorLevel::At(-1.0));
    assert_eq!(shot.environment, EnvironmentChoice::Absent);
    assert_eq!(load("(model: \"a.glb\", clip: 2)").expect("a shot").clip, ClipChoice::Index(2));
}

#[test]
fn every_field_survives_writing_and_reading() {
    let shot = Shot {
        model: "fish.glb".into(),
        clip: ClipChoice::Name("swim".into()),
        speed: -0.5,
        repeat: LoopMode::PingPong,
        layers: vec![ShotLayer {
            clip: ClipChoice::Index(1),
            speed: 2.0,
            repeat: LoopMode::Clamp,
            weight: 0.75,
            from: 1.0,
            until: Some(3.0),
            fade: 0.5,
            add: true,
            mask: vec!["tail".into()],
        }],
        skinning: Skinning::DualQuaternion,
        variant: Some(ClipChoice::Name("night".into())),
        hold: Some(0.25),
        camera: ShotCamera {
            model: Some("front".into()),
            eye: Some([1.0, 2.0, 3.0]),
            target: Some([0.0, 0.5, 0.0]),
            fov: 35.0,
            azimuth: 12.0,
            elevation: -5.0,
            orbit: 15.0,
            keys: vec![
                CameraKey { time: 0.0, eye: [0.0, 1.0, 4.0], target: [0.0; 3], fov: None },
                CameraKey { time: 2.0, eye: [4.0, 1.0, 0.0], target: [0.0; 3], fov: Some(30.0) },
            ],
        },
        light: ShotLight {
            model: true,
            kind: ShotLightKind::Directional,
            position: Some([0.0, 5.0, 0.0]),
            direction: Some([0.0, -1.0, 0.25]),
            color: [1.0, 0.9, 0.8],
            intensity: Some(900.0),
            cone: Some(45.0),
            orbit: 5.0,
        },
        glass: ShotGlass {
            bodies: GlassBodies::Named(vec!["scales".into()]),
            ior: Some(1.6),
            attenuation_color: Some([0.2, 0.8, 0.7]),
            attenuation_distance: Some(0.5),
            dispersion: Some(0.3),
            roughness: Some(0.2),
            thin: Some(true),
        },
        environment: EnvironmentChoice::File("studio.hdr".into()),
        floor: ShotFloor { level: FloorLevel::At(0.125), albedo: [0.5, 0.4, 0.3] },
        output: ShotOutput { size: [640, 360], fps: 30.0, frames: Some(48), samples: 4 },
        exposure: 1.5,
        tone_map: ToneMapChoice::Agx,
    };
    assert_eq!(load(&shot.to_ron().expect("RON")).expect("a shot"), shot);
    let bare = Shot::for_model(Path::new("bare.glb"));
    assert_eq!(load(&bare.to_ron().expect("RON")).expect("a shot"), bare);
}

#[test]
fn errors_name_the_line_or_the_field() {
    let error = load("(\n    model: \"a.glb\",\n    lihgt: (),\n)").expect_err("a misspelt field");
    assert!(matches!(&error, ShotError::Syntax { .. }));
    assert!(error.to_string().contains("lihgt") && error.to_string().contains('3'), "{error}");

    for (text, expected) in [
        ("camera: (fov: 180)", "camera.fov"),
        ("camera: (eye: (0, NaN, 0))", "camera.eye"),
        (
            "camera: (keys: [(time: 1, eye: (0,0,1), target: (0,0,0)), (time: 1, eye: (0,0,1), target: (0,0,0))])",
            "camera.keys[1].time",
        ),
        ("light: (direction: (0, 0, 0))", "light.direction"),
        ("light: (intensity: -1)", "light.intensity"),
        ("glass: (ior: 0.9)", "glass.ior"),
        ("glass: (attenuation_distance: 0)", "glass.attenuation_distance"),
        ("floor: (albedo: (1, 1, 2))", "floor.albedo"),
        ("output: (size: (0, 512))", "output.size"),
        ("output: (samples: 0)", "output.samples"),
        ("output: (fps: 0)", "output.fps"),
        ("output: (frames: 0)", "output.frames"),
        ("exposure: inf", "exposure"),
    ] {
        let error = load(&format!("(model: \"a.glb\", {text})")).expect_err(text);
        assert!(matches!(&error, ShotError::Invalid { field, .. } if field == expected), "{text}: {error}");
    }
    assert!(matches!(Shot::load(Path::new("none.ron")), Err(ShotError::Unreadable { .. })));
}

#[test]
fn cameras_orbit_and_follow_their_keys() {
    let framed = Aim { eye: DVec3::new(0.0, 1.0, 5.0), target: DVec3::Y, fov: 50.0 };
    let orbiting = ShotCamera { orbit: 90.0, ..ShotCamera::default() };
    let aim = orbiting.at(1.0, framed);
    assert!(aim.eye.abs_diff_eq(DVec3::new(5.0, 1.0, 0.0), 1e-12), "{}", aim.eye);
    assert_eq!((aim.target, aim.fov), (DVec3::Y, 40.0));

    let key = |time: f64, x: f64| CameraKey { time, eye: [x, 0.0, 1.0], target: [x, 0.0, 0.0], fov: None };
    let keyed = ShotCamera { keys: vec![key(1.0, 0.0), key(2.0, 1.0), key(4.0, 3.0)], ..ShotCamera::default() };
    for (time, x) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (3.0, 2.0), (4.0, 3.0), (9.0, 3.0)] {
        let aim = keyed.at(time, framed);
        assert!((aim.eye.x - x).abs() < 1e-12 && (aim.target.x - x).abs() < 1e-12, "{time}: {}", aim.eye);
    }
}

#[test]
fn lights_orbit_their_centre() {
    let light = ShotLight { position: Some([2.0, 3.0, 0.0]), orbit: 45.0, ..ShotLight::default() };
    let (position, direction) = light.at(2.0, DVec3::ZERO, DVec3::new(-2.0, -3.0, 0.0), DVec3::X);
    assert!(position.abs_diff_eq(DVec3::new(1.0, 3.0, -1.0), 1e-12), "{position}");
    assert!((direction.length() - 1.0).abs() < 1e-12 && direction.z > 0.0);
}

#[test]
fn a_layer_fades_in_and_out() {
    let layer = ShotLayer { weight: 0.5, from: 1.0, until: Some(4.0), fade: 1.0, ..ShotLayer::default() };
    assert_eq!([0.0, 1.0, 1.5, 2.0, 3.0, 3.5, 4.0].map(|t| layer.weight_at(t)), [0.0, 0.0, 0.25, 0.5, 0.5, 0.25, 0.0]);
    let hard = ShotLayer { from: 1.0, until: Some(2.0), ..ShotLayer::default() };
    assert_eq!([0.99, 1.0, 1.99, 2.0].map(|t| hard.weight_at(t)), [0.0, 1.0, 1.0, 0.0]);
}

#[test]
fn layers_are_checked() {
    for (layer, field) in [("until: 0.0", "until"), ("fade: -1.0", "fade"), ("speed: inf", "speed")] {
        let error = load(&format!("(model: \"a.glb\", layers: [({layer})])")).expect_err(layer).to_string();
        assert!(error.contains(&format!("layers[0].{field}")), "{error}");
    }
}
