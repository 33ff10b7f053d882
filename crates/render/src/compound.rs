//! Bodies of glass that touch or lie within one another, as one: light is followed from any of them into any other.

use std::sync::{Arc, Mutex};

use glam::{DVec2, DVec3};
use murano_animation::{Bounds, GeometryError};
use murano_gpu::{GpuError, Work};
use murano_refraction::{Glass, Interfaces, Mapped, Media, Viewpoint};
use murano_scene::{LightKind, PlacedLight, Scene, look_along};
use murano_scheduler::Plan;

use crate::{
    bodies::{Body, Part, Sorted},
    frame::{FramePlan, PosedBody},
    overlap::shared_part,
};

/// Compounds that are kept for the next time: more than bodies at hand make at once, so that a still scene makes none anew.
const MOST_KEPT: usize = 64;
/// Added to the instance of passes over a compound; apart from what is added over a moment before or a body at rest.
const COMPOUND: u32 = 1 << 29;

/// Several bodies as one.
struct Compound {
    /// Their indices, in the order in which they displace each other.
    members: Vec<usize>,
    body: Body,
    /// Tells its passes from those of others.
    number: u32,
}

/// Compounds that have been asked for.
#[derive(Default)]
pub(crate) struct Compounds {
    kept: Mutex<(Vec<Arc<Compound>>, u32)>,
}

impl Compounds {
    /// The bodies of these indices as one.
    fn get(&self, scene: &Scene, bodies: &[Body], members: &[usize]) -> Result<Arc<Compound>, GeometryError> {
        let mut members = members.to_vec();
        // A thing in water displaces it.
        // Of what rounding alone tells apart, the first.
        let volume = |body: &usize| bodies[*body].volume(scene) as f32;
        members.sort_by(|a, b| volume(a).total_cmp(&volume(b)).then(a.cmp(b)));
        let mut kept = self.kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (list, made) = &mut *kept;
        if let Some(place) = list.iter().position(|compound| compound.members == members) {
            let known = list.remove(place);
            list.push(known.clone());
            return Ok(known);
        }
        let shells: Vec<&[Part]> = members.iter().map(|&member| &bodies[member].parts[..]).collect();
        let body = Body::of_shells(scene, &shells)?;
        let compound = Arc::new(Compound { members, body, number: *made % COMPOUND });
        *made += 1;
        if list.len() == MOST_KEPT {
            list.remove(0);
        }
        list.push(compound.clone());
        Ok(compound)
    }
}

/// Whether their boxes meet.
fn meet(a: &PosedBody, b: &PosedBody) -> bool {
    let apart = a.bounds.max.cmplt(b.bounds.min).any() || b.bounds.max.cmplt(a.bounds.min).any();
    !apart
}

/// Share of the smaller of two bodies, as a lamp sees them, from which on its light is followed through both bodies.
const SHARED: f64 = 0.25;

/// How much of a lamp's light that meets one of the bodies in two boxes would meet both, as a part of the smaller one's. From [`SHARED`]
/// on it is followed through both bodies; of less, each ray's light is counted once ([`murano_caustics::shield`]), and goes through one
/// of the two alone.
pub(crate) fn shared_light(lamp: &PlacedLight, a: &Bounds, b: &Bounds) -> f64 {
    shared_part(&view_of(lamp, a, a.union(*b).diameter()), a, b)
}

/// A lamp's view towards the middle of a box, a parallel one's from well before things of this diameter.
fn view_of(lamp: &PlacedLight, bounds: &Bounds, diameter: f64) -> Viewpoint {
    let position = lamp.world_from_light.w_axis.truncate();
    let perspective = lamp.light.kind != LightKind::Directional;
    let to =
        if perspective { bounds.center() - position } else { lamp.world_from_light.transform_vector3(DVec3::NEG_Z) };
    let axis = to.normalize_or(DVec3::NEG_Z);
    Viewpoint {
        world_from_view: look_along(if perspective { position } else { bounds.center() - 4.0 * diameter * axis }, axis),
        perspective,
        half_extent: DVec2::ONE,
        center: DVec2::ZERO,
        size: [1; 2],
        near: 1e-9 * diameter,
    }
}

/// Whether one picture holds all of a box as a lamp sees it.
fn lamp_faces(lamp: &PlacedLight, bounds: &Bounds) -> bool {
    view_of(lamp, bounds, bounds.diameter()).fitted(bounds, 1.02).is_some()
}

/// Places of the bodies that are to be one, for each compound.
fn grouped(bodies: &[PosedBody], are_one: impl Fn(&PosedBody, &PosedBody) -> bool) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in 0..bodies.len() {
        let joins = |group: &Vec<usize>| group.iter().any(|&other| are_one(&bodies[place], &bodies[other]));
        let (met, mut others): (Vec<_>, Vec<_>) = groups.into_iter().partition(joins);
        let mut group: Vec<usize> = met.into_iter().flatten().collect();
        group.push(place);
        group.sort_unstable();
        others.push(group);
        groups = others;
    }
    groups
}

impl FramePlan<'_> {
    /// The bodies as the eye sees them: those whose boxes meet as one, where light is followed on. Sheets are no bodies that light is
    /// within; where roughness differs, or the eye may be in the glass, each is drawn by itself.
    pub(crate) fn seen_together(
        &mut self,
        plan: &mut Plan<Work>,
        bodies: &[PosedBody],
    ) -> Result<Vec<PosedBody>, GpuError> {
        if !self.request.refraction.reenters() {
            return Ok(bodies.to_vec());
        }
        let alone: Vec<bool> = bodies.iter().map(|body| body.glass.thin || self.begins_in(&body.bounds)).collect();
        let alone =
            |body: &PosedBody| bodies.iter().zip(&alone).any(|(other, alone)| *alone && other.index == body.index);
        let alike = |a: &PosedBody, b: &PosedBody| a.rough == b.rough && a.glass.roughness == b.glass.roughness;
        let are_one = |a: &PosedBody, b: &PosedBody| meet(a, b) && alike(a, b) && !alone(a) && !alone(b);
        self.joined(plan, bodies, are_one, |_| true)
    }

    /// The bodies as a lamp's light goes through them: those whose boxes meet as one, and such as stand in each other's light where nothing
    /// opaque could stand between them; not such as stand around the lamp.
    pub(crate) fn lit_together(
        &mut self,
        plan: &mut Plan<Work>,
        bodies: &[PosedBody],
        lamp: &PlacedLight,
    ) -> Result<Vec<PosedBody>, GpuError> {
        let all = self.request.caustics.is_some_and(|caustics| caustics.interfaces == Interfaces::All);
        if !all || !self.request.refraction.followed().reenters() {
            return Ok(bodies.to_vec());
        }
        let clear = !self.stock.sorted.opaque.may_hide;
        let are_one = |a: &PosedBody, b: &PosedBody| {
            !a.glass.thin
                && !b.glass.thin
                && (meet(a, b) || (clear && shared_light(lamp, &a.bounds, &b.bounds) >= SHARED))
        };
        self.joined(plan, bodies, are_one, |bounds| lamp_faces(lamp, bounds))
    }

    fn joined(
        &mut self,
        plan: &mut Plan<Work>,
        bodies: &[PosedBody],
        are_one: impl Fn(&PosedBody, &PosedBody) -> bool,
        may_be_one: impl Fn(&Bounds) -> bool,
    ) -> Result<Vec<PosedBody>, GpuError> {
        let mut all = Vec::new();
        for group in grouped(bodies, are_one) {
            let members: Vec<&PosedBody> = group.iter().map(|&place| &bodies[place]).collect();
            let bounds = members.iter().fold(Bounds::EMPTY, |all, member| all.union(member.bounds));
            let several = (2..=Media::MOST).contains(&members.len()) && may_be_one(&bounds);
            match if several { self.whole(plan, &members)? } else { None } {
                Some(whole) => all.push(whole),
                None => all.extend(members.into_iter().cloned()),
            }
        }
        all.sort_by_key(|body| body.index);
        Ok(all)
    }

    /// Bodies as one; `None` where they are too large for one geometry.
    fn whole(&mut self, plan: &mut Plan<Work>, parts: &[&PosedBody]) -> Result<Option<PosedBody>, GpuError> {
        let indices: Vec<usize> = parts.iter().map(|part| part.index as usize).collect();
        if let Some((_, known)) = self.wholes.iter().find(|(known, _)| *known == indices) {
            return Ok(Some(known.clone()));
        }
        let Sorted { bodies, compounds, .. } = self.stock.sorted;
        let Ok(compound) = compounds.get(self.stock.scene, bodies, &indices) else { return Ok(None) };
        let Compound { body, number, members } = &*compound;
        let gpu = self.stock.gpu;
        let instance = COMPOUND | number;
        let deformed = body.leaves.deform(gpu, plan, instance, &body.geometry, self.pose, self.origin)?;
        let look = self.stock.looks.of_compound(self.stock.scene, body);
        let media: Vec<Glass> = members.iter().map(|&member| self.stock.looks.bodies[member].glass).collect();
        let mut mapped = Mapped::from(deformed);
        mapped.shows_triangles = true;
        mapped.relief = look.surface.as_ref().and_then(|surface| surface.relief(plan));
        if self.request.refraction.method.traces() {
            let tree = body.tree(self.stock.scene);
            mapped.tree = Some(tree.refit(gpu, plan, ("refit", instance), &deformed)?);
        }
        let spread = |glass: &&Glass| if glass.ior > 1.0 { glass.dispersion } else { 0.0 };
        let most = media.iter().max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(&look.glass);
        let glass = Glass { ior: most.ior, dispersion: most.dispersion, ..look.glass };
        mapped.media = Some(Media::new(plan, &media, &self.request.refraction));
        let whole = PosedBody {
            index: parts.iter().map(|part| part.index).min().unwrap_or(0),
            glass,
            mapped,
            bounds: parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.bounds)),
            surface: look.surface,
            rough: look.rough,
            faceted: parts.iter().any(|part| part.faceted),
        };
        self.wholes.push((indices, whole.clone()));
        Ok(Some(whole))
    }

    /// Whether the eye's rays, or some of them, may begin within a body.
    fn begins_in(&self, bounds: &Bounds) -> bool {
        let place = self.eye.world_from_view.w_axis.truncate();
        let reach = self.eye.near * (1.0 + self.eye.half_extent.length());
        if self.eye.perspective { bounds.widened(reach).contains(place) } else { self.eye.begins_within(bounds) }
    }
}
