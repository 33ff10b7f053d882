//! What light meets once it has left the glass: shown where the picture shows it, guessed where it cannot, and said so.

use glam::{DQuat, DVec3, Vec3};
use murano_optics::Ior;
use murano_refraction::{Interfaces, Method, Refraction};
use murano_render::{Aov, Floor, View, World};
use murano_scene::{Environment, Local, Material, Mesh, Node, Primitive, Transform};
use murano_tests::bench::{Distribution, asset, glass_body, gpu, renderer, scalars, settings, still, vectors};

const SIDE: u32 = 128;

/// A ball of radius 1 in white surroundings, over a black floor if there is one.
fn ball(ior: f64, floor: Option<f64>) -> World {
    World {
        environment: Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] }),
        floor: floor.map(|height| Floor { height, center: [0.0; 2], half_extent: 50.0, albedo: [0.0; 3] }),
        ..glass_body(&asset("sphere.glb"), Ior::new(ior).expect("an index"))
    }
}

fn seen(world: World, view: View, refraction: Refraction) -> Aov {
    let request = still(view, [SIDE; 2], refraction);
    renderer(gpu(), world).render(&request).unwrap_or_else(|error| panic!("{error}")).aov.expect("asked for")
}

#[test]
fn what_light_meets_fades_towards_the_border_of_the_picture_and_says_so() {
    let view = View::look_at(2.0 * DVec3::Y, 1e-3 * DVec3::Z, 0.7);
    // Bends nothing.
    let aov = seen(ball(1.0001, Some(-1.5)), view, settings(Method::Layers, 5));
    let (radiance, guessed) = (vectors(&aov, "radiance"), scalars(&aov, "guessed"));
    let side = f64::from(SIDE);
    for (index, (radiance, guessed)) in radiance.into_iter().zip(guessed).enumerate() {
        let texel = [index as u32 % SIDE, index as u32 / SIDE].map(|place| f64::from(place) + 0.5);
        let inwards = texel.into_iter().map(|place| place.min(side - place)).fold(f64::INFINITY, f64::min);
        let expected = (1.0 - inwards / (side / 32.0)).max(0.0);
        assert!((guessed - expected).abs() < 0.02, "pixel {texel:?}: {guessed} is a guess, not {expected}");
        // The floor is black, the surroundings are white.
        assert!((radiance - DVec3::splat(expected)).abs().max_element() < 0.02, "pixel {texel:?}: {radiance}");
    }
}

#[test]
fn light_that_meets_nothing_is_no_guess() {
    let view = View::look_at(DVec3::new(0.0, 2.0, 4.0), DVec3::ZERO, 0.5);
    let aov = seen(ball(1.5, None), view, settings(Method::Layers, 5));
    assert!(scalars(&aov, "guessed").into_iter().all(|share| share == 0.0));
}

#[test]
fn light_that_meets_what_the_picture_does_not_show_is_a_guess() {
    // The floor lies far below the picture.
    let view = View::look_at(DVec3::new(0.0, 0.0, 8.0), DVec3::ZERO, 0.3);
    let aov = seen(ball(1.5, Some(-6.0)), view, settings(Method::Layers, 5));
    let (mut down, mut up) = (0, 0);
    // Zero where there is no glass.
    for (exit, guessed) in vectors(&aov, "exit_direction").into_iter().zip(scalars(&aov, "guessed")) {
        // Steep enough to meet the floor before it ends.
        if exit.y < -0.3 {
            down += 1;
            assert_eq!(guessed, 1.0, "{exit} sees a floor that is not in the picture");
        } else if exit.y > 0.0 {
            up += 1;
            assert_eq!(guessed, 0.0, "{exit} sees the surroundings");
        }
    }
    assert!(down > 100 && up > 100, "{down} pixels look down, {up} up");
}

/// A tall block of opaque stuff beside and behind the ball: its corners.
const BLOCK: [DVec3; 2] = [DVec3::new(1.2, -2.0, -3.0), DVec3::new(2.0, 4.0, -2.0)];

fn with_block(mut world: World) -> World {
    let corner = |i: usize| {
        let side = |axis: usize| BLOCK[(i >> axis) & 1][axis] as f32;
        Vec3::new(side(0), side(1), side(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let scene = &mut world.scene;
    let block = Primitive {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        material: Some(scene.materials.len()),
        ..Primitive::default()
    };
    scene.materials.push(Material::default());
    scene.meshes.push(Mesh { name: "block".into(), primitives: vec![block] });
    scene.roots.push(scene.nodes.len());
    let local = Local::Trs(Transform::IDENTITY);
    scene.nodes.push(Node { name: "block".into(), local, mesh: Some(scene.meshes.len() - 1), ..Node::default() });
    world
}

/// Whether a ray meets the block, or passes it by less than this.
fn meets_block(origin: DVec3, direction: DVec3, margin: f64) -> bool {
    let [to_low, to_high] = [BLOCK[0] - margin, BLOCK[1] + margin].map(|corner| (corner - origin) / direction);
    to_low.min(to_high).max_element().max(0.0) < to_low.max(to_high).min_element()
}

#[test]
fn light_that_passes_things_by_sees_the_surroundings_where_it_goes() {
    let view = View::look_at(DVec3::new(0.0, 0.5, 6.0), DVec3::new(0.5, 0.3, 0.0), 0.9);
    let colours = (0..8_u16).map(|i| [f32::from(i & 1), f32::from((i >> 1) & 1), f32::from(i >> 2)]).collect();
    let surroundings = Environment { width: 4, height: 2, pixels: colours };
    let alone = || World { environment: Some(surroundings.clone()), ..ball(1.5, None) };
    // The ball stands between floor and block's top, in the box around everything opaque.
    let floor = Floor { height: -2.0, center: [0.0; 2], half_extent: 6.0, albedo: [0.5; 3] };
    let beside = World { floor: Some(floor), ..with_block(alone()) };
    let [beside, alone] = [beside, alone()].map(|world| seen(world, view, settings(Method::Exact, 5)));
    let rays = vectors(&alone, "p2").into_iter().zip(vectors(&alone, "exit_direction"));
    let shown = vectors(&beside, "radiance").into_iter().zip(vectors(&alone, "radiance"));
    let (mut by, mut met) = (0, 0);
    for (((p2, exit), (radiance, expected)), guessed) in rays.zip(shown).zip(scalars(&beside, "guessed")) {
        // Of what goes up, so that it does not meet the floor.
        if exit.y <= 0.0 {
            continue;
        }
        if !meets_block(p2, exit, 0.3) && guessed == 0.0 {
            by += 1;
            assert!((radiance - expected).abs().max_element() < 2e-3, "{exit} from {p2}: {radiance}, not {expected}");
        } else if guessed == 0.0 && meets_block(p2, exit, -0.3) {
            met += usize::from((radiance - expected).length() > 0.01);
        }
    }
    assert!(by > 400 && met > 10, "{by} pixels look past the block, {met} at it");
}

/// Two rings of coloured glass that bends nothing, each through the other, in white surroundings; one of them alone.
fn rings(alone: Option<usize>) -> World {
    let mut world = glass_body(&asset("torus.glb"), Ior::new(1.0001).expect("an index"));
    let scene = &mut world.scene;
    let first = scene.nodes.iter().position(|node| node.mesh.is_some()).expect("a ring");
    let mesh = scene.nodes[first].mesh.expect("a ring");
    let glass = scene.materials[scene.meshes[mesh].primitives[0].material.expect("glass")].clone();
    let colours = [Vec3::new(0.9, 0.4, 0.2), Vec3::new(0.3, 0.5, 0.9)];
    let places = [
        Transform { translation: -0.5 * DVec3::X, ..Transform::IDENTITY },
        Transform {
            translation: 0.5 * DVec3::X,
            rotation: DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
            ..Transform::IDENTITY
        },
    ];
    let ring = scene.meshes[mesh].clone();
    (scene.nodes, scene.roots) = (Vec::new(), Vec::new());
    for (body, (colour, place)) in colours.into_iter().zip(places).enumerate() {
        if alone.is_some_and(|alone| alone != body) {
            continue;
        }
        let mut coloured = ring.clone();
        coloured.primitives[0].material = Some(scene.materials.len());
        scene.materials.push(Material { attenuation_color: colour, attenuation_distance: 0.5, ..glass.clone() });
        scene.meshes.push(coloured);
        scene.roots.push(scene.nodes.len());
        scene.nodes.push(Node {
            name: format!("ring {body}"),
            local: Local::Trs(place),
            mesh: Some(scene.meshes.len() - 1),
            ..Node::default()
        });
    }
    World { environment: Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] }), floor: None, ..world }
}

#[test]
fn interlocked_bodies_are_seen_through_one_another_whichever_is_in_front() {
    let view = View::look_at(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, 0.5);
    let look = |alone, interfaces| {
        let refraction = Refraction { interfaces, reflection: false, ..settings(Method::Layers, 5) };
        seen(rings(alone), view, refraction)
    };
    let both = look(None, Interfaces::Two);
    let [first, second] = [0, 1].map(|body| {
        let [once, whole] = [Interfaces::Two, Interfaces::All].map(|interfaces| look(Some(body), interfaces));
        // A ray that meets the ring twice does not come straight out of it at its exit.
        let single: Vec<bool> = vectors(&once, "radiance")
            .into_iter()
            .zip(vectors(&whole, "radiance"))
            .map(|(once, whole)| (once - whole).abs().max_element() < 1e-4)
            .collect();
        let status = scalars(&once, "status");
        (vectors(&once, "radiance"), scalars(&once, "depth"), status, single)
    });
    let (mut in_front, mut off) = ([0, 0], Vec::new());
    for (index, shown) in vectors(&both, "radiance").into_iter().enumerate() {
        if [&first, &second].iter().all(|ring| ring.2[index] == 1.0 && ring.3[index]) {
            in_front[usize::from(second.1[index] < first.1[index])] += 1;
            // Whichever absorbs first.
            off.push((shown - first.0[index] * second.0[index]).abs().max_element());
        }
    }
    let off = Distribution::of(off);
    eprintln!("radiance through two rings, of which one or the other is in front ({in_front:?} pixels): off by {off}");
    assert!(off.max < 0.01 && off.mean < 3e-4, "radiance is off by {off}");
    assert!(in_front[0] > 200 && in_front[1] > 200, "{in_front:?} pixels have one or the other in front");
}
