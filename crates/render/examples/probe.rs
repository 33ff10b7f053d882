//! probe
use glam::DVec3;
use murano_gpu::{AdapterChoice, Gpu};
use murano_render::*;
use murano_scene::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut scene = import(std::path::Path::new(&args[1])).unwrap();
    let out = &args[2];
    let size: u32 = args[3].parse().unwrap();
    let method: murano_refraction::Method = args[4].parse().unwrap();
    for m in &mut scene.materials { m.transmission = 1.0; m.base_color = glam::Vec4::ONE; m.ior = 1.5; m.metallic=0.0; m.base_color_texture=None; }
    if scene.materials.is_empty() { scene.materials.push(Material::glass(1.5)); for m in &mut scene.meshes { for p in &mut m.primitives { p.material = Some(0);} } }
    let pose = murano_animation::Pose::sample(&scene, Some(0).filter(|_| !scene.clips.is_empty()), 0.3);
    let g = murano_animation::Geometry::build(&scene, &murano_animation::shown_primitives(&scene)).unwrap();
    let b = g.posed_bounds(&pose);
    let r = 0.5 * b.diameter();
    let c = b.center();
    let env = Environment::load(std::path::Path::new("assets/studio.hdr")).ok();
    let clip = if scene.clips.is_empty() { None } else { Some(0) };
    let world = World { scene, environment: env, floor: Some(Floor { height: b.min.y, center: [c.x, c.z], half_extent: 12.0 * r, albedo: [0.6; 3] }) };
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
    println!("{}", gpu.adapter_name());
    let mut renderer = Renderer::new(gpu, world).unwrap();
    let eye = c + DVec3::new(0.5, 0.35, 1.0).normalize() * r * 3.6;
    let lamp = c + DVec3::new(-0.8, 1.3, -0.5).normalize() * r * 5.0;
    let light = PlacedLight { world_from_light: look_along(lamp, c - lamp), light: Light { name: String::new(), kind: LightKind::Spot { inner: 0.4, outer: 0.5 }, color: glam::Vec3::ONE, intensity: (3.14 * 25.0 * r * r) as f32, range: f32::INFINITY } };
    let mut request = FrameRequest { clip, time: 0.3, size: [size, size], view: View::look_at(eye, c, 0.6), lights: vec![light],
        refraction: murano_refraction::Refraction { method, ..Default::default() }, caustics: Some(Default::default()), exposure: 1.0, tone_map: ToneMap::Neutral, aov: false, skipping: Skipping::On };
    for i in 0..4 {
        if i == 2 { request.skipping = Skipping::Off; }
        if i == 3 { request.skipping = Skipping::Verify; }
        let f = renderer.render(&request).unwrap();
        println!("frame {i}: cpu {:.1} ms gpu {:.1} ms cache {} MB", f.cpu_ms, f.gpu_ms, f.cache_bytes >> 20);
        if i != 1 { for p in &f.passes { println!("  {:16} {:8} {:30} {:?}", p.name, p.decision, p.reason, p.gpu_ms); } }
        image::save_buffer(out, &f.rgba, size, size, image::ColorType::Rgba8).unwrap();
    }
    for a in renderer.caustic_accounts(&request).unwrap() { println!("sent {} landed {}", a.sent, a.landed); }
}
