//! The laying down of photons alone: paths and differentials are traced in f64, the map's texels are those of an independent tracer's
//! caustics, so that what differs is what footprints make of them.

use glam::{DMat4, DVec2, DVec3, Vec3, Vec4};
use murano_animation::{Bounds, DeformedGeometry};
use murano_caustics::{Cast, Caster, Caustics, Lamp, Photons, Receivers, Surfaces, deposit, light_map_size};
use murano_gpu::{Gpu, Leaf, Work};
use murano_metrics::irradiance::IrradianceMap;
use murano_optics::fresnel_dielectric;
use murano_reference::{
    Departure, Facing, PhotonClass, PhotonTracing, Ray, Shape, Status, Window, World, caustic_map, trace_two,
};
use murano_refraction::{Glass, InterfaceMap, Interfaces, Viewpoint};
use murano_scene::{Light, LightKind, Material, PlacedLight, look_along};
use murano_scheduler::{History, Output, Plan, Skipping};
use murano_tests::bench::{ExrLayers, gpu, shared};
use murano_tests::caustics::streaks;
use murano_tests::ground_truth::{body, index, number, text, vector};
use serde_json::Value;

/// Texels along a side.
const SIZE: u32 = 256;
/// Texels of the map along a side of each of them: what is laid down in the map's finer level is shared out between those of the
/// coarser one, which here would blur it.
const FINER: u32 = 4;
/// Step over which a path is differentiated, cells of the grid.
const STEP: f64 = 1e-3;
/// Height of the view that the map is a picture of over the receiver, metres.
const ABOVE: f64 = 10.0;

/// A body under a point light, and its caustic on a plane below it.
struct Scene {
    world: World,
    ior: f64,
    lamp: PlacedLight,
    plane: f64,
    half: f64,
    /// W/m^2, by two refractions alone.
    truth: Vec<f64>,
}

impl Scene {
    /// `None` where the body is not at hand.
    fn of(entry: &Value) -> Option<Self> {
        let ior = number(&entry["ior"]);
        let place = vector(&entry["pos"]);
        let light = Light {
            name: String::new(),
            kind: LightKind::Point,
            color: Vec3::ONE,
            intensity: number(&entry["intensity_cd"]) as f32,
            range: f32::INFINITY,
        };
        let layers = ExrLayers::read(&shared(&format!("reference/{}", text(&entry["file"])))?);
        let world = body(text(&entry["mesh"]), ior)?;
        let lamp = PlacedLight { world_from_light: look_along(place, -place), light };
        let (plane, half) = (number(&entry["plane_y"]), number(&entry["half"]));
        // The layer holds what left after two refractions and was then mirrored off the body's outside: a percent at most.
        let window = Window::horizontal(DVec3::Y * plane, half, SIZE);
        let tracing = PhotonTracing { photons: 2_000_000, ..PhotonTracing::default() };
        let map = caustic_map(&world, &lamp, window, &tracing, &|_, _| {}).expect("a caustic");
        let mirrored = map.class(PhotonClass::OutsideReflection).iter().map(|irradiance| irradiance.x);
        let truth = layers.channel("E_TT.V").iter().zip(mirrored).map(|(all, part)| f64::from(*all) - part).collect();
        Some(Self { world, ior, lamp, plane, half, truth })
    }

    fn mesh(&self) -> &murano_reference::TriangleMesh {
        match &self.world.bodies[0].shape {
            Shape::Mesh(mesh) => mesh,
            _ => panic!("a mesh was loaded"),
        }
    }

    /// What the lamp sees of the body, drawn in around its corners, and the box around it.
    fn seen(&self, photons: u32) -> (Viewpoint, Bounds) {
        let corners = || (0..self.mesh().len()).flat_map(|index| self.mesh().triangle(index));
        let bounds = Bounds::of(corners());
        let place = self.lamp.world_from_light.w_axis.truncate();
        let world_from_view = look_along(place, bounds.center() - place);
        let view_from_world = world_from_view.inverse();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners() {
            let p = view_from_world.transform_point3(corner);
            (low, high) = (low.min(p.truncate() / -p.z), high.max(p.truncate() / -p.z));
        }
        let viewpoint = Viewpoint {
            world_from_view,
            perspective: true,
            half_extent: 0.5 * (high - low),
            center: 0.5 * (low + high),
            size: [light_map_size(photons); 2],
            near: 1e-3,
        };
        (viewpoint, bounds)
    }

    /// Where light through a point of the lamp's image plane enters and leaves the body, in which direction, and what part of it; `None`
    /// unless it is refracted in and out and meets the body no more.
    fn path(&self, viewpoint: &Viewpoint, plane: DVec2) -> Option<[DVec3; 4]> {
        let origin = viewpoint.world_from_view.w_axis.truncate();
        let direction = viewpoint.world_from_view.transform_vector3(plane.extend(-1.0)).normalize();
        let path = trace_two(&self.world, &Ray { origin, direction });
        if path.status != Status::Left {
            return None;
        }
        let out = Ray { origin: path.p2 + 1e-6 * path.exit, direction: path.exit };
        if self.mesh().nearest(&out, Departure::Free, Some(Facing::Front), f64::INFINITY).is_some() {
            return None;
        }
        let passed = |incident: DVec3, normal: DVec3, eta: f64| {
            let [s, p] = fresnel_dielectric(incident.dot(normal).abs(), eta).into();
            1.0 - 0.5 * (s + p)
        };
        let part = passed(direction, path.n1, 1.0 / self.ior) * passed(path.t1, path.n2, self.ior);
        Some([path.p1, path.p2, path.exit, DVec3::splat(part)])
    }

    /// Photons and their differentials as shaders read them, a cell of the grid each, and the flux that comes down within the window
    /// for a lamp of intensity 1.
    fn photons(&self, viewpoint: &Viewpoint, photons: u32) -> (Vec<Vec4>, Vec<Vec4>, f64) {
        let count = (photons * photons) as usize;
        let (mut rays, mut differentials) = (vec![Vec4::ZERO; 2 * count], vec![Vec4::ZERO; 6 * count]);
        let cell = 2.0 * viewpoint.half_extent / f64::from(photons);
        let corner = viewpoint.center + viewpoint.half_extent * DVec2::new(-1.0, 1.0);
        let mut within = 0.0;
        for index in 0..count {
            let (x, y) = (index as u32 % photons, index as u32 / photons);
            let steps = DVec2::new(f64::from(x) + 0.5, -(f64::from(y) + 0.5));
            let plane = corner + steps * cell;
            let Some([entry, exit, direction, part]) = self.path(viewpoint, plane) else { continue };
            let cosine = 1.0 / plane.extend(1.0).length();
            let flux = cell.x * cell.y * cosine.powi(3) * part.x;
            rays[2 * index] = exit.as_vec3().extend(flux as f32);
            rays[2 * index + 1] = direction.as_vec3().extend(0.0);
            let depth = viewpoint.world_from_view.inverse().transform_point3(entry).z.abs();
            differentials[6 * index] = entry.as_vec3().extend((cell.x * depth) as f32);
            for (side, step) in [(0, DVec2::X), (1, DVec2::NEG_Y)] {
                let moved = |by: f64| self.path(viewpoint, plane + by * step * cell).map(|to| (to, by));
                let Some((to, by)) = moved(STEP).or_else(|| moved(-STEP)) else { continue };
                differentials[6 * index + 2 + side] = ((to[1] - exit) / by).as_vec3().extend(0.0);
                differentials[6 * index + 4 + side] = ((to[2] - direction) / by).as_vec3().extend(0.0);
            }
            let landing = exit + direction * ((self.plane - exit.y) / direction.y);
            if direction.y < 0.0 && landing.x.abs().max(landing.z.abs()) < self.half {
                within += flux;
            }
        }
        (rays, differentials, within)
    }

    /// Watts a texel of the window for a lamp of intensity 1, as the GPU lays them down.
    fn laid(
        &self,
        gpu: &Gpu,
        viewpoint: Viewpoint,
        bounds: &Bounds,
        rays: &[Vec4],
        differentials: &[Vec4],
    ) -> Vec<f64> {
        let photons = ((rays.len() / 2) as f64).sqrt() as u32;
        let mut plan = Plan::new();
        let mut leaf = |name, rows: &[Vec4]| {
            let (stamp, leaf) = Leaf::of(rows);
            plan.leaf(name, stamp, Work::Leaf(leaf))
        };
        let (rays, differentials) = (leaf("rays", rays), leaf("differentials", differentials));
        // Nothing is known of where light enters, so that nothing shades it.
        let front = leaf("front", &vec![Vec4::ZERO; (light_map_size(photons) as usize).pow(2)]);
        // Level, as deep everywhere.
        let receivers =
            leaf("receivers", &vec![Vec4::new(0.0, 0.0, 1.0, ABOVE as f32); (FINER * SIZE).pow(2) as usize]);
        let mut lamp = Lamp::new(&self.lamp, bounds, bounds, FINER * SIZE);
        lamp.receivers = Viewpoint {
            world_from_view: DMat4::from_cols(
                DVec3::X.extend(0.0),
                DVec3::NEG_Z.extend(0.0),
                DVec3::Y.extend(0.0),
                (DVec3::Y * (self.plane + ABOVE)).extend(1.0),
            ),
            perspective: false,
            half_extent: DVec2::splat(self.half),
            center: DVec2::ZERO,
            size: [FINER * SIZE; 2],
            near: 1e-3,
        };
        let cast = Cast {
            instance: 0,
            lamp: &lamp,
            viewpoint: &viewpoint.in_frame(DVec3::ZERO),
            map: &nothing_mapped(front),
            bounds,
            caster: &Caster::Glass(Glass::of(&Material::glass(self.ior))),
            surface: None,
            shielded: None,
            bends: false,
            faceted: false,
        };
        let caustics = Caustics { photons, map_size: FINER * SIZE, interfaces: Interfaces::Two, ..Caustics::default() };
        let photons = Photons::followed_elsewhere(rays, Some(differentials));
        let map = deposit(
            gpu,
            &mut plan,
            &cast,
            &caustics,
            photons,
            (&Receivers { seen: receivers, hidden: None }, Surfaces::Seen),
            4.0 * ABOVE,
        )
        .expect("a caustic map");
        let executed = gpu.execute(&plan, &[map.flux], &mut History::new(), Skipping::Off).expect("a caustic map");
        assert!(map.monochrome, "clear glass colours nothing");
        let texel = |bytes: &[u8]| f64::from(f32::from_le_bytes(bytes[..4].try_into().expect("a number")));
        let fine = executed.targets[0].chunks_exact(4).take((FINER * SIZE).pow(2) as usize).map(texel).collect();
        // Watts a texel are means here, to be summed.
        let fine = IrradianceMap::new([FINER * SIZE; 2], 1.0, fine).expect("a map");
        let part = f64::from(FINER * FINER);
        fine.downsampled(FINER).expect("whole texels").values().iter().map(|watts| part * watts).collect()
    }
}

/// Where photons are given, nobody looks for them.
fn nothing_mapped(any: Output) -> InterfaceMap {
    InterfaceMap {
        front: any,
        back: None,
        depth_range: None,
        layer_lists: None,
        thickness: None,
        front_triangles: None,
        tree: None,
        relief: None,
        media: None,
        geometry: DeformedGeometry {
            positions: any,
            normals: any,
            tangents: None,
            triangles: any,
            neighbours: any,
            vertex_count: 0,
            triangle_count: 0,
        },
    }
}

/// The most relative L1 at 128, 256 and 512 photons a side.
fn limits(mesh: &str) -> Option<[f64; 3]> {
    match mesh {
        "bumpy20k.glb" => Some([0.047, 0.0225, 0.014]),
        "bunny_69k.glb" => Some([0.16, 0.075, 0.035]),
        _ => None,
    }
}

#[test]
fn footprints_of_exact_paths_reach_the_truth() {
    let Some(index) = index() else { return };
    let gpu = gpu();
    for entry in index["caustics"].as_array().expect("a list").iter().filter(|entry| text(&entry["light"]) == "point") {
        let Some(most) = limits(text(&entry["mesh"])) else { continue };
        let Some(scene) = Scene::of(entry) else { continue };
        let texel = (2.0 * scene.half / f64::from(SIZE)).powi(2);
        let strength = f64::from(scene.lamp.light.intensity);
        let total = scene.truth.iter().sum::<f64>() * texel;
        for (photons, most) in [128, 256, 512].into_iter().zip(most) {
            let (viewpoint, bounds) = scene.seen(photons);
            let (rays, differentials, within) = scene.photons(&viewpoint, photons);
            let laid = scene.laid(&gpu, viewpoint, &bounds, &rays, &differentials);
            let ours: Vec<f64> = laid.iter().map(|watts| strength * watts / texel).collect();
            let error = ours.iter().zip(&scene.truth).map(|(a, b)| (a - b).abs()).sum::<f64>() * texel / total;
            let kept = laid.iter().sum::<f64>() / within;
            let streaks = streaks(&ours, &scene.truth, SIZE as usize);
            let mesh = text(&entry["mesh"]);
            eprintln!(
                "{mesh}, {photons}^2: relative L1 {error:.4}; {kept:.5} of the photons' light, {:.4} of the truth's; streaks \
                 {streaks:.5}",
                strength * within / total
            );
            assert!(error <= most, "{mesh}, {photons}^2: {error} > {most}");
            assert!((kept - 1.0).abs() <= 0.005, "{mesh}, {photons}^2: {kept} of the light");
            assert!(streaks <= 0.005, "{mesh}, {photons}^2: {streaks} of the flux in streaks");
        }
    }
}
