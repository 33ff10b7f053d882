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
    /// Draws bodies over what lies behind them; of several each pixel's farthest first, in rounds of all of them, of which each draws
    /// those pixels where it is next.
    pub(crate) fn draw_glass<'a>(
        &self,
        plan: &mut Plan<Work>,
        bodies: impl Iterator<Item = &'a PosedBody>,
        behind: Layered,
        drawn: &mut Bounds,
        paths: &mut Vec<Output>,
    ) -> Result<Layered, GpuError> {
        let mut group = Vec::new();
        for body in bodies {
            group.extend(self.map_body(plan, body)?);
        }
        let mut firsts = None;
        for mapped in group.iter().filter(|_| group.len() > 1) {
            let request = self.refract_request(mapped, drawn, mapped.body.index, None);
            firsts = Some(first_interfaces(self.stock.gpu, plan, &mapped.map, firsts, &request)?);
        }
        let mut layered = behind;
        // So many draws hold every order of the bodies.
        for draw in 0..(group.len() * group.len() + 1).saturating_sub(group.len().max(1)) {
            let (round, rank) = (draw / group.len(), draw % group.len());
            let mapped = &group[rank];
            let turn = firsts.map(|firsts| Turn { firsts, rank: rank as u32 });
            let instance = mapped.body.index + (round * self.stock.sorted.bodies.len()) as u32;
            let request = self.refract_request(mapped, drawn, instance, turn);
            let (over, written) = refract(self.stock.gpu, plan, &mapped.map, layered, self.environment, &request)?;
            layered = over;
            paths.extend(written);
            *drawn = drawn.union(mapped.body.bounds);
        }
        Ok(layered)
    }

    fn map_body<'a>(&self, plan: &mut Plan<Work>, body: &'a PosedBody) -> Result<Option<MappedBody<'a>>, GpuError> {
        if !self.eye.sees(&body.bounds) {
            plan.cull("eye_map", body.index, "the body is out of the picture")?;
            plan.cull("refract", body.index, "the body is out of the picture")?;
            return Ok(None);
        }
        let refraction = body.refraction(&self.request.refraction);
        let layers = refraction.layers();
        let eye = self.eye.in_frame(self.origin);
        let map = interface_map(self.stock.gpu, plan, ("eye_map", body.index), &body.mapped, &eye, layers)?;
        let source = self.stock.looks.bodies[body.index as usize].surface.as_ref();
        let surface = source
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
        Ok(Some(MappedBody { body, eye, refraction, map, surface, inside_map }))
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
            rough: self.stock.looks.bodies[body.index as usize].rough,
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
