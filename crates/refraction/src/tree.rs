//! A hierarchy of boxes over a body's triangles: built once, from its rest pose, and refitted to every pose by the GPU.

use encase::ShaderType;
use glam::{DVec3, Vec3A};
use murano_animation::DeformedGeometry;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, Leaf, ShaderSpec, Work};
use murano_scheduler::{Output, Plan, Stamp};
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, leaf_collapser, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};

/// Triangles of a leaf.
const LEAF: u32 = 4;
/// `tree_layout.wesl`: a child that is a leaf.
const LEAF_BIT: u32 = 1 << 31;

/// What of the hierarchy no pose changes: which triangles and nodes lie under which node.
pub struct TriangleTree {
    buffers: [(&'static str, Stamp, Leaf); 3],
    /// Nodes of each height, leaves' parents first.
    heights: Vec<u32>,
}

/// The hierarchy of a pose.
#[derive(Clone, Copy, Debug)]
pub struct RefittedTree {
    /// Four `u32` a node: its children.
    pub children: Output,
    /// `u32` a triangle: leaves hold ranges of this list.
    pub order: Output,
    /// 24 `f32` a node: the boxes of its children.
    pub boxes: Output,
}

impl TriangleTree {
    /// The hierarchy of some triangles; positions in metres, in any pose. Triangles of vertices that do not exist are left
    /// out, positions that are not finite count as the middle.
    pub fn build(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let finite = || positions.iter().filter(|p| p.is_finite());
        let low = finite().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = finite().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        let (centre, radius) = (0.5 * (low + high), (0.5 * (high - low)).max_element().max(f64::MIN_POSITIVE.sqrt()));
        let unit = |&vertex: &u32| {
            let scaled = positions.get(vertex as usize).map(|p| ((p - centre) / radius).as_vec3());
            scaled.map(|p| if p.is_finite() { Vec3A::from(p) } else { Vec3A::ZERO })
        };
        let mut boxes = Vec::new();
        let mut order = Vec::new();
        for (index, triangle) in (0..).zip(triangles) {
            if let [Some(a), Some(b), Some(c)] = triangle.each_ref().map(unit) {
                let shift = shift(index);
                boxes.push(Aabb::new(a.min(b).min(c) + shift, a.max(b).max(c) + shift));
                order.push(index);
            }
        }
        let nodes = if boxes.is_empty() { vec![Children::default()] } else { wide_nodes(&boxes, &mut order) };
        let (children, ranges) = by_height(&nodes);
        let buffer = |name, (stamp, leaf)| (name, stamp, leaf);
        Self {
            buffers: [
                buffer("tree_children", Leaf::of(&children)),
                buffer("tree_order", Leaf::of(&order)),
                buffer("tree_heights", Leaf::of(&ranges)),
            ],
            heights: ranges.iter().map(|[start, end]| end - start).collect(),
        }
    }

    /// Adds the pass `name:instance` that refits the boxes.
    ///
    /// # Errors
    /// [`GpuError`] if the shader or the plan is defective.
    pub fn refit(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        (name, instance): (&'static str, u32),
        geometry: &DeformedGeometry,
    ) -> Result<RefittedTree, GpuError> {
        let shader = gpu.shader(&ShaderSpec::new("refraction::refit"))?;
        let [children, order, heights] =
            self.buffers.each_ref().map(|(name, stamp, leaf)| plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        let nodes: u32 = self.heights.iter().sum();
        let mut pass = ComputePass::new(name, instance)
            .input("tree_children", children)
            .input("tree_order", order)
            .input("tree_heights", heights)
            .input("positions", geometry.positions)
            .input("triangles", geometry.triangles)
            .output("tree_boxes", 96 * u64::from(nodes));
        for (rows, count) in (1..).zip(&self.heights) {
            // The number of rows tells the shader the height.
            pass = pass.dispatch(&shader, "main", Groups::Direct([count.div_ceil(64), rows, 1]));
        }
        let outputs = pass.add_to(plan)?;
        Ok(RefittedTree { children, order, boxes: outputs[0] })
    }
}

#[derive(ShaderType)]
struct ThicknessParams {
    vertex_count: u32,
    scale: f32,
}

/// Adds the pass `thickness:instance`: for each vertex, `f32`, how far it is along the inward normal to the far side, times
/// `scale`; 0 where there is none (Wyman's d_N).
///
/// # Errors
/// [`GpuError`] if the shader or the plan is defective.
pub fn thickness(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    instance: u32,
    geometry: &DeformedGeometry,
    tree: &RefittedTree,
    scale: f64,
) -> Result<Output, GpuError> {
    let shader = gpu.shader(&ShaderSpec::new("refraction::thickness").feature("tree", true))?;
    let params = ThicknessParams { vertex_count: geometry.vertex_count as u32, scale: scale as f32 };
    let outputs = ComputePass::new("thickness", instance)
        .value("params", &params)
        .input("mesh_positions", geometry.positions)
        .input("mesh_normals", geometry.normals)
        .input("mesh_triangles", geometry.triangles)
        .input("tree_children", tree.children)
        .input("tree_order", tree.order)
        .input("tree_boxes", tree.boxes)
        .output("thickness", 4 * geometry.vertex_count as u64)
        .dispatch(&shader, "main", Groups::linear(geometry.vertex_count, 64))
        .add_to(plan)?;
    Ok(outputs[0])
}

/// Of boxes that are all the same the library makes a chain as deep as they are many, so that no two may be. What boxes
/// there are only decides what lies under which node.
fn shift(index: u32) -> Vec3A {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
    Vec3A::splat((2e-4 * (f64::from(index) * GOLDEN_RATIO).fract()) as f32)
}

/// Four children as `tree_layout.wesl` has them; 0: none.
type Children = [u32; 4];

/// Nodes of four children, parents before children; `order` is rearranged as the leaves hold it.
fn wide_nodes(boxes: &[Aabb], order: &mut Vec<u32>) -> Vec<Children> {
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes.iter().map(|&it| Boxed(it)).collect::<Vec<_>>(),
        indices,
        SortPrecision::U64,
        1,
    );
    ReinsertionOptimizer::default().run(&mut tree, 0.05, None);
    leaf_collapser::collapse(&mut tree, LEAF, 1.0);
    *order = tree.primitive_indices.iter().map(|&index| order[index as usize]).collect();
    let mut nodes: Vec<Children> = vec![[0; 4]];
    let mut waiting = vec![(0u32, 0usize)];
    while let Some((narrow, wide)) = waiting.pop() {
        for (slot, child) in opened(&tree, narrow).into_iter().enumerate() {
            let it = &tree.nodes[child as usize];
            nodes[wide][slot] = if it.is_leaf() {
                LEAF_BIT | (it.prim_count - 1) << 28 | it.first_index
            } else {
                waiting.push((child, nodes.len()));
                nodes.push([0; 4]);
                nodes.len() as u32 - 1
            };
        }
    }
    nodes
}

/// Up to four nodes that together hold what a node holds: the largest is opened first.
fn opened(tree: &Bvh2, node: u32) -> Vec<u32> {
    let mut open = vec![node];
    while open.len() < 4 {
        let inner = open.iter().enumerate().filter(|&(_, &index)| !tree.nodes[index as usize].is_leaf());
        let area = |index: u32| tree.nodes[index as usize].aabb().half_area();
        let Some((place, &largest)) = inner.max_by(|(_, a), (_, b)| area(**a).total_cmp(&area(**b))) else { break };
        open.swap_remove(place);
        let first = tree.nodes[largest as usize].first_index;
        open.extend([first, first + 1]);
    }
    open
}

/// Nodes sorted by height, the root first, and where each height begins and ends, the lowest first.
fn by_height(nodes: &[Children]) -> (Vec<Children>, Vec<[u32; 2]>) {
    let inner = |child: u32| (child != 0 && child & LEAF_BIT == 0).then_some(child as usize);
    let mut heights = vec![0u32; nodes.len()];
    // Children come after their parents.
    for (index, children) in nodes.iter().enumerate().rev() {
        heights[index] =
            children.iter().filter_map(|&child| inner(child)).map(|child| heights[child] + 1).max().unwrap_or(0);
    }
    let mut sorted: Vec<usize> = (0..nodes.len()).collect();
    sorted.sort_by_key(|&index| std::cmp::Reverse(heights[index]));
    let mut place = vec![0u32; nodes.len()];
    for (new, &old) in (0..).zip(&sorted) {
        place[old] = new;
    }
    let moved = |child: u32| inner(child).map_or(child, |index| place[index]);
    let mut ranges = vec![[0u32; 2]; heights[0] as usize + 1];
    for (new, &old) in (0..).zip(&sorted) {
        let range = &mut ranges[heights[old] as usize];
        *range = if range[1] == 0 { [new, new + 1] } else { [range[0], new + 1] };
    }
    (sorted.iter().map(|&old| nodes[old].map(moved)).collect(), ranges)
}

/// A box as the library takes it.
struct Boxed(Aabb);

impl obvhs::Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    /// Everything under a child, and how many nodes a path to it goes through at most.
    fn under(children: &[Children], child: u32, found: &mut Vec<u32>) {
        if child & LEAF_BIT != 0 {
            let first = child & 0x0fff_ffff;
            found.extend(first..=first + (child >> 28 & 7));
        } else {
            children[child as usize]
                .iter()
                .filter(|&&child| child != 0)
                .for_each(|&child| under(children, child, found));
        }
    }

    fn grid(side: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let points =
            (0..side * side).map(|i| DVec3::new(f64::from(i % side), f64::from(i / side).sin(), f64::from(i / side)));
        let cells = (0..side * (side - 1)).filter(|i| i % side + 1 < side);
        (points.collect(), cells.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect())
    }

    #[test]
    fn every_triangle_lies_under_the_root_once() {
        for side in [2, 3, 40] {
            let (points, triangles) = grid(side);
            let boxes: Vec<Aabb> = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|i| Vec3A::from(points[i as usize].as_vec3()));
                    Aabb::new(a.min(b).min(c), a.max(b).max(c))
                })
                .collect();
            let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
            let nodes = wide_nodes(&boxes, &mut order);
            let (children, ranges) = by_height(&nodes);
            let mut found = Vec::new();
            under(&children, 0, &mut found);
            let mut seen: Vec<u32> = found.iter().map(|&slot| order[slot as usize]).collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..triangles.len() as u32).collect::<Vec<_>>());
            assert_eq!(ranges.last(), Some(&[0, 1]), "the root is the highest node, and the first");
            for (height, &[start, end]) in ranges.iter().enumerate() {
                for node in start..end {
                    let inner = children[node as usize].iter().filter(|&&c| c != 0 && c & LEAF_BIT == 0);
                    assert!(inner.clone().all(|&c| ranges[..height].iter().any(|r| (r[0]..r[1]).contains(&c))));
                }
            }
        }
    }

    #[test]
    fn triangles_in_one_place_make_no_chain() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_ONE, DVec3::ONE];
        // All alike; all in a corner, where f32 tells the least apart, and one that reaches across.
        let collapsed: Vec<[u32; 3]> = [[3, 4, 0]].into_iter().chain(vec![[4, 4, 4]; 5000]).collect();
        for triangles in [vec![[0, 1, 2]; 5000], collapsed] {
            let tree = TriangleTree::build(&points, &triangles);
            // A third of what `tree.wesl` can put by.
            assert!(tree.heights.len() <= 21, "{:?}", tree.heights);
        }
    }

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let shader = Shader::link(&ShaderSpec::new("refraction::thickness").feature("tree", true)).unwrap();
        check_uniform_layout!(shader, "Params", ThicknessParams { vertex_count: 1, scale: 2.0 }).unwrap();
    }

    #[test]
    fn nothing_and_nonsense_have_hierarchies_too() {
        let nan = [DVec3::NAN, DVec3::X, DVec3::Y];
        for (points, triangles) in [(&[][..], &[][..]), (&nan[..], &[[0, 1, 2], [0, 1, 9]][..])] {
            assert_eq!(TriangleTree::build(points, triangles).heights, [1]);
        }
    }
}
