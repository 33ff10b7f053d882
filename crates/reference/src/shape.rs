//! Shapes a body can have.

use glam::DVec3;

use crate::{Ball, Departure, Facing, Hit, Ray, TriangleMesh};

/// The surface of a body.
pub enum Shape {
    /// Triangles.
    Mesh(TriangleMesh),
    /// An ellipsoid or a sphere.
    Ellipsoid(Ellipsoid),
    /// A slab, a prism, any convex solid with plane faces.
    Convex(Convex),
}

impl Shape {
    /// The nearest place where the ray meets the surface from the wanted side within `farthest` metres.
    pub fn nearest(&self, ray: &Ray, from: Departure, facing: Option<Facing>, farthest: f64) -> Option<Hit> {
        match self {
            Self::Mesh(mesh) => mesh.nearest(ray, from, facing, farthest),
            Self::Ellipsoid(ellipsoid) => ellipsoid.nearest(ray, from, facing, farthest),
            Self::Convex(convex) => convex.nearest(ray, from, facing, farthest),
        }
    }

    /// A ball around it; `None` for what plane faces bound, which may be infinite.
    pub fn ball(&self) -> Option<Ball> {
        match self {
            Self::Mesh(mesh) => {
                let (centre, radius) = mesh.ball();
                Some(Ball { centre, radius })
            }
            Self::Ellipsoid(ellipsoid) => {
                Some(Ball { centre: ellipsoid.centre, radius: ellipsoid.radii.max_element() })
            }
            Self::Convex(_) => None,
        }
    }

    /// How much is inside of it, cubic metres; infinite for what plane faces bound.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.volume(),
            Self::Ellipsoid(ellipsoid) => 4.0 / 3.0 * std::f64::consts::PI * ellipsoid.radii.element_product(),
            Self::Convex(_) => f64::INFINITY,
        }
    }

    /// Whether the ray meets the surface, from either side, within `farthest` metres.
    pub fn blocks(&self, ray: &Ray, from: Departure, farthest: f64) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.blocks(ray, from, farthest),
            Self::Ellipsoid(_) | Self::Convex(_) => self.nearest(ray, from, None, farthest).is_some(),
        }
    }
}

/// An ellipsoid with its axes along the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// World, metres.
    pub centre: DVec3,
    /// Half-axes, metres, positive.
    pub radii: DVec3,
}

impl Ellipsoid {
    fn nearest(&self, ray: &Ray, from: Departure, facing: Option<Facing>, farthest: f64) -> Option<Hit> {
        // In the space where it is the unit ball.
        let o = (ray.origin - self.centre) / self.radii;
        let d = ray.direction / self.radii;
        let (a, half_b) = (d.length_squared(), o.dot(d));
        let roots = if from == Departure::Free {
            // |o + t d|^2 = 1 by the distance of the line from the centre, which does not cancel for far origins.
            let line = o - half_b / a * d;
            let rest = 1.0 - line.length_squared();
            if rest < 0.0 {
                return None;
            }
            let half = (rest / a).sqrt();
            [-half_b / a - half, -half_b / a + half]
        } else {
            // One root is the start itself.
            [0.0, -2.0 * half_b / a]
        };
        roots.into_iter().filter(|&t| t > 0.0 && t <= farthest).find_map(|t| {
            let position = ray.at(t);
            let geometric = ((position - self.centre) / (self.radii * self.radii)).normalize();
            let hit = Hit { t, position, geometric, normal: geometric, element: 0, barycentric: DVec3::ZERO };
            facing.is_none_or(|side| side == hit.facing(ray.direction)).then_some(hit)
        })
    }
}

/// The half-space `dot(normal, p) <= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit, outward.
    pub normal: DVec3,
    /// Metres from the origin along the normal.
    pub offset: f64,
}

/// What is inside of every one of some half-spaces; unbounded where they leave it so.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    /// Faces.
    pub faces: Vec<Plane>,
}

impl Convex {
    /// The infinite slab between y = 0 and y = -thickness.
    pub fn slab(thickness: f64) -> Self {
        let faces = vec![Plane { normal: DVec3::Y, offset: 0.0 }, Plane { normal: DVec3::NEG_Y, offset: thickness }];
        Self { faces }
    }

    fn nearest(&self, ray: &Ray, from: Departure, facing: Option<Facing>, farthest: f64) -> Option<Hit> {
        // The ray is inside between its last entry and its first exit.
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, None), (f64::INFINITY, None));
        for (element, plane) in (0u32..).zip(&self.faces) {
            if from == Departure::Element(element) {
                continue;
            }
            let speed = plane.normal.dot(ray.direction);
            let t = (plane.offset - plane.normal.dot(ray.origin)) / speed;
            if speed < 0.0 && t > enter.0 {
                enter = (t, Some(element));
            } else if speed > 0.0 && t < leave.0 {
                leave = (t, Some(element));
            } else if speed == 0.0 && plane.normal.dot(ray.origin) > plane.offset {
                return None;
            }
        }
        if enter.0 > leave.0 {
            return None;
        }
        [(enter, Facing::Front), (leave, Facing::Back)].into_iter().find_map(|((t, element), side)| {
            let element = element?;
            let wanted = t > 0.0 && t <= farthest && facing.is_none_or(|facing| facing == side);
            let normal = self.faces[element as usize].normal;
            let hit = Hit { t, position: ray.at(t), geometric: normal, normal, element, barycentric: DVec3::ZERO };
            wanted.then_some(hit)
        })
    }
}
