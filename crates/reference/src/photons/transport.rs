//! One photon's way: split at every interface it meets, until each part has arrived, left or faded.

use glam::DVec3;
use murano_optics::{beer_lambert, fresnel_unpolarised, reflected, snell};

use super::class::History;
use super::{Landing, PhotonAccount, PhotonTracing, Receiver};
use crate::{Contact, Departure, Facing, Ray, Within, World};

/// A part of a photon, on its way from an interface.
struct Branch {
    ray: Ray,
    /// Body and element it comes from.
    from: (usize, u32),
    within: Within,
    flux: DVec3,
    history: History,
    interfaces: u32,
}

/// Follows photons one after the other.
pub(super) struct Transport<'a> {
    pub(super) world: &'a World,
    pub(super) receiver: &'a Receiver,
    pub(super) tracing: &'a PhotonTracing,
    pub(super) account: PhotonAccount,
    pub(super) landings: Vec<Landing>,
    /// Parts still to be followed: empty between photons.
    branches: Vec<Branch>,
}

impl<'a> Transport<'a> {
    pub(super) fn new(world: &'a World, receiver: &'a Receiver, tracing: &'a PhotonTracing) -> Self {
        let (account, landings, branches) = (PhotonAccount::default(), Vec::new(), Vec::new());
        Self { world, receiver, tracing, account, landings, branches }
    }

    /// Follows a photon of a flux, watts, from the light on.
    pub(super) fn photon(&mut self, ray: Ray, flux: DVec3) {
        self.account.photons += 1;
        self.account.emitted += flux;
        if flux == DVec3::ZERO {
            return;
        }
        self.account.rays += 1;
        let Some(first) = self.world.first_glass(&ray) else {
            self.account.missed += flux;
            return;
        };
        self.account.hit += flux;
        let least = flux.max_element() * self.tracing.least_weight;
        self.interface(&ray, (flux, Within::default()), History::default(), 0, first, least);
        while let Some(branch) = self.branches.pop() {
            self.follow(branch, least);
        }
    }

    fn follow(&mut self, branch: Branch, least: f64) {
        self.account.rays += 1;
        let Branch { ray, from: (body, element), within, mut flux, history, interfaces } = branch;
        let contact = self.world.next_glass(&ray, body, Departure::Element(element));
        let Some(contact) = contact else {
            return self.leave(&ray, flux, history, f64::INFINITY);
        };
        if let Some(medium) = self.world.medium(&within) {
            let left = flux * beer_lambert(self.world.bodies[medium].absorption, contact.hit.t);
            self.account.absorbed += flux - left;
            flux = left;
        } else if self.stops_before(&ray, contact.hit.t) {
            return self.leave(&ray, flux, history, contact.hit.t);
        }
        if interfaces >= self.tracing.interfaces {
            self.account.dropped += flux;
            return;
        }
        self.interface(&ray, (flux, within), history, interfaces, contact, least);
    }

    /// Splits light that meets glass into what is refracted and what is reflected (Fresnel, unpolarised).
    fn interface(
        &mut self,
        ray: &Ray,
        (flux, within): (DVec3, Within),
        history: History,
        met: u32,
        contact: Contact,
        least: f64,
    ) {
        let Contact { body, hit } = contact;
        let glass = &self.world.bodies[body];
        if glass.thin {
            return self.sheet(ray, (flux, within), history, met, contact, least);
        }
        let outside = hit.facing(ray.direction) == Facing::Front;
        let [here, beyond] = within.across(body, hit.facing(ray.direction));
        let Some([before, behind]) = self.world.interface([here, beyond]) else {
            let onward = Ray { origin: hit.position, direction: ray.direction };
            let from = (body, hit.element);
            return self.branches.push(Branch { ray: onward, from, within: beyond, flux, history, interfaces: met });
        };
        // Where the interpolated normal faces away, light grazes the smooth surface that the mesh stands for: all of it is
        // reflected, and hardly turned. (The triangle's own normal would let it into the body and catch it there.)
        let eta = self.world.ior(before) / self.world.ior(behind);
        let normal = if outside { hit.normal } else { -hit.normal };
        let reflectance = fresnel_unpolarised(-ray.direction.dot(normal), eta);

        let mirrored = flux * reflectance;
        let mut passed = flux - mirrored;
        if outside {
            let tinted = passed * glass.tint_at(&hit);
            self.account.absorbed += passed - tinted;
            passed = tinted;
            if met == 0 {
                self.account.first_reflected += mirrored;
            }
        }
        let onward = |direction: DVec3, within: Within, flux: DVec3, history: History| Branch {
            ray: Ray { origin: hit.position, direction },
            from: (body, hit.element),
            within,
            flux,
            history,
            interfaces: met + 1,
        };
        let after = if here.is_none() { history.reflected_outside() } else { history.reflected_inside() };
        self.keep(onward(reflected(ray.direction, normal), here, mirrored, after), least);
        // Totally reflected light leaves nothing to pass.
        let through = snell(ray.direction, normal, eta);
        self.keep(onward(through.direction, beyond, passed, history.refracted()), least);
    }

    /// A sheet of glass: straight on through it, which counts as the two refractions that it is, the first time.
    fn sheet(
        &mut self,
        ray: &Ray,
        (flux, within): (DVec3, Within),
        history: History,
        met: u32,
        contact: Contact,
        least: f64,
    ) {
        let Contact { body, hit } = contact;
        let glass = &self.world.bodies[body];
        let normal = hit.normal_against(ray.direction);
        let once = fresnel_unpolarised(-ray.direction.dot(normal), glass.ior.recip());
        let mirrored = flux * (2.0 * once / (1.0 + once));
        let passed = (flux - mirrored) * glass.tint_at(&hit);
        self.account.absorbed += flux - mirrored - passed;
        if met == 0 {
            self.account.first_reflected += mirrored;
        }
        let onward = |direction: DVec3, flux: DVec3, history: History| Branch {
            ray: Ray { origin: hit.position, direction },
            from: (body, hit.element),
            within,
            flux,
            history,
            interfaces: met + 1,
        };
        self.keep(onward(reflected(ray.direction, normal), mirrored, history.reflected_outside()), least);
        self.keep(onward(ray.direction, passed, history.through_sheet()), least);
    }

    fn keep(&mut self, branch: Branch, least: f64) {
        if branch.flux.max_element() > least {
            self.branches.push(branch);
        } else {
            self.account.pruned += branch.flux;
        }
    }

    /// Whether light outside of glass meets the receiver or something opaque within `farthest` metres.
    fn stops_before(&self, ray: &Ray, farthest: f64) -> bool {
        let receives = match self.receiver {
            Receiver::Plane(window) => window.meets(ray).is_some_and(|t| t <= farthest),
            Receiver::Opaque => false,
        };
        receives || self.world.blocked(ray, farthest)
    }

    /// Light that meets no more glass arrives, or is lost to the surroundings.
    fn leave(&mut self, ray: &Ray, flux: DVec3, history: History, farthest: f64) {
        let class = history.class();
        let landing = |position: DVec3, triangle: Option<(u32, DVec3)>| Landing {
            position,
            direction: ray.direction,
            flux,
            class,
            triangle,
            half: 0,
        };
        let landed = match self.receiver {
            Receiver::Plane(window) => window
                .meets(ray)
                .filter(|&t| !self.world.blocked(ray, t))
                .map(|t| (window.texel(ray.at(t)).is_some(), landing(ray.at(t), None))),
            Receiver::Opaque => {
                let opaque = self.world.opaque.as_ref();
                let hit = opaque.and_then(|opaque| opaque.mesh.nearest(ray, Departure::Free, None, farthest));
                hit.map(|hit| (true, landing(hit.position, Some((hit.element, hit.barycentric)))))
            }
        };
        let Some((in_window, landing)) = landed else {
            self.account.escaped[class as usize] += flux;
            return;
        };
        self.account.arrived[class as usize] += flux;
        if in_window {
            self.account.in_window[class as usize] += flux;
            self.landings.push(landing);
        }
    }
}
