//! Photons: light traced from a lamp through the glass to a receiver, every watt accounted for.
//!
//! A light's pencil towards the glass is cut into two square grids of photons, jittered within their cells; every photon
//! carries the flux of its cell. At each interface it splits into what is refracted and what is reflected (Fresnel,
//! unpolarised at every interface), until a part arrives, leaves, or carries less than a set part of the photon. So the only
//! noise is that of where the photons start, and the difference of the two grids measures it.
//!
//! What comes out depends on the seed alone, to the bit: photons are numbered, traced in chunks, and summed in their order.

mod class;
mod emission;
mod map;
mod transport;
mod window;

use glam::{DVec2, DVec3};
use murano_scene::PlacedLight;
use rayon::prelude::*;

pub use class::{PhotonAccount, PhotonClass};
pub use emission::Ball;
pub use map::{CausticMap, Noise, caustic_map, direct_irradiance};
pub use window::{Receiver, Window};

use crate::{World, sampler::Sampler};
use emission::{Emission, Source, glass_ball};
use transport::Transport;

/// Photons that one task traces.
const CHUNK: u64 = 1024;
/// Tasks between two reports of progress: what lies in memory at a time.
const WAVE: u64 = 64;

/// How photons are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonTracing {
    /// Photons to send, at least: rounded up to two square grids.
    pub photons: u64,
    /// Places the photons within their cells.
    pub seed: u64,
    /// Interfaces that light may meet.
    pub interfaces: u32,
    /// Light is followed while it carries more than this part of its photon.
    pub least_weight: f64,
    /// What to shine at instead of a ball around all glass: a part of a body without bounds.
    pub aim: Option<Ball>,
}

impl Default for PhotonTracing {
    fn default() -> Self {
        Self { photons: 1 << 20, seed: 0, interfaces: 64, least_weight: 1e-4, aim: None }
    }
}

/// Light that reached the receiver. World space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Where, metres.
    pub position: DVec3,
    /// Unit; where it was going.
    pub direction: DVec3,
    /// Watts, linear RGB.
    pub flux: DVec3,
    /// What it went through.
    pub class: PhotonClass,
    /// Triangle of the opaque mesh, and the weights of its corners; `None` on a plane.
    pub triangle: Option<(u32, DVec3)>,
    /// Which of the two independent grids sent it, 0 or 1; each carries half of the light.
    pub half: usize,
}

/// Why photons cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PhotonError {
    /// A body reaches to infinity.
    #[error("body {0} has no bounds to shine at; set `aim` to the ball of it that is to be lit")]
    Unbounded(usize),
    /// The window has no area.
    #[error("the window has no texels or no area; give it two half-widths that differ in direction and a size above 0")]
    NoWindow,
}

/// Sends photons and hands on what the receiver gets, in an order that depends on nothing but the seed. `progress` is told the
/// photons done and to be done. Without glass nothing is sent.
///
/// # Errors
/// [`PhotonError`]: the receiver is no window, or there is nothing to aim at.
pub fn trace_photons(
    world: &World,
    light: &PlacedLight,
    receiver: &Receiver,
    tracing: &PhotonTracing,
    progress: &(dyn Fn(usize, usize) + Sync),
    receive: &mut dyn FnMut(&Landing),
) -> Result<PhotonAccount, PhotonError> {
    if let Receiver::Plane(window) = receiver {
        window.check()?;
    }
    let mut account = PhotonAccount::default();
    let aim = match tracing.aim {
        Some(ball) => Some(ball),
        None => glass_ball(world)?,
    };
    let Some(ball) = aim else { return Ok(account) };
    let source = Source::new(light);
    let emission = source.towards(ball, upstream(world, ball, &source));

    let side = (tracing.photons.max(1) as f64 / 2.0).sqrt().ceil() as u64;
    let grid = Grid { side, seed: tracing.seed };
    let total = 2 * side * side;
    let chunks = total.div_ceil(CHUNK);
    for wave in (0..chunks).step_by(WAVE as usize) {
        let last = (wave + WAVE).min(chunks);
        let traced: Vec<(PhotonAccount, Vec<Landing>)> = (wave..last)
            .into_par_iter()
            .map(|chunk| {
                let mut transport = Transport::new(world, receiver, tracing);
                for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(total) {
                    trace_one(&mut transport, &emission, &grid, index);
                }
                (transport.account, transport.landings)
            })
            .collect();
        for (part, landings) in traced {
            account.add(&part);
            landings.iter().for_each(&mut *receive);
        }
        progress((last * CHUNK).min(total) as usize, total as usize);
    }
    Ok(account)
}

fn trace_one(transport: &mut Transport, emission: &Emission, grid: &Grid, index: u64) {
    let (place, half) = grid.place(index);
    let (ray, flux) = emission.photon(place, 0.5 / (grid.side * grid.side) as f64);
    let before = transport.landings.len();
    transport.photon(ray, flux);
    transport.landings[before..].iter_mut().for_each(|landing| landing.half = half);
}

/// How far before a ball parallel light starts: before the ball and all opaque things.
fn upstream(world: &World, ball: Ball, source: &Source) -> f64 {
    let (direction, _) = source.ray_to(ball.centre);
    let shadows = world.opaque.as_ref().map_or(0.0, |opaque| {
        let (centre, radius) = opaque.mesh.ball();
        (ball.centre - centre).dot(direction) + radius
    });
    shadows.max(2.0 * ball.radius)
}

/// Two grids over the unit square with one place in each cell.
struct Grid {
    side: u64,
    seed: u64,
}

impl Grid {
    /// The place of a photon, and which grid it belongs to.
    fn place(&self, index: u64) -> (DVec2, usize) {
        let cells = self.side * self.side;
        let (half, cell) = (index / cells, index % cells);
        let corner = DVec2::new((cell % self.side) as f64, (cell / self.side) as f64);
        let jitter = DVec2::from_array(Sampler::new(self.seed, cell, half).pair());
        ((corner + jitter) / self.side as f64, half as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_either_grid_holds_one_place() {
        let grid = Grid { side: 16, seed: 7 };
        let mut seen = vec![0; 512];
        for index in 0..512 {
            let (place, half) = grid.place(index);
            let cell = (place * 16.0).floor();
            seen[half * 256 + (cell.y * 16.0 + cell.x) as usize] += 1;
        }
        assert!(seen.iter().all(|&count| count == 1));
        assert_ne!(grid.place(0).0, Grid { seed: 8, ..grid }.place(0).0, "seeds place photons differently");
    }
}
