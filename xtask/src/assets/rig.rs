//! Skeletons, poses and skin weights.

use glam::{DMat3, DQuat, DVec3};

/// A joint in the rest pose. Rest orientations are those of the world, so a local rotation reads in world axes.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Node name.
    pub name: String,
    /// Index of the parent, which comes before its children.
    pub parent: Option<usize>,
    /// Rest position in the world, metres.
    pub position: DVec3,
}

/// A hierarchy of joints; the first is the root.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    /// Joints, parents first.
    pub joints: Vec<Joint>,
}

impl Skeleton {
    /// Adds a joint and returns its index.
    pub fn add(&mut self, name: impl Into<String>, parent: Option<usize>, position: DVec3) -> usize {
        self.joints.push(Joint { name: name.into(), parent, position });
        self.joints.len() - 1
    }

    /// Position relative to the parent in the rest pose, metres.
    pub fn offset(&self, joint: usize) -> DVec3 {
        let Joint { parent, position, .. } = &self.joints[joint];
        *position - parent.map_or(DVec3::ZERO, |p| self.joints[p].position)
    }

    /// Rest pose.
    pub fn rest(&self) -> Pose {
        Pose { rotations: vec![DQuat::IDENTITY; self.joints.len()], root: self.joints[0].position }
    }
}

/// A pose: a local rotation a joint and the place of the root.
#[derive(Clone, Debug)]
pub struct Pose {
    /// Local rotations, one a joint.
    pub rotations: Vec<DQuat>,
    /// World position of the root joint, metres.
    pub root: DVec3,
}

impl Pose {
    /// World rotation of `joint`.
    pub fn world_rotation(&self, skeleton: &Skeleton, joint: usize) -> DQuat {
        let above = skeleton.joints[joint].parent.map_or(DQuat::IDENTITY, |p| self.world_rotation(skeleton, p));
        above * self.rotations[joint]
    }

    /// World position of `joint`, metres.
    pub fn world_position(&self, skeleton: &Skeleton, joint: usize) -> DVec3 {
        skeleton.joints[joint].parent.map_or(self.root, |parent| {
            self.world_position(skeleton, parent) + self.world_rotation(skeleton, parent) * skeleton.offset(joint)
        })
    }

    /// Sets the local rotation of `joint` such that it is turned to `world` in the world, given its ancestors.
    pub fn set_world_rotation(&mut self, skeleton: &Skeleton, joint: usize, world: DQuat) {
        let above = skeleton.joints[joint].parent.map_or(DQuat::IDENTITY, |p| self.world_rotation(skeleton, p));
        self.rotations[joint] = (above.inverse() * world).normalize();
    }

    /// Bends the two-bone limb `upper`, `lower`, `end` such that its end comes to `target` (or as near as it reaches),
    /// with the middle joint towards `pole`, a direction. `hinge` is the middle joint's axis in the rest pose.
    pub fn reach(&mut self, skeleton: &Skeleton, limb: [usize; 3], target: DVec3, pole: DVec3, hinge: DVec3) {
        let [upper, lower, end] = limb;
        let (first, second) = (skeleton.offset(lower), skeleton.offset(end));
        let (a, b) = (first.length(), second.length());
        let from = self.world_position(skeleton, upper);
        let reach = (target - from).clamp_length((a - b).abs() + 1e-3, (a + b) * 0.9995);
        let along = reach.normalize();
        let c = reach.length();
        // Law of cosines: how far along the line to the target the middle joint lies, and how far off it.
        let foot = (a * a - b * b + c * c) / (2.0 * c);
        let off = (a * a - foot * foot).max(0.0).sqrt();
        let bend = pole.reject_from(along).normalize();
        let middle = along * foot + bend * off;
        let axis = along.cross(bend);
        self.set_world_rotation(skeleton, upper, turn(first, hinge, middle, axis));
        self.set_world_rotation(skeleton, lower, turn(second, hinge, reach - middle, axis));
    }
}

/// Rotation that takes direction `from` to `to`, and `from_side` to the part of `to_side` that is perpendicular to `to`.
pub fn turn(from: DVec3, from_side: DVec3, to: DVec3, to_side: DVec3) -> DQuat {
    let frame = |direction: DVec3, side: DVec3| {
        let x = direction.normalize();
        let y = side.reject_from(x).normalize();
        DMat3::from_cols(x, y, x.cross(y))
    };
    DQuat::from_mat3(&(frame(to, to_side) * frame(from, from_side).transpose())).normalize()
}

/// Rotation by `degrees` about the unit vector `axis`.
pub fn rotation(axis: DVec3, degrees: f64) -> DQuat {
    let (sine, cosine) = super::trig::sin_cos(degrees.to_radians() / 2.0);
    DQuat::from_vec4((axis * sine).extend(cosine))
}

/// Joints that move a point, with weights that need not be normalised.
pub type Influences = Vec<(usize, f64)>;

/// A chain of joints along a line: each takes over from the one before at its station.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Joint that moves the start of the line.
    pub first: usize,
    /// Each later joint with its station (metres along the line) and half the width of the change-over.
    pub rest: Vec<(usize, f64, f64)>,
}

impl Chain {
    /// Influences at `station`; they sum to 1.
    pub fn at(&self, station: f64) -> Influences {
        let mut influences = vec![(self.first, 1.0)];
        for &(joint, centre, half_width) in &self.rest {
            let share = super::implicit::smooth_step(centre - half_width, centre + half_width, station);
            for (_, weight) in &mut influences {
                *weight *= 1.0 - share;
            }
            influences.push((joint, share));
        }
        influences.retain(|&(_, weight)| weight > 0.0);
        influences
    }
}

/// The four strongest of `influences`, as joint indices and weights in 65 535ths that sum to 65 535 exactly.
pub fn pack(influences: &[(usize, f64)]) -> ([u8; 4], [u16; 4]) {
    let mut merged: Influences = Vec::new();
    for &(joint, weight) in influences {
        match merged.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sum)) => *sum += weight,
            None => merged.push((joint, weight)),
        }
    }
    merged.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    merged.truncate(4);
    let total: f64 = merged.iter().map(|&(_, weight)| weight).sum();
    let (mut joints, mut weights) = ([0_u8; 4], [0_u16; 4]);
    for (slot, &(joint, weight)) in merged.iter().enumerate().skip(1) {
        weights[slot] = (weight / total * 65535.0).round() as u16;
        // A joint without weight is named 0, as the specification asks.
        joints[slot] = if weights[slot] == 0 { 0 } else { joint as u8 };
    }
    joints[0] = merged[0].0 as u8;
    weights[0] = 65535 - weights[1] - weights[2] - weights[3];
    (joints, weights)
}
