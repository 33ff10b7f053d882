//! Bodies of glass that touch or lie within one another, as one: light is followed from any of them into any other.

use std::sync::{Arc, Mutex};

use murano_animation::{Bounds, GeometryError, Pose};
use murano_gpu::{GpuError, Work};
use murano_refraction::{Glass, Mapped, Media};
use murano_scene::Scene;
use murano_scheduler::Plan;

use crate::{
    bodies::{Body, Part, Sorted},
    frame::{FramePlan, PosedBody},
};

/// Compounds that are kept for the next time.
const MOST_KEPT: usize = 8;
/// Added to the instance of passes over a compound.
const COMPOUND: u32 = 1 << 30;

/// Several bodies as one.
pub(crate) struct Compound {
    /// Their indices, in the order in which they displace each other.
    members: Vec<usize>,
    pub(crate) body: Body,
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
        let volume = |body: &usize| bodies[*body].volume(scene);
        members.sort_by(|a, b| volume(a).total_cmp(&volume(b)).then(a.cmp(b)));
        let mut kept = self.kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (list, made) = &mut *kept;
        if let Some(known) = list.iter().find(|compound| compound.members == members) {
            return Ok(known.clone());
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

/// Bodies of a frame that are one compound.
pub(crate) struct Joined {
    /// Places in the list of the frame's bodies.
    places: Vec<usize>,
    whole: PosedBody,
}

/// The bodies with some of them joined.
pub(crate) fn with_joined(
    bodies: &[PosedBody],
    joined: &[Joined],
    wanted: impl Fn(&[Bounds]) -> bool,
) -> Vec<PosedBody> {
    let wanted = |joined: &&Joined| {
        let bounds: Vec<Bounds> = joined.places.iter().map(|&place| bodies[place].bounds).collect();
        wanted(&bounds)
    };
    let joined: Vec<&Joined> = joined.iter().filter(wanted).collect();
    let alone = (0..bodies.len()).filter(|place| joined.iter().all(|joined| !joined.places.contains(place)));
    let mut all: Vec<PosedBody> = alone.map(|place| bodies[place].clone()).collect();
    all.extend(joined.iter().map(|joined| joined.whole.clone()));
    all.sort_by_key(|body| body.index);
    all
}

/// Whether light may go from one into the other before anything else is drawn: their boxes meet. Sheets are no bodies that light is
/// within; where roughness differs, each has to be drawn by itself, as a compound is as rough as what is seen first of it.
fn touch(a: &PosedBody, b: &PosedBody) -> bool {
    let apart = a.bounds.max.cmplt(b.bounds.min).any() || b.bounds.max.cmplt(a.bounds.min).any();
    !apart && !a.glass.thin && !b.glass.thin && a.rough == b.rough && a.glass.roughness == b.glass.roughness
}

/// Places of the bodies that are to be one, for each compound.
fn touching(bodies: &[PosedBody]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in 0..bodies.len() {
        let meets = |group: &Vec<usize>| group.iter().any(|&other| touch(&bodies[place], &bodies[other]));
        let (met, mut others): (Vec<_>, Vec<_>) = groups.into_iter().partition(meets);
        let mut group: Vec<usize> = met.into_iter().flatten().collect();
        group.push(place);
        group.sort_unstable();
        others.push(group);
        groups = others;
    }
    groups.retain(|group| (2..=Media::MOST).contains(&group.len()));
    groups
}

impl FramePlan<'_> {
    /// Those of the bodies that are to be drawn or to throw caustics as one.
    pub(crate) fn join(
        &self,
        plan: &mut Plan<Work>,
        pose: &Pose,
        bodies: &[PosedBody],
    ) -> Result<Vec<Joined>, GpuError> {
        let mut all = Vec::new();
        for places in touching(bodies) {
            let Sorted { bodies: sorted, compounds, .. } = self.stock.sorted;
            let members: Vec<usize> = places.iter().map(|&place| bodies[place].index as usize).collect();
            // What is too large for one geometry is drawn body by body.
            let Ok(compound) = compounds.get(self.stock.scene, sorted, &members) else { continue };
            let Compound { body, number, members } = &*compound;
            let gpu = self.stock.gpu;
            let instance = COMPOUND | number;
            let deformed = body.leaves.deform(gpu, plan, instance, &body.geometry, pose, self.origin)?;
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
                index: members.iter().min().map_or(0, |&first| first as u32),
                glass,
                mapped,
                bounds: places.iter().fold(Bounds::EMPTY, |all, &place| all.union(bodies[place].bounds)),
                surface: look.surface,
                rough: look.rough,
                faceted: body.faceted,
            };
            all.push(Joined { places, whole });
        }
        Ok(all)
    }

    /// Whether the eye's rays, or some of them, may begin within one of these bodies.
    pub(crate) fn begins_in(&self, bodies: &[Bounds]) -> bool {
        let place = self.eye.world_from_view.w_axis.truncate();
        let reach = self.eye.near * (1.0 + self.eye.half_extent.length());
        bodies.iter().any(|bounds| {
            if self.eye.perspective { bounds.widened(reach).contains(place) } else { self.eye.begins_within(bounds) }
        })
    }
}
