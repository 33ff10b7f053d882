//! Caustics against closed forms: plate, lens, ellipsoid, water and mirror, by every method. The truth is a fine lattice of rays, each
//! followed by the body's own geometry, not by the search that it judges.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3, Vec4};
use murano_caustics::Method;
use murano_optics::{
    Ior,
    analytic::{BallLens, Ellipsoid},
    fresnel_dielectric, snell,
};
use murano_render::{FrameRequest, PlacedLight, World};
use murano_scene::{LightKind, Material, Mesh, Node, Primitive, Scene};
use murano_tests::{
    bench::{asset, body, glass_body, gpu, renderer, vectors},
    caustics::{ENERGY, floor, from_above, light, off, picture, request, with_method},
};

/// Texels a side of the compared maps, and pixels a side of each of them.
const SIZE: u32 = 256;
const FINER: u32 = 4;
/// Rays along a side of the truth's lattice.
const RAYS: u32 = 4096;
const PHOTONS: [u32; 3] = [128, 256, 512];

/// A square around the vertical axis, on the floor; what of it counts.
struct Square {
    half: f64,
    /// Farthest from the axis, metres.
    radius: f64,
}

impl Square {
    fn index(&self, place: DVec2) -> Option<usize> {
        let at = ((place / self.half + 1.0) * 0.5 * f64::from(SIZE)).floor();
        let within = at.min_element() >= 0.0 && at.max_element() < f64::from(SIZE);
        let index = within.then(|| at.y as usize * SIZE as usize + at.x as usize)?;
        self.counts(index).then_some(index)
    }

    /// Distance of a texel's centre from the square's, metres.
    fn distance(&self, index: usize) -> f64 {
        let side = |texel: usize| ((texel as f64 + 0.5) / f64::from(SIZE) * 2.0 - 1.0) * self.half;
        side(index % SIZE as usize).hypot(side(index / SIZE as usize))
    }

    fn counts(&self, index: usize) -> bool {
        self.distance(index) < self.radius
    }

    fn texel_area(&self) -> f64 {
        (2.0 * self.half / f64::from(SIZE)).powi(2)
    }

    /// Irradiance of the flux that `landings` brings to places on the floor.
    fn gather(&self, landings: impl FnOnce(&mut dyn FnMut(DVec2, DVec3))) -> Vec<DVec3> {
        let mut map = vec![DVec3::ZERO; (SIZE * SIZE) as usize];
        landings(&mut |place, flux| {
            if let Some(index) = self.index(place) {
                map[index] += flux / self.texel_area();
            }
        });
        map
    }
}

/// A caustic whose truth is known: what throws it on which floor, the light, and the square in which it is compared.
struct Case {
    name: &'static str,
    world: World,
    lamp: PlacedLight,
    /// Height of the camera that looks down on the floor, metres.
    camera: f64,
    square: Square,
    exact: Vec<DVec3>,
}

/// Renders a case by every method and holds it to the most relative L1 for each of [`PHOTONS`], measured plus a fifth; energy to
/// `ENERGY`.
fn judge(case: Case, methods: &[(Method, [f64; 3])]) {
    let Case { name, world, lamp, camera, square, exact } = case;
    let mut renderer = renderer(gpu(), world);
    for &(method, most) in methods {
        for (photons, most) in PHOTONS.into_iter().zip(most) {
            let view = from_above(camera, square.half);
            let asked = with_method(request(view, SIZE * FINER, lamp.clone(), photons), method);
            let frame = picture(&mut renderer, &asked);
            let mut ours = vec![DVec3::ZERO; exact.len()];
            for (pixel, light) in vectors(&frame.aov.expect("asked for"), "caustic").into_iter().enumerate() {
                let side = (SIZE * FINER) as usize;
                let [x, y] = [pixel % side, pixel / side].map(|place| place / FINER as usize);
                let texel = y * SIZE as usize + x;
                if square.counts(texel) {
                    ours[texel] += light / f64::from(FINER * FINER);
                }
            }
            let total = exact.iter().copied().sum::<DVec3>();
            let energy = ours.iter().copied().sum::<DVec3>() / total;
            let error = ours.iter().zip(&exact).map(|(a, b)| (*a - *b).abs()).sum::<DVec3>() / total;
            eprintln!("{name}, {method}, {photons}^2 photons: {energy:.4} of the energy, relative L1 {error:.4}");
            let worst = energy.to_array().map(|channel| off(channel, 1.0)).into_iter().fold(0.0, f64::max);
            assert!(worst <= ENERGY, "{name}, {method}, {photons}^2: {energy} of the energy");
            assert!(error.max_element() <= most, "{name}, {method}, {photons}^2: {error} > {most}");
        }
    }
}

/// The sun, 1 lux.
fn sun(direction: DVec3) -> PlacedLight {
    light(LightKind::Directional, -5.0 * direction, direction)
}

/// Fraction of unpolarised light that an interface lets through.
fn passed(incident: DVec3, normal: DVec3, eta: f64) -> f64 {
    let [s, p] = fresnel_dielectric(incident.dot(normal).abs(), eta).into();
    1.0 - 0.5 * (s + p)
}

/// Where a ray that has come to a second interface from within lands on the floor at a height, and what part of it, of what came.
fn landed(inside: DVec3, exit: DVec3, normal: DVec3, height: f64) -> Option<(DVec2, f64)> {
    let leaving = snell(inside, -normal, Ior::GLASS.eta_leaving());
    let falls = !leaving.tir && leaving.direction.y < 0.0;
    let place = exit + leaving.direction * ((exit.y - height) / -leaving.direction.y);
    falls.then(|| (DVec2::new(place.x, place.z), passed(inside, normal, Ior::GLASS.eta_leaving())))
}

/// Sunlight straight down on a square of this half-width: `through` says where a ray over (x, z) lands and what part of it.
fn straight_down(
    half: f64,
    through: impl Fn(DVec2) -> Option<(DVec2, f64)>,
) -> impl FnOnce(&mut dyn FnMut(DVec2, DVec3)) {
    move |land| {
        let step = 2.0 * half / f64::from(RAYS);
        for j in 0..RAYS {
            for i in 0..RAYS {
                let over = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * step - half;
                if let Some((place, part)) = through(over) {
                    land(place, DVec3::splat(part * step * step));
                }
            }
        }
    }
}

#[test]
fn glass_of_almost_no_power_leaves_the_light_as_it_was() {
    let ior = Ior::new(1.0001).expect("an index");
    let square = Square { half: 0.6, radius: 0.6 };
    // Even this gathers light by a part in two thousand.
    let ball = BallLens::new(1.0, ior, 1.05);
    let light = |index| if square.counts(index) { ball.irradiance(square.distance(index)) } else { 0.0 };
    let exact = (0..(SIZE * SIZE) as usize).map(|index| DVec3::splat(light(index)));
    let case = Case {
        name: "n = 1.0001",
        exact: exact.collect(),
        world: World { floor: Some(floor(-1.05)), ..glass_body(&asset("sphere.glb"), ior) },
        lamp: sun(DVec3::NEG_Y),
        camera: -1.02,
        square,
    };
    judge(
        case,
        &[
            (Method::Splat, [0.011, 0.0025, 0.0009]),
            (Method::Shah, [1.18, 0.312, 0.023]),
            (Method::Beams, [0.0002, 0.0003, 0.0004]),
            (Method::Footprint, [0.0002, 0.0002, 0.0002]),
        ],
    );
}

#[test]
fn a_plate_shifts_slanted_sunlight_and_keeps_it_even() {
    let direction = DVec3::new(0.5, -(0.75_f64.sqrt()), 0.0);
    let square = Square { half: 0.5, radius: 0.5 };
    let even = passed(direction, DVec3::Y, Ior::GLASS.eta_entering()).powi(2) * -direction.y;
    let exact =
        (0..(SIZE * SIZE) as usize).map(|index| if square.counts(index) { DVec3::splat(even) } else { DVec3::ZERO });
    let case = Case {
        name: "plate, sun at 30 degrees",
        exact: exact.collect(),
        world: World { floor: Some(floor(-0.5)), ..glass_body(&asset("slab.glb"), Ior::GLASS) },
        lamp: sun(direction),
        camera: -0.35,
        square,
    };
    judge(
        case,
        &[
            (Method::Splat, [0.0092, 0.0058, 0.0009]),
            (Method::Shah, [1.34, 0.385, 0.024]),
            (Method::Beams, [0.0002, 0.0002, 0.0003]),
            (Method::Footprint, [0.0001, 0.0002, 0.0002]),
        ],
    );
}

#[test]
fn an_ellipsoid_gathers_sunlight_in_its_far_focus() {
    const FLOOR: f64 = -1.05;
    let minor = (1.0_f64 - 1.0 / (1.5 * 1.5)).sqrt();
    let ellipsoid = Ellipsoid { semi_axes: DVec3::new(minor, 1.0, minor), ior: Ior::GLASS };
    let square = Square { half: 0.8, radius: 0.8 };
    let exact = square.gather(straight_down(minor, |over| {
        let way = ellipsoid.passage(DVec3::new(over.x, 5.0, over.y), DVec3::NEG_Y)?;
        let entered = passed(DVec3::NEG_Y, way.entry_normal, Ior::GLASS.eta_entering());
        let (place, part) = landed(way.inside, way.exit, way.exit_normal, FLOOR)?;
        Some((place, entered * part))
    }));
    let case = Case {
        name: "ellipsoid",
        world: World { floor: Some(floor(FLOOR)), ..glass_body(&asset("ellipsoid.glb"), Ior::GLASS) },
        lamp: sun(DVec3::NEG_Y),
        camera: -1.02,
        square,
        exact,
    };
    judge(
        case,
        &[
            (Method::Splat, [0.0955, 0.021, 0.0066]),
            (Method::Shah, [0.288, 0.0782, 0.0188]),
            (Method::Beams, [0.037, 0.021, 0.011]),
            (Method::Footprint, [0.018, 0.011, 0.0069]),
        ],
    );
}

/// A closed body of glass, n = 1.5, over a floor.
fn glass_over(height: f64, parts: Vec<Primitive>) -> World {
    let scene = Scene {
        nodes: vec![Node { mesh: Some(0), ..Node::default() }],
        roots: vec![0],
        meshes: vec![Mesh { name: String::new(), primitives: parts }],
        materials: vec![Material { base_color: Vec4::ONE, ..Material::glass(1.5) }],
        ..Scene::default()
    };
    World { scene, environment: None, floor: Some(floor(height)) }
}

/// A grid of `cells` quads over (u, v) in 0..1, counter-clockwise where v runs to the left of u.
fn grid([across, along]: [u32; 2], vertex: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Primitive {
    let place = |i: u32| {
        vertex(f64::from(i % (across + 1)) / f64::from(across), f64::from(i / (across + 1)) / f64::from(along))
    };
    let vertices: Vec<(DVec3, DVec3)> = (0..(across + 1) * (along + 1)).map(place).collect();
    let quads = (0..along).flat_map(|j| (0..across).map(move |i| j * (across + 1) + i));
    Primitive {
        positions: vertices.iter().map(|(position, _)| position.as_vec3()).collect(),
        normals: Some(vertices.iter().map(|(_, normal)| normal.as_vec3()).collect()),
        triangles: quads.flat_map(|a| [[a, a + 1, a + across + 2], [a, a + across + 2, a + across + 1]]).collect(),
        material: Some(0),
        ..Primitive::default()
    }
}

/// A plate of 2 x 0.4 x 2 about the origin, cut in two at x = 0: amber to the left, blue to the right, by its vertices' colours.
fn plate_of_two_colours(floor: f64) -> World {
    let half = DVec3::new(1.0, 0.2, 1.0);
    let colour = |x: f32| if x < 0.0 { AMBER } else { BLUE }.extend(1.0);
    let parts = (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]).map(|(axis, side)| {
        let w = DVec3::AXES[axis] * half * side;
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|other| DVec3::AXES[other] * half);
        let [u, v] = if side > 0.0 { [u, v] } else { [v, u] };
        let whole = grid([8, 8], move |s, t| (w + u * (2.0 * s - 1.0) + v * (2.0 * t - 1.0), w.normalize()));
        // Every triangle has its own corners, all of one colour.
        let of = |corner: &u32| whole.positions[*corner as usize];
        let middle = |face: &[u32; 3]| face.iter().map(|corner| of(corner).x).sum::<f32>();
        Primitive {
            positions: whole.triangles.iter().flatten().map(of).collect(),
            normals: Some(vec![w.normalize().as_vec3(); 3 * whole.triangles.len()]),
            colors: Some(whole.triangles.iter().flat_map(|face| [colour(middle(face)); 3]).collect()),
            triangles: (0..whole.triangles.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
            material: Some(0),
            ..Primitive::default()
        }
    });
    let mut world = glass_over(floor, parts.collect());
    world.scene.materials[0].attenuation_color = Vec3::new(0.9, 0.8, 0.7);
    world.scene.materials[0].attenuation_distance = 0.5;
    world
}

const AMBER: Vec3 = Vec3::new(0.9, 0.6, 0.1);
const BLUE: Vec3 = Vec3::new(0.1, 0.3, 0.8);

/// What goes through glass is coloured where it entered and by what it went through: in its caustic, and in its shadow where there
/// are no caustics.
#[test]
fn coloured_glass_colours_its_caustic_and_its_shadow() {
    let lamp = sun(DVec3::NEG_Y);
    let mut renderer = renderer(gpu(), plate_of_two_colours(-0.5));
    let once = passed(DVec3::NEG_Y, DVec3::Y, Ior::GLASS.eta_entering());
    let kept = DVec3::new(0.9, 0.8, 0.7).powf(0.4 / 0.5) * once * once;
    let with = request(from_above(-0.35, 0.8), 64, lamp, 128);
    for (method, caustics) in [("caustic", with.caustics), ("shadow", None)] {
        let asked = with_method(FrameRequest { caustics, ..with.clone() }, Method::Footprint);
        let seen = vectors(&picture(&mut renderer, &asked).aov.expect("asked for"), method);
        for (pixel, light) in seen.iter().enumerate() {
            let x = (pixel % 64) as f64 / 32.0 - 1.0 + 1.0 / 64.0;
            if x.abs() < 0.1 {
                continue;
            }
            let exact = kept * if x < 0.0 { AMBER } else { BLUE }.as_dvec3();
            let worst = (*light / exact - 1.0).abs().max_element();
            assert!(worst < ENERGY, "{method} at {x}: {light}, not {exact}");
        }
    }
}

/// A painted sheet that turns its back to the sun has no front whose paint could be seen: it takes the glass's own colour.
#[test]
fn a_painted_sheet_met_from_behind_lets_light_through() {
    let sheet = grid([4, 4], |u, v| (DVec3::new(2.0 * u - 1.0, 0.0, 2.0 * v - 1.0), DVec3::NEG_Y));
    let colors = Some(vec![AMBER.extend(1.0); sheet.positions.len()]);
    let mut world = glass_over(-0.3, vec![Primitive { colors, ..sheet }]);
    world.scene.materials[0].thickness = 0.0;
    let mut renderer = renderer(gpu(), world);
    let once = 1.0 - passed(DVec3::NEG_Y, DVec3::Y, Ior::GLASS.eta_entering());
    let wall = 1.0 - 2.0 * once / (1.0 + once);
    let with = request(from_above(-0.1, 0.6), 32, sun(DVec3::NEG_Y), 64);
    for (layer, caustics) in [("caustic", with.caustics), ("shadow", None)] {
        let asked = with_method(FrameRequest { caustics, ..with.clone() }, Method::Footprint);
        for light in vectors(&picture(&mut renderer, &asked).aov.expect("asked for"), layer) {
            assert!((light / wall - 1.0).abs().max_element() < ENERGY, "{layer}: {light}, not {wall}");
        }
    }
}

#[test]
fn a_plano_convex_lens_narrows_sunlight() {
    const FLOOR: f64 = -1.2;
    const RADIUS: f64 = 1.2;
    const APERTURE: f64 = 0.8;
    const RIM: f64 = 0.05;
    let to_rim = (RADIUS * RADIUS - APERTURE * APERTURE).sqrt();
    let centre = DVec3::Y * (RIM - to_rim);
    let around = |turn: f64| DVec3::new((TAU * turn).cos(), 0.0, -(TAU * turn).sin());
    let cap = grid([192, 64], |turn, v| {
        let normal = around(turn) * ((1.0 - v) * APERTURE / RADIUS);
        let normal = normal + DVec3::Y * (1.0 - normal.length_squared()).sqrt();
        (centre + RADIUS * normal, normal)
    });
    let rim = grid([192, 1], |turn, v| (around(turn) * APERTURE + DVec3::Y * RIM * v, around(turn)));
    let base = grid([192, 1], |turn, v| (around(turn) * APERTURE * v, DVec3::NEG_Y));
    let square = Square { half: 0.6, radius: 0.6 };
    let exact = square.gather(straight_down(APERTURE, |over| {
        let normal = DVec3::new(over.x, 0.0, over.y) / RADIUS;
        let normal = normal + DVec3::Y * (1.0 - normal.length_squared()).max(0.0).sqrt();
        let entry = centre + RADIUS * normal;
        let inside = snell(DVec3::NEG_Y, normal, Ior::GLASS.eta_entering()).direction;
        let exit = entry + inside * (entry.y / -inside.y);
        let whole = over.length() < APERTURE && exit.length() < APERTURE;
        let (place, part) = whole.then(|| landed(inside, exit, DVec3::NEG_Y, FLOOR))??;
        Some((place, passed(DVec3::NEG_Y, normal, Ior::GLASS.eta_entering()) * part))
    }));
    let case = Case {
        name: "plano-convex lens",
        world: glass_over(FLOOR, vec![cap, rim, base]),
        lamp: sun(DVec3::NEG_Y),
        camera: -0.6,
        square,
        exact,
    };
    judge(
        case,
        &[
            (Method::Splat, [0.029, 0.0278, 0.0275]),
            (Method::Shah, [0.137, 0.0775, 0.0137]),
            (Method::Beams, [0.019, 0.011, 0.0075]),
            (Method::Footprint, [0.013, 0.0096, 0.0069]),
        ],
    );
}

#[test]
fn a_wave_on_water_draws_lines_of_light() {
    const FLOOR: f64 = -0.7;
    const DEPTH: f64 = 0.4;
    const HEIGHT: f64 = 0.02;
    const WAVE: f64 = TAU / 0.5;
    let surface = |x: f64| {
        let normal = DVec3::new(HEIGHT * WAVE * (WAVE * x).sin(), 1.0, 0.0).normalize();
        (HEIGHT * (WAVE * x).cos(), normal)
    };
    let at = |side: f64| 2.0 * side - 1.0;
    let top = grid([512, 4], |u, v| {
        let (y, normal) = surface(at(u));
        (DVec3::new(at(u), y, -at(v)), normal)
    });
    let base = grid([4, 4], |u, v| (DVec3::new(at(u), -DEPTH, at(v)), DVec3::NEG_Y));
    let wall = |place: fn(f64) -> DVec3, normal: DVec3| {
        grid([512, 1], move |u, v| {
            let foot = place(2.0 * u - 1.0);
            (foot + DVec3::Y * (v * (surface(foot.x).0 + DEPTH) - DEPTH), normal)
        })
    };
    let walls = [
        wall(|s| DVec3::new(s, 0.0, 1.0), DVec3::Z),
        wall(|s| DVec3::new(-s, 0.0, -1.0), DVec3::NEG_Z),
        wall(|s| DVec3::new(1.0, 0.0, -s), DVec3::X),
        wall(|s| DVec3::new(-1.0, 0.0, s), DVec3::NEG_X),
    ];
    let square = Square { half: 0.6, radius: 0.6 };
    let exact = square.gather(straight_down(1.0, |over| {
        let (y, normal) = surface(over.x);
        let inside = snell(DVec3::NEG_Y, normal, Ior::GLASS.eta_entering()).direction;
        let exit = DVec3::new(over.x, y, over.y) + inside * ((y + DEPTH) / -inside.y);
        let (place, part) = landed(inside, exit, DVec3::NEG_Y, FLOOR)?;
        Some((place, passed(DVec3::NEG_Y, normal, Ior::GLASS.eta_entering()) * part))
    }));
    let case = Case {
        name: "wave",
        world: glass_over(FLOOR, [vec![top, base], walls.to_vec()].concat()),
        lamp: sun(DVec3::NEG_Y),
        camera: -0.55,
        square,
        exact,
    };
    judge(
        case,
        &[
            (Method::Splat, [0.2361, 0.1633, 0.1634]),
            (Method::Shah, [1.141, 0.402, 0.1274]),
            (Method::Beams, [0.079, 0.075, 0.075]),
            (Method::Footprint, [0.076, 0.075, 0.075]),
        ],
    );
}

/// Of the ring of gold: radius of its inner wall and half its height, metres; what it reflects at normal incidence.
const RING: (f64, f64) = (1.0, 0.18);
const GOLD: DVec3 = DVec3::new(1.0, 0.78, 0.34);

/// Where the sun's light lands that the ring's inner wall reflects, in closed form: the wall's normal at an angle says where a
/// ray goes, the next wall's angle follows from the chord, and heights fall with the way along the floor. Calls `landed` with the
/// place on the floor at the ring's foot and the flux of each of many equal parts of the wall, for sunlight of 1 lux.
fn ring_landings(direction: DVec3, landed: &mut dyn FnMut(DVec2, DVec3)) {
    const ANGLES: u32 = 16_384;
    const HEIGHTS: u32 = 1024;
    let (radius, half) = RING;
    let along = DVec2::new(direction.x, direction.z);
    // Height lost a metre of way over the floor.
    let fall = -direction.y / along.length();
    let heading = along.normalize();
    for i in 0..ANGLES {
        let (sine, cosine) = (TAU * (f64::from(i) + 0.5) / f64::from(ANGLES)).sin_cos();
        let normal = -DVec2::new(cosine, sine);
        let facing = -heading.dot(normal);
        if facing <= 0.0 {
            continue;
        }
        let flux = facing * along.length() * radius * TAU / f64::from(ANGLES) * 2.0 * half / f64::from(HEIGHTS);
        for j in 0..HEIGHTS {
            let mut height = 2.0 * half * (f64::from(j) + 0.5) / f64::from(HEIGHTS);
            // The near wall throws its shadow onto the far one.
            if height + fall * 2.0 * radius * facing < 2.0 * half {
                continue;
            }
            let (mut at, mut facing, mut normal, mut going) = (-radius * normal, facing, normal, heading);
            let mut flux = DVec3::splat(flux);
            loop {
                // The cosine in space, of Schlick's law.
                let cos = facing * along.length();
                flux *= GOLD + (1.0 - GOLD) * (1.0 - cos).powi(5);
                going -= 2.0 * going.dot(normal) * normal;
                let chord = 2.0 * radius * facing;
                if height <= fall * chord {
                    landed(at + height / fall * going, flux);
                    break;
                }
                height -= fall * chord;
                at += chord * going;
                normal = -at.normalize();
                facing = -going.dot(normal);
            }
        }
    }
}

#[test]
fn a_ring_of_gold_in_the_sun_draws_the_caustic_of_the_closed_form() {
    let direction = DVec3::new(0.8, -0.6, 0.0);
    // Clear of the wall, along which 128 beams a side cut the corners of a circle: nearer to it some of its light lies within.
    let square = Square { half: 1.0, radius: 0.95 };
    let case = Case {
        name: "ring of gold",
        exact: square.gather(|land| ring_landings(direction, land)),
        world: World { floor: Some(floor(-RING.1)), ..body(&asset("ring.glb")) },
        lamp: sun(direction),
        camera: 3.0,
        square,
    };
    // The iteration of `shah` ends on the ring, which the light sees as well as the floor, or has no end: photons arrive at too flat an
    // angle.
    judge(
        case,
        &[
            (Method::Splat, [0.274, 0.269, 0.269]),
            (Method::Beams, [0.099, 0.071, 0.061]),
            (Method::Footprint, [0.087, 0.065, 0.062]),
        ],
    );
}
