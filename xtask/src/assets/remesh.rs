//! Remeshing of an implicit surface to triangles as fine as its curvature asks: rounds of edge splits, collapses, flips
//! and tangential smoothing (Botsch and Kobbelt 2004), with a sizing field (Dunyach et al. 2013).

use glam::DVec3;

use super::implicit::{gradient, max_curvature, project};
use super::surface::Surface;

const ROUNDS: usize = 8;
/// Curvature is measured anew after this many rounds.
const MEASURED: usize = 3;
/// Edges longer than this share of the wanted length are split, shorter ones than its inverse counterpart collapsed.
const SPLIT: f64 = 4.0 / 3.0;
const COLLAPSE: f64 = 4.0 / 5.0;
/// Growth of the wanted length per metre along the surface, so that triangle sizes change gently.
const GRADING: f64 = 0.35;
/// Cosine between a triangle and the surface below which an operation would crease or fold the mesh.
const UPRIGHT: f64 = 0.8;

/// How fine a mesh is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    /// Distance between an edge's middle and the surface, metres.
    pub error: f64,
    /// Shortest edge, metres.
    pub finest: f64,
    /// Longest edge, metres.
    pub coarsest: f64,
}

impl Resolution {
    /// Edge length whose chord leaves a circle of curvature `curvature` by `error`.
    fn edge(self, curvature: f64) -> f64 {
        (8.0 * self.error / curvature.max(1e-9)).sqrt().clamp(self.finest, self.coarsest)
    }
}

/// Remeshes `surface`, a closed manifold near the zero set of `field`. Vertices and normals are the field's own.
pub fn remesh(field: &dyn Fn(DVec3) -> f64, surface: Surface, resolution: Resolution) -> Surface {
    let mut mesh = Mesh::new(field, surface, resolution);
    for round in 0..ROUNDS {
        // Vertices move little between rounds, and new ones take their neighbours' size.
        if round % MEASURED == 0 {
            mesh.measure();
        }
        mesh.split_long_edges();
        mesh.collapse_short_edges();
        mesh.flip_edges();
        mesh.relax();
    }
    mesh.finish()
}

const DEAD: [u32; 3] = [u32::MAX; 3];

struct Mesh<'a> {
    field: &'a dyn Fn(DVec3) -> f64,
    resolution: Resolution,
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Wanted edge length at each vertex, metres.
    sizes: Vec<f64>,
    triangles: Vec<[u32; 3]>,
    /// Triangles round each vertex; empty for a vertex that is gone.
    stars: Vec<Vec<u32>>,
}

impl<'a> Mesh<'a> {
    fn new(field: &'a dyn Fn(DVec3) -> f64, surface: Surface, resolution: Resolution) -> Self {
        let Surface { positions, normals, triangles } = surface;
        let mut stars = vec![Vec::new(); positions.len()];
        for (index, triangle) in triangles.iter().enumerate() {
            for &corner in triangle {
                stars[corner as usize].push(index as u32);
            }
        }
        Self { field, resolution, sizes: vec![0.0; positions.len()], positions, normals, triangles, stars }
    }

    fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.position(a).distance(self.position(b))
    }

    fn wanted(&self, a: u32, b: u32) -> f64 {
        self.sizes[a as usize].min(self.sizes[b as usize])
    }

    /// Every edge once, lower vertex first.
    fn edges(&self) -> Vec<(u32, u32)> {
        let corners = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        self.triangles.iter().filter(|t| **t != DEAD).flat_map(corners).filter(|(a, b)| a < b).collect()
    }

    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let mut ring: Vec<u32> =
            self.stars[vertex as usize].iter().map(|&t| next(self.triangles[t as usize], vertex)).collect();
        ring.sort_unstable();
        ring
    }

    /// The two triangles at edge (a, b), the one that runs from a to b first, with the corners opposite the edge.
    fn wings(&self, a: u32, b: u32) -> Option<[(u32, u32); 2]> {
        let find = |from: u32, to: u32| {
            let mut found = self.stars[from as usize].iter().filter(|&&t| next(self.triangles[t as usize], from) == to);
            let index = *found.next()?;
            Some((index, next(self.triangles[index as usize], to)))
        };
        Some([find(a, b)?, find(b, a)?])
    }

    /// Wanted edge lengths from the curvature, graded along the edges.
    fn measure(&mut self) {
        for vertex in 0..self.positions.len() {
            if !self.stars[vertex].is_empty() {
                let curvature = max_curvature(self.field, self.positions[vertex], self.resolution.finest * 0.5);
                self.sizes[vertex] = self.resolution.edge(curvature);
            }
        }
        let edges = self.edges();
        for _ in 0..4 {
            for &(a, b) in &edges {
                let slack = GRADING * self.length(a, b);
                let (i, j) = (a as usize, b as usize);
                self.sizes[i] = self.sizes[i].min(self.sizes[j] + slack);
                self.sizes[j] = self.sizes[j].min(self.sizes[i] + slack);
            }
        }
    }

    fn split_long_edges(&mut self) {
        for (a, b) in self.edges() {
            if self.length(a, b) <= SPLIT * self.wanted(a, b) {
                continue;
            }
            let Some([(left, c), (right, d)]) = self.wings(a, b) else { continue };
            let middle = self.positions.len() as u32;
            let position = project(self.field, (self.position(a) + self.position(b)) / 2.0, self.length(a, b) / 2.0);
            self.positions.push(position);
            self.normals.push(gradient(self.field, position).normalize());
            self.sizes.push(f64::midpoint(self.sizes[a as usize], self.sizes[b as usize]));
            self.stars.push(Vec::with_capacity(6));
            for triangle in [[middle, b, c], [middle, d, b]] {
                self.add(triangle);
            }
            for (index, triangle) in [(left, [a, middle, c]), (right, [middle, a, d])] {
                self.stars[b as usize].retain(|&t| t != index);
                self.stars[middle as usize].push(index);
                self.triangles[index as usize] = triangle;
            }
        }
    }

    fn add(&mut self, triangle: [u32; 3]) {
        for corner in triangle {
            self.stars[corner as usize].push(self.triangles.len() as u32);
        }
        self.triangles.push(triangle);
    }

    fn collapse_short_edges(&mut self) {
        for (a, b) in self.edges() {
            let gone = self.stars[a as usize].is_empty() || self.stars[b as usize].is_empty();
            if !gone && self.length(a, b) < COLLAPSE * self.wanted(a, b) {
                self.collapse(a, b);
            }
        }
    }

    /// Merges b into a, at the middle of their edge, where that keeps the surface a manifold, upright and not too
    /// coarse.
    fn collapse(&mut self, a: u32, b: u32) {
        let Some([(left, c), (right, d)]) = self.wings(a, b) else { return };
        let (ring_a, ring_b) = (self.neighbours(a), self.neighbours(b));
        let shared = ring_a.iter().filter(|v| ring_b.contains(v)).count();
        let valence = |v: u32| self.stars[v as usize].len();
        if shared != 2 || valence(c) <= 4 || valence(d) <= 4 || valence(a) + valence(b) > 14 {
            return;
        }
        let middle = project(self.field, (self.position(a) + self.position(b)) / 2.0, self.length(a, b) / 2.0);
        let normal = gradient(self.field, middle).normalize();
        let limit = SPLIT * self.wanted(a, b);
        if ring_a.iter().chain(&ring_b).any(|&v| self.position(v).distance(middle) > limit) {
            return;
        }
        let moved =
            |v: u32| if v == a || v == b { (middle, normal) } else { (self.position(v), self.normals[v as usize]) };
        let kept = self.stars[a as usize].iter().chain(&self.stars[b as usize]).filter(|&&t| t != left && t != right);
        if !kept.copied().all(|t| is_upright(self.triangles[t as usize].map(moved))) {
            return;
        }
        for index in [left, right] {
            for corner in self.triangles[index as usize] {
                self.stars[corner as usize].retain(|&t| t != index);
            }
            self.triangles[index as usize] = DEAD;
        }
        let orphans = std::mem::take(&mut self.stars[b as usize]);
        for &index in &orphans {
            let triangle = &mut self.triangles[index as usize];
            *triangle = triangle.map(|v| if v == b { a } else { v });
        }
        self.stars[a as usize].extend(orphans);
        self.positions[a as usize] = middle;
        self.normals[a as usize] = normal;
    }

    /// Flips edges where that brings the valences nearer to six.
    fn flip_edges(&mut self) {
        for (a, b) in self.edges() {
            let Some([(left, c), (right, d)]) = self.wings(a, b) else { continue };
            let excess = |v: u32, change: i64| {
                let off = self.stars[v as usize].len() as i64 - 6 + change;
                off * off
            };
            let before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
            let after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
            let corner = |v: u32| (self.position(v), self.normals[v as usize]);
            let flipped = [[a, d, c], [d, b, c]];
            if after >= before
                || self.stars[a as usize].len().min(self.stars[b as usize].len()) < 5
                || self.neighbours(c).contains(&d)
                || self.length(c, d) > SPLIT * self.wanted(c, d)
                || !flipped.iter().all(|triangle| is_upright(triangle.map(corner)))
            {
                continue;
            }
            self.triangles[left as usize] = flipped[0];
            self.triangles[right as usize] = flipped[1];
            self.stars[a as usize].retain(|&t| t != right);
            self.stars[b as usize].retain(|&t| t != left);
            self.stars[c as usize].push(right);
            self.stars[d as usize].push(left);
        }
    }

    /// Moves each vertex towards the centre of its neighbours, along the surface, unless a triangle would fold.
    fn relax(&mut self) {
        for vertex in 0..self.positions.len() as u32 {
            let ring = self.neighbours(vertex);
            if ring.is_empty() {
                continue;
            }
            let centre = ring.iter().map(|&n| self.position(n)).sum::<DVec3>() / ring.len() as f64;
            let (p, normal) = (self.position(vertex), self.normals[vertex as usize]);
            let shift = (centre - p).reject_from(normal) * 0.7;
            let position = project(self.field, p + shift, self.sizes[vertex as usize]);
            let normal = gradient(self.field, position).normalize();
            let corner =
                |v: u32| if v == vertex { (position, normal) } else { (self.position(v), self.normals[v as usize]) };
            let star = &self.stars[vertex as usize];
            if star.iter().all(|&t| is_upright(self.triangles[t as usize].map(corner))) {
                self.positions[vertex as usize] = position;
                self.normals[vertex as usize] = normal;
            }
        }
    }

    fn finish(self) -> Surface {
        let mut surface = Surface::default();
        let mut renamed = vec![u32::MAX; self.positions.len()];
        for triangle in self.triangles.iter().filter(|t| **t != DEAD) {
            let corners = triangle.map(|v| {
                let slot = &mut renamed[v as usize];
                if *slot == u32::MAX {
                    *slot = surface.push(self.positions[v as usize], self.normals[v as usize]);
                }
                *slot
            });
            surface.triangles.push(corners);
        }
        surface
    }
}

/// The corner after `vertex` in a triangle that has it.
fn next(triangle: [u32; 3], vertex: u32) -> u32 {
    let place = triangle.iter().position(|&v| v == vertex).unwrap_or(0);
    triangle[(place + 1) % 3]
}

/// Whether a triangle, given as positions and surface normals, faces the way the surface does.
fn is_upright(corners: [(DVec3, DVec3); 3]) -> bool {
    let [(a, na), (b, nb), (c, nc)] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    [na, nb, nc].into_iter().all(|n| n.dot(normal) > UPRIGHT * 0.5) && (na + nb + nc).normalize().dot(normal) > UPRIGHT
}
