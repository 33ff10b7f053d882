//! Meshing of implicit bodies: surface nets (Gibson 1998), whose vertices are then drawn to the exact surface.

use glam::{DVec3, IVec3};

use super::implicit::{gradient, project};
use super::surface::Surface;

/// Rounds of tangential smoothing, each followed by a projection.
const RELAXATIONS: usize = 3;

/// Edge of the blocks in which the grid is sampled, corners.
const BLOCK: i32 = 4;

/// Meshes the zero set of `field` (negative inside) in the box from `low` to `high`, which it must not reach, with
/// triangles of about `cell` metres. Vertices lie on the zero set, normals are those of the field.
///
/// Where a grid face is crossed twice, a surface net can join four quads at one edge. Such places are narrower than the
/// grid can tell, so the grid is made finer until there are none.
pub fn extract(field: &dyn Fn(DVec3) -> f64, low: DVec3, high: DVec3, mut cell: f64) -> Surface {
    let (mut positions, quads) = loop {
        let (positions, quads) = Grid::sample(field, low, high, cell).net();
        if is_manifold(&quads) {
            break (positions, quads);
        }
        cell *= 0.95;
    };
    let neighbours = edges_of(&quads, positions.len());
    for position in &mut positions {
        *position = project(field, *position, cell);
    }
    for _ in 0..RELAXATIONS {
        let relaxed: Vec<DVec3> = positions
            .iter()
            .zip(&neighbours)
            .map(|(&p, ring)| {
                let mean = ring.iter().map(|&i| positions[i as usize]).sum::<DVec3>() / ring.len() as f64;
                let normal = gradient(field, p).normalize();
                let shift = (mean - p) * 0.6;
                project(field, p + shift - normal * shift.dot(normal), cell)
            })
            .collect();
        positions = relaxed;
    }
    let normals = positions.iter().map(|&p| gradient(field, p).normalize()).collect();
    let mut surface = Surface { positions, normals, triangles: Vec::with_capacity(quads.len() * 2) };
    for quad in quads {
        surface.push_quad(quad);
    }
    surface
}

/// Whether no directed edge is used twice.
fn is_manifold(quads: &[[u32; 4]]) -> bool {
    let mut edges: Vec<(u32, u32)> =
        quads.iter().flat_map(|quad| (0..4).map(|i| (quad[i], quad[(i + 1) % 4]))).collect();
    edges.sort_unstable();
    edges.windows(2).all(|pair| pair[0] != pair[1])
}

/// Vertices that share a quad edge with each vertex, in order of first appearance.
fn edges_of(quads: &[[u32; 4]], vertices: usize) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::with_capacity(4); vertices];
    for quad in quads {
        for i in 0..4 {
            let (a, b) = (quad[i], quad[(i + 1) % 4]);
            for (from, to) in [(a, b), (b, a)] {
                let ring: &mut Vec<u32> = &mut neighbours[from as usize];
                if !ring.contains(&to) {
                    ring.push(to);
                }
            }
        }
    }
    neighbours
}

/// Field values at the corners of a regular grid.
struct Grid {
    low: DVec3,
    cell: f64,
    size: IVec3,
    values: Vec<f64>,
}

impl Grid {
    /// Samples the field block by block; a block whose centre is far from the surface takes the centre's value.
    fn sample(field: &dyn Fn(DVec3) -> f64, low: DVec3, high: DVec3, cell: f64) -> Self {
        let size = ((high - low) / cell).ceil().as_ivec3() + IVec3::ONE;
        let mut grid = Self { low, cell, size, values: vec![0.0; (size.x * size.y * size.z) as usize] };
        let corners = |from: IVec3, to: IVec3, stride: i32| {
            let steps = move |axis: usize| (from[axis]..to[axis]).step_by(stride as usize);
            steps(2).flat_map(move |z| steps(1).flat_map(move |y| steps(0).map(move |x| IVec3::new(x, y, z))))
        };
        // Fields grow with the distance, but not at one rate: three radii are safe where one would do for a distance.
        let far = 3.0 * BLOCK as f64 * cell * 3.0_f64.sqrt() / 2.0;
        for block in corners(IVec3::ZERO, size, BLOCK) {
            let end = (block + BLOCK).min(size);
            let centre = field(low + (block + end - 1).as_dvec3() / 2.0 * cell);
            for corner in corners(block, end, 1) {
                let index = grid.index(corner);
                grid.values[index] = if centre.abs() > far { centre } else { field(low + corner.as_dvec3() * cell) };
            }
        }
        grid
    }

    fn index(&self, corner: IVec3) -> usize {
        ((corner.z * self.size.y + corner.y) * self.size.x + corner.x) as usize
    }

    /// One vertex for every cell that the surface passes, one quad for every grid edge that it crosses.
    fn net(&self) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let mut vertex_of = vec![u32::MAX; self.values.len()];
        let mut positions = Vec::new();
        let mut quads = Vec::new();
        for z in 0..self.size.z - 1 {
            for y in 0..self.size.y - 1 {
                for x in 0..self.size.x - 1 {
                    let corner = IVec3::new(x, y, z);
                    if let Some(position) = self.cell_vertex(corner) {
                        vertex_of[self.index(corner)] = positions.len() as u32;
                        positions.push(position);
                        self.edge_quads(corner, &vertex_of, &mut quads);
                    }
                }
            }
        }
        (positions, quads)
    }

    /// Mean of the points where the surface crosses the edges of the cell at `corner`.
    fn cell_vertex(&self, corner: IVec3) -> Option<DVec3> {
        let mut sum = DVec3::ZERO;
        let mut crossings = 0;
        for axis in 0..3 {
            for (u, v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let mut offset = IVec3::ZERO;
                offset[(axis + 1) % 3] = u;
                offset[(axis + 2) % 3] = v;
                let from = corner + offset;
                let (a, b) = (self.values[self.index(from)], self.values[self.index(from + IVec3::AXES[axis])]);
                if (a < 0.0) != (b < 0.0) {
                    sum += from.as_dvec3() + DVec3::AXES[axis] * (a / (a - b));
                    crossings += 1;
                }
            }
        }
        (crossings > 0).then(|| self.low + sum / f64::from(crossings) * self.cell)
    }

    /// Quads around the crossed edges that leave `corner` in the positive directions. The three other cells round such
    /// an edge come before this one, so they have their vertices.
    fn edge_quads(&self, corner: IVec3, vertex_of: &[u32], quads: &mut Vec<[u32; 4]>) {
        for axis in 0..3 {
            let (u, v) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
            let inside = self.values[self.index(corner)] < 0.0;
            if inside == (self.values[self.index(corner + IVec3::AXES[axis])] < 0.0) {
                continue;
            }
            let cells = [corner, corner - u, corner - u - v, corner - v];
            let mut quad = cells.map(|cell| vertex_of[self.index(cell)]);
            if !inside {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
}
