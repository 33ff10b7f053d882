//! Which triangle lies across each edge: constant under deformation, so that walks over a deformed surface need no
//! structure that is refitted.

use std::collections::HashMap;

use glam::Vec3;
use murano_scene::NodeIndex;

use crate::Geometry;

/// A directed edge between welded corners.
struct Edge {
    /// Ends in increasing order: both triangles of an edge have the same.
    ends: [u32; 2],
    /// Whether the triangle runs from the second end to the first.
    backwards: bool,
    triangle: u32,
    /// The corner that it lies opposite of.
    opposite: u32,
}

impl Geometry {
    /// For each triangle, the triangles across the edges opposite its first, second and third corner, as index plus one.
    ///
    /// Corners are welded by their rest position within a node, whatever their normals and texture coordinates. Where more
    /// than two triangles share an edge, those that run through it one way are matched with those that run the other way,
    /// in their order; surplus ones with the last. 0: the edge is open, as no other triangle runs through it the other way.
    pub fn neighbours(&self) -> Vec<[u32; 3]> {
        let welded = self.welded_vertices();
        let mut edges = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, corners) in (0u32..).zip(&self.triangles) {
            let corners = corners.map(|vertex| welded[vertex as usize]);
            for opposite in 0..3 {
                let [from, to] = [corners[(opposite + 1) % 3], corners[(opposite + 2) % 3]];
                let ends = [from.min(to), from.max(to)];
                // Of a triangle with a corner twice, whose other two edges are one.
                if from == to || corners[opposite] == from || corners[opposite] == to {
                    continue;
                }
                edges.push(Edge { ends, backwards: from > to, triangle, opposite: opposite as u32 });
            }
        }
        edges.sort_unstable_by_key(|edge| (edge.ends, edge.backwards, edge.triangle, edge.opposite));
        let mut neighbours = vec![[0; 3]; self.triangles.len()];
        for shared in edges.chunk_by(|a, b| a.ends == b.ends) {
            let forwards = shared.partition_point(|edge| !edge.backwards);
            let (forwards, backwards) = shared.split_at(forwards);
            for (one_way, other_way) in [(forwards, backwards), (backwards, forwards)] {
                let Some(last) = other_way.len().checked_sub(1) else { continue };
                for (index, edge) in one_way.iter().enumerate() {
                    neighbours[edge.triangle as usize][edge.opposite as usize] =
                        other_way[index.min(last)].triangle + 1;
                }
            }
        }
        neighbours
    }

    /// For each vertex, the first one of its node that rests in the same place.
    fn welded_vertices(&self) -> Vec<u32> {
        let mut first: HashMap<(NodeIndex, [u32; 3]), u32> = HashMap::with_capacity(self.vertices.len());
        (0u32..)
            .zip(&self.vertices)
            .map(|(index, vertex)| {
                let instance = &self.instances[vertex.instance as usize];
                let place = (instance.pivot + Vec3::from(vertex.position).as_dvec3()).as_vec3();
                // Adding zero makes -0 and 0 one place.
                *first.entry((instance.node, (place + Vec3::ZERO).to_array().map(f32::to_bits))).or_insert(index)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use murano_scene::{Local, Mesh, Node, Primitive, Scene, Transform};

    use super::*;

    fn neighbours(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let primitive = Primitive {
            positions: positions.iter().copied().map(Vec3::from).collect(),
            triangles: triangles.to_vec(),
            ..Primitive::default()
        };
        let node = Node {
            name: String::new(),
            parent: None,
            children: Vec::new(),
            local: Local::Trs(Transform::IDENTITY),
            mesh: Some(0),
            skin: None,
            camera: None,
            light: None,
            weights: Vec::new(),
        };
        let mesh = Mesh { name: String::new(), primitives: vec![primitive] };
        let scene = Scene { meshes: vec![mesh], nodes: vec![node], roots: vec![0], ..Scene::default() };
        Geometry::build(&scene, &[(0, 0)]).unwrap().neighbours()
    }

    const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn triangles_meet_across_split_vertices() {
        // The diagonal from (0, 0) to (1, 1) has vertices of its own on either side, one of them at minus zero.
        let positions = [SQUARE[0], SQUARE[1], SQUARE[2], [-0.0, 0.0, -0.0], SQUARE[2], SQUARE[3]];
        assert_eq!(neighbours(&positions, &[[0, 1, 2], [3, 4, 5]]), [[0, 2, 0], [0, 0, 1]]);
    }

    #[test]
    fn surplus_triangles_at_an_edge_lead_back_to_the_surface() {
        let fin = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]];
        let meeting = neighbours(&fin, &[[0, 1, 2], [0, 2, 3], [0, 2, 4]]);
        assert_eq!(meeting, [[0, 2, 0], [0, 0, 1], [0, 0, 1]], "three triangles at one edge");
        assert_eq!(neighbours(&SQUARE, &[[0, 1, 2], [2, 0, 3]]), [[0; 3]; 2], "both run through it the same way");
    }

    #[test]
    fn a_surface_laid_down_twice_is_two_surfaces() {
        let twice = [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]];
        assert_eq!(neighbours(&SQUARE, &twice), [[0, 2, 0], [0, 0, 1], [0, 4, 0], [0, 0, 3]]);
    }

    #[test]
    fn a_triangle_with_a_corner_twice_stands_between_no_others() {
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 2, 2]];
        assert_eq!(neighbours(&SQUARE, &triangles), [[0, 2, 0], [0, 0, 1], [0; 3]]);
    }

    #[test]
    fn a_closed_body_has_no_open_edge_and_every_neighbour_points_back() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let neighbours = neighbours(&positions, &triangles);
        for (index, across) in (1..).zip(&neighbours) {
            assert!(across.iter().all(|&other| other != 0 && neighbours[other as usize - 1].contains(&index)));
        }
    }
}
