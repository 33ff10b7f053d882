//! Which glass light runs in.

use crate::Facing;

/// Bodies that can be within one another at a point; what comes on top of that many is taken as air.
const MOST: usize = 8;

/// The bodies that light is within. Where several overlap, the one of the least volume displaces the others
/// ([`crate::World::medium`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Within {
    bodies: [u32; MOST],
    count: usize,
}

impl Within {
    /// Their indices.
    pub fn bodies(&self) -> impl Iterator<Item = usize> {
        self.bodies[..self.count].iter().map(|&body| body as usize)
    }

    /// Whether it is none: air.
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Before and behind a face of a body that light meets from this side, whatever it was thought to be within.
    pub fn across(self, body: usize, facing: Facing) -> [Self; 2] {
        let (outside, inside) = (self.left(body), self.entered(body));
        match facing {
            Facing::Front => [outside, inside],
            Facing::Back => [inside, outside],
        }
    }

    /// And another one.
    #[must_use]
    pub fn entered(mut self, body: usize) -> Self {
        if self.count < MOST && self.bodies().all(|other| other != body) {
            self.bodies[self.count] = body as u32;
            self.count += 1;
        }
        self
    }

    /// Less one of them.
    #[must_use]
    pub fn left(mut self, body: usize) -> Self {
        let place = self.bodies().position(|other| other == body);
        if let Some(place) = place {
            self.count -= 1;
            self.bodies[place] = self.bodies[self.count];
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_entered_once_and_left_in_any_order() {
        let within = Within::default().entered(3).entered(7).entered(3).left(3).left(5);
        assert_eq!(within.bodies().collect::<Vec<_>>(), [7]);
        assert!(within.left(7).is_none());
        let crowded = (0..20).fold(Within::default(), Within::entered);
        assert_eq!(crowded.bodies().count(), MOST);
    }
}
