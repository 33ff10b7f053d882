//! Glass bodies as the eye sees them, over what lies behind them.

use murano_animation::Bounds;
use murano_gpu::{ComputePass, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{
    FrameViewpoint, InterfaceMap, Layered, Layers, RefractRequest, Refraction, Turn, first_interfaces, interface_map,
    refract, texels,
};
use murano_scheduler::{Output, Plan};

use crate::{
    frame::{FramePlan, PosedBody},
    looks::SurfaceSource,
};

/// What the eye sees of a body.
struct MappedBody<'a> {
    body: &'a PosedBody,
    eye: FrameViewpoint,
    refraction: Refraction,
    map: InterfaceMap,
    surface: Option<Output>,
    inside_map: Option<Output>,
}

impl FramePlan<'_> {
    /// Draws bodies over what lies behind them; of several each pixel's farthest first, in rounds, in each of which every body draws those
    /// pixels where it is next. With each body, how many rounds it takes part in.
    pub(crate) fn draw_glass(
        &self,
        plan: &mut Plan<Work>,
        bodies: &[(&PosedBody, usize)],
        behind: Layered,
        drawn: &mut Bounds,
        paths: &mut Vec<Output>,
    ) -> Result<Layered, GpuError> {
        let group = bodies.iter().map(|(body, _)| self.map_body(plan, body)).collect::<Result<Vec<_>, _>>()?;
        let mut firsts = None;
        for mapped in group.iter().filter(|_| group.len() > 1) {
            let request = self.refract_request(mapped, drawn, mapped.body.index, None);
            firsts = Some(first_interfaces(self.stock.gpu, plan, &mapped.map, firsts, &request)?);
        }
        let mut layered = behind;
        let rounds = bodies.iter().map(|&(_, rounds)| rounds).max().unwrap_or(0);
        for round in 0..rounds {
            for (rank, mapped) in group.iter().enumerate().filter(|&(rank, _)| round < bodies[rank].1) {
                let turn = firsts.map(|firsts| Turn { firsts, rank: rank as u32 });
                let instance = mapped.body.index + (round * self.stock.sorted.bodies.len()) as u32;
                let request = self.refract_request(mapped, drawn, instance, turn);
                let (over, written) = refract(self.stock.gpu, plan, &mapped.map, layered, self.environment, &request)?;
                layered = over;
                paths.extend(written);
                *drawn = drawn.union(mapped.body.bounds);
            }
        }
        Ok(layered)
    }

    fn map_body<'a>(&self, plan: &mut Plan<Work>, body: &'a PosedBody) -> Result<MappedBody<'a>, GpuError> {
        let refraction = body.refraction(&self.request.refraction);
        let layers = refraction.layers();
        let eye = self.eye.in_frame(self.origin);
        let map = interface_map(self.stock.gpu, plan, ("eye_map", body.index), &body.mapped, &eye, layers)?;
        let surface = body
            .surface
            .as_ref()
            .map(|source| {
                self.glass_surface(plan, ("glass_surface", body.index), (&eye, self.sample_width()), source, &map)
            })
            .transpose()?
            .flatten();
        let farthest = matches!(layers, Layers::FarthestBack { .. });
        let inside_map = if farthest && self.eye.begins_within(&body.bounds) {
            let key = ("inside_map", body.index);
            interface_map(self.stock.gpu, plan, key, &body.mapped, &eye, Layers::NearestBack)?.back
        } else {
            None
        };
        Ok(MappedBody { body, eye, refraction, map, surface, inside_map })
    }

    fn refract_request<'a>(
        &self,
        mapped: &'a MappedBody<'_>,
        drawn: &'a Bounds,
        instance: u32,
        turn: Option<Turn>,
    ) -> RefractRequest<'a> {
        let body = mapped.body;
        RefractRequest {
            instance,
            object: 0x8000_0000 | body.index,
            viewpoint: &mapped.eye,
            bounds: &body.bounds,
            glass: &body.glass,
            refraction: &mapped.refraction,
            drawn,
            inside_map: mapped.inside_map,
            surface: mapped.surface,
            rough: body.rough,
            sample_width: self.sample_width(),
            sample: (self.request.samples > 1).then_some(self.sample),
            turn,
            aov: self.aov,
        }
    }

    /// A body's first interface as a viewpoint sees it, where that is not the same everywhere, through rays that sample so wide a part
    /// of their texel.
    pub(crate) fn glass_surface(
        &self,
        plan: &mut Plan<Work>,
        (name, instance): (&'static str, u32),
        (viewpoint, sample_width): (&FrameViewpoint, f32),
        source: &SurfaceSource,
        map: &InterfaceMap,
    ) -> Result<Option<Output>, GpuError> {
        let Some(front_triangles) = map.front_triangles else { return Ok(None) };
        let tangents = map.geometry.tangents.filter(|_| source.textured);
        let spec = ShaderSpec::new("render::glass_surface")
            .feature("textured", source.textured)
            .feature("framed", tangents.is_some());
        let shader = self.stock.gpu.shader(&spec)?;
        let size = viewpoint.viewpoint.size;
        let mut pass = viewpoint
            .tell(ComputePass::new(name, instance), "viewpoint")
            .input("positions", map.geometry.positions)
            .input("triangles", map.geometry.triangles)
            .input("front_triangles", front_triangles)
            .cleared_output("glass_surface", 32 * texels(size));
        if source.textured {
            pass = pass.input("normals", map.geometry.normals).value("sample_width", &sample_width);
        }
        if let Some(tangents) = tangents {
            pass = pass.input("tangents", tangents);
        }
        for (name, stamp, leaf) in &source.buffers {
            pass = pass.input(name, plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        }
        Ok(Some(pass.dispatch(&shader, "main", Groups::tiles(size)).add_to(plan)?[0]))
    }
}
