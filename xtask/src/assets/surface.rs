//! Triangle surfaces in f64, before they are rounded into a file.

use glam::DVec3;

/// An indexed triangle surface. Counter-clockwise triangles face outwards; lengths are metres.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Unit outward normals, one a vertex.
    pub normals: Vec<DVec3>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Appends a vertex and returns its index.
    pub fn push(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.positions.len() as u32 - 1
    }

    /// Appends two triangles that fill the quadrilateral `corners` (counter-clockwise seen from outside), split along
    /// its shorter diagonal.
    pub fn push_quad(&mut self, corners: [u32; 4]) {
        let [a, b, c, d] = corners;
        let at = |i: u32| self.positions[i as usize];
        if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            self.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }

    /// Appends a flat polygon (convex, counter-clockwise seen from outside) with its own vertices and normal.
    pub fn push_flat(&mut self, corners: &[DVec3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let first = self.positions.len() as u32;
        for &corner in corners {
            self.push(corner, normal);
        }
        for i in 1..corners.len() as u32 - 1 {
            self.triangles.push([first, first + i, first + i + 1]);
        }
    }
}
