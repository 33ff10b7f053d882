//! Motion vectors: against points of the scene projected as they were a frame ago.

use glam::{DVec2, DVec3};
use murano_animation::Layer;
use murano_refraction::{Method, Refraction};
use murano_render::{FrameRequest, Moment, Renderer, Skipping, Stage, View};
use murano_scene::{Channel, Clip, Interpolation, Path, Projection, Sampler, Shot};
use murano_tests::bench::{asset, gpu, scalars, still, vectors};

const SIZE: [u32; 2] = [96, 64];

/// Where a point of the world lies in a view's picture, pixels.
fn pixel_of(view: &View, point: DVec3) -> DVec2 {
    let Projection::Perspective { yfov } = view.projection else { panic!("a perspective view") };
    let seen = view.world_from_view.inverse().transform_point3(point);
    let height = (0.5 * yfov).tan();
    let plane = DVec2::new(seen.x, -seen.y) / -seen.z / height;
    DVec2::new(0.5 * f64::from(SIZE[0]), 0.5 * f64::from(SIZE[1])) + 0.5 * f64::from(SIZE[1]) * plane
}

/// A ball of glass over a floor whose clip moves it by a known way.
fn rolling(way: DVec3) -> (Renderer, Stage) {
    let (mut world, stage) = Stage::open(Shot::for_model(&asset("sphere.glb"))).unwrap_or_else(|e| panic!("{e}"));
    let start = world.scene.nodes[0].local.matrix().w_axis.truncate();
    let values = [start, start + way].map(|place| place.as_vec3().to_array()).concat();
    let sampler = Sampler { interpolation: Interpolation::Linear, times: vec![0.0, 1.0], width: 3, values };
    world.scene.clips = vec![Clip {
        name: "roll".into(),
        channels: vec![Channel { node: 0, path: Path::Translation, sampler }],
        duration: 1.0,
        ..Clip::default()
    }];
    (Renderer::new(gpu(), world).unwrap_or_else(|error| panic!("{error}")), stage)
}

#[test]
fn what_moves_is_where_it_was_projected_before() {
    let way = DVec3::new(0.2, 0.05, -0.1);
    let (mut renderer, stage) = rolling(way);
    let center = stage.extent().center;
    let radius = stage.extent().radius;
    let eye = |turn: f64| center + radius * DVec3::new(turn, 1.0, 4.0);
    let [before, now] = [0.0, 0.3].map(|turn| View::look_at(eye(turn), center, 0.9));
    let refraction = Refraction { method: Method::Newton, ..Refraction::default() };
    let moment = Moment { playing: Layer::alone(Some(0), 0.25), view: before };
    let request =
        FrameRequest { playing: Layer::alone(Some(0), 0.75), before: Some(moment), ..still(now, SIZE, refraction) };
    let aov = renderer.render(&request).unwrap_or_else(|error| panic!("{error}")).aov.expect("asked for");
    let (motion, status, first) = (vectors(&aov, "motion"), scalars(&aov, "status"), vectors(&aov, "p1"));
    let depth = scalars(&aov, "depth");
    let Projection::Perspective { yfov } = now.projection else { panic!("a perspective view") };
    let (mut glass, mut floor) = (0, 0);
    for index in 0..motion.len() {
        let texel = DVec2::new((index % SIZE[0] as usize) as f64 + 0.5, (index / SIZE[0] as usize) as f64 + 0.5);
        let earlier = if status[index] > 0.0 {
            glass += 1;
            first[index] - 0.5 * way
        } else if depth[index] > 0.0 {
            floor += 1;
            let plane = (texel - 0.5 * DVec2::new(SIZE[0].into(), SIZE[1].into())) / (0.5 * f64::from(SIZE[1]));
            let plane = plane * (0.5 * yfov).tan() * depth[index];
            now.world_from_view.transform_point3(DVec3::new(plane.x, -plane.y, -depth[index]))
        } else {
            continue;
        };
        let wanted = texel - pixel_of(&before, earlier);
        let off = wanted.distance(motion[index].truncate());
        assert!(off < 2e-3, "pixel {texel}: {} for {wanted}", motion[index]);
    }
    assert!(glass > 200 && floor > 1000, "{glass} pixels of glass, {floor} of floor");
}

#[test]
fn nothing_moves_without_a_frame_before_or_where_it_is_the_same() {
    let (mut renderer, stage) = rolling(DVec3::X);
    let view = View::look_at(stage.extent().center + DVec3::new(0.0, 1.0, 5.0), stage.extent().center, 0.9);
    let request = FrameRequest { playing: Layer::alone(Some(0), 0.5), ..still(view, SIZE, Refraction::default()) };
    let same = Moment { playing: request.playing.clone(), view };
    for before in [None, Some(same)] {
        let request = FrameRequest { before, ..request.clone() };
        let aov = renderer.render(&request).unwrap_or_else(|error| panic!("{error}")).aov.expect("asked for");
        let most = vectors(&aov, "motion").iter().map(|motion| motion.length()).fold(0.0, f64::max);
        assert!(most < 1e-3, "{most}");
    }
}

/// The earlier pose is what the frame before has deformed: it is not deformed again.
#[test]
fn the_frame_before_leaves_its_positions() {
    let (mut renderer, stage) = rolling(DVec3::new(0.01, 0.0, 0.0));
    let view = View::look_at(stage.extent().center + DVec3::new(0.0, 1.0, 5.0), stage.extent().center, 0.9);
    let at = |time: f64, before: f64| FrameRequest {
        playing: Layer::alone(Some(0), time),
        before: Some(Moment { playing: Layer::alone(Some(0), before), view }),
        skipping: Skipping::On,
        ..still(view, SIZE, Refraction::default())
    };
    renderer.render(&at(0.1, 0.0)).unwrap_or_else(|error| panic!("{error}"));
    let frame = renderer.render(&at(0.2, 0.1)).unwrap_or_else(|error| panic!("{error}"));
    let deforms: Vec<_> = frame.passes.iter().filter(|pass| pass.name.starts_with("deform")).collect();
    let ran = deforms.iter().filter(|pass| pass.decision == "ran").count();
    // The body as it is now. What it was is known, and the floor stands still: it is one pass, now and before.
    assert_eq!((deforms.len(), ran), (3, 1), "{deforms:#?}");
}
