//! A case rendered by a method and held against its truth.

use anyhow::{Result, anyhow};
use glam::DVec3;
use murano_animation::{Geometry, Pose, shown_primitives};
use murano_caustics::{Caustics, Method as CausticsMethod};
use murano_gpu::{Gpu, GpuError};
use murano_refraction::{Interfaces, Method, Refraction};
use murano_render::{Aov, Floor, Frame, FrameRequest, RenderError, Renderer, Skipping, ToneMap, World};
use murano_scene::{Environment, Scene};

use super::{
    case::Case,
    truth::{Answers, Expected},
};

/// Photons and texels a side of the small caustics.
const CAUSTICS: Caustics =
    Caustics { method: CausticsMethod::Footprint, photons: 40, map_size: 96, interfaces: Interfaces::All };

/// What one picture of one method came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub label: String,
    /// Pictures rendered: one, or two with the one under lamps.
    pub pictures: u32,
    /// Numbers in outputs of passes that are NaN or infinite, up to the first pass that wrote one.
    pub non_finite: u64,
    /// Which pass wrote them.
    pub finding: Option<String>,
    /// Pixels by status: none, left, totally reflected, flagged.
    pub statuses: [u64; 4],
    /// Angles between exit directions, degrees, sorted.
    pub degrees: Vec<f64>,
    /// Pixels inside the true silhouette with a known answer.
    pub compared: u64,
    /// Of these, pixels of another status that do not say so.
    pub wrong: u64,
    /// Of these, pixels that are flagged without need.
    pub flagged: u64,
}

impl Outcome {
    /// Mean error, degrees; 0 if nothing was compared.
    pub fn mean_degrees(&self) -> f64 {
        self.degrees.iter().sum::<f64>() / self.degrees.len().max(1) as f64
    }

    /// An error that this share of the pixels does not exceed, degrees.
    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.degrees.len().saturating_sub(1);
        self.degrees.get((last as f64 * share).round() as usize).copied().unwrap_or(0.0)
    }

    /// Share of compared pixels that are wrong without saying so.
    pub fn wrong_share(&self) -> f64 {
        self.wrong as f64 / self.compared.max(1) as f64
    }

    /// Share of compared pixels that are flagged without need.
    pub fn flagged_share(&self) -> f64 {
        self.flagged as f64 / self.compared.max(1) as f64
    }
}

/// Renders a case with every method. Takes the device and gives it back.
pub fn measure(mut gpu: Gpu, case: &Case) -> Result<(Gpu, Vec<(Method, Outcome)>)> {
    let answers = Answers::traced(case)?;
    let mut outcomes: Vec<(Method, Outcome)> =
        Method::ALL.map(|method| (method, Outcome { label: case.label.clone(), ..Outcome::default() })).to_vec();
    let mut renderer = Renderer::new(gpu, world(case.scene.clone(), None))?;
    for (method, outcome) in &mut outcomes {
        if let Some(frame) = render(&mut renderer, &request(case, *method), outcome)? {
            let aov = frame.aov.ok_or_else(|| anyhow!("the frame has no layers"))?;
            outcome.compare(&aov, answers.as_ref().map(|answers| (answers.of(*method), answers.inner.as_slice())))?;
        }
    }
    gpu = renderer.into_gpu();
    if !case.lamps.is_empty() {
        let mut renderer = Renderer::new(gpu, world(case.scene.clone(), Some(floor(case)?)))?;
        for (method, outcome) in &mut outcomes {
            let lamps = case.lamps.clone();
            let request = FrameRequest { lights: lamps, caustics: Some(CAUSTICS), ..request(case, *method) };
            render(&mut renderer, &request, outcome)?;
        }
        gpu = renderer.into_gpu();
    }
    Ok((gpu, outcomes))
}

/// A picture, or `None` and a finding if a pass wrote what is no number.
fn render(renderer: &mut Renderer, request: &FrameRequest, outcome: &mut Outcome) -> Result<Option<Frame>> {
    outcome.pictures += 1;
    match renderer.render(request) {
        Ok(frame) => Ok(Some(frame)),
        Err(RenderError::Gpu(GpuError::NonFinite(found))) => {
            outcome.non_finite += u64::from(found.count);
            outcome.finding.get_or_insert(found.to_string());
            Ok(None)
        }
        Err(error) => Err(anyhow!(error).context(format!("{}, method {}", outcome.label, request.refraction.method))),
    }
}

impl Outcome {
    fn compare(&mut self, aov: &Aov, answers: Option<(&[Expected], &[bool])>) -> Result<()> {
        let statuses: Vec<usize> = plane(aov, "status", 0)?.iter().map(|status| (*status as usize).min(3)).collect();
        for &status in &statuses {
            self.statuses[status] += 1;
        }
        let Some((expected, inner)) = answers else { return Ok(()) };
        let exits = [0, 1, 2].map(|channel| plane(aov, "exit_direction", channel));
        let [x, y, z] = exits;
        let (x, y, z) = (x?, y?, z?);
        for (pixel, (&status, expected)) in statuses.iter().zip(expected).enumerate() {
            if !inner[pixel] || *expected == Expected::Unknown {
                continue;
            }
            self.compared += 1;
            match (expected, status) {
                (Expected::Leaves(truth), 1) => {
                    let exit = DVec3::new(x[pixel].into(), y[pixel].into(), z[pixel].into());
                    self.degrees.push(degrees_between(exit, *truth));
                }
                (Expected::Nothing, 0) | (Expected::Reflected, 2) | (Expected::Flagged, 3) => {}
                (_, 3) => self.flagged += 1,
                _ => self.wrong += 1,
            }
        }
        self.degrees.sort_by(f64::total_cmp);
        Ok(())
    }
}

fn plane<'a>(aov: &'a Aov, name: &str, channel: usize) -> Result<&'a [f32]> {
    let layer = aov.layers.iter().find(|layer| layer.name == name);
    let plane = layer.and_then(|layer| layer.planes.get(channel));
    plane.map(Vec::as_slice).ok_or_else(|| anyhow!("the frame has no layer `{name}`"))
}

/// Exact for small angles too.
fn degrees_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// A scene under a small sky without symmetry.
pub fn world(scene: Scene, floor: Option<Floor>) -> World {
    let (width, height) = (16, 8);
    let texel = |i: u32| [0.1 * (i % 7) as f32, 0.3, 0.05 * (i % 11) as f32];
    let sky = Environment { width, height, pixels: (0..width * height).map(texel).collect() };
    World { scene, environment: Some(sky), floor }
}

/// A floor under a case's body, as far below as the body is large.
fn floor(case: &Case) -> Result<Floor> {
    let pose = Pose::sample(&case.scene, &case.playing());
    let bounds = Geometry::build(&case.scene, &shown_primitives(&case.scene))?.posed_bounds(&pose);
    let center = bounds.center();
    let half_extent = 20.0 * bounds.diameter().max(1e-9);
    Ok(Floor { height: bounds.min.y, center: [center.x, center.z], half_extent, albedo: [0.5; 3] })
}

/// A picture of a case with its layers, without lamps.
pub fn request(case: &Case, method: Method) -> FrameRequest {
    FrameRequest {
        playing: case.playing(),
        size: case.size,
        view: case.view,
        lights: Vec::new(),
        refraction: Refraction { method, ..Refraction::default() },
        caustics: None,
        samples: 1,
        exposure: 1.0,
        tone_map: ToneMap::Neutral,
        aov: true,
        before: None,
        skipping: Skipping::On,
    }
}
