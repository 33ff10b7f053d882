//! The swan: afloat on the floor, its neck in a slow S that travels from the breast to the head.

use glam::{DMat3, DVec3};

use super::character::{Character, Clip, Morph, Part, WeightKey};
use super::implicit::{Loft, ellipsoid, section, smooth_intersection, smooth_step};
use super::material::Glass;
use super::remesh::Resolution;
use super::rig::{Chain, Pose, Skeleton, rotation, turn};
use super::trig::wave;

/// Joints of the neck, evenly spaced by [`BONE`] metres along [`neck_axis`] from [`NECK_ROOT`].
const NECK_JOINTS: usize = 8;
const BONE: f64 = 0.125;
const NECK_ROOT: DVec3 = DVec3::new(0.0, 0.36, 0.40);

const DURATION: f64 = 6.0;
const KEYS: usize = 60;

struct Joints {
    body: usize,
    neck: [usize; NECK_JOINTS],
    head: usize,
    tail: usize,
    wings: [Wing; 2],
}

#[derive(Clone, Copy)]
struct Wing {
    /// 1 on the swan's left (+x), -1 on the right.
    sign: f64,
    /// Shoulder, middle and tip.
    joints: [usize; 3],
}

/// The character, ready to be written.
pub fn swan() -> Character {
    let (skeleton, joints) = skeleton();
    let mut poses: Vec<Pose> = (0..KEYS).map(|i| pose(&skeleton, &joints, i as f64 / KEYS as f64)).collect();
    poses.push(poses[0].clone());
    Character {
        name: "Swan",
        parts: parts(&joints),
        skeleton,
        morphs: vec![Morph { name: "ruffle", displace: Box::new(ruffle) }],
        clip: Clip { name: "glide", duration: DURATION, poses, weights: weights() },
        glass: Glass { name: "Honey glass", ior: 1.5, thickness: 0.4, attenuation: Some(([1.0, 0.80, 0.46], 0.7)) },
        bounds: [DVec3::new(-0.62, -0.06, -1.15), DVec3::new(0.62, 1.75, 1.15)],
        sharing: 0.12,
        resolution: Resolution { error: 0.00028, finest: 0.0055, coarsest: 0.03 },
    }
}

/// In the rest pose the neck is straight, up and forwards.
fn neck_axis() -> DVec3 {
    DVec3::new(0.0, 0.94, 0.34).normalize()
}

/// In the rest pose the bill points along the neck, so that the whole of neck and head is straight.
fn head_root() -> DVec3 {
    NECK_ROOT + neck_axis() * (BONE * NECK_JOINTS as f64)
}

/// Where a wing starts and which way it points in the rest pose: back, up and a little out.
fn wing_line(sign: f64) -> (DVec3, DVec3) {
    (DVec3::new(0.20 * sign, 0.37, 0.24), DVec3::new(0.16 * sign, 0.40, -0.90).normalize())
}

fn skeleton() -> (Skeleton, Joints) {
    let mut bones = Skeleton::default();
    let body = bones.add("body", None, DVec3::new(0.0, 0.24, 0.0));
    let mut parent = body;
    let neck = std::array::from_fn(|i| {
        parent = bones.add(format!("neck_{}", i + 1), Some(parent), NECK_ROOT + neck_axis() * (BONE * i as f64));
        parent
    });
    let head = bones.add("head", Some(parent), head_root());
    let tail = bones.add("tail", Some(body), DVec3::new(0.0, 0.28, -0.48));
    let wings = [("left", 1.0), ("right", -1.0)].map(|(side, sign)| {
        let (start, axis) = wing_line(sign);
        let mut parent = body;
        let joints = std::array::from_fn(|i| {
            parent = bones.add(format!("wing_{side}_{}", i + 1), Some(parent), start + axis * (0.26 * i as f64));
            parent
        });
        Wing { sign, joints }
    });
    (bones, Joints { body, neck, head, tail, wings })
}

fn parts(joints: &Joints) -> Vec<Part> {
    let mut parts = vec![body(joints), neck(joints)];
    parts.extend(head(joints.head));
    parts.push(tail(joints));
    parts.extend(joints.wings.iter().map(|wing| wing_part(joints.body, *wing)));
    parts
}

/// The hull: a boat from breast to rump, flattened where it floats.
fn body(joints: &Joints) -> Part {
    let joint = joints.body;
    let (center, radii) = (DVec3::new(0.0, 0.25, 0.0), DVec3::new(0.27, 0.26, 0.60));
    Part {
        bounds: [center - radii, center + radii],
        field: Box::new(move |p| {
            // The rump is lifted: the keel bends up towards the tail.
            let back = (-p.z - 0.05).max(0.0);
            let bent = p - center - DVec3::Y * (0.32 * back * back);
            smooth_intersection(ellipsoid(bent, radii), 0.002 - p.y, 0.10)
        }),
        blend: 0.0,
        influences: Box::new(move |_| vec![(joint, 1.0)]),
    }
}

fn neck(joints: &Joints) -> Part {
    let axis = neck_axis();
    let start = NECK_ROOT - axis * 0.12;
    let loft = Loft {
        start,
        frame: DMat3::from_cols(axis, DVec3::X, axis.cross(DVec3::X)),
        length: 0.12 + BONE * NECK_JOINTS as f64,
        sections: [0.150, 0.125, 0.088, 0.068, 0.058, 0.052, 0.048, 0.046, 0.047]
            .map(|radius| section(radius, radius, 0.0))
            .to_vec(),
        caps: [0.08, 0.04],
    };
    let chain = joints.neck.iter().chain([&joints.head]).enumerate();
    let rest = chain.map(|(i, &joint)| (joint, 0.12 + BONE * i as f64, if i == 0 { 0.11 } else { 0.13 })).collect();
    Part::limb(loft, 0.20, Chain { first: joints.body, rest })
}

/// Skull and bill, along the neck.
fn head(joint: usize) -> Vec<Part> {
    let axis = neck_axis();
    let frame = DMat3::from_cols(axis, DVec3::X, axis.cross(DVec3::X));
    let skull = Loft {
        start: head_root() - axis * 0.01,
        frame,
        length: 0.12,
        sections: vec![
            section(0.050, 0.052, 0.0),
            section(0.062, 0.066, 0.0),
            section(0.058, 0.062, 0.002),
            section(0.040, 0.042, 0.004),
        ],
        caps: [0.03, 0.03],
    };
    let bill = Loft {
        start: head_root() + axis * 0.10,
        frame,
        length: 0.17,
        sections: vec![
            section(0.034, 0.036, 0.004),
            section(0.029, 0.024, 0.010),
            section(0.027, 0.017, 0.014),
            section(0.025, 0.014, 0.015),
            section(0.016, 0.011, 0.014),
        ],
        caps: [0.03, 0.014],
    };
    let chain = Chain { first: joint, rest: vec![] };
    vec![Part::limb(skull, 0.05, chain.clone()), Part::limb(bill, 0.03, chain)]
}

fn tail(joints: &Joints) -> Part {
    let axis = DVec3::new(0.0, 0.40, -0.92).normalize();
    let loft = Loft {
        start: DVec3::new(0.0, 0.30, -0.44),
        frame: DMat3::from_cols(axis, DVec3::X, axis.cross(DVec3::X)),
        length: 0.34,
        sections: vec![
            section(0.15, 0.11, 0.0),
            section(0.15, 0.075, 0.0),
            section(0.125, 0.048, 0.0),
            section(0.080, 0.032, 0.0),
            section(0.022, 0.020, 0.0),
        ],
        caps: [0.06, 0.02],
    };
    Part::limb(loft, 0.10, Chain { first: joints.body, rest: vec![(joints.tail, 0.08, 0.12)] })
}

fn wing_part(body: usize, wing: Wing) -> Part {
    let (start, axis) = wing_line(wing.sign);
    // Thin across the wing, broad in its plane, which stands steeply.
    let thin = DVec3::new(wing.sign, 0.34, 0.0).reject_from(axis).normalize();
    let loft = Loft {
        start,
        frame: DMat3::from_cols(axis, thin, axis.cross(thin)),
        length: 0.84,
        sections: vec![
            section(0.070, 0.13, 0.0),
            section(0.066, 0.19, 0.0),
            section(0.058, 0.20, 0.0),
            section(0.048, 0.165, 0.0),
            section(0.038, 0.110, 0.0),
            section(0.028, 0.060, 0.0),
            section(0.016, 0.020, 0.0),
        ],
        caps: [0.10, 0.03],
    };
    let [shoulder, middle, tip] = wing.joints;
    let chain = Chain { first: body, rest: vec![(shoulder, 0.10, 0.16), (middle, 0.30, 0.18), (tip, 0.54, 0.18)] };
    Part::limb(loft, 0.10, chain)
}

/// Back and wings swell in three soft rows, as when feathers are shaken out.
fn ruffle(p: DVec3) -> DVec3 {
    let along = smooth_step(0.30, 0.05, p.z) * smooth_step(-0.55, -0.20, p.z);
    let high = smooth_step(0.38, 0.55, p.y) * smooth_step(0.95, 0.75, p.y);
    let rows = 0.5 + 0.5 * wave(p.z / 0.20 + 0.1);
    DVec3::new(0.06 * p.x, 0.012, -0.006) * (along * high * (0.4 + 0.6 * rows))
}

fn weights() -> Vec<WeightKey> {
    [(0.0, 0.0), (0.3, 0.25), (0.55, 1.0), (0.75, 0.2), (1.0, 0.0)]
        .map(|(turns, ruffle)| WeightKey { time: turns * DURATION, weights: vec![ruffle], slopes: vec![0.0] })
        .to_vec()
}

fn pose(skeleton: &Skeleton, joints: &Joints, turns: f64) -> Pose {
    let mut pose = skeleton.rest();
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    // Afloat: it rocks and bobs, and its breast dips as the head goes forwards.
    let reach = bow(turns);
    pose.root += DVec3::new(0.0, 0.006 + 0.007 * wave(2.0 * turns), 0.03 * wave(turns + 0.1));
    pose.rotations[joints.body] =
        rotation(y, 3.0 * wave(turns)) * rotation(z, 2.0 * wave(2.0 * turns + 0.3)) * rotation(x, -1.5 + 3.0 * reach);
    neck_pose(skeleton, &mut pose, joints, turns);
    pose.rotations[joints.tail] = rotation(y, 12.0 * wave(3.0 * turns)) * rotation(x, 5.0 * wave(turns + 0.4));
    for wing in &joints.wings {
        for (i, &joint) in wing.joints.iter().enumerate() {
            let delay = 0.05 * i as f64;
            let lifted = spread(turns - delay);
            let own = 0.015 * wing.sign;
            let open = rotation(z, -wing.sign * (2.0 + 9.0 * lifted)) * rotation(y, wing.sign * 5.0 * lifted);
            let flutter = 2.5 * wave(4.0 * turns - 4.0 * delay + own) * lifted;
            pose.rotations[joint] = open * rotation(x, 2.0 + 5.0 * lifted + flutter);
        }
    }
    pose
}

/// How far the head is bowed, 0..1, once a loop.
fn bow(turns: f64) -> f64 {
    smooth_step(-0.8, 1.0, wave(turns - 0.25))
}

/// How far the wings are opened, 0..1: after the bow, as the neck rises.
fn spread(turns: f64) -> f64 {
    smooth_step(-0.3, 1.0, wave(turns - 0.42))
}

/// The neck leans back, arches over and carries the head level; bowing opens the S from the breast upwards.
fn neck_pose(skeleton: &Skeleton, pose: &mut Pose, joints: &Joints, turns: f64) {
    // Pitch of each joint against the one before: back at first, then forwards over the crown.
    const HIGH: [f64; NECK_JOINTS] = [-8.0, -26.0, -22.0, -6.0, 12.0, 26.0, 34.0, 34.0];
    const LOW: [f64; NECK_JOINTS] = [20.0, -8.0, -20.0, -14.0, 14.0, 34.0, 40.0, 36.0];
    for (i, &joint) in joints.neck.iter().enumerate() {
        let delay = 0.022 * i as f64;
        let bowed = bow(turns - delay);
        let pitch = HIGH[i] + (LOW[i] - HIGH[i]) * bowed + 2.5 * wave(2.0 * turns - 2.0 * delay);
        let yaw = 4.0 * wave(turns - delay + 0.15);
        pose.rotations[joint] = rotation(DVec3::Y, yaw) * rotation(DVec3::X, pitch);
    }
    // The head stays nearly level and looks about.
    let look = 22.0 * wave(turns + 0.02);
    let bill = rotation(DVec3::Y, look) * rotation(DVec3::X, 14.0 + 22.0 * bow(turns - 0.2)) * DVec3::Z;
    let level = turn(neck_axis(), DVec3::X, bill, rotation(DVec3::Y, look) * DVec3::X);
    pose.set_world_rotation(skeleton, joints.head, level);
}
