//! Photons held to closed forms and to the conservation of energy.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use murano_optics::{Ior, absorption_coefficient, analytic::BallLens, beer_lambert, fresnel_unpolarised};
use murano_reference::{
    Ball, CausticMap, Convex, Ellipsoid, GlassBody, Landing, Opaque, PhotonAccount, PhotonClass, PhotonError,
    PhotonTracing, Receiver, Shape, SurfaceData, TriangleMesh, Window, World, caustic_map, direct_irradiance,
    trace_photons,
};
use murano_scene::{Light, LightKind, PlacedLight, look_along};
use rayon::ThreadPoolBuilder;

const GLASS: f64 = 1.5;

fn quietly(_: usize, _: usize) {}

fn light(kind: LightKind, position: DVec3, direction: DVec3) -> PlacedLight {
    PlacedLight {
        world_from_light: look_along(position, direction),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity: 2.0, range: f32::INFINITY },
    }
}

fn sun(direction: DVec3) -> PlacedLight {
    light(LightKind::Directional, DVec3::ZERO, direction)
}

fn tracing(photons: u64) -> PhotonTracing {
    PhotonTracing { photons, ..PhotonTracing::default() }
}

fn ball_at(centre: DVec3, ior: f64) -> GlassBody {
    GlassBody::clear(Shape::Ellipsoid(Ellipsoid { centre, radii: DVec3::ONE }), ior)
}

fn ball(ior: f64) -> World {
    World::of_body(ball_at(DVec3::ZERO, ior))
}

fn below(distance: f64, half: f64, size: u32) -> Window {
    Window::horizontal(DVec3::NEG_Y * distance, half, size)
}

fn map_of(world: &World, light: &PlacedLight, window: Window, tracing: &PhotonTracing) -> CausticMap {
    caustic_map(world, light, window, tracing, &quietly).unwrap()
}

fn landings_of(
    world: &World,
    light: &PlacedLight,
    receiver: &Receiver,
    tracing: &PhotonTracing,
) -> (PhotonAccount, Vec<Landing>) {
    let mut landings = Vec::new();
    let mut keep = |landing: &Landing| landings.push(*landing);
    let account = trace_photons(world, light, receiver, tracing, &quietly, &mut keep).unwrap();
    (account, landings)
}

fn off(value: f64, truth: f64) -> f64 {
    (value / truth - 1.0).abs()
}

fn mean(steps: u32, f: impl Fn(f64) -> f64) -> f64 {
    (0..steps).map(|step| f((f64::from(step) + 0.5) / f64::from(steps))).sum::<f64>() / f64::from(steps)
}

/// Lamps around a ball at the origin: the sun aslant, a point, spots whose cones lie within the ball and across its outline.
fn lamps() -> [PlacedLight; 4] {
    let place = DVec3::new(0.5, 4.0, -0.3);
    let cone = LightKind::Spot { inner: 0.1, outer: 0.2 };
    [
        sun(DVec3::new(0.3, -1.0, 0.2)),
        light(LightKind::Point, place, DVec3::X),
        light(cone, place, -place),
        light(cone, place, DVec3::X - place),
    ]
}

/// Unshadowed irradiance, the mean of 8 x 8 points of each texel.
fn texel_means(lamp: &PlacedLight, window: &Window) -> Vec<DVec3> {
    const FINE: usize = 8;
    let width = window.size[0] as usize;
    let fine = Window { size: window.size.map(|side| side * FINE as u32), ..*window };
    let points = direct_irradiance(&World::default(), lamp, &fine).unwrap();
    let mut means = vec![DVec3::ZERO; window.texels()];
    for (index, point) in points.into_iter().enumerate() {
        let (x, y) = (index % (width * FINE) / FINE, index / (width * FINE) / FINE);
        means[y * width + x] += point / (FINE * FINE) as f64;
    }
    means
}

/// The inverse-square law, the cosine, the spot's cone, and that the light of the shadow is what hits the body.
#[test]
fn glass_of_index_1_leaves_the_light_as_it_is() {
    const SIZE: u32 = 48;
    let window = below(1.5, 3.0, SIZE);
    for lamp in lamps() {
        let map = map_of(&ball(1.0), &lamp, window, &tracing(1 << 18));
        let straight = map.account.arrived[PhotonClass::TwoRefractions as usize];
        assert!(off(straight.x, map.account.hit.x) < 1e-12, "{straight} of {}", map.account.hit);

        let bare = texel_means(&lamp, &window);
        let past = direct_irradiance(&ball(1.0), &lamp, &window).unwrap();
        let through = map.total();
        let side = SIZE as usize;
        // Where the shadow's edge crosses a texel, its centre does not speak for it.
        let inner = |texel: &usize| {
            let (x, y) = (texel % side, texel / side);
            (1..side - 1).contains(&x)
                && (1..side - 1).contains(&y)
                && (0..9).all(|k| {
                    let neighbour = (y + k / 3 - 1) * side + x + k % 3 - 1;
                    (past[neighbour] == DVec3::ZERO) == (past[*texel] == DVec3::ZERO)
                })
        };
        let texels: Vec<usize> = (0..window.texels()).filter(inner).collect();
        let lit: f64 = texels.iter().map(|&texel| bare[texel].x).sum();
        let shade = |texel: usize| if past[texel] == DVec3::ZERO { through[texel] } else { bare[texel] };
        let error: f64 = texels.iter().map(|&texel| (shade(texel) - bare[texel]).x.abs()).sum();
        assert!(texels.iter().all(|&texel| past[texel] == DVec3::ZERO || through[texel] == DVec3::ZERO));
        let noise = map.noise(PhotonClass::TwoRefractions).relative_l1;
        eprintln!("{:?}: relative L1 {:.4}, noise {noise:.4}", lamp.light.kind, error / lit);
        assert!(texels.len() > 1000 && noise < 0.02);
        // The noise is itself an estimate, from two halves.
        assert!(error / lit < 1.5 * noise, "{:?}: {}", lamp.light.kind, error / lit);
    }
}

#[test]
fn a_light_sends_what_its_cone_holds() {
    let falloff = |cosine: f64, inner: f64, outer: f64| {
        ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2)
    };
    let distance = lamps()[1].world_from_light.w_axis.truncate().length();
    let height = 1.0 - (1.0 - 1.0 / (distance * distance)).sqrt();
    let (inner, outer) = (f64::from(0.1_f32), f64::from(0.2_f32));
    let cone = 1.0 - outer.cos();
    let whole = |lamp: &PlacedLight, world: &World| landings_of(world, lamp, &Receiver::Opaque, &tracing(1 << 16)).0;
    let [parallel, point, within, _] = lamps();
    let account = whole(&parallel, &ball(GLASS));
    assert!(off(account.emitted.x, 2.0 * PI) < 1e-9 && account.missed.x < 1e-9);
    let account = whole(&point, &ball(GLASS));
    assert!(off(account.emitted.x, 2.0 * TAU * height) < 1e-9 && account.missed.x < 1e-9);
    let account = whole(&within, &ball(GLASS));
    let sent = 2.0 * TAU * cone * mean(20_000, |part| falloff(1.0 - cone * part, inner, outer));
    // What the places of photons within their cells leave open.
    assert!(off(account.hit.x, sent) < 1e-4, "{} of {sent}", account.hit.x);

    // From within the ball a point light shines all around; it meets no front face.
    let inside = light(LightKind::Point, DVec3::X * 0.5, DVec3::X);
    let account = whole(&inside, &ball(GLASS));
    assert!(off(account.emitted.x, 8.0 * PI) < 1e-9 && account.missed == account.emitted);
}

/// Rings about the axis under a ball in the sun.
const RINGS: usize = 50;
const WIDTH: f64 = 0.02;

/// Unpolarised at either interface, as the tracer takes it; the closed form knows that the first polarises the light.
fn unpolarised_transmittance(ball: &BallLens, height: f64) -> f64 {
    let cosine = (1.0 - height * height).max(0.0).sqrt();
    (1.0 - fresnel_unpolarised(cosine, ball.sphere.ior.eta_entering())).powi(2)
}

#[test]
fn the_irradiance_under_a_ball_is_that_of_the_closed_form() {
    for distance in [1.05, 1.5, 2.5] {
        let lens = BallLens::new(1.0, Ior::GLASS, distance);
        let receiver = Receiver::Plane(below(distance, 1e3, 1));
        let (account, landings) =
            landings_of(&ball(GLASS), &sun(DVec3::NEG_Y), &receiver, &PhotonTracing { seed: 3, ..tracing(1 << 19) });

        // Of 2 lux: what the closed form sends to the plane, and what it reflects first.
        let disc = |f: &dyn Fn(f64) -> f64| 2.0 * PI * mean(20_000, |square| f(square.sqrt()));
        let lands = |height: f64| f64::from(u8::from(lens.landing(height).is_some()));
        let sent = disc(&|height| lands(height) * unpolarised_transmittance(&lens, height));
        let arrived = account.arrived[PhotonClass::TwoRefractions as usize].x;
        assert!(off(arrived, sent) < 2e-5, "{arrived} of {sent}");
        let mirrored = disc(&|height| 1.0 - unpolarised_transmittance(&lens, height).sqrt());
        assert!(off(account.first_reflected.x, mirrored) < 2e-4, "{} of {mirrored}", account.first_reflected.x);

        let mut halves = [[0.0; RINGS]; 2];
        for landing in landings.iter().filter(|landing| landing.class == PhotonClass::TwoRefractions) {
            // The chord is symmetric: the leaving ray passes the centre as far off as the incident one.
            let height = landing.position.cross(landing.direction).length().min(1.0);
            let polarised = lens.transmittance(height) / unpolarised_transmittance(&lens, height);
            let ring = (landing.position.x.hypot(landing.position.z) / WIDTH) as usize;
            if let Some(sum) = halves[landing.half].get_mut(ring) {
                *sum += 2.0 * landing.flux.x * polarised;
            }
        }
        let (mut error, mut noise, mut total, mut smooth) = (0.0, 0.0, 0.0, 0);
        for (ring, (first, second)) in halves[0].iter().zip(&halves[1]).enumerate() {
            let inner = ring as f64 * WIDTH;
            // The irradiance is infinite on the caustic itself: there the flux is summed by heights.
            let flux = |steps: u32| {
                mean(steps, |part| TAU * (inner + part * WIDTH) * WIDTH * lens.irradiance(inner + part * WIDTH))
            };
            let within = |radius: f64| lens.flux_within(radius, 400_000);
            let exact = if off(flux(8), flux(25)) < 1e-3 {
                smooth += 1;
                2.0 * flux(25)
            } else {
                2.0 * (within(inner + WIDTH) - within(inner))
            };
            error += (0.5 * (first + second) - exact).abs();
            noise += 0.5 * (first - second).abs();
            total += exact;
        }
        eprintln!(
            "{distance} below: relative L1 {:.5}, noise {:.5}; {smooth} smooth rings",
            error / total,
            noise / total
        );
        assert!(error <= 1.5 * noise && noise < 0.005 * total, "{distance} below: relative L1 {}", error / total);
        assert!(smooth >= RINGS - 5);
    }
}

/// Every photon takes the same way through a slab: its fractions are exact.
#[test]
fn a_slab_passes_what_fresnel_and_beer_say() {
    let (thickness, theta) = (0.2, 0.7_f64);
    let theta_t = Ior::GLASS.refraction_angle(theta);
    let reflectance = fresnel_unpolarised(theta.cos(), 1.0 / GLASS);
    let tint = DVec3::new(0.9, 1.0, 0.5);
    let absorption = absorption_coefficient(DVec3::new(0.2, 0.7, 1.0), 0.5);
    let once = beer_lambert(absorption, thickness / theta_t.cos());

    let mut slab = GlassBody::clear(Shape::Convex(Convex::slab(thickness)), GLASS);
    slab.absorption = absorption;
    slab.tint = tint;
    let world = World::of_body(slab);
    let mut lamp = sun(DVec3::new(theta.sin(), -theta.cos(), 0.0));
    lamp.light.color = Vec3::new(1.0, 0.5, 0.25);
    let strength = 2.0 * lamp.light.color.as_dvec3();
    let aim = Ball { centre: DVec3::ZERO, radius: 1.5 };
    let settings = PhotonTracing { aim: Some(aim), least_weight: 1e-9, ..tracing(1 << 17) };
    let window = Window::horizontal(DVec3::new(1.0 * theta.tan(), -1.0, 0.0), 0.3, 12);
    let map = map_of(&world, &lamp, window, &settings);

    let account = &map.account;
    assert!(account.imbalance() < 1e-12 && account.missed == DVec3::ZERO && account.dropped == DVec3::ZERO);
    let closed = |value: DVec3, truth: DVec3, what: &str| {
        assert!((value / truth - 1.0).abs().max_element() < 1e-7, "{what}: {value} of {truth}");
    };
    closed(account.emitted, strength * PI * aim.radius * aim.radius, "emitted");
    closed(account.first_reflected, reflectance * account.emitted, "first reflected");
    let passed = account.emitted * (1.0 - reflectance) * tint * once * (1.0 - reflectance);
    closed(account.arrived[PhotonClass::TwoRefractions as usize], passed, "refracted twice");
    let round = (reflectance * once).powf(2.0);
    closed(account.arrived[PhotonClass::InternalReflection as usize], passed * round / (1.0 - round), "after two more");
    let up = account.emitted * (1.0 - reflectance) * tint * once * reflectance * once * (1.0 - reflectance);
    closed(account.escaped[PhotonClass::InternalReflection as usize], up / (1.0 - round), "back up");

    // Uniform, as far as photons can be.
    let even = strength * theta.cos() * passed / account.emitted;
    let error: f64 = map.class(PhotonClass::TwoRefractions).iter().map(|texel| ((*texel - even) / even).abs().x).sum();
    let noise = map.noise(PhotonClass::TwoRefractions).relative_l1;
    assert!(error / window.texels() as f64 <= 1.5 * noise && noise < 0.1, "{error}, noise {noise}");
}

fn quad(y: f64, half: f64) -> Opaque {
    let corner = |x: f64, z: f64| DVec3::new(x * half, y, z * half);
    let corners = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    let mesh = TriangleMesh::new(&corners, &[DVec3::Y; 4], &[[0, 1, 2], [0, 2, 3]]).unwrap();
    Opaque { mesh, data: SurfaceData::default() }
}

#[test]
fn opaque_things_receive_what_a_window_in_their_place_does() {
    let lamp = &lamps()[1];
    let window = below(1.5, 1.2, 8);
    let map = map_of(&ball(GLASS), lamp, window, &tracing(1 << 15));
    let floor = World { opaque: Some(quad(-1.5, 1.2)), ..ball(GLASS) };
    let (account, landings) = landings_of(&floor, lamp, &Receiver::Opaque, &tracing(1 << 15));
    assert!(account.imbalance() < 1e-12);
    assert_eq!(account.in_window, account.arrived);
    let mesh = &floor.opaque.as_ref().unwrap().mesh;
    for class in PhotonClass::ALL {
        let of_class = landings.iter().filter(|landing| landing.class == class);
        let flux: DVec3 = of_class.map(|landing| landing.flux).sum();
        let truth = map.account.in_window[class as usize];
        assert!((flux - truth).abs().max_element() <= 1e-9 * account.hit.x, "{class:?}: {flux} of {truth}");
    }
    for landing in &landings {
        let (triangle, weights) = landing.triangle.unwrap();
        let [a, b, c] = mesh.triangle(triangle as usize);
        assert!((weights.x * a + weights.y * b + weights.z * c).distance(landing.position) < 1e-12);
    }

    // Before the glass it takes all the light, behind it all that would land.
    let shade = World { opaque: Some(quad(2.0, 5.0)), ..ball(GLASS) };
    assert_eq!(map_of(&shade, lamp, window, &tracing(1 << 12)).account.hit, DVec3::ZERO);
    let roof = World { opaque: Some(quad(-1.2, 50.0)), ..ball(GLASS) };
    let account = map_of(&roof, lamp, window, &tracing(1 << 12)).account;
    let arrived: DVec3 = account.arrived.iter().sum();
    assert_eq!(account.arrived[PhotonClass::TwoRefractions as usize], DVec3::ZERO);
    assert!(
        arrived.x < 5e-3 * account.hit.x,
        "what is mirrored off the ball's flank passes the roof's edge: {arrived}"
    );
    assert!(account.imbalance() < 1e-12 && account.hit == account.emitted);
}

#[test]
fn light_takes_every_way_between_two_bodies_and_none_is_lost() {
    let bodies = vec![ball_at(DVec3::ZERO, GLASS), ball_at(DVec3::new(1.6, -1.4, 0.0), 2.4)];
    let world = World { bodies, opaque: None };
    let map = map_of(&world, &sun(DVec3::new(0.4, -1.0, 0.0)), below(3.0, 4.0, 16), &tracing(1 << 15));
    let account = &map.account;
    assert!(account.imbalance() < 1e-12 && account.missed.x > 0.0);
    for class in PhotonClass::ALL {
        assert!(account.arrived[class as usize].x > 1e-4 * account.hit.x, "{class:?}: {account:?}");
        let area = map.window.texel_area();
        let mapped: f64 = map.class(class).iter().map(|texel| texel.x * area).sum();
        assert!((mapped - account.in_window[class as usize].x).abs() < 1e-12 * account.hit.x);
    }

    let shallow = PhotonTracing { interfaces: 2, ..tracing(1 << 13) };
    let account = map_of(&world, &sun(DVec3::NEG_Y), below(3.0, 4.0, 16), &shallow).account;
    assert!(account.dropped.x > 0.0 && account.imbalance() < 1e-12);
    let coarse = PhotonTracing { least_weight: 0.1, ..tracing(1 << 13) };
    let account = map_of(&world, &sun(DVec3::NEG_Y), below(3.0, 4.0, 16), &coarse).account;
    assert!(account.pruned.x > 0.01 * account.hit.x && account.imbalance() < 1e-12);
}

#[test]
fn maps_depend_on_the_seed_and_not_on_the_threads() {
    let world = ball(GLASS);
    let map = |threads: usize, seed: u64| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = PhotonTracing { seed, ..tracing(200_000) };
        pool.install(|| map_of(&world, &lamps()[1], below(2.0, 1.5, 32), &settings))
    };
    let first = map(1, 5);
    assert!(first == map(2, 5) && first == map(3, 5), "threads change the map");
    assert!(first.irradiance != map(2, 6).irradiance, "the seed changes nothing");
}

#[test]
fn progress_ends_with_all_photons() {
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |done: usize, total: usize| seen.lock().unwrap().push((done, total));
    let window = below(2.0, 1.0, 4);
    let map = caustic_map(&ball(GLASS), &lamps()[1], window, &tracing(150_000), &progress).unwrap();
    let seen = seen.into_inner().unwrap();
    let total = map.account.photons as usize;
    assert!(total >= 150_000 && seen.last() == Some(&(total, total)));
    assert!(seen.len() > 2 && seen.is_sorted() && seen.iter().all(|(_, of)| *of == total));
}

#[test]
fn what_cannot_be_traced_is_said() {
    let window = below(2.0, 1.0, 4);
    let slab = World::of_body(GlassBody::clear(Shape::Convex(Convex::slab(1.0)), GLASS));
    let result = caustic_map(&slab, &sun(DVec3::NEG_Y), window, &tracing(16), &quietly);
    assert_eq!(result.err(), Some(PhotonError::Unbounded(0)));
    for broken in [Window { size: [0, 4], ..window }, Window { half_v: window.half_u, ..window }] {
        let result = caustic_map(&ball(GLASS), &sun(DVec3::NEG_Y), broken, &tracing(16), &quietly);
        assert_eq!(result.err(), Some(PhotonError::NoWindow));
        assert_eq!(direct_irradiance(&slab, &sun(DVec3::NEG_Y), &broken).err(), Some(PhotonError::NoWindow));
    }
    let empty = map_of(&World::default(), &sun(DVec3::NEG_Y), window, &tracing(16));
    assert_eq!(empty.account, PhotonAccount::default());
}
