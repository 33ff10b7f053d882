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

/// A directed edge with nothing across it.
#[derive(Clone, Copy)]
struct OpenEdge {
    triangle: usize,
    opposite: usize,
    from: u32,
    to: u32,
}

/// How far off an edge a corner may lie and still split it, in lengths of the edge.
const ON_EDGE: f64 = 1e-5;
/// Parts that an edge is looked for in.
const MOST_LINKS: usize = 64;
/// Open edges that begin at a corner where a split edge is followed on: with more, all of them by all would take too long.
const MOST_ONWARD: usize = 64;

impl Geometry {
    /// For each triangle, the triangles across the edges opposite its first, second and third corner, as index plus one.
    ///
    /// Corners are welded by their rest position within a node and a shell, whatever their normals and texture coordinates. Where more
    /// than two triangles share an edge, those that run through it one way are matched with those that run the other way,
    /// in their order; surplus ones with the last. An edge along which several shorter ones lie end to end (T-junctions) has the
    /// triangle of the longest of them across, and all of them have its own; not where more than 64 open edges begin at one
    /// corner. 0: the edge is open, as no other triangle runs through it the other way.
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
        self.join_split_edges(&welded, &mut neighbours);
        neighbours
    }

    /// Joins open edges to the shorter open ones that lie along them.
    fn join_split_edges(&self, welded: &[u32], neighbours: &mut [[u32; 3]]) {
        let mut open = Vec::new();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let corners = corners.map(|vertex| welded[vertex as usize]);
            for opposite in 0..3 {
                let [from, to] = [corners[(opposite + 1) % 3], corners[(opposite + 2) % 3]];
                if neighbours[triangle][opposite] == 0 && from != to {
                    open.push(OpenEdge { triangle, opposite, from, to });
                }
            }
        }
        let mut beginning: HashMap<u32, Vec<OpenEdge>> = HashMap::with_capacity(open.len());
        for &edge in &open {
            beginning.entry(edge.from).or_default().push(edge);
        }
        let place = |vertex: u32| {
            let vertex = &self.vertices[vertex as usize];
            self.instances[vertex.instance as usize].pivot + Vec3::from(vertex.position).as_dvec3()
        };
        for long in open {
            let (start, way) = (place(long.to), place(long.from) - place(long.to));
            // How far along the edge an open one that goes on from `at` ends; `None` if it leaves the edge.
            let reach = |edge: &OpenEdge, at: f64| {
                let end = place(edge.to) - start;
                let share = end.dot(way) / way.length_squared();
                let aside = (end - share * way).length();
                (share > at && share < 1.0 + ON_EDGE && aside < ON_EDGE * way.length()).then_some(share)
            };
            let mut links: Vec<(OpenEdge, f64)> = Vec::new();
            let (mut vertex, mut at) = (long.to, 0.0);
            while vertex != long.from && links.len() < MOST_LINKS {
                let onward = beginning.get(&vertex).filter(|edges| edges.len() <= MOST_ONWARD).into_iter().flatten();
                let onward = onward.filter(|edge| edge.triangle != long.triangle);
                let next = onward.filter_map(|edge| Some((*edge, reach(edge, at)?))).min_by(|a, b| a.1.total_cmp(&b.1));
                let Some((edge, end)) = next else { break };
                links.push((edge, end - at));
                (vertex, at) = (edge.to, end);
            }
            if vertex != long.from || links.len() < 2 {
                continue;
            }
            let longest =
                links.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(edge, _)| edge.triangle as u32 + 1);
            neighbours[long.triangle][long.opposite] = longest;
            for (edge, _) in links {
                neighbours[edge.triangle][edge.opposite] = long.triangle as u32 + 1;
            }
        }
    }

    /// For each vertex, the first one of its node and shell that rests in the same place.
    fn welded_vertices(&self) -> Vec<u32> {
        let mut first: HashMap<(NodeIndex, u32, [u32; 3]), u32> = HashMap::with_capacity(self.vertices.len());
        (0u32..)
            .zip(&self.vertices)
            .map(|(index, vertex)| {
                let instance = &self.instances[vertex.instance as usize];
                let place = (instance.pivot + Vec3::from(vertex.position).as_dvec3()).as_vec3();
                // Adding zero makes -0 and 0 one place.
                let place = (place + Vec3::ZERO).to_array().map(f32::to_bits);
                *first.entry((instance.node, instance.shell, place)).or_insert(index)
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
    fn an_edge_split_on_one_side_is_joined() {
        // The diagonal is whole in the first triangle and split in the middle and at three quarters by the others.
        let [a, b] = [0.5, 0.75];
        let positions = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[3], [a, a, 0.0], [b, b, 0.0]];
        let split = neighbours(&positions, &[[0, 1, 2], [0, 4, 3], [4, 5, 3], [5, 2, 3]]);
        assert_eq!(split, [[0, 2, 0], [3, 0, 1], [4, 2, 1], [0, 3, 1]]);
        // A corner beside the edge splits nothing.
        let beside = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[3], [0.4, 0.41, 0.0]];
        assert_eq!(neighbours(&beside, &[[0, 1, 2], [0, 4, 3], [4, 2, 3]])[0], [0; 3]);
    }

    #[test]
    fn blades_that_share_a_tip_are_not_compared_each_with_each() {
        let blade = |index: u32| {
            let turn = (0.01 * index as f32).sin_cos();
            [[turn.0, turn.1, index as f32], [turn.0, turn.1, index as f32 + 0.5]]
        };
        let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain((1..40_000).flat_map(blade)).collect();
        let triangles: Vec<[u32; 3]> = (1..40_000).map(|index| [0, 2 * index - 1, 2 * index]).collect();
        assert!(neighbours(&positions, &triangles).iter().all(|across| *across == [0; 3]));
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
