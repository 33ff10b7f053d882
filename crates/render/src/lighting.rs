//! The frame's lamps: what each sees, the caustics it throws through each body, its light on what the eye sees.

use encase::ShaderType;
use glam::{DMat4, Mat4, Vec3};
use murano_animation::{Bounds, DeformedGeometry};
use murano_caustics::{
    Cast, Caster, CausticMap, Caustics, Lamp, Lamps, Mirror, Receivers, SeenCaster, Surfaces, cone_cosines, deposit,
    emit, gather, light_map_size, receive, shield,
};
use murano_gpu::{ComputePass, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{
    FrameViewpoint, InterfaceMap, Layered, Layers, Mapped, Refraction, ViewpointUniform, interface_map, texels,
};
use murano_scene::{LightKind, PlacedLight};
use murano_scheduler::{Output, Plan};

use crate::{
    compound::shared_light,
    frame::{FramePlan, OpaquePicture, PosedBody, PosedMirror},
    looks::SurfaceSource,
};

/// Texels a side of a lamp's view where no caustic map asks for another size.
const SHADOW_MAP_SIZE: u32 = 512;
/// `vec4f` rows a pixel of a lamp's light.
pub(crate) const LIGHT_ROWS: usize = 3;
/// Texels a side of a lamp's view of a caster where there are no photons.
const CASTER_MAP_SIZE: u32 = 384;

#[derive(ShaderType)]
struct LampParams {
    lamp_from_eye: Mat4,
    intensity: Vec3,
    punctual: f32,
    cos_outer: f32,
    cos_inner: f32,
    range: f32,
}

/// Where a lamp shines, and what it sees there.
struct Side<'a> {
    lamp: &'a Lamp,
    receivers: Receivers,
}

/// What a caster does to a lamp's light at what the eye sees.
struct Received {
    /// Where the lamp sees it.
    seen: Output,
    /// And where it does not, for something opaque: its caustic alone.
    hidden: Option<Output>,
}

/// What a lamp's light through one caster leaves.
#[derive(Clone, Copy)]
pub(crate) struct Deposited {
    /// On what the lamp sees.
    pub(crate) seen: CausticMap,
    /// On what that hides.
    pub(crate) hidden: Option<CausticMap>,
}

/// What a lamp sees to each side, as `render::illuminate` names it.
const RECEIVERS: [&str; 6] = ["receivers", "second", "third", "fourth", "fifth", "sixth"];
/// And what that hides.
const HIDDEN: [&str; 6] = ["hidden", "hidden_second", "hidden_third", "hidden_fourth", "hidden_fifth", "hidden_sixth"];

#[derive(ShaderType)]
struct Sides {
    viewpoints: [ViewpointUniform; RECEIVERS.len()],
    count: u32,
}

/// Something that throws caustics under a lamp.
struct Thrower<'a> {
    /// Tells the pairs of lamps and casters apart.
    pair: u32,
    caster: Caster,
    mapped: Mapped,
    bounds: &'a Bounds,
    refraction: Refraction,
    /// What its surface is sampled from, where that is not the same everywhere.
    surface: Option<&'a SurfaceSource>,
    /// Whether that is made of facets.
    faceted: bool,
}

/// Part of the smaller of two casters, as a lamp sees them, up to which they may be in each other's light and nobody minds: else each would wait
/// for the other's map, and throw its caustic anew where the other moves.
const LEAST_SHARED: f64 = 0.02;

/// A caster as a lamp sees it.
struct Lit<'a> {
    thrower: Thrower<'a>,
    side: &'a Side<'a>,
    viewpoint: FrameViewpoint,
    map: InterfaceMap,
}

impl Lit<'_> {
    fn seen(&self) -> SeenCaster<'_> {
        let thin = matches!(self.thrower.caster, Caster::Glass(glass) if glass.thin);
        SeenCaster { viewpoint: &self.viewpoint, map: &self.map, thin }
    }
}

impl FramePlan<'_> {
    /// Adds every lamp's light, with shadows and caustics.
    pub(crate) fn light(
        &mut self,
        plan: &mut Plan<Work>,
        (opaque, opaque_bounds): (&DeformedGeometry, &Bounds),
        (bodies, glass_bounds): (&[PosedBody], &Bounds),
        mirrors: &[PosedMirror],
        seen: &OpaquePicture,
    ) -> Result<(Layered, Vec<Output>), GpuError> {
        let mut layered = seen.layered;
        let mut layers = Vec::new();
        let everything = glass_bounds.union(*opaque_bounds);
        for (number, placed) in (0..).zip(&self.request.lights) {
            if opaque.triangle_count == 0 {
                plan.cull("illuminate", number, "there is nothing opaque to light")?;
                continue;
            }
            let lit = placed.light.intensity > 0.0 && placed.light.color != Vec3::ZERO;
            if !lit {
                plan.cull("illuminate", number, "the light is out")?;
                continue;
            }
            let bodies = self.lit_together(plan, bodies, placed)?;
            let casters: Vec<Bounds> =
                bodies.iter().map(|body| body.bounds).chain(mirrors.iter().map(|mirror| mirror.bounds)).collect();
            let map_size = self.request.caustics.map_or(SHADOW_MAP_SIZE, |caustics| caustics.map_size);
            let lamps = Lamps::new(placed, &casters, &everything, map_size);
            let hides = self.stock.sorted.opaque.may_hide
                && self.request.caustics.is_some_and(|caustics| caustics.method.follows_hidden());
            let mut sides = Vec::new();
            for (side, lamp) in (0..).zip(&lamps.sides) {
                let instance = number + side * self.request.lights.len() as u32;
                let viewpoint = lamp.receivers.in_frame(self.origin);
                let map = (*opaque).into();
                let mut see =
                    |name, layers| interface_map(self.stock.gpu, plan, (name, instance), &map, &viewpoint, layers);
                let seen = see("receivers", Layers::Nearest)?.front;
                let mut hidden = None;
                if hides && !casters.is_empty() {
                    let behind = see("hidden", Layers::Behind(seen))?;
                    hidden = behind.back.map(|back| [behind.front, back]);
                }
                sides.push(Side { lamp, receivers: Receivers { seen, hidden } });
            }
            let mut lit = Vec::new();
            let mut received = Vec::new();
            let mut received_hidden = Vec::new();
            let sorted = self.stock.sorted;
            let pairs = number * (sorted.bodies.len() + sorted.mirrors.len()) as u32;
            // Light is followed as far as it goes, whatever the eye's settings: it is paid for once, and gone otherwise.
            let glass = bodies.iter().map(|body| {
                let refraction = body.refraction(&self.request.refraction.followed());
                let surface = (body.surface.as_ref(), body.faceted);
                (body.index, Caster::Glass(body.glass), &body.mapped, &body.bounds, refraction, surface)
            });
            let metal = mirrors.iter().map(|body| {
                let surface = (None, sorted.mirrors[body.index as usize - sorted.bodies.len()].faceted);
                (body.index, Caster::Mirror(body.mirror), &body.mapped, &body.bounds, Mirror::refraction(), surface)
            });
            let throwers = glass.chain(metal).zip(&lamps.side_of).collect::<Vec<_>>();
            for ((index, caster, mapped, bounds, refraction, (surface, faceted)), side) in throwers {
                let pair = pairs + index;
                let side = &sides[*side];
                if !side.lamp.receivers.sees(opaque_bounds) {
                    plan.cull("emit", pair, "no receiver is in the light's view")?;
                    continue;
                }
                if self.request.caustics.is_none() && matches!(caster, Caster::Mirror(_)) {
                    plan.cull("receive", pair, "a mirror throws its shadow with everything opaque")?;
                    continue;
                }
                let thrower = Thrower { pair, caster, mapped: *mapped, bounds, refraction, surface, faceted };
                lit.extend(self.lit(plan, thrower, side)?);
            }
            let pairs_in_all = self.request.lights.len() * (sorted.bodies.len() + sorted.mirrors.len());
            for (place, one) in lit.iter().enumerate() {
                let mut shielded = None;
                let in_its_light = |other: &&Lit<'_>| self.may_stand_in_light(other, one);
                for (number, other) in lit.iter().enumerate().filter(|(other, _)| *other != place) {
                    if in_its_light(&other) {
                        let instance = one.thrower.pair + (number * pairs_in_all) as u32;
                        let before = shielded;
                        // Where something opaque may stand behind a sheet, its light may end there.
                        let gives_way = !self.stock.sorted.opaque.may_hide;
                        shielded = Some(shield(
                            self.stock.gpu,
                            plan,
                            instance,
                            one.seen(),
                            other.seen(),
                            (gives_way, before),
                        )?);
                    }
                }
                let by_caster = self.cast(plan, one, shielded, seen.surfaces)?;
                received.push(by_caster.seen);
                received_hidden.extend(by_caster.hidden);
            }
            let with_caustics = self.request.caustics.is_some();
            let mut gathered =
                |on, received| gather(self.stock.gpu, plan, (on, pairs), received, self.eye.size, with_caustics);
            let received = gathered(Surfaces::Seen, received)?;
            let hidden = gathered(Surfaces::Hidden, received_hidden)?;
            let received = received.map(|seen| Received { seen, hidden });
            let (colour, layer) = self.illuminate(plan, number, &sides, received, seen, layered.colour)?;
            layered.colour = colour;
            layers.extend(layer);
        }
        Ok((layered, layers))
    }

    /// Whether some of a lamp's light meets another caster before it would meet this one, or the other way round, so that it is one's alone.
    fn may_stand_in_light(&self, other: &Lit<'_>, this: &Lit<'_>) -> bool {
        let is_glass = |lit: &Lit<'_>| matches!(lit.thrower.caster, Caster::Glass(_));
        // What is opaque shades with everything else that is, and sheets pass light on to what stands behind them.
        self.request.caustics.is_some()
            && is_glass(other)
            && (!other.seen().thin || (this.seen().thin && !self.stock.sorted.opaque.may_hide))
            && shared_light(this.side.lamp.placed(), this.thrower.bounds, other.thrower.bounds) > LEAST_SHARED
    }

    /// The lamp's view of a caster; `None` where it does not see it.
    fn lit<'a>(
        &self,
        plan: &mut Plan<Work>,
        thrower: Thrower<'a>,
        side: &'a Side<'a>,
    ) -> Result<Option<Lit<'a>>, GpuError> {
        let Side { lamp, .. } = side;
        let Thrower { pair, refraction, bounds, mapped, .. } = &thrower;
        let caustics: Option<&Caustics> = self.request.caustics.as_ref();
        let size = caustics.map_or(CASTER_MAP_SIZE, |caustics| light_map_size(caustics.photons));
        let viewpoint = match lamp.caster_viewpoint(bounds, size) {
            Ok(viewpoint) => viewpoint,
            Err(reason) => {
                plan.cull("light_map", *pair, reason)?;
                return Ok(None);
            }
        };
        let gpu = self.stock.gpu;
        let viewpoint = viewpoint.in_frame(self.origin).fitted(gpu, plan, *pair, &mapped.geometry)?;
        // What comes straight through needs no search.
        let layers = caustics.map_or(Layers::NearestBack, |_| refraction.layers());
        let map = interface_map(gpu, plan, ("light_map", *pair), mapped, &viewpoint, layers)?;
        Ok(Some(Lit { thrower, side, viewpoint, map }))
    }

    /// One caster under one lamp: its shadow and its caustic at what the eye sees.
    fn cast(
        &mut self,
        plan: &mut Plan<Work>,
        lit: &Lit<'_>,
        shielded: Option<Output>,
        surfaces: Output,
    ) -> Result<Received, GpuError> {
        let Lit { thrower, side: Side { lamp, receivers }, viewpoint, map } = lit;
        let Thrower { pair, refraction, bounds, caster, .. } = thrower;
        let caustics: Option<&Caustics> = self.request.caustics.as_ref();
        let gpu = self.stock.gpu;
        let size = viewpoint.viewpoint.size[0];
        // Of a photon's cell little: its differential tells the rest.
        let sampled = caustics.map_or(1.0, |caustics| 0.25 * size as f32 / caustics.photons as f32);
        let surface = thrower
            .surface
            .map(|source| self.glass_surface(plan, ("lit_surface", *pair), (viewpoint, sampled), source, map))
            .transpose()?
            .flatten();
        let cast = Cast {
            instance: *pair,
            lamp,
            viewpoint,
            map,
            bounds,
            caster,
            surface,
            shielded,
            faceted: thrower.faceted,
            bends: thrower.surface.is_some_and(|source| source.relief.is_some()),
        };
        let mut caustic_maps = None;
        if let Some(caustics) = caustics {
            let photons = emit(gpu, plan, &cast, caustics, refraction)?;
            let mut on = |on| deposit(gpu, plan, &cast, caustics, photons, (receivers, on), self.reach);
            let seen = on(Surfaces::Seen)?;
            let hidden = receivers.hidden.map(|_| on(Surfaces::Hidden)).transpose()?;
            let deposited = Deposited { seen, hidden };
            self.accounts.push(deposited);
            caustic_maps = Some(deposited);
        }
        let mut on = |map: Option<&CausticMap>, on| {
            receive(gpu, plan, &cast, &self.eye, self.sample_width(), surfaces, (map, on))
        };
        let seen = on(caustic_maps.as_ref().map(|maps| &maps.seen), Surfaces::Seen)?;
        let hidden = caustic_maps.and_then(|maps| maps.hidden);
        let hidden = hidden.map(|map| on(Some(&map), Surfaces::Hidden)).transpose()?;
        Ok(Received { seen, hidden })
    }

    #[allow(clippy::too_many_arguments)]
    fn illuminate(
        &self,
        plan: &mut Plan<Work>,
        number: u32,
        sides: &[Side<'_>],
        received: Option<Received>,
        seen: &OpaquePicture,
        unlit: Output,
    ) -> Result<(Output, Option<Output>), GpuError> {
        let spec = ShaderSpec::new("render::illuminate")
            .feature("casters", received.is_some())
            .feature("caustic", self.request.caustics.is_some())
            .feature("aov", self.aov);
        let hidden = received.as_ref().and_then(|received| received.hidden);
        let spec = spec.feature("hidden", hidden.is_some());
        let spec = RECEIVERS.iter().zip(sides).skip(1).fold(spec, |spec, (name, _)| spec.feature(name, true));
        let shader = self.stock.gpu.shader(&spec)?;
        let count = texels(self.eye.size);
        // Those beyond the last one are not looked at.
        let side_or_first = |side: usize| sides.get(side).unwrap_or(&sides[0]).lamp.receivers.uniform(self.origin);
        let viewpoints = std::array::from_fn(side_or_first);
        let mut pass = ComputePass::new("illuminate", number)
            .value("params", &lamp_params(sides[0].lamp.placed(), &self.eye.world_from_view))
            .value("eye", &self.eye.uniform(self.origin))
            .value("sides", &Sides { viewpoints, count: sides.len() as u32 })
            .value("render_from_eye", &self.eye.view_from_render(self.origin).inverse().as_mat4())
            .input("surfaces", seen.surfaces)
            .input("albedo", seen.albedo)
            .input("unlit", unlit)
            .output("colour", 16 * count);
        for ((name, name_hidden), side) in RECEIVERS.iter().zip(HIDDEN).zip(sides) {
            pass = pass.input(name, side.receivers.seen);
            if let Some([next, _]) = side.receivers.hidden.filter(|_| hidden.is_some()) {
                pass = pass.input(name_hidden, next);
            }
        }
        if let Some(received) = received {
            pass = pass.input("received", received.seen);
        }
        if let Some(hidden) = hidden {
            pass = pass.input("received_hidden", hidden);
        }
        if self.aov {
            pass = pass.cleared_output("light_layers", 16 * LIGHT_ROWS as u64 * count);
        }
        let outputs = pass.dispatch(&shader, "main", Groups::tiles(self.eye.size)).add_to(plan)?;
        Ok((outputs[0], outputs.get(1).copied()))
    }
}

fn lamp_params(placed: &PlacedLight, world_from_eye: &DMat4) -> LampParams {
    let light = &placed.light;
    let (cos_outer, cos_inner) = cone_cosines(light.kind);
    LampParams {
        lamp_from_eye: (placed.world_from_light.inverse() * *world_from_eye).as_mat4(),
        intensity: light.color * light.intensity,
        punctual: f32::from(u8::from(light.kind != LightKind::Directional)),
        cos_outer,
        cos_inner,
        range: if light.range.is_finite() { light.range } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let matrix = Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0));
        let illuminate = Shader::link(&ShaderSpec::new("render::illuminate")).unwrap();
        check_uniform_layout!(
            illuminate,
            "Params",
            LampParams {
                lamp_from_eye: matrix,
                intensity: Vec3::new(1.0, 2.0, 3.0),
                punctual: 4.0,
                cos_outer: 5.0,
                cos_inner: 6.0,
                range: 7.0,
            }
        )
        .unwrap();
    }
}
