//! What light went through, and the balance of its energy.

use glam::DVec3;

/// The kinds of light that a caustic is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum PhotonClass {
    /// Refracted in and out, no more, and never reflected: what two-interface methods draw.
    TwoRefractions,
    /// Reflected at the first interface it met, whatever it did then.
    FirstReflection,
    /// Refracted more than twice, and never reflected inside; or once, when it left through a hole of an open mesh.
    OtherRefractions,
    /// Reflected inside at least once, in part or totally.
    InternalReflection,
    /// Refracted in and out, and reflected after that off the outside of a body it met again.
    OutsideReflection,
}

impl PhotonClass {
    /// All of them, in the order in which arrays by class are kept.
    pub const ALL: [Self; 5] = [
        Self::TwoRefractions,
        Self::FirstReflection,
        Self::OtherRefractions,
        Self::InternalReflection,
        Self::OutsideReflection,
    ];
}

/// What happened to light so far.
#[derive(Clone, Copy, Default)]
pub(super) struct History {
    refractions: u32,
    first_reflection: bool,
    internal_reflection: bool,
    outside_reflection: bool,
}

impl History {
    pub(super) fn refracted(self) -> Self {
        Self { refractions: self.refractions + 1, ..self }
    }

    /// Through a sheet and out of it again.
    pub(super) fn through_sheet(self) -> Self {
        Self { refractions: self.refractions.max(2), ..self }
    }

    pub(super) fn reflected_outside(self) -> Self {
        let first = self.refractions == 0 && !self.internal_reflection && !self.outside_reflection;
        Self { first_reflection: self.first_reflection || first, outside_reflection: true, ..self }
    }

    pub(super) fn reflected_inside(self) -> Self {
        Self { internal_reflection: true, ..self }
    }

    pub(super) fn class(self) -> PhotonClass {
        if self.first_reflection {
            PhotonClass::FirstReflection
        } else if self.internal_reflection {
            PhotonClass::InternalReflection
        } else if self.refractions != 2 {
            PhotonClass::OtherRefractions
        } else if self.outside_reflection {
            PhotonClass::OutsideReflection
        } else {
            PhotonClass::TwoRefractions
        }
    }
}

/// Where the light went, watts, linear RGB. `emitted = missed + hit`, and `hit` is the sum of all that follow it but
/// `first_reflected` and `in_window`, which are parts of others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonAccount {
    /// Sent towards the glass.
    pub emitted: DVec3,
    /// Met no glass, or something opaque first.
    pub missed: DVec3,
    /// Met glass.
    pub hit: DVec3,
    /// Reflected at the first interface.
    pub first_reflected: DVec3,
    /// Absorbed inside, and by the tint.
    pub absorbed: DVec3,
    /// Given up because too little was left to follow.
    pub pruned: DVec3,
    /// Given up at the limit of interfaces.
    pub dropped: DVec3,
    /// Reached the receiver, by [`PhotonClass`]; of a plane, within the window or not.
    pub arrived: [DVec3; 5],
    /// Reached the window of a plane, by class; all that arrived on other receivers.
    pub in_window: [DVec3; 5],
    /// Left for the surroundings, or for opaque things that are not the receiver, by class.
    pub escaped: [DVec3; 5],
    /// Photons sent.
    pub photons: u64,
    /// Rays traced, to glass or to a receiver.
    pub rays: u64,
}

impl PhotonAccount {
    /// What is missing from the balance, as a part of what was emitted: rounding. The worst channel.
    pub fn imbalance(&self) -> f64 {
        let received: DVec3 = self.arrived.iter().chain(&self.escaped).sum();
        let hit = self.hit - self.absorbed - self.pruned - self.dropped - received;
        let sent = self.emitted - self.missed - self.hit;
        let scale = self.emitted.max_element().max(f64::MIN_POSITIVE);
        (hit.abs() / scale).max_element().max((sent.abs() / scale).max_element())
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (sum, part) in [
            (&mut self.emitted, other.emitted),
            (&mut self.missed, other.missed),
            (&mut self.hit, other.hit),
            (&mut self.first_reflected, other.first_reflected),
            (&mut self.absorbed, other.absorbed),
            (&mut self.pruned, other.pruned),
            (&mut self.dropped, other.dropped),
        ] {
            *sum += part;
        }
        for (sums, parts) in [
            (&mut self.arrived, &other.arrived),
            (&mut self.in_window, &other.in_window),
            (&mut self.escaped, &other.escaped),
        ] {
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += *part);
        }
        self.photons += other.photons;
        self.rays += other.rays;
    }
}
