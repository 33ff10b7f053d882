//! The dancer's choreography: a loop of two mirrored halves. She sinks through the middle, shifts her weight, rises on
//! one foot, lifts the other leg to the side and leans away from it under the raised arm.

use glam::{DQuat, DVec3};

use super::character::{Clip, WeightKey};
use super::dancer::{Joints, Side};
use super::implicit::smooth_step;
use super::rig::{Pose, Skeleton, rotation, turn};
use super::trig::wave;

const DURATION: f64 = 4.0;
const KEYS: usize = 64;

/// The looping clip.
pub fn clip(skeleton: &Skeleton, joints: &Joints) -> Clip {
    let mut poses: Vec<Pose> = (0..KEYS).map(|i| pose(skeleton, joints, i as f64 / KEYS as f64)).collect();
    poses.push(poses[0].clone());
    Clip { name: "dance", duration: DURATION, poses, weights: weights() }
}

/// Breath and flare at the quarters of the loop: she breathes in as she rises, and the skirt opens as she sinks and
/// turns back.
fn weights() -> Vec<WeightKey> {
    [(0.0, 0.1, 1.0), (0.25, 1.0, 0.15), (0.5, 0.1, 1.0), (0.75, 1.0, 0.15), (1.0, 0.1, 1.0)]
        .map(|(turns, breath, flare)| WeightKey {
            time: turns * DURATION,
            weights: vec![breath, flare],
            slopes: vec![0.0, 0.0],
        })
        .to_vec()
}

/// Where her weight is: -1 on the right foot, 1 on the left; it lingers at the ends.
fn weight_shift(turns: f64) -> f64 {
    let s = wave(turns);
    s * (1.4 - 0.4 * s * s)
}

fn pose(skeleton: &Skeleton, joints: &Joints, turns: f64) -> Pose {
    let mut pose = skeleton.rest();
    let shift = weight_shift(turns);
    let (lag, late) = (weight_shift(turns - 0.035), weight_shift(turns - 0.07));
    let height = shift * shift;
    pose.root = DVec3::new(0.088 * shift, 0.826 + 0.10 * height, -0.012 + 0.012 * height);
    let about = |axis: DVec3, degrees: f64| rotation(axis, degrees);
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    pose.rotations[joints.hips] = about(y, -9.0 * shift) * about(z, 5.0 * shift) * about(x, 3.0 - 3.0 * height);
    pose.rotations[joints.spine] = about(y, 5.0 * lag) * about(z, -12.0 * lag) * about(x, 3.0 - 7.0 * height);
    pose.rotations[joints.chest] = about(y, 10.0 * lag) * about(z, -13.0 * lag) * about(x, 3.0 - 8.0 * height);
    pose.rotations[joints.neck] = about(y, -10.0 * late) * about(z, 3.0 * late) * about(x, 2.0 - 4.0 * height);
    pose.rotations[joints.head] = about(y, -18.0 * late) * about(z, 5.0 * late) * about(x, 5.0 - 11.0 * late * late);
    for (i, &joint) in joints.hair.iter().enumerate() {
        let behind = 0.06 + 0.045 * i as f64;
        let sway = wave(turns - behind + 0.25);
        // Swings against the movement, and hangs down as the back arches.
        pose.rotations[joint] =
            about(z, 15.0 * sway + 5.0 * shift) * about(x, 4.0 - 9.0 * wave(2.0 * (turns - behind)));
    }
    for side in &joints.sides {
        leg(skeleton, &mut pose, side, turns);
        arm(skeleton, &mut pose, joints.chest, side, turns);
    }
    skirt(skeleton, &mut pose, joints, turns);
    pose
}

/// How far the leg of `side` is lifted, 0..1: when the weight is on the other one.
fn lift(side: &Side, turns: f64) -> f64 {
    smooth_step(0.12, 1.0, -side.sign * weight_shift(turns))
}

fn leg(skeleton: &Skeleton, pose: &mut Pose, side: &Side, turns: f64) {
    let [thigh, shin, foot, toes] = side.leg;
    let raised = lift(side, turns);
    let standing = smooth_step(0.1, 1.0, side.sign * weight_shift(turns));
    let yaw = rotation(DVec3::Y, side.sign * (24.0 + 26.0 * raised));
    let heel = 30.0 * standing;
    // On the floor the foot turns about its ball; in the air it is pointed.
    let ball = skeleton.offset(toes);
    let planted = yaw * (-(rotation(DVec3::X, heel) * ball));
    let place = DVec3::new((0.092 + 0.48 * raised) * side.sign, 0.020 + 0.26 * raised, 0.045 + 0.06 * raised);
    let pitch = rotation(DVec3::X, heel + 42.0 * smooth_step(0.0, 0.6, raised));
    let roll = rotation(DVec3::Z, side.sign * 34.0 * raised);
    let ankle = place + planted * (1.0 - raised);
    let pole = DVec3::new(side.sign * (0.62 + 0.3 * raised), 0.35 * raised, 1.0);
    pose.reach(skeleton, [thigh, shin, foot], ankle, pole, DVec3::NEG_X);
    pose.set_world_rotation(skeleton, foot, roll * yaw * pitch);
    let flat = heel * (1.0 - raised);
    pose.rotations[toes] = rotation(DVec3::X, -flat + 14.0 * raised);
}

fn arm(skeleton: &Skeleton, pose: &mut Pose, chest: usize, side: &Side, turns: f64) {
    let [collar, upper, fore, hand] = side.arm;
    // Up on the side of the lifted leg; through the front, low, in between.
    let angles = |delay: f64| {
        let up = -side.sign * weight_shift(turns - delay);
        let middle = 1.0 - up * up;
        (33.0 + 41.0 * up - 38.0 * middle, 10.0 + 34.0 * middle)
    };
    let (raise, forward) = angles(0.005);
    let (fore_raise, fore_forward) = angles(0.022);
    let (hand_raise, hand_forward) = angles(0.042);
    let trunk = pose.world_rotation(skeleton, chest);
    let direction = |raise: f64, forward: f64| {
        rotation(DVec3::Y, -side.sign * forward) * rotation(DVec3::Z, side.sign * raise) * DVec3::X * side.sign
    };
    let rest = DVec3::X * side.sign;
    pose.rotations[collar] = rotation(DVec3::Z, side.sign * 0.36 * raise.max(-10.0));
    let aim = |direction: DVec3| trunk * turn(rest, DVec3::Z, direction, DVec3::new(-0.4 * side.sign, 0.25, 1.0));
    pose.set_world_rotation(skeleton, upper, aim(direction(raise, forward)));
    let up = smooth_step(10.0, 75.0, fore_raise);
    pose.set_world_rotation(skeleton, fore, aim(direction(fore_raise + 8.0 + 22.0 * up, fore_forward + 24.0)));
    pose.set_world_rotation(skeleton, hand, aim(direction(hand_raise - 4.0 + 44.0 * up, hand_forward + 20.0)));
}

/// The side panels lie on the thighs but do not twist with them; all swing after the hips.
fn skirt(skeleton: &Skeleton, pose: &mut Pose, joints: &Joints, turns: f64) {
    let sway = wave(turns - 0.10 + 0.25);
    let bounce = wave(2.0 * turns - 0.2);
    let hips = pose.world_rotation(skeleton, joints.hips);
    for side in &joints.sides {
        let thigh = hips.inverse() * pose.world_rotation(skeleton, side.leg[0]) * DVec3::NEG_Y;
        let on_thigh = DQuat::from_rotation_arc(DVec3::NEG_Y, thigh);
        let swing = rotation(DVec3::Z, 3.0 * sway + 2.0 * side.sign * bounce) * rotation(DVec3::Y, -5.0 * sway);
        pose.rotations[side.skirt] = on_thigh * swing;
    }
    for (joint, sign) in joints.skirt.into_iter().zip([1.0, -1.0]) {
        let twist = rotation(DVec3::Y, -7.0 * sway) * rotation(DVec3::Z, 5.0 * sway);
        pose.rotations[joint] = twist * rotation(DVec3::X, -sign * (6.0 + 5.0 * bounce));
    }
}
