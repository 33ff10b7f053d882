//! Triangle meshes: a library's bounding-volume hierarchy in f32 proposes triangles, a watertight test in f64 decides.
//!
//! The hierarchy is built in a space where the mesh fills the unit ball around the origin, over boxes grown by more than
//! the rounding of f32 there. So no scale and no distance from the origin loses a triangle.

use glam::{DVec3, Vec3, Vec3A};
use murano_animation::Deformed;
use obvhs::{
    Boundable,
    aabb::Aabb,
    bvh2::reinsertion::ReinsertionOptimizer,
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
    ray,
};

use crate::{Departure, Facing, Hit, Ray};

/// How far boxes are grown, in radii of the mesh: well above the rounding of f32 at 1, well below any feature.
const GROWTH: f32 = 2e-6;
/// Hits nearer than this after leaving a triangle are rounding, in radii of the mesh.
const NEAREST: f64 = 1e-13;

/// Why a mesh cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidMesh {
    /// A vertex is not a point.
    #[error("vertex {0} has a position or a normal that is not finite; repair the mesh before tracing it")]
    NotFinite(usize),
    /// A triangle names a vertex that is not there.
    #[error("triangle {0} refers to a vertex that does not exist; repair the mesh before tracing it")]
    MissingVertex(usize),
    /// Positions and normals differ in number.
    #[error("there are {positions} positions but {normals} normals; give one normal a vertex")]
    Unequal {
        /// Positions given.
        positions: usize,
        /// Normals given.
        normals: usize,
    },
}

/// Triangles with vertex normals, ready to be traced.
pub struct TriangleMesh {
    corners: Vec<[DVec3; 3]>,
    normals: Vec<[DVec3; 3]>,
    bvh: CwBvh,
    /// `bvh.primitive_indices`' triangles side by side in memory, in the order in which traversal asks for them.
    ordered: Vec<[DVec3; 3]>,
    centre: DVec3,
    radius: f64,
    volume: f64,
}

struct TriangleBox(Aabb);

impl Boundable for TriangleBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl TriangleMesh {
    /// Builds the hierarchy. Positions in metres, world; normals unit and outward (zero: the triangle's own is used);
    /// triangles counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`InvalidMesh`] names the vertex or triangle.
    pub fn new(positions: &[DVec3], normals: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, InvalidMesh> {
        if positions.len() != normals.len() {
            return Err(InvalidMesh::Unequal { positions: positions.len(), normals: normals.len() });
        }
        if let Some(vertex) = positions.iter().zip(normals).position(|(p, n)| !(p.is_finite() && n.is_finite())) {
            return Err(InvalidMesh::NotFinite(vertex));
        }
        if let Some(triangle) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= positions.len())) {
            return Err(InvalidMesh::MissingVertex(triangle));
        }
        let gather = |list: &[DVec3]| triangles.iter().map(|t| t.map(|v| list[v as usize])).collect::<Vec<_>>();
        Ok(Self::build(gather(positions), gather(normals)))
    }

    /// A deformed body.
    ///
    /// # Errors
    /// [`InvalidMesh`] names the vertex or triangle.
    pub fn of(deformed: &Deformed, triangles: &[[u32; 3]]) -> Result<Self, InvalidMesh> {
        Self::new(&deformed.positions, &deformed.normals, triangles)
    }

    fn build(corners: Vec<[DVec3; 3]>, normals: Vec<[DVec3; 3]>) -> Self {
        let all = || corners.iter().flatten();
        let low = all().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = all().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        let centre = if corners.is_empty() { DVec3::ZERO } else { 0.5 * (low + high) };
        let radius = all().map(|p| p.distance(centre)).fold(0.0, f64::max).max(f64::MIN_POSITIVE.sqrt());
        let boxes: Vec<TriangleBox> = corners
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|p| Vec3A::from(((p - centre) / radius).as_vec3()));
                let growth = Vec3A::splat(GROWTH);
                TriangleBox(Aabb::new(a.min(b).min(c) - growth, a.max(b).max(c) + growth))
            })
            .collect();
        let mut bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Medium,
            &boxes,
            (0..boxes.len() as u32).collect(),
            SortPrecision::U64,
            3,
        );
        ReinsertionOptimizer::default().run(&mut bvh2, 0.05, None);
        let bvh = bvh2_to_cwbvh(&bvh2, 3, true, false);
        let ordered = bvh.primitive_indices.iter().map(|&index| corners[index as usize]).collect();
        // About the centre, where least cancels.
        let sixth = |[a, b, c]: &[DVec3; 3]| (*a - centre).dot((*b - centre).cross(*c - centre)) / 6.0;
        let volume = corners.iter().map(sixth).sum::<f64>().abs();
        Self { corners, normals, bvh, ordered, centre, radius, volume }
    }

    /// Triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Corners of a triangle, world, metres.
    pub fn triangle(&self, index: usize) -> [DVec3; 3] {
        self.corners[index]
    }

    /// How much a closed mesh encloses, cubic metres.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Centre and radius of a ball around the mesh, metres.
    pub fn ball(&self) -> (DVec3, f64) {
        (self.centre, self.radius)
    }

    /// The nearest triangle that the ray meets from the wanted side within `farthest` metres.
    pub fn nearest(&self, ray: &Ray, from: Departure, facing: Option<Facing>, farthest: f64) -> Option<Hit> {
        let (near, far) = self.span(ray, farthest)?;
        let test = WatertightTest::new(ray);
        let least = if from == Departure::Free { 0.0 } else { NEAREST * self.radius };
        let mut best: Option<(f64, u32, DVec3)> = None;
        let mut found = ray::RayHit::none();
        self.bvh.ray_traverse(self.unit_ray(ray, near, far), &mut found, |_, slot| {
            let element = self.bvh.primitive_indices[slot];
            if from == Departure::Element(element) {
                return f32::INFINITY;
            }
            let Some((t, weights)) = test.cross(&self.ordered[slot], facing) else { return f32::INFINITY };
            // Of two triangles at one distance the lower number wins, whatever the order of traversal.
            let nearer = best.is_none_or(|(other, index, _)| t < other || (t == other && element < index));
            if t <= least || t > farthest || !nearer {
                return f32::INFINITY;
            }
            best = Some((t, element, weights));
            (((t - near) / self.radius) as f32) * (1.0 + 1e-6) + GROWTH
        });
        best.map(|(t, element, weights)| self.hit(ray, t, element, weights))
    }

    /// Whether the ray meets any triangle within `farthest` metres.
    pub fn blocks(&self, ray: &Ray, from: Departure, farthest: f64) -> bool {
        let Some((near, far)) = self.span(ray, farthest) else { return false };
        let test = WatertightTest::new(ray);
        let least = if from == Departure::Free { 0.0 } else { NEAREST * self.radius };
        !self.bvh.ray_traverse_miss(self.unit_ray(ray, near, far), |_, slot| {
            if from == Departure::Element(self.bvh.primitive_indices[slot]) {
                return f32::INFINITY;
            }
            match test.cross(&self.ordered[slot], None) {
                Some((t, _)) if t > least && t <= farthest => 0.0,
                _ => f32::INFINITY,
            }
        })
    }

    /// Where along the ray the mesh can be: its passage through the ball, in f64, so that the hierarchy sees small numbers.
    fn span(&self, ray: &Ray, farthest: f64) -> Option<(f64, f64)> {
        if self.corners.is_empty() || ray.direction == DVec3::ZERO {
            return None;
        }
        let to_centre = self.centre - ray.origin;
        let middle = to_centre.dot(ray.direction);
        let off_axis = to_centre - middle * ray.direction;
        let radius = 1.001 * self.radius;
        let half = radius * radius - off_axis.length_squared();
        if half < 0.0 {
            return None;
        }
        let half = half.sqrt();
        let (near, far) = ((middle - half).max(0.0), (middle + half).min(farthest));
        (near <= far).then_some((near, far))
    }

    fn unit_ray(&self, ray: &Ray, near: f64, far: f64) -> ray::Ray {
        let origin = ((ray.at(near) - self.centre) / self.radius).as_vec3();
        let reach = ((far - near) / self.radius) as f32 * (1.0 + 1e-6) + GROWTH;
        // Without negative zeros, whose sign the hierarchy would take for a direction.
        let direction = ray.direction.as_vec3() + Vec3::ZERO;
        ray::Ray::new(origin.into(), direction.into(), 0.0, reach)
    }

    fn hit(&self, ray: &Ray, t: f64, element: u32, weights: DVec3) -> Hit {
        let [a, b, c] = self.corners[element as usize];
        let [na, nb, nc] = self.normals[element as usize];
        let geometric = (b - a).cross(c - a).normalize_or_zero();
        let normal = (weights.x * na + weights.y * nb + weights.z * nc).normalize_or(geometric);
        let position = weights.x * a + weights.y * b + weights.z * c;
        debug_assert!(position.distance(ray.at(t)) < 1e-6 * self.radius + 1e-9 * t);
        Hit { t, position, geometric, normal, element, barycentric: weights }
    }
}

/// The watertight test of Woop, Benthin and Wald (JCGT 2013), in f64: corners are sheared into a space where the ray runs
/// along +z, and edge functions of shared edges are equal to the bit.
struct WatertightTest {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl WatertightTest {
    fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = d.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            // Keeps the winding.
            (x, y) = (y, x);
        }
        Self { origin: ray.origin, axes: [x, y, z], shear: DVec3::new(d[x] / d[z], d[y] / d[z], 1.0 / d[z]) }
    }

    /// Distance and weights of the corners, if the triangle is met from the wanted side ahead of the origin.
    fn cross(&self, triangle: &[DVec3; 3], facing: Option<Facing>) -> Option<(f64, DVec3)> {
        let [x, y, z] = self.axes;
        let sheared = triangle.map(|corner| {
            let p = corner - self.origin;
            (p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], self.shear.z * p[z])
        });
        let [(ax, ay, az), (bx, by, bz), (cx, cy, cz)] = sheared;
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        // Positive: seen from outside, since the shear looks along the ray.
        let inside = match facing {
            Some(Facing::Front) => u >= 0.0 && v >= 0.0 && w >= 0.0,
            Some(Facing::Back) => u <= 0.0 && v <= 0.0 && w <= 0.0,
            None => (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0),
        };
        let sum = u + v + w;
        if !inside || sum == 0.0 {
            return None;
        }
        let weights = DVec3::new(u, v, w) / sum;
        let t = weights.dot(DVec3::new(az, bz, cz));
        (t >= 0.0 && weights.is_finite()).then_some((t, weights))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TriangleMesh {
        let positions = [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 2.0, 0.0)];
        TriangleMesh::new(&positions, &[DVec3::Z; 3], &[[0, 1, 2]]).unwrap()
    }

    #[test]
    fn sides_are_told_apart() {
        let mesh = triangle();
        for (origin, direction, side, other) in [
            (DVec3::new(0.1, 0.2, 3.0), DVec3::NEG_Z, Facing::Front, Facing::Back),
            (DVec3::new(0.1, 0.2, -3.0), DVec3::Z, Facing::Back, Facing::Front),
        ] {
            let ray = Ray { origin, direction };
            let hit = mesh.nearest(&ray, Departure::Free, Some(side), f64::INFINITY).unwrap();
            assert!((hit.t - 3.0).abs() < 1e-15 && hit.position.distance(DVec3::new(0.1, 0.2, 0.0)) < 1e-15);
            assert_eq!(hit.geometric, DVec3::Z);
            assert_eq!(hit.facing(direction), side);
            assert_eq!(mesh.nearest(&ray, Departure::Free, Some(other), f64::INFINITY), None);
            assert_eq!(mesh.nearest(&ray, Departure::Element(0), None, f64::INFINITY), None);
            assert!(mesh.blocks(&ray, Departure::Free, 3.5) && !mesh.blocks(&ray, Departure::Free, 2.5));
        }
    }

    #[test]
    fn broken_meshes_are_refused() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::NAN];
        assert_eq!(TriangleMesh::new(&p, &[DVec3::Z; 3], &[]).err(), Some(InvalidMesh::NotFinite(2)));
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(TriangleMesh::new(&p, &[DVec3::Z; 3], &[[0, 1, 3]]).err(), Some(InvalidMesh::MissingVertex(0)));
        assert!(matches!(TriangleMesh::new(&p, &[], &[]), Err(InvalidMesh::Unequal { .. })));
        let none = TriangleMesh::new(&[], &[], &[]).unwrap();
        assert!(
            none.is_empty() && !none.blocks(&Ray { origin: DVec3::ZERO, direction: DVec3::X }, Departure::Free, 1.0)
        );
    }
}
