//! The project's own assets, generated: optics bodies, animated glass characters, the studio environment.
//!
//! The same source gives the same bytes everywhere: no clock, no random numbers, no hash order, and only `+ - * /` and
//! square roots (sine and cosine come from [`trig`]). The files are committed; a test compares them with a fresh run.

mod character;
mod contour;
mod dance;
mod dancer;
mod glb;
mod implicit;
mod material;
mod octopus;
mod optics_bodies;
mod panes;
mod radiance_hdr;
mod remesh;
mod rig;
mod studio;
mod surface;
mod swan;
#[cfg(test)]
mod tests;
mod trig;

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::Context as _;
use glam::DVec3;
use serde_json::{Value, json};

use glb::{Document, Shape, Target};
use material::Glass;
use surface::Surface;

/// One generated file.
#[derive(Debug)]
pub struct Asset {
    /// File name inside the assets folder.
    pub name: &'static str,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Writes every asset into the folder `out`, which is made if it is missing.
///
/// # Errors
/// When the folder or a file cannot be written; the message names it.
pub fn run(out: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(out).with_context(|| format!("cannot make the assets folder {}", out.display()))?;
    for asset in generate() {
        let path = out.join(asset.name);
        std::fs::write(&path, &asset.bytes).with_context(|| format!("cannot write {}", path.display()))?;
        eprintln!("{:>9} bytes  {}", asset.bytes.len(), path.display());
    }
    Ok(())
}

/// Every asset, in the order in which they are written.
pub fn generate() -> Vec<Asset> {
    let bodies: [(&str, &str, f64, Surface); 7] = [
        ("sphere.glb", "Sphere", 2.0, optics_bodies::sphere()),
        ("ellipsoid.glb", "Ellipsoid", 1.5, optics_bodies::ellipsoid()),
        ("slab.glb", "Slab", 0.4, optics_bodies::slab()),
        ("prism.glb", "Prism", 0.6, optics_bodies::prism()),
        ("lens.glb", "Lens", 0.7, optics_bodies::lens()),
        ("torus.glb", "Torus", 0.8, optics_bodies::torus()),
        ("bumpy.glb", "Bumpy sphere", 2.0, optics_bodies::bumpy()),
    ];
    let mut assets: Vec<Asset> = bodies
        .into_iter()
        .map(|(name, title, thickness, surface)| Asset { name, bytes: body_file(title, thickness, &surface) })
        .collect();
    assets.push(Asset { name: "ring.glb", bytes: gold_file("Ring", &optics_bodies::ring()) });
    assets.push(Asset { name: "dancer.glb", bytes: dancer::dancer().to_glb() });
    assets.push(Asset { name: "octopus.glb", bytes: octopus::octopus().to_glb() });
    assets.push(Asset { name: "swan.glb", bytes: swan::swan().to_glb() });
    assets.push(Asset { name: "pool.glb", bytes: panes::pool() });
    assets.push(Asset { name: "window.glb", bytes: panes::window() });
    assets.push(Asset { name: "links.glb", bytes: chain_file() });
    assets.push(Asset { name: "studio.hdr", bytes: studio::studio_hdr() });
    assets
}

/// A file with one still body of clear glass, n = 1.5.
fn body_file(title: &str, thickness: f64, surface: &Surface) -> Vec<u8> {
    let mut document = Document::default();
    let glass = Glass { name: "Clear glass", ior: 1.5, thickness, attenuation: None };
    let material = glass.add_to(&mut document);
    finish_body(document, title, surface, material)
}

/// A file with one still body of polished gold.
fn gold_file(title: &str, surface: &Surface) -> Vec<u8> {
    let mut document = Document::default();
    let gold = json!({ "baseColorFactor": [1.0, 0.78, 0.34, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.05 });
    let material = document.push("materials", json!({ "name": "Polished gold", "pbrMetallicRoughness": gold }));
    finish_body(document, title, surface, material)
}

/// A file with three rings of coloured glass, each through the next.
fn chain_file() -> Vec<u8> {
    const RING: f64 = 0.5;
    const TUBE: f64 = 0.14;
    const APART: f64 = 0.6;
    let mut document = Document::default();
    let geometry = add_surface(&mut document, &optics_bodies::torus_of(RING, TUBE, 42, 16));
    // An eighth of a turn to either side of level, so that each leans across the next.
    let (turn_sine, turn_cosine) = (trig::sin(TAU / 16.0), trig::cos(TAU / 16.0));
    let height = RING * trig::sin(TAU / 8.0) + TUBE;
    let colours =
        [("Ruby glass", [0.95, 0.22, 0.18]), ("Honey glass", [1.0, 0.72, 0.25]), ("Cobalt glass", [0.2, 0.42, 0.95])];
    let links = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)];
    let mut nodes = Vec::new();
    for ((name, colour), (place, side)) in colours.into_iter().zip(links) {
        let glass = Glass { name, ior: 1.5, thickness: 2.0 * TUBE, attenuation: Some((colour, 2.0 * TUBE)) };
        let material = glass.add_to(&mut document);
        let mesh = add_mesh(&mut document, name, &geometry, material);
        nodes.push(document.push(
            "nodes",
            json!({
                "name": name,
                "mesh": mesh,
                "translation": [place * APART, height, 0.0],
                "rotation": [side * turn_sine, 0.0, 0.0, turn_cosine],
            }),
        ));
    }
    document.finish(&nodes)
}

fn finish_body(mut document: Document, title: &str, surface: &Surface, material: usize) -> Vec<u8> {
    let geometry = add_surface(&mut document, surface);
    let mesh = add_mesh(&mut document, title, &geometry, material);
    let node = document.push("nodes", json!({ "name": title, "mesh": mesh }));
    document.finish(&[node])
}

/// Attributes and indices of a primitive.
fn add_surface(document: &mut Document, surface: &Surface) -> Value {
    let positions = document.floats(&flatten(&surface.positions), Shape::Vec3, Some(Target::Vertices), true);
    let normals = document.floats(&flatten(&surface.normals), Shape::Vec3, Some(Target::Vertices), false);
    let indices = document.indices(&surface.triangles);
    json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices })
}

/// A mesh of one primitive.
fn add_mesh(document: &mut Document, name: &str, geometry: &Value, material: usize) -> usize {
    let mut primitive = geometry.clone();
    primitive["material"] = json!(material);
    document.push("meshes", json!({ "name": name, "primitives": [primitive] }))
}

fn flatten(vectors: &[DVec3]) -> Vec<f32> {
    vectors.iter().flat_map(|v| v.as_vec3().to_array()).collect()
}
