//! The octopus: a glass bulb on eight arms through which a wave travels round and outwards.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::character::{Character, Clip, Morph, Part, WeightKey};
use super::implicit::{Loft, section, smooth_step, smooth_union};
use super::material::Glass;
use super::remesh::Resolution;
use super::rig::{Chain, Pose, Skeleton, rotation};
use super::trig::{sin_cos, wave};

const ARMS: usize = 8;
/// Joints of an arm, evenly spaced by [`BONE`] metres.
const ARM_JOINTS: usize = 6;
const BONE: f64 = 0.165;
/// Where an arm leaves the body, metres from the axis, and at what height.
const ARM_ROOT: f64 = 0.13;
const ARM_HEIGHT: f64 = 0.40;

const DURATION: f64 = 4.0;
const KEYS: usize = 48;

struct Joints {
    body: usize,
    /// Lower and upper half of the mantle.
    mantle: [usize; 2],
    arms: Vec<[usize; ARM_JOINTS]>,
}

/// The character, ready to be written.
pub fn octopus() -> Character {
    let (skeleton, joints) = skeleton();
    let mut poses: Vec<Pose> = (0..KEYS).map(|i| pose(&skeleton, &joints, i as f64 / KEYS as f64)).collect();
    poses.push(poses[0].clone());
    Character {
        name: "Octopus",
        parts: parts(&joints),
        skeleton,
        morphs: vec![Morph { name: "breath", displace: Box::new(breath) }],
        clip: Clip { name: "ripple", duration: DURATION, poses, weights: weights() },
        glass: Glass { name: "Lagoon glass", ior: 1.5, thickness: 0.4, attenuation: Some(([0.35, 0.86, 0.92], 0.8)) },
        bounds: [DVec3::new(-1.3, 0.1, -1.3), DVec3::new(1.3, 1.75, 1.3)],
        sharing: 0.14,
        resolution: Resolution { error: 0.0006, finest: 0.011, coarsest: 0.045 },
    }
}

/// Direction in which arm `arm` leaves the body; none points straight ahead.
fn outwards(arm: usize) -> DVec3 {
    let (sine, cosine) = sin_cos(TAU * (arm as f64 + 0.5) / ARMS as f64);
    DVec3::new(sine, 0.0, cosine)
}

fn skeleton() -> (Skeleton, Joints) {
    let mut bones = Skeleton::default();
    let body = bones.add("body", None, DVec3::new(0.0, 0.48, 0.0));
    let lower = bones.add("mantle_lower", Some(body), DVec3::new(0.0, 0.72, -0.02));
    let upper = bones.add("mantle_upper", Some(lower), DVec3::new(0.0, 1.05, -0.06));
    let arms = (0..ARMS)
        .map(|arm| {
            let mut parent = body;
            std::array::from_fn(|i| {
                let position = outwards(arm) * (ARM_ROOT + BONE * i as f64) + DVec3::Y * ARM_HEIGHT;
                parent = bones.add(format!("arm_{}_{}", arm + 1, i + 1), Some(parent), position);
                parent
            })
        })
        .collect();
    (bones, Joints { body, mantle: [lower, upper], arms })
}

fn parts(joints: &Joints) -> Vec<Part> {
    let mut parts = vec![bulb(joints), neck(joints)];
    parts.extend([1.0, -1.0].map(|sign| eye(joints.body, sign)));
    parts.extend((0..ARMS).map(|arm| tentacle(joints, arm)));
    parts
}

/// Joints along the height of the mantle.
fn mantle_chain(joints: &Joints, base: f64) -> Chain {
    let [lower, upper] = joints.mantle;
    Chain { first: joints.body, rest: vec![(lower, 0.74 - base, 0.20), (upper, 1.06 - base, 0.26)] }
}

fn bulb(joints: &Joints) -> Part {
    let chain = mantle_chain(joints, 0.0);
    Part {
        influences: Box::new(move |p| chain.at(p.y)),
        ..Part::blob(DVec3::new(0.0, 1.14, -0.07), DVec3::new(0.365, 0.44, 0.345), 0.0, joints.body)
    }
}

fn neck(joints: &Joints) -> Part {
    let axis = DVec3::new(0.0, 1.0, -0.13).normalize();
    let loft = Loft {
        start: DVec3::new(0.0, 0.42, 0.02),
        frame: DMat3::from_cols(axis, DVec3::X, axis.cross(DVec3::X)),
        length: 0.52,
        sections: vec![
            section(0.17, 0.17, 0.0),
            section(0.215, 0.205, 0.0),
            section(0.195, 0.185, 0.0),
            section(0.230, 0.220, 0.0),
            section(0.240, 0.230, 0.0),
        ],
        caps: [0.08, 0.20],
    };
    Part::limb(loft, 0.22, mantle_chain(joints, 0.42))
}

fn eye(body: usize, sign: f64) -> Part {
    Part::blob(DVec3::new(0.165 * sign, 0.655, 0.155), DVec3::new(0.062, 0.070, 0.062), 0.07, body)
}

fn tentacle(joints: &Joints, arm: usize) -> Part {
    let axis = outwards(arm);
    let loft = Loft {
        start: axis * 0.06 + DVec3::Y * ARM_HEIGHT,
        frame: DMat3::from_cols(axis, DVec3::Y, axis.cross(DVec3::Y)),
        length: 1.08,
        sections: [0.105, 0.102, 0.090, 0.078, 0.066, 0.054, 0.043, 0.033, 0.024]
            .map(|radius| section(radius, radius * 1.06, 0.0))
            .to_vec(),
        caps: [0.05, 0.03],
    };
    let rest = joints.arms[arm]
        .iter()
        .enumerate()
        .map(|(i, &joint)| (joint, ARM_ROOT - 0.06 + BONE * i as f64, if i == 0 { 0.10 } else { 0.17 }))
        .collect();
    Part::limb(loft, 0.13, Chain { first: joints.body, rest })
}

/// The mantle fills: it widens most at its middle.
fn breath(p: DVec3) -> DVec3 {
    let swell = smooth_step(0.70, 1.05, p.y) * smooth_step(1.55, 1.05, p.y);
    DVec3::new(0.11 * p.x, 0.0, 0.11 * (p.z + 0.06)) * swell + DVec3::Y * 0.05 * smooth_step(0.95, 1.45, p.y)
}

/// Breath in time with the bob: in while the body rises, out as it sinks, twice a loop.
fn weights() -> Vec<WeightKey> {
    [(0.0, 0.15), (0.22, 1.0), (0.5, 0.15), (0.72, 1.0), (1.0, 0.15)]
        .map(|(turns, breath)| WeightKey { time: turns * DURATION, weights: vec![breath], slopes: vec![0.0] })
        .to_vec()
}

fn pose(skeleton: &Skeleton, joints: &Joints, turns: f64) -> Pose {
    let mut pose = skeleton.rest();
    let bob = wave(2.0 * turns - 0.25);
    pose.root += DVec3::new(0.045 * wave(turns), 0.035 * bob, 0.045 * wave(turns + 0.25));
    let (x, z) = (DVec3::X, DVec3::Z);
    // The body leans round in a circle; the mantle follows late and overshoots.
    let lean = |degrees: f64, delay: f64| {
        rotation(x, degrees * wave(turns - delay + 0.25)) * rotation(z, -degrees * wave(turns - delay))
    };
    pose.rotations[joints.body] = lean(5.0, 0.0);
    pose.rotations[joints.mantle[0]] = lean(7.0, 0.09) * rotation(x, 2.5 * wave(2.0 * turns - 0.1));
    pose.rotations[joints.mantle[1]] = lean(9.0, 0.18) * rotation(x, 4.0 * wave(2.0 * turns - 0.2));
    for arm in 0..ARMS {
        bend_arm(skeleton, &mut pose, joints, arm, turns);
    }
    pose
}

/// Each arm arches down to the floor and curls up at its tip. The wave goes round the body once a loop and runs
/// outwards along each arm, growing towards the tip.
fn bend_arm(skeleton: &Skeleton, pose: &mut Pose, joints: &Joints, arm: usize, turns: f64) {
    const BASES: [f64; ARM_JOINTS] = [-44.0, -6.0, 14.0, 18.0, 22.0, 24.0];
    const SWINGS: [f64; ARM_JOINTS] = [0.0, 5.0, 7.0, 9.0, 12.0, 14.0];
    let chain = joints.arms[arm];
    let lift = outwards(arm).cross(DVec3::Y);
    let place = arm as f64 / ARMS as f64;
    // Arms differ a little, as living ones do.
    let own = wave(3.0 * place + 0.1);
    let turn = |i: usize, pitch: f64| {
        let sideways = wave(turns - place - 0.08 * i as f64);
        rotation(DVec3::Y, (4.0 + 2.4 * i as f64) * sideways + 6.0 * own) * rotation(lift, pitch)
    };
    for (i, &joint) in chain.iter().enumerate().skip(1) {
        let ripple = wave(2.0 * turns - place * 2.0 - 0.065 * i as f64);
        pose.rotations[joint] = turn(i, BASES[i] + 3.5 * own * (i as f64 - 2.0) + SWINGS[i] * ripple);
    }
    // The root joint takes the body's lean back and lays the arm on the floor, or above it while its turn to be lifted
    // comes round.
    let steady = pose.rotations[joints.body].inverse();
    let clearance = 0.08 * smooth_step(0.1, 1.0, wave(turns - place));
    let mut pitch = BASES[0];
    for _ in 0..12 {
        pose.rotations[chain[0]] = steady * turn(0, pitch);
        let (lowest, reach) = lowest_point(skeleton, pose, chain);
        pitch = (pitch - ((lowest - clearance) / reach).to_degrees()).clamp(-80.0, 10.0);
    }
}

/// Height of the lowest point of an arm's underside, and its distance from the arm's root, metres. The minimum over the
/// joints is a smooth one, so that it moves smoothly in time.
fn lowest_point(skeleton: &Skeleton, pose: &Pose, chain: [usize; ARM_JOINTS]) -> (f64, f64) {
    let root = pose.world_position(skeleton, chain[0]);
    let last = chain[ARM_JOINTS - 1];
    let tip = pose.world_position(skeleton, last) + pose.world_rotation(skeleton, last) * skeleton.offset(last);
    let points = chain.iter().skip(1).map(|&joint| pose.world_position(skeleton, joint)).chain([tip]);
    let mut lowest = f64::INFINITY;
    let (mut reach, mut total) = (0.0, 0.0);
    for (i, point) in points.enumerate() {
        let height = point.y - (0.092 - 0.0125 * i as f64);
        lowest = if lowest.is_finite() { smooth_union(lowest, height, 0.06) } else { height };
        // Points near the floor count for the lever.
        let near = 1.0 / (1.0 + (height * height) / 0.01);
        reach += near * (point - root).length();
        total += near;
    }
    (lowest, reach / total)
}
