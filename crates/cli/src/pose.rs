//! `murano pose`: the deformed body of one moment, as vertices in world space.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use glam::DVec3;
use murano_animation::{Bounds, Deformed, Geometry, Layer, Pose, clip_time, deform_f64, shown_primitives, write_ply};
use murano_render::{Renderer, World, find_clip};
use murano_scene::{ClipChoice, LoopMode, Property, Scene, Skinning};
use serde_json::json;

use crate::{
    export::{prepare_folder, write_whole},
    options::AdapterOption,
    terminal::{say, say_json},
    values,
};

/// Writes the deformed vertices of one moment as PLY, and says how far the GPU is from the f64 path
#[derive(Args)]
#[command(after_help = "Example:\n  murano pose assets/dancer.glb --clip 0 --time 0.5 -o out/dancer.ply")]
pub struct Arguments {
    /// A model (.glb, .gltf)
    file: PathBuf,
    /// Clip; the first one unless said otherwise
    #[arg(long, value_name = "NAME|INDEX", value_parser = values::clip())]
    clip: Option<ClipChoice>,
    /// Time in the clip, seconds; outside of it the clip repeats
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true, default_value = "0")]
    time: f64,
    /// How joints are blended that move a vertex together: linear, dual-quaternion
    #[arg(long, value_name = "WAY", value_parser = values::skinning, default_value = "linear")]
    skinning: Skinning,
    /// The file: binary PLY, world space, metres
    #[arg(short, long, value_name = "FILE.ply")]
    output: Option<PathBuf>,
    /// Write the vertices of the f64 path instead of the GPU's
    #[arg(long)]
    cpu: bool,
    /// One line of JSON on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    adapter: AdapterOption,
}

/// How far the GPU is from the f64 path.
struct Difference {
    adapter: String,
    /// Largest distance of two vertices, metres.
    metres: f64,
    /// The same over the body's diameter.
    relative: f64,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut scene = murano_scene::import(&arguments.file)?;
    let clip = find_clip(&scene, arguments.clip.as_ref().unwrap_or(&ClipChoice::First), &arguments.file)?;
    if let Some(output) = &arguments.output {
        prepare_folder(output)?;
    }
    scene.skinning = arguments.skinning;
    // The renderer keeps glass bodies apart. Without glass it has one geometry, with its vertices in the file's order.
    as_one_body(&mut scene);
    let geometry = Geometry::build(&scene, &shown_primitives(&scene))?;
    let duration = clip.map_or(0.0, |clip| scene.clips[clip].duration);
    let playing = Layer::alone(clip, clip_time(LoopMode::Loop, arguments.time, duration));
    let pose = Pose::sample(&scene, &playing);
    let truth = deform_f64(&geometry, &scene, &pose);
    let triangles = geometry.oriented_triangles(&pose);

    let (body, difference) = match arguments.deform_on_gpu(scene, &playing) {
        Ok((body, adapter)) => {
            let difference = compare(&body.positions, &truth, adapter)?;
            (if arguments.cpu { truth } else { body }, Some(difference))
        }
        // The f64 path needs no adapter.
        Err(error) if arguments.cpu => {
            eprintln!("not compared with the GPU: {error:#}");
            (truth, None)
        }
        Err(error) => return Err(error),
    };
    if let Some(output) = &arguments.output {
        write_whole(output, |file| Ok(write_ply(file, &body.positions, &body.normals, &triangles)?))?;
    }
    arguments.report(body.positions.len(), triangles.len(), difference.as_ref())
}

/// Makes everything opaque, at all times, so that the renderer keeps it as one geometry.
pub fn as_one_body(scene: &mut Scene) {
    scene.materials.iter_mut().for_each(|material| material.transmission = 0.0);
    for clip in &mut scene.clips {
        clip.properties.retain(|channel| matches!(channel.property, Property::Weight(..)));
    }
}

impl Arguments {
    /// Every vertex as the GPU deforms it, and the adapter that did.
    fn deform_on_gpu(&self, scene: Scene, playing: &[Layer]) -> Result<(Deformed, String)> {
        let gpu = self.adapter.open()?;
        let adapter = gpu.adapter_name();
        let mut renderer = Renderer::new(gpu, World { scene, environment: None, floor: None })?;
        let mut body = Deformed::default();
        for mesh in renderer.deform(playing)? {
            body.positions.extend(mesh.positions);
            body.normals.extend(mesh.normals);
        }
        Ok((body, adapter))
    }

    fn report(&self, vertices: usize, triangles: usize, difference: Option<&Difference>) -> Result<()> {
        if self.json {
            return say_json(&json!({
                "file": self.file,
                "time": self.time,
                "vertices": vertices,
                "triangles": triangles,
                "adapter": difference.map(|difference| &difference.adapter),
                "max_difference": difference.map(|difference| difference.metres),
                "max_difference_over_diameter": difference.map(|difference| difference.relative),
            }));
        }
        say(format!("{vertices} vertices, {triangles} triangles"))?;
        if let Some(Difference { adapter, metres, relative }) = difference {
            say(format!(
                "largest difference of {adapter} to f64: {metres:.3e} m, {relative:.3e} of the body's diameter"
            ))?;
        }
        Ok(())
    }
}

/// The largest distance between vertices of the same place in the order.
fn compare(positions: &[DVec3], truth: &Deformed, adapter: String) -> Result<Difference> {
    if positions.len() != truth.positions.len() {
        bail!("the GPU deformed {} vertices, the f64 path {}", positions.len(), truth.positions.len());
    }
    let distances = positions.iter().zip(&truth.positions).map(|(a, b)| a.distance(*b));
    // A distance that is no number is as bad as can be, and `f64::max` would pass over it.
    let metres = distances.map(|d| if d.is_nan() { f64::INFINITY } else { d }).fold(0.0, f64::max);
    Ok(Difference { adapter, metres, relative: metres / diameter(truth) })
}

/// The longest side of the box around the body, which is never longer than its diameter; 1 for a single point.
fn diameter(body: &Deformed) -> f64 {
    let Bounds { min, max } = body.bounds();
    let side = (max - min).max_element();
    if side > 0.0 { side } else { 1.0 }
}
