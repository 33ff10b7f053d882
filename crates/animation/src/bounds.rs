//! Axis-aligned boxes, and the box of a posed body without deforming its vertices.

use glam::{DMat4, DVec3};
use murano_scene::Skinning;

use crate::companies::Company;
use crate::geometry::{Geometry, PaletteEntry};
use crate::motion::Motion;
use crate::pose::Pose;

/// Share of its own diagonal by which a posed box is widened, so that it also holds the vertices as f32 arithmetic
/// finds them (which is held to 1e-5 of the body's diameter).
const DEFORMATION_MARGIN: f64 = 1e-5;

/// Share of its distance from the world's origin by which it is widened, for the rounding of f64 matrices.
const WORLD_MARGIN: f64 = 1e-12;

/// An axis-aligned box, metres. Empty when `min` exceeds `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box of one point.
    pub const fn point(point: DVec3) -> Self {
        Self { min: point, max: point }
    }

    /// The smallest box around points; empty without any.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        let mut bounds = Self::EMPTY;
        points.into_iter().for_each(|point| bounds.include(point));
        bounds
    }

    /// Grows to hold a point.
    pub fn include(&mut self, point: DVec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Whether a point lies inside or on the border.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// The middle; the origin for an empty box.
    pub fn center(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.min.midpoint(self.max) }
    }

    /// Length of the diagonal, metres: at least the diameter of what is inside, at most sqrt(3) times as much.
    pub fn diameter(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.distance(self.max) }
    }

    /// The box widened by a distance on every side; an empty one stays empty.
    #[must_use]
    pub fn widened(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// The box that holds its points after displacements inside of others, each times a weight.
    #[must_use]
    pub(crate) fn morphed(self, displacements: &[Self], weights: &[f64]) -> Self {
        displacements.iter().zip(weights).fold(self, |morphed, (displacement, &weight)| {
            let (a, b) = (displacement.min * weight, displacement.max * weight);
            Self { min: morphed.min + a.min(b), max: morphed.max + a.max(b) }
        })
    }

    /// Its eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let high = |axis: usize| if corner >> axis & 1 == 1 { self.max[axis] } else { self.min[axis] };
            DVec3::new(high(0), high(1), high(2))
        })
    }

    /// The box around the image of this one under an affine map (Arvo, "Transforming axis-aligned bounding boxes",
    /// Graphics Gems, 1990).
    #[must_use]
    pub fn transformed(self, matrix: &DMat4) -> Self {
        if self.is_empty() {
            return self;
        }
        let half = (self.max - self.min) * 0.5;
        let center = matrix.transform_point3(self.center());
        let reach = matrix.x_axis.truncate().abs() * half.x
            + matrix.y_axis.truncate().abs() * half.y
            + matrix.z_axis.truncate().abs() * half.z;
        Self { min: center - reach, max: center + reach }
    }
}

impl PaletteEntry {
    /// World bounds of what this matrix makes of the vertices that it influences. A skinned vertex is a convex
    /// combination of such images, so it lies in the box around all of an instance's entries.
    fn posed_bounds(&self, pose: &Pose, weights: &[f64]) -> Bounds {
        self.rest
            .morphed(&self.displacements, weights)
            .transformed(&(pose.world_from_node[self.node] * self.node_from_vertex))
    }
}

impl Geometry {
    /// World bounds of each posed instance, without deforming its vertices: never too small, usually a little too large.
    pub fn posed_instance_bounds(&self, pose: &Pose) -> Vec<Bounds> {
        let motions: Vec<Motion> = match self.skinning {
            Skinning::Linear => Vec::new(),
            Skinning::DualQuaternion => {
                self.palette_entries.iter().map(|entry| Motion::of(&entry.world_from_vertex(pose))).collect()
            }
        };
        let bounds_of = |instance: &crate::Instance| {
            let entries = &self.palette_entries[instance.palette.start as usize..instance.palette.end as usize];
            let weights = &pose.weights[instance.node];
            let bounds = match self.skinning {
                Skinning::Linear => {
                    entries.iter().map(|entry| entry.posed_bounds(pose, weights)).fold(Bounds::EMPTY, Bounds::union)
                }
                Skinning::DualQuaternion => {
                    let companies = &self.companies[instance.companies.start as usize..instance.companies.end as usize];
                    let of = |company: &Company| company.posed_bounds(&motions, weights);
                    companies.iter().map(of).fold(Bounds::EMPTY, Bounds::union)
                }
            };
            let reach = bounds.center().abs().max_element();
            bounds.widened(DEFORMATION_MARGIN * bounds.diameter() + WORLD_MARGIN * reach)
        };
        self.instances.iter().map(bounds_of).collect()
    }

    /// World bounds of everything posed: the union of [`Self::posed_instance_bounds`].
    pub fn posed_bounds(&self, pose: &Pose) -> Bounds {
        self.posed_instance_bounds(pose).into_iter().fold(Bounds::EMPTY, Bounds::union)
    }
}
