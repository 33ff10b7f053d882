//! The light that arrives along one ray: a tree of branches that reflect, refract and scatter.

use glam::DVec3;
use murano_optics::{beer_lambert, fresnel_unpolarised, snell};

use super::{
    PathScene, PathSettings,
    brdf::{Reflection, unshadowed, visible_normal},
    lights::arriving,
    sky::Sky,
    surface::{Surface, kept, surface},
};
use crate::{Departure, Facing, Hit, Opaque, Ray, Within, sampler::Sampler};

/// What a branch leaves from.
#[derive(Clone, Copy)]
enum Left {
    Eye,
    Glass { body: usize, element: u32 },
    Opaque { triangle: u32 },
}

impl Left {
    fn departure_of_body(self, body: usize) -> Departure {
        match self {
            Self::Glass { body: left, element } if left == body => Departure::Element(element),
            _ => Departure::Free,
        }
    }

    fn departure_of_opaque(self) -> Departure {
        match self {
            Self::Opaque { triangle } => Departure::Element(triangle),
            _ => Departure::Free,
        }
    }
}

/// Light still to be found.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    left: Left,
    /// Share of what is found here in what the eye sees.
    weight: DVec3,
    /// The bodies it runs in.
    within: Within,
    interfaces: u32,
    scatterings: u32,
    /// Density with which its direction was drawn, where the sky could have been sampled instead.
    drawn: Option<f64>,
}

/// What one ray from the eye found.
#[derive(Clone, Copy, Default)]
pub(super) struct Found {
    pub radiance: DVec3,
    /// Whether the ray met anything.
    pub covered: bool,
    /// Weight of the branches that were cut off.
    pub pruned: f64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
}

/// The scene made ready.
pub(super) struct Tracer<'a> {
    pub scene: &'a PathScene<'a>,
    pub settings: &'a PathSettings,
    pub sky: Sky<'a>,
}

impl Tracer<'_> {
    /// Follows a ray from the eye until all its light is found. `branches` is scratch space.
    pub fn follow(&self, ray: Ray, sampler: &mut Sampler, branches: &mut Branches) -> Found {
        let mut found = Found::default();
        branches.0.clear();
        branches.0.push(Branch {
            ray,
            left: Left::Eye,
            weight: DVec3::ONE,
            within: Within::default(),
            interfaces: 0,
            scatterings: 0,
            drawn: None,
        });
        while let Some(branch) = branches.0.pop() {
            let Some(branch) = self.survivor(branch, sampler) else { continue };
            found.rays += 1;
            let glass = self.glass_ahead(&branch);
            let farthest = glass.map_or(f64::INFINITY, |(_, hit)| hit.t);
            let opaque = self.scene.world.opaque.as_ref();
            let blocked = opaque.and_then(|opaque| {
                Some((opaque, opaque.mesh.nearest(&branch.ray, branch.left.departure_of_opaque(), None, farthest)?))
            });
            if let Some((opaque, hit)) = blocked {
                found.covered = true;
                let branch = self.absorbed(branch, hit.t);
                self.scatter(opaque, branch, &hit, sampler, branches, &mut found);
            } else if let Some((body, hit)) = glass {
                found.covered = true;
                let branch = self.absorbed(branch, hit.t);
                self.cross(body, branch, &hit, sampler, branches, &mut found);
            } else if found.covered || self.settings.background {
                found.radiance += branch.weight * self.distant(&branch);
            }
        }
        found
    }

    /// Russian roulette: a branch too light to be worth its cost lives by chance, and then for those that do not.
    fn survivor(&self, branch: Branch, sampler: &mut Sampler) -> Option<Branch> {
        let chance = branch.weight.max_element() / self.settings.smallest_weight;
        if chance >= 1.0 {
            return Some(branch);
        }
        (sampler.unit() < chance).then(|| Branch { weight: branch.weight / chance, ..branch })
    }

    fn glass_ahead(&self, branch: &Branch) -> Option<(usize, Hit)> {
        let mut nearest: Option<(usize, Hit)> = None;
        for (index, body) in self.scene.world.bodies.iter().enumerate() {
            let farthest = nearest.map_or(f64::INFINITY, |(_, hit)| hit.t);
            let hit = body.nearest(&branch.ray, branch.left.departure_of_body(index), None, farthest);
            nearest = hit.filter(|hit| hit.t < farthest).map(|hit| (index, hit)).or(nearest);
        }
        nearest
    }

    fn absorbed(&self, branch: Branch, length: f64) -> Branch {
        let world = self.scene.world;
        let medium = world.medium(&branch.within);
        let kept = medium.map_or(DVec3::ONE, |body| beer_lambert(world.bodies[body].absorption, length));
        Branch { weight: branch.weight * kept, ..branch }
    }

    /// The sky behind everything. Where it might have been sampled instead, both ways share the weight (balance heuristic,
    /// Veach 1997).
    fn distant(&self, branch: &Branch) -> DVec3 {
        let share = branch.drawn.map_or(1.0, |drawn| drawn / (drawn + self.sky.density(branch.ray.direction)));
        share * self.sky.radiance(branch.ray.direction)
    }

    /// An interface of glass: reflection and refraction, both where both weigh enough, else one of them by chance.
    fn cross(
        &self,
        body: usize,
        branch: Branch,
        hit: &Hit,
        sampler: &mut Sampler,
        branches: &mut Branches,
        found: &mut Found,
    ) {
        if branch.interfaces >= self.settings.interfaces {
            found.pruned += branch.weight.max_element();
            return;
        }
        let glass = &self.scene.world.bodies[body];
        let direction = branch.ray.direction;
        let facing = hit.facing(direction);
        let shading = hit.normal_against(direction);
        let roughness = glass.roughness_at(hit);
        let normal = facet(shading, direction, roughness, sampler);
        let tint = if facing == Facing::Front { glass.tint_at(hit) } else { DVec3::ONE };
        let world = self.scene.world;
        let [here, beyond] = branch.within.across(body, facing);
        let media = if glass.thin { Some([None; 2]) } else { world.interface([here, beyond]) };
        let Some([before, behind]) = media else {
            let ray = Ray { origin: hit.position, direction };
            let left = Left::Glass { body, element: hit.element };
            branches.0.push(Branch { ray, left, within: beyond, drawn: None, ..branch });
            return;
        };
        let eta = world.ior(before) / world.ior(behind);
        let refracted = snell(direction, normal, eta);
        let reflectance = if refracted.tir { 1.0 } else { fresnel_unpolarised(-direction.dot(normal), eta) };
        let mirror = murano_optics::reflected(direction, normal);
        if glass.thin {
            // Light that goes to and fro within the sheet is part of either branch; a rough one scatters what it transmits as
            // it does what it mirrors.
            let once = fresnel_unpolarised(-direction.dot(normal), glass.ior.recip());
            let onward = mirror - 2.0 * mirror.dot(shading) * shading;
            let onward = if roughness > 0.0 { onward } else { direction };
            return self.split(
                [(mirror, branch.within), (onward, branch.within)],
                2.0 * once / (1.0 + once),
                glass.tint_at(hit),
                (body, branch, hit, shading),
                sampler,
                branches,
            );
        }
        self.split(
            [(mirror, here), (refracted.direction, beyond)],
            reflectance,
            tint,
            (body, branch, hit, shading),
            sampler,
            branches,
        );
    }

    /// Sends a branch on from an interface, mirrored and transmitted, each a direction and the bodies it runs in.
    fn split(
        &self,
        [mirrored, transmitted]: [(DVec3, Within); 2],
        reflectance: f64,
        tint: DVec3,
        (body, branch, hit, shading): (usize, Branch, &Hit, DVec3),
        sampler: &mut Sampler,
        branches: &mut Branches,
    ) {
        let alpha = self.scene.world.bodies[body].roughness_at(hit).powi(2);
        let from_there = |(direction, within): (DVec3, Within), weight: DVec3, side: f64| {
            let cosine = side * direction.dot(shading);
            // What leaves a rough surface on the wrong side would meet another facet; single scattering loses it.
            let kept = if alpha == 0.0 { 1.0 } else { unshadowed(alpha, cosine.max(0.0)) };
            Branch {
                ray: Ray { origin: hit.position, direction },
                left: Left::Glass { body, element: hit.element },
                weight: weight * kept,
                within,
                interfaces: branch.interfaces + 1,
                scatterings: branch.scatterings,
                drawn: None,
            }
        };
        let reflected = |share: f64| from_there(mirrored, branch.weight * share, 1.0);
        let transmitted = |share: f64| from_there(transmitted, branch.weight * tint * share, -1.0);
        let lesser = branch.weight.max_element() * reflectance.min(1.0 - reflectance);
        if lesser >= self.settings.smallest_weight {
            branches.0.push(reflected(reflectance));
            branches.0.push(transmitted(1.0 - reflectance));
        } else if reflectance > 0.0 && sampler.unit() < reflectance {
            branches.0.push(reflected(1.0));
        } else {
            branches.0.push(transmitted(1.0));
        }
    }

    /// An opaque surface: light that it emits, light of lamps and sky that it reflects, and one branch for the rest.
    fn scatter(
        &self,
        opaque: &Opaque,
        branch: Branch,
        hit: &Hit,
        sampler: &mut Sampler,
        branches: &mut Branches,
        found: &mut Found,
    ) {
        let there = kept(opaque, self.scene.fade.as_ref(), hit);
        let mut weight = branch.weight;
        if there < 1.0 {
            let past = Branch {
                ray: Ray { origin: hit.position, ..branch.ray },
                left: Left::Opaque { triangle: hit.element },
                ..branch
            };
            if weight.max_element() * there.min(1.0 - there) >= self.settings.smallest_weight {
                branches.0.push(Branch { weight: (1.0 - there) * weight, ..past });
                weight *= there;
            } else if sampler.unit() >= there {
                branches.0.push(past);
                return;
            }
        }
        let surface = surface(opaque, self.scene.scene, hit, branch.ray.direction);
        found.radiance += weight * surface.emitted;
        let view = -branch.ray.direction;
        let reflection = Reflection::new(surface.normal, view, surface.albedo, surface.roughness, surface.metallic);
        if branch.within.is_none() {
            let lit = self.lamps(opaque, &surface, &reflection, hit, found)
                + self.sampled_sky(opaque, &surface, &reflection, hit, sampler, found);
            found.radiance += weight * lit;
        }
        if let Some(photons) = self.scene.photons {
            photons.gather(surface.position, surface.geometric, |towards, irradiance| {
                found.radiance += weight * reflection.brdf(towards) * irradiance;
            });
        }
        if branch.scatterings >= self.settings.scatterings {
            found.pruned += weight.max_element();
            return;
        }
        let towards = reflection.sample(sampler.unit(), sampler.pair());
        let (value, density) = reflection.evaluate(towards);
        if density > 0.0 && surface.geometric.dot(towards) > 0.0 {
            branches.0.push(Branch {
                ray: Ray { origin: surface.position, direction: towards },
                left: Left::Opaque { triangle: hit.element },
                weight: weight * value / density,
                within: branch.within,
                interfaces: branch.interfaces,
                scatterings: branch.scatterings + 1,
                drawn: branch.within.is_none().then_some(density),
            });
        }
    }

    /// Reflected light of the lamps that nothing blocks.
    fn lamps(
        &self,
        opaque: &Opaque,
        surface: &Surface,
        reflection: &Reflection,
        hit: &Hit,
        found: &mut Found,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for light in self.scene.lights.iter().filter_map(|placed| arriving(placed, surface.position)) {
            let (value, _) = reflection.evaluate(light.towards);
            if value != DVec3::ZERO && surface.geometric.dot(light.towards) > 0.0 {
                let ray = Ray { origin: surface.position, direction: light.towards };
                sum += value * light.irradiance * self.unblocked(opaque, &ray, hit.element, light.distance, found);
            }
        }
        sum
    }

    /// Reflected light of one direction drawn from the sky, with its share of the weight.
    fn sampled_sky(
        &self,
        opaque: &Opaque,
        surface: &Surface,
        reflection: &Reflection,
        hit: &Hit,
        sampler: &mut Sampler,
        found: &mut Found,
    ) -> DVec3 {
        let Some((towards, density)) = self.sky.sample(sampler.pair()) else { return DVec3::ZERO };
        let (value, drawn) = reflection.evaluate(towards);
        if value == DVec3::ZERO || surface.geometric.dot(towards) <= 0.0 {
            return DVec3::ZERO;
        }
        let ray = Ray { origin: surface.position, direction: towards };
        let seen = self.unblocked(opaque, &ray, hit.element, f64::INFINITY, found);
        if seen == 0.0 {
            return DVec3::ZERO;
        }
        value * self.sky.radiance(towards) * (seen / (density + drawn))
    }

    /// How much of straight light passes: none through glass, whose light arrives by other ways, and what has faded of the
    /// surfaces between.
    fn unblocked(&self, opaque: &Opaque, ray: &Ray, triangle: u32, distance: f64, found: &mut Found) -> f64 {
        found.rays += 1;
        if self.scene.world.bodies.iter().any(|body| body.shape.blocks(ray, Departure::Free, distance)) {
            return 0.0;
        }
        let (mut ray, mut from, mut left, mut passing) = (*ray, Departure::Element(triangle), distance, 1.0);
        if self.scene.fade.is_none() {
            return if opaque.mesh.blocks(&ray, from, left) { 0.0 } else { 1.0 };
        }
        while passing > 0.0 {
            let Some(hit) = opaque.mesh.nearest(&ray, from, None, left) else { break };
            passing *= 1.0 - kept(opaque, self.scene.fade.as_ref(), &hit);
            (ray.origin, from, left) = (hit.position, Departure::Element(hit.element), left - hit.t);
        }
        passing
    }
}

/// The normal of a facet of rough glass that a ray meets, drawn among those it sees; `shading`, its mean, where the glass is
/// smooth (Walter, Marschner, Li, Torrance: "Microfacet Models for Refraction through Rough Surfaces", 2007).
fn facet(shading: DVec3, direction: DVec3, roughness: f64, sampler: &mut Sampler) -> DVec3 {
    if roughness <= 0.0 {
        return shading;
    }
    let (tangent, bitangent) = shading.any_orthonormal_pair();
    let view = DVec3::new(-tangent.dot(direction), -bitangent.dot(direction), -shading.dot(direction));
    let view = if view.z < 1e-4 { DVec3::new(view.x, view.y, 1e-4).normalize() } else { view };
    let half = visible_normal(view, roughness * roughness, sampler.pair());
    (half.x * tangent + half.y * bitangent + half.z * shading).normalize()
}

/// Branches waiting to be followed.
#[derive(Default)]
pub(super) struct Branches(Vec<Branch>);
