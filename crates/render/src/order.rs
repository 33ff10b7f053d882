//! In which order glass bodies are drawn: each over what lies behind it.

use glam::DVec3;
use murano_animation::Bounds;
use murano_refraction::Viewpoint;

/// Bodies by their boxes, farthest first, in groups. Within a group no order is right for all pixels, as bodies interlock or run into
/// one another, so that each pixel has its own.
pub(crate) fn back_to_front(boxes: &[Bounds], eye: &Viewpoint) -> Vec<Vec<usize>> {
    let seen: Vec<_> = boxes.iter().map(|bounds| InView::of(bounds, eye)).collect();
    let mut sorted: Vec<usize> = (0..boxes.len()).collect();
    sorted.sort_by(|&a, &b| seen[b].middle.total_cmp(&seen[a].middle));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, &body) in sorted.iter().enumerate() {
        // From the first that it does not stay in front of, all are of its group: their order hangs together.
        let first = sorted[..place].iter().position(|&before| !stays_in_front(&seen[body], &seen[before], eye));
        let mut group = vec![body];
        while let Some(last) = groups.last()
            && first.is_some_and(|first| sorted[first..place].contains(&last[last.len() - 1]))
        {
            group.splice(0..0, groups.pop().unwrap_or_default());
        }
        groups.push(group);
    }
    groups
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

/// Whether no ray of the eye meets this body before it meets the other: they are apart on the picture or in depth, or a plane
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

    #[test]
    fn bodies_apart_have_one_order() {
        for perspective in [true, false] {
            let boxes = [2.0, -3.0, 5.0, -1.0].map(|z| cube(z * DVec3::Z, DVec3::splat(0.5)));
            assert_eq!(back_to_front(&boxes, &eye(perspective)), [[1], [3], [0], [2]]);
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
            assert_eq!(back_to_front(&boxes, &eye(perspective)), [vec![1], vec![0, 2], vec![3]]);
        }
    }

    #[test]
    fn what_lies_between_two_of_a_group_is_of_it() {
        // A long one, whose middle is nearer than that of one before it, and one between.
        let long = cube(DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.2, 0.2, 6.0));
        let boxes = [long, cube(-DVec3::Z, DVec3::splat(0.4)), cube(DVec3::Y, DVec3::new(0.1, 0.1, 0.1))];
        assert_eq!(back_to_front(&boxes, &eye(true)), [[1, 2, 0]]);
    }

    #[test]
    fn a_box_around_the_eye_is_in_any_order() {
        let boxes = [cube(10.0 * DVec3::Z, DVec3::ONE), cube(9.5 * DVec3::Z, DVec3::splat(0.2))];
        assert_eq!(back_to_front(&boxes, &eye(true)).len(), 1);
    }
}
