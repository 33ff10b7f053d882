use std::path::PathBuf;

use murano_scene::{LightKind, LoopMode, Projection};

use super::*;

fn asset(name: &str) -> Shot {
    Shot::for_model(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name))
}

fn on_stage(shot: Shot) -> (World, Stage) {
    Stage::open(shot).unwrap()
}

/// Largest of |x / w|, |y / w| over the ball around the body, seen by the request's camera: 1 is the picture's border.
fn reach(stage: &Stage, request: &FrameRequest) -> f64 {
    let Projection::Perspective { yfov } = request.view.projection else { panic!("a shot's camera is perspective") };
    let [width, height] = request.size.map(f64::from);
    let view_from_world = request.view.world_from_view.inverse();
    let Extent { center, radius, .. } = stage.extent();
    let directions = (0..400).map(|k| {
        let (y, around) = (1.0 - (f64::from(k) + 0.5) / 200.0, f64::from(k) * 2.399_963);
        DVec3::new(around.cos() * (1.0 - y * y).sqrt(), y, around.sin() * (1.0 - y * y).sqrt())
    });
    let scale = (yfov / 2.0).tan();
    directions
        .map(|direction| (view_from_world * (center + direction * radius).extend(1.0)).truncate())
        .map(|point| (point.x / (scale * width / height)).abs().max((point.y / scale).abs()) / -point.z)
        .fold(0.0, f64::max)
}

#[test]
fn a_bare_model_fits_the_picture() {
    for size in [[512, 512], [960, 540], [300, 700]] {
        let mut shot = asset("dancer.glb");
        shot.output.size = size;
        let (_, stage) = on_stage(shot);
        let reach = reach(&stage, &stage.request(0.0, &Settings::default()));
        assert!((0.75..1.0).contains(&reach), "{size:?}: {reach}");
    }
}

#[test]
fn the_floor_lies_under_the_body_at_all_times() {
    let (world, stage) = on_stage(asset("dancer.glb"));
    let floor = world.floor.unwrap();
    let duration = world.scene.clips[0].duration;
    let moments: Vec<_> = (0..16).map(|k| stage.playing(duration * f64::from(k) / 16.0, 0.0)).collect();
    let whole = Extent::measure(&world.scene, &moments).unwrap();
    for k in 0..16 {
        let time = duration * f64::from(k) / 16.0;
        let held = Extent::measure(&world.scene, &[Layer::alone(stage.clip(), time)]).unwrap();
        assert!(held.lowest >= floor.height, "{time}");
        assert!(held.center.distance(whole.center) <= whole.radius, "{time}");
    }
}

#[test]
fn the_light_covers_the_body_and_its_shadow() {
    let (world, stage) = on_stage(asset("sphere.glb"));
    let placed = stage.placed_light(0.0);
    let LightKind::Spot { inner, outer } = placed.light.kind else { panic!("the default light is a spot") };
    assert!(inner < outer);
    let position = placed.world_from_light.w_axis.truncate();
    let forward = -placed.world_from_light.z_axis.truncate();
    let Extent { center, radius, .. } = stage.extent();
    let height = world.floor.unwrap().height;
    for k in 0..64 {
        let around = f64::from(k) * std::f64::consts::TAU / 64.0;
        let side = forward.any_orthonormal_vector();
        let rim = center + glam::DQuat::from_axis_angle(forward, around) * (side * radius);
        let ray = (rim - position).normalize();
        assert!(forward.angle_between(ray) < f64::from(inner), "body");
        let landed = position + ray * ((height - position.y) / ray.y);
        assert!(forward.angle_between(landed - position) < f64::from(inner), "shadow");
    }
}

#[test]
fn a_white_floor_would_be_exposed_to_one() {
    let (world, stage) = on_stage(asset("sphere.glb"));
    let placed = stage.placed_light(0.0);
    let below = DVec3::new(stage.extent().center.x, world.floor.unwrap().height, stage.extent().center.z);
    let to_light = placed.world_from_light.w_axis.truncate() - below;
    let irradiance = f64::from(placed.light.intensity) * to_light.normalize().y / to_light.length_squared();
    assert!((irradiance / std::f64::consts::PI - 1.0).abs() < 1e-6, "{irradiance}");
}

#[test]
fn time_moves_what_the_shot_moves_and_nothing_else() {
    let mut shot = asset("dancer.glb");
    shot.hold = Some(0.25);
    shot.light.orbit = 90.0;
    let (_, stage) = on_stage(shot.clone());
    let settings = Settings::default();
    let (first, second) = (stage.request(0.0, &settings), stage.request(1.0, &settings));
    assert_eq!((first.time(), second.time()), (0.25, 0.25));
    assert_eq!(first.view, second.view);
    assert_ne!(first.lights, second.lights);
    assert_eq!(first.lights[0].light, second.lights[0].light);

    shot.hold = None;
    shot.light.orbit = 0.0;
    shot.camera.orbit = 360.0;
    let (world, stage) = on_stage(shot);
    let duration = world.scene.clips[0].duration;
    let (first, second) = (stage.request(0.0, &settings), stage.request(0.25, &settings));
    assert_eq!(first.lights, second.lights);
    let [eye, turned] =
        [first, second].map(|request| request.view.world_from_view.w_axis.truncate() - stage.extent().center);
    assert!((turned - DVec3::new(eye.z, eye.y, -eye.x)).length() < 1e-9 * eye.length(), "a quarter turn");
    let wrapped = stage.request(duration + 0.25, &Settings { start: 0.5, ..settings });
    assert!((wrapped.time() - 0.75).abs() < 1e-9);
}

#[test]
fn a_loop_is_the_default_length() {
    let (world, stage) = on_stage(asset("dancer.glb"));
    let frames = (world.scene.clips[0].duration * stage.shot().output.fps).round() as u32;
    assert_eq!(stage.frame_count(), frames);
    let (_, still) = on_stage(asset("sphere.glb"));
    assert!(still.frame_count() >= 1);
}

/// A round that is no whole number of frames is played a little faster or slower, so that the last frame meets the first.
#[test]
fn a_loop_closes() {
    let mut shot = asset("dancer.glb");
    shot.output.fps = 7.3;
    let settings = Settings::default();
    for repeat in [LoopMode::Loop, LoopMode::PingPong] {
        shot.repeat = repeat;
        let (world, stage) = on_stage(shot.clone());
        let duration = world.scene.clips[0].duration;
        let end = stage.request(f64::from(stage.frame_count()) / 7.3, &settings).time();
        assert!(end.min(duration - end) < 1e-9, "{repeat:?}: {end} of {duration}");
    }
    // As many frames as are asked for are at their own times.
    shot.output.frames = Some(10);
    shot.repeat = LoopMode::Loop;
    let (_, stage) = on_stage(shot);
    assert!((stage.request(1.0, &settings).time() - 1.0).abs() < 1e-12);
}

#[test]
fn what_does_not_exist_is_named_with_what_does() {
    let mut shot = asset("dancer.glb");
    shot.clip = ClipChoice::Name("swim".into());
    let message = Stage::open(shot.clone()).err().unwrap().to_string();
    assert!(message.contains("`swim`") && message.contains("0 `"), "{message}");
    shot.clip = ClipChoice::First;
    shot.glass.bodies = murano_scene::GlassBodies::Named(vec!["wood".into()]);
    let message = Stage::open(shot).err().unwrap().to_string();
    assert!(message.contains("`wood`") && message.contains("dancer.glb"), "{message}");
    assert!(open_shot(Path::new("fox.obj")).unwrap_err().to_string().contains(".glb"));
}
