//! `murano inspect`: what a model file holds.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use murano_scene::{Clip, Image, Material, Mesh, Node, Scene};
use serde_json::{Value, json};

use crate::terminal::{say, say_json};

/// Lists nodes, meshes, joints, targets, clips, materials, variants, extensions and warnings of a model
#[derive(Args)]
#[command(after_help = "Example:\n  murano inspect assets/dancer.glb")]
pub struct Arguments {
    /// A model (.glb, .gltf)
    file: PathBuf,
    /// One line of JSON on stdout
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let scene = murano_scene::import(&arguments.file)?;
    if arguments.json { say_json(&as_json(&arguments.file, &scene)) } else { say(as_text(&scene)) }
}

fn as_json(file: &std::path::Path, scene: &Scene) -> Value {
    json!({
        "file": file,
        "nodes": scene.nodes.iter().map(node_json).collect::<Vec<_>>(),
        "roots": scene.roots,
        "meshes": scene.meshes.iter().map(mesh_json).collect::<Vec<_>>(),
        "skins": scene.skins.iter().map(|skin| json!({ "name": skin.name, "joints": skin.joints.len() })).collect::<Vec<_>>(),
        "clips": scene.clips.iter().map(clip_json).collect::<Vec<_>>(),
        "materials": scene.materials.iter().map(material_json).collect::<Vec<_>>(),
        "variants": scene.variants,
        "cameras": scene.cameras.iter().map(|camera| &camera.name).collect::<Vec<_>>(),
        "lights": scene.lights.iter().map(|light| &light.name).collect::<Vec<_>>(),
        "images": scene.images.iter()
            .map(|image| json!({ "name": image.name, "width": image.width, "height": image.height }))
            .collect::<Vec<_>>(),
        "extensions_used": scene.report.extensions_used,
        "extensions_required": scene.report.extensions_required,
        "extensions_ignored": scene.report.extensions_ignored,
        "warnings": scene.report.warnings,
    })
}

fn node_json(node: &Node) -> Value {
    json!({
        "name": node.name,
        "parent": node.parent,
        "mesh": node.mesh,
        "skin": node.skin,
        "camera": node.camera,
        "light": node.light,
    })
}

fn mesh_json(mesh: &Mesh) -> Value {
    json!({
        "name": mesh.name,
        "primitives": mesh.primitives.len(),
        "vertices": vertices(mesh),
        "triangles": triangles(mesh),
        "targets": targets(mesh),
        "joint_sets": joint_sets(mesh),
    })
}

fn clip_json(clip: &Clip) -> Value {
    json!({ "name": clip.name, "duration": clip.duration, "channels": clip.channels.len(), "properties": clip.properties.len() })
}

fn material_json(material: &Material) -> Value {
    json!({
        "name": material.name,
        "glass": material.is_glass(),
        "transmission": material.transmission,
        "ior": material.ior,
        "attenuation_color": material.attenuation_color.to_array(),
        // JSON has no infinity: clear glass has no distance.
        "attenuation_distance": Some(material.attenuation_distance).filter(|distance| distance.is_finite()),
        "dispersion": material.dispersion,
        "metallic": material.metallic,
        "roughness": material.roughness,
    })
}

fn vertices(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.positions.len()).sum()
}

fn triangles(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.triangles.len()).sum()
}

fn targets(mesh: &Mesh) -> usize {
    mesh.primitives.first().map_or(0, |primitive| primitive.targets.len())
}

fn joint_sets(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.joints.len()).max().unwrap_or(0)
}

fn as_text(scene: &Scene) -> String {
    let lines_of = |images: &[Image]| {
        images.iter().map(|image| format!("{}: {}x{}", named(&image.name), image.width, image.height)).collect()
    };
    let sections: [(&str, Vec<String>); 12] = [
        ("Nodes", node_lines(scene)),
        ("Meshes", scene.meshes.iter().map(mesh_line).collect()),
        (
            "Skins",
            scene.skins.iter().map(|skin| format!("{}: {} joints", named(&skin.name), skin.joints.len())).collect(),
        ),
        ("Clips", scene.clips.iter().map(clip_line).collect()),
        ("Materials", scene.materials.iter().map(material_line).collect()),
        ("Material variants", scene.variants.clone()),
        ("Cameras", scene.cameras.iter().map(|camera| named(&camera.name).to_owned()).collect()),
        ("Lights", scene.lights.iter().map(|light| format!("{}: {:?}", named(&light.name), light.kind)).collect()),
        ("Images", lines_of(&scene.images)),
        ("Extensions used", scene.report.extensions_used.clone()),
        ("Extensions ignored", scene.report.extensions_ignored.clone()),
        ("Warnings", scene.report.warnings.clone()),
    ];
    let filled = sections.into_iter().filter(|(_, lines)| !lines.is_empty());
    let printed = filled.flat_map(|(title, lines)| {
        let heading = format!("{title} ({})", lines.len());
        let numbered = lines.into_iter().enumerate().map(|(index, line)| format!("  {index:>3}  {line}"));
        std::iter::once(heading).chain(numbered)
    });
    printed.collect::<Vec<_>>().join("\n")
}

fn named(name: &str) -> &str {
    if name.is_empty() { "(unnamed)" } else { name }
}

/// The hierarchy of what is shown, indented.
fn node_lines(scene: &Scene) -> Vec<String> {
    let mut depths = vec![0_usize; scene.nodes.len()];
    let line = |index: usize| {
        let node = &scene.nodes[index];
        depths[index] = node.parent.map_or(0, |parent| depths[parent] + 1);
        let parts = [("mesh", node.mesh), ("skin", node.skin), ("camera", node.camera), ("light", node.light)];
        let carried = parts.into_iter().filter_map(|(what, index)| Some(format!("  {what} {}", index?)));
        format!("{}{}{}", "  ".repeat(depths[index]), named(&node.name), carried.collect::<String>())
    };
    scene.traversal().into_iter().map(line).collect()
}

fn mesh_line(mesh: &Mesh) -> String {
    let mut parts = vec![
        format!("{} primitives", mesh.primitives.len()),
        format!("{} vertices", vertices(mesh)),
        format!("{} triangles", triangles(mesh)),
    ];
    if joint_sets(mesh) > 0 {
        parts.push(format!("{} joint sets", joint_sets(mesh)));
    }
    if targets(mesh) > 0 {
        parts.push(format!("{} morph targets", targets(mesh)));
    }
    format!("{}: {}", named(&mesh.name), parts.join(", "))
}

fn clip_line(clip: &Clip) -> String {
    let properties = match clip.properties.len() {
        0 => String::new(),
        count => format!(", {count} of materials, lights, cameras or single weights"),
    };
    format!("{}: {:.3} s, {} channels of nodes{properties}", named(&clip.name), clip.duration, clip.channels.len())
}

fn material_line(material: &Material) -> String {
    let name = named(&material.name);
    if !material.is_glass() {
        return format!("{name}: metallic {}, roughness {}", material.metallic, material.roughness);
    }
    let [r, g, b] = material.attenuation_color.to_array();
    let absorption = if material.attenuation_distance.is_finite() {
        format!(", white turns into ({r}, {g}, {b}) after {} m", material.attenuation_distance)
    } else {
        String::new()
    };
    format!("{name}: glass, n = {}, transmission {}{absorption}", material.ior, material.transmission)
}
