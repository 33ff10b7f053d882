//! In which order glass bodies are drawn: each over what lies behind it.

use glam::DVec3;
use murano_animation::Bounds;
use murano_refraction::Viewpoint;
use petgraph::{
    algo::kosaraju_scc,
    graph::{DiGraph, NodeIndex},
};

/// A body in the order in which bodies are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Placed {
    pub(crate) body: usize,
    /// Of its group's rounds, in how many it may have its turn.
    pub(crate) rounds: usize,
}

/// Pictures that a group may take; the bodies of a larger one are drawn once each, as each drawing holds a picture of its own.
const MOST_DRAWS: usize = 32;

/// Bodies by their boxes, those behind others first, and of bodies that have nothing to do with each other the farthest. A group of
/// several interlock or run into one another, so that no order of them is right for all pixels.
pub(crate) fn back_to_front(boxes: &[Bounds], eye: &Viewpoint) -> Vec<Vec<Placed>> {
    let seen: Vec<_> = boxes.iter().map(|bounds| InView::of(bounds, eye)).collect();
    let may_be_behind = |body: usize, other: usize| body != other && !stays_in_front(&seen[body], &seen[other], eye);
    let pairs = (0..boxes.len()).flat_map(|body| (0..boxes.len()).map(move |other| (body, other)));
    let mut graph = DiGraph::<(), (), usize>::default();
    for _ in boxes {
        graph.add_node(());
    }
    for (body, other) in pairs.filter(|&(body, other)| may_be_behind(body, other)) {
        graph.add_edge(body.into(), other.into(), ());
    }
    let mut groups: Vec<Vec<usize>> = kosaraju_scc(&graph)
        .into_iter()
        .map(|group| {
            let mut group: Vec<usize> = group.into_iter().map(NodeIndex::index).collect();
            group.sort_by(|&a, &b| seen[b].middle.total_cmp(&seen[a].middle).then(a.cmp(&b)));
            group
        })
        .collect();
    groups.sort_by(|a, b| seen[b[0]].middle.total_cmp(&seen[a[0]].middle).then(a[0].cmp(&b[0])));
    let mut ordered = Vec::new();
    while !groups.is_empty() {
        // The farthest that no other has to be drawn before. There is one, as groups are not in a circle.
        let waits = |group: &Vec<usize>| {
            let others = groups.iter().filter(|other| other[0] != group[0]).flatten();
            others.into_iter().any(|&other| group.iter().any(|&body| may_be_behind(other, body)))
        };
        let next = groups.iter().position(|group| !waits(group)).unwrap_or(0);
        let group = groups.remove(next);
        let last = group.len();
        let placed = group.iter().enumerate().map(|(rank, &body)| {
            // It waits for no more than those that may be behind it; the first alone may have to wait for all, as whoever comes after
            // another in the group's order need not wait for it to come round again.
            let behind = group.iter().filter(|&&other| may_be_behind(other, body)).count();
            Placed { body, rounds: (behind + 1).min(if rank == 0 { last } else { (last - 1).max(1) }) }
        });
        let placed: Vec<Placed> = placed.collect();
        if placed.iter().map(|placed| placed.rounds).sum::<usize>() <= MOST_DRAWS {
            ordered.push(placed);
        } else {
            ordered.extend(placed.into_iter().map(|placed| vec![Placed { rounds: 1, ..placed }]));
        }
    }
    ordered
}

/// A body's box, and what of the view it takes.
struct InView {
    bounds: Bounds,
    /// Depth of its middle, metres.
    middle: f64,
    /// Least and most of depth and, on the picture, of x and y; all of them where part of the box lies behind the eye.
    low: DVec3,
    high: DVec3,
}

impl InView {
    fn of(bounds: &Bounds, eye: &Viewpoint) -> Self {
        let view_from_world = eye.world_from_view.inverse();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..8 {
            let side = |axis: usize| if (i >> axis) & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            let p = view_from_world.transform_point3(DVec3::new(side(0), side(1), side(2)));
            let depth = -p.z;
            let across = if eye.perspective { p.truncate() / depth } else { p.truncate() };
            low = low.min(across.extend(depth));
            high = high.max(across.extend(depth));
        }
        if eye.perspective && low.z <= 0.0 {
            (low, high) = (DVec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, low.z), DVec3::INFINITY.with_z(high.z));
        }
        Self { bounds: *bounds, middle: -view_from_world.transform_point3(bounds.center()).z, low, high }
    }
}

/// Whether no ray of the eye meets the other body before it meets this one: they are apart on the picture or in depth, or a plane
/// between their boxes has the eye on this one's side (or lies so that no ray meets both).
fn stays_in_front(this: &InView, other: &InView, eye: &Viewpoint) -> bool {
    let apart = (0..2).any(|axis| this.high[axis] < other.low[axis] || other.high[axis] < this.low[axis]);
    let nearer = this.high.z <= other.low.z;
    let place = eye.world_from_view.w_axis.truncate();
    let towards = eye.world_from_view.z_axis.truncate();
    let beyond = |axis: usize, sign: f64, border: f64| {
        if eye.perspective { sign * (place[axis] - border) >= 0.0 } else { sign * towards[axis] >= 0.0 }
    };
    let (a, b) = (&this.bounds, &other.bounds);
    apart
        || nearer
        || (0..3).any(|axis| {
            (a.min[axis] >= b.max[axis] && beyond(axis, 1.0, b.max[axis]))
                || (a.max[axis] <= b.min[axis] && beyond(axis, -1.0, b.min[axis]))
        })
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec2};

    use super::*;

    fn eye(perspective: bool) -> Viewpoint {
        Viewpoint {
            world_from_view: DMat4::from_translation(10.0 * DVec3::Z),
            perspective,
            half_extent: DVec2::splat(if perspective { 0.5 } else { 5.0 }),
            center: DVec2::ZERO,
            size: [64; 2],
            near: 0.1,
        }
    }

    fn cube(center: DVec3, half: DVec3) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    fn bodies(groups: &[Vec<Placed>]) -> Vec<Vec<usize>> {
        groups.iter().map(|group| group.iter().map(|placed| placed.body).collect()).collect()
    }

    #[test]
    fn bodies_apart_have_one_order() {
        for perspective in [true, false] {
            let boxes = [2.0, -3.0, 5.0, -1.0].map(|z| cube(z * DVec3::Z, DVec3::splat(0.5)));
            assert_eq!(bodies(&back_to_front(&boxes, &eye(perspective))), [[1], [3], [0], [2]]);
            // Side by side: no pixel sees both through one another.
            let boxes = [-1.0, 1.0].map(|x| cube(x * DVec3::X, DVec3::splat(0.9)));
            assert_eq!(back_to_front(&boxes, &eye(perspective)).len(), 2);
        }
    }

    #[test]
    fn bodies_that_overlap_are_a_group() {
        for perspective in [true, false] {
            let ball = |x: f64, z: f64| cube(DVec3::new(x, 0.0, z), DVec3::ONE);
            let boxes = [ball(0.0, 0.0), ball(0.0, -6.0), ball(0.5, 0.3), ball(0.0, 4.0)];
            let groups = back_to_front(&boxes, &eye(perspective));
            assert_eq!(bodies(&groups), [vec![1], vec![0, 2], vec![3]]);
            let rounds: Vec<usize> = groups[1].iter().map(|placed| placed.rounds).collect();
            assert_eq!(
                rounds,
                [2, 1],
                "the nearer one has had its turn before the other has it again, or has it first"
            );
        }
    }

    #[test]
    fn what_stands_on_a_slab_is_drawn_after_it_wherever_their_middles_are() {
        let slab = cube(DVec3::new(0.0, -1.0, 0.0), DVec3::new(4.0, 0.2, 4.0));
        let above = Viewpoint {
            world_from_view: murano_scene::look_along(DVec3::new(0.0, 5.0, 10.0), DVec3::new(0.0, -0.5, -1.0)),
            ..eye(true)
        };
        let boxes = [slab, cube(-3.0 * DVec3::Z, DVec3::splat(0.5)), cube(3.0 * DVec3::Z, DVec3::splat(0.5))];
        assert_eq!(bodies(&back_to_front(&boxes, &above)), [[0], [1], [2]]);
    }

    #[test]
    fn a_circle_of_bodies_is_a_group_and_what_is_behind_it_is_not() {
        // Three long boxes, each over the next, and one far behind.
        let boxes = [
            cube(DVec3::new(0.0, 0.0, 0.0), DVec3::new(2.0, 0.2, 0.4)),
            cube(DVec3::new(1.0, 0.0, 0.2), DVec3::new(0.2, 2.0, 0.4)),
            cube(DVec3::new(0.0, 0.0, -8.0), DVec3::ONE),
            cube(DVec3::new(-1.0, 0.0, -0.2), DVec3::new(0.2, 2.0, 0.4)),
        ];
        let groups = back_to_front(&boxes, &eye(true));
        assert_eq!(bodies(&groups), [vec![2], vec![3, 0, 1]]);
        // The ones at either side have nothing to do with each other.
        let rounds: Vec<usize> = groups[1].iter().map(|placed| placed.rounds).collect();
        assert_eq!(rounds, [2, 2, 2]);
    }

    #[test]
    fn too_many_at_once_are_drawn_once_each() {
        let chain = |count: u32| -> Vec<Bounds> {
            (0..count)
                .map(|i| cube(DVec3::new(0.1 * f64::from(i) - 1.0, 0.0, 0.0), DVec3::new(0.09, 0.5, 0.5)))
                .collect()
        };
        assert_eq!(back_to_front(&chain(8), &eye(true)).len(), 1, "a chain of eight");
        let heap: Vec<_> = (0..20_u32).map(|i| cube(0.01 * f64::from(i) * DVec3::Z, DVec3::ONE)).collect();
        let groups = back_to_front(&heap, &eye(true));
        assert_eq!(bodies(&groups), (0..20).map(|body| vec![body]).collect::<Vec<_>>());
        assert!(groups.iter().flatten().all(|placed| placed.rounds == 1));
    }

    #[test]
    fn a_box_around_the_eye_is_in_any_order() {
        let boxes = [cube(10.0 * DVec3::Z, DVec3::ONE), cube(9.5 * DVec3::Z, DVec3::splat(0.2))];
        assert_eq!(back_to_front(&boxes, &eye(true)).len(), 1);
    }
}
