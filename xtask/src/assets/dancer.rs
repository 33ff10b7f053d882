//! The dancer: a glass figurine who sways from foot to foot, arm overhead, skirt and hair following.

use glam::{DMat3, DVec3};

use super::character::{Character, Morph, Part};
use super::dance;
use super::implicit::{Loft, section, smooth_intersection, smooth_step};
use super::material::Glass;
use super::remesh::Resolution;
use super::rig::{Chain, Influences, Skeleton};

/// Joints of one side of the body.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// 1 on the dancer's left (+x), -1 on the right.
    pub sign: f64,
    /// Collar bone, upper arm, forearm, hand.
    pub arm: [usize; 4],
    /// Thigh, shin, foot, toes.
    pub leg: [usize; 4],
    /// The panel of the skirt on this side, which lies on the thigh.
    pub skirt: usize,
}

/// The dancer's joints by name.
#[derive(Clone, Debug)]
pub struct Joints {
    /// Root of the skeleton.
    pub hips: usize,
    /// Lower back.
    pub spine: usize,
    /// Rib cage.
    pub chest: usize,
    /// Neck.
    pub neck: usize,
    /// Head.
    pub head: usize,
    /// Pony tail from the head outwards.
    pub hair: [usize; 3],
    /// Left, then right.
    pub sides: [Side; 2],
    /// Front and back panel of the skirt.
    pub skirt: [usize; 2],
}

/// The character, ready to be written.
pub fn dancer() -> Character {
    let (skeleton, joints) = skeleton();
    let clip = dance::clip(&skeleton, &joints);
    Character {
        name: "Dancer",
        parts: parts(&joints),
        skeleton,
        morphs: vec![
            Morph { name: "breath", displace: Box::new(breath) },
            Morph { name: "flare", displace: Box::new(flare) },
        ],
        clip,
        glass: Glass { name: "Rose glass", ior: 1.5, thickness: 0.15, attenuation: Some(([1.0, 0.62, 0.58], 0.35)) },
        bounds: [DVec3::new(-0.86, -0.03, -0.38), DVec3::new(0.86, 1.68, 0.38)],
        sharing: 0.06,
        resolution: Resolution { error: 0.0003, finest: 0.005, coarsest: 0.025 },
    }
}

fn skeleton() -> (Skeleton, Joints) {
    let mut bones = Skeleton::default();
    let hips = bones.add("hips", None, DVec3::new(0.0, 0.90, 0.0));
    let spine = bones.add("spine", Some(hips), DVec3::new(0.0, 1.00, 0.0));
    let chest = bones.add("chest", Some(spine), DVec3::new(0.0, 1.14, -0.005));
    let neck = bones.add("neck", Some(chest), DVec3::new(0.0, 1.35, -0.012));
    let head = bones.add("head", Some(neck), DVec3::new(0.0, 1.44, 0.0));
    let mut hair = [head; 3];
    for (i, joint) in hair.iter_mut().enumerate() {
        let parent = if i == 0 { head } else { head + i };
        *joint = bones.add(format!("hair_{}", i + 1), Some(parent), HAIR_ROOT + hair_axis() * (0.11 * i as f64));
    }
    let sides = [("left", 1.0), ("right", -1.0)].map(|(side, sign)| {
        let mut chain = |first: usize, names: [&str; 4], positions: [DVec3; 4]| {
            let mut parent = first;
            let mut indices = [0; 4];
            for i in 0..4 {
                let position = positions[i] * DVec3::new(sign, 1.0, 1.0);
                parent = bones.add(format!("{}_{side}", names[i]), Some(parent), position);
                indices[i] = parent;
            }
            indices
        };
        let arm = chain(
            chest,
            ["collar", "upper_arm", "forearm", "hand"],
            [
                DVec3::new(0.03, 1.29, -0.005),
                DVec3::new(0.14, ARM_HEIGHT, -0.005),
                DVec3::new(0.40, ARM_HEIGHT, -0.005),
                DVec3::new(0.63, ARM_HEIGHT, -0.005),
            ],
        );
        let leg = chain(
            hips,
            ["thigh", "shin", "foot", "toes"],
            [
                DVec3::new(LEG_X, 0.88, 0.0),
                DVec3::new(LEG_X, 0.475, 0.004),
                DVec3::new(LEG_X, 0.075, -0.004),
                DVec3::new(LEG_X, 0.020, 0.105),
            ],
        );
        let skirt = bones.add(format!("skirt_{side}"), Some(hips), DVec3::new(LEG_X * sign, 0.88, 0.0));
        Side { sign, arm, leg, skirt }
    });
    let skirt = [("front", 0.06), ("back", -0.06)]
        .map(|(name, z)| bones.add(format!("skirt_{name}"), Some(hips), DVec3::new(0.0, 0.92, z)));
    (bones, Joints { hips, spine, chest, neck, head, hair, sides, skirt })
}

const ARM_HEIGHT: f64 = 1.298;
const LEG_X: f64 = 0.085;
const HAIR_ROOT: DVec3 = DVec3::new(0.0, 1.565, -0.085);

fn hair_axis() -> DVec3 {
    DVec3::new(0.0, -0.90, -0.42).normalize()
}

fn parts(joints: &Joints) -> Vec<Part> {
    let mut parts = vec![torso(joints)];
    for side in &joints.sides {
        parts.push(bust(joints, side.sign));
        parts.push(leg(joints.hips, side));
        parts.push(foot(side));
        parts.push(arm(joints.chest, side));
        parts.push(thumb(side));
    }
    parts.push(neck(joints));
    parts.extend(head(joints.head));
    parts.push(hair(joints));
    parts.push(skirt(joints));
    parts
}

fn torso(joints: &Joints) -> Part {
    let loft = Loft {
        start: DVec3::new(0.0, 0.83, 0.0),
        frame: DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::Z),
        length: 0.50,
        sections: vec![
            section(0.105, 0.080, -0.004),
            section(0.116, 0.092, -0.010),
            section(0.112, 0.082, -0.006),
            section(0.080, 0.062, 0.002),
            section(0.106, 0.080, 0.002),
            section(0.130, 0.084, -0.004),
            section(0.088, 0.056, -0.012),
        ],
        caps: [0.07, 0.05],
    };
    let chain = Chain {
        first: joints.hips,
        rest: vec![(joints.spine, 0.16, 0.08), (joints.chest, 0.31, 0.08), (joints.neck, 0.54, 0.05)],
    };
    Part::limb(loft, 0.0, chain)
}

fn bust(joints: &Joints, sign: f64) -> Part {
    Part::blob(DVec3::new(0.052 * sign, 1.218, 0.042), DVec3::new(0.046, 0.052, 0.042), 0.07, joints.chest)
}

fn leg(hips: usize, side: &Side) -> Part {
    let loft = Loft {
        start: DVec3::new(LEG_X * side.sign, 0.90, 0.0),
        frame: DMat3::from_cols(-DVec3::Y, DVec3::X, DVec3::Z),
        length: 0.83,
        sections: vec![
            section(0.052, 0.070, -0.006),
            section(0.060, 0.078, -0.002),
            section(0.068, 0.076, 0.006),
            section(0.057, 0.062, 0.008),
            section(0.042, 0.045, 0.010),
            section(0.046, 0.053, -0.012),
            section(0.042, 0.046, -0.018),
            section(0.024, 0.027, -0.008),
            section(0.025, 0.031, -0.004),
        ],
        caps: [0.06, 0.03],
    };
    let [thigh, shin, foot, _] = side.leg;
    Part::limb(
        loft,
        0.05,
        Chain { first: hips, rest: vec![(thigh, 0.14, 0.10), (shin, 0.425, 0.06), (foot, 0.825, 0.04)] },
    )
}

fn foot(side: &Side) -> Part {
    let loft = Loft {
        start: DVec3::new(LEG_X * side.sign, 0.0, -0.032),
        frame: DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
        length: 0.19,
        sections: vec![
            section(0.023, 0.030, 0.032),
            section(0.029, 0.044, 0.043),
            section(0.031, 0.032, 0.036),
            section(0.036, 0.021, 0.020),
            section(0.026, 0.015, 0.014),
        ],
        caps: [0.022, 0.022],
    };
    let [_, _, ankle, toes] = side.leg;
    let axis = loft.clone();
    let chain = Chain { first: ankle, rest: vec![(toes, 0.137, 0.035)] };
    Part {
        bounds: loft.bounds(),
        // A floor rounds the sole off to a flat one.
        field: Box::new(move |p| smooth_intersection(loft.field(p), -p.y, 0.012)),
        blend: 0.035,
        influences: Box::new(move |p| chain.at(axis.station(p))),
    }
}

fn arm(chest: usize, side: &Side) -> Part {
    let loft = Loft {
        start: DVec3::new(0.08 * side.sign, ARM_HEIGHT, -0.005),
        frame: DMat3::from_cols(DVec3::X * side.sign, DVec3::Y, DVec3::Z),
        length: 0.73,
        sections: vec![
            section(0.040, 0.050, 0.0),
            section(0.044, 0.050, 0.0),
            section(0.036, 0.040, 0.0),
            section(0.034, 0.037, 0.0),
            section(0.029, 0.031, 0.0),
            section(0.032, 0.035, 0.002),
            section(0.024, 0.027, 0.002),
            section(0.017, 0.022, 0.002),
            section(0.018, 0.042, 0.004),
            section(0.012, 0.018, 0.0),
        ],
        caps: [0.04, 0.025],
    };
    let [collar, upper, fore, hand] = side.arm;
    let chain = Chain {
        first: chest,
        rest: vec![(collar, -0.01, 0.07), (upper, 0.075, 0.085), (fore, 0.32, 0.075), (hand, 0.55, 0.04)],
    };
    Part::limb(loft, 0.07, chain)
}

fn thumb(side: &Side) -> Part {
    let axis = DVec3::new(0.80 * side.sign, -0.05, 0.60).normalize();
    let up = DVec3::Y.reject_from(axis).normalize();
    let loft = Loft {
        start: DVec3::new(0.665 * side.sign, ARM_HEIGHT - 0.002, 0.012),
        frame: DMat3::from_cols(axis, up, axis.cross(up)),
        length: 0.055,
        sections: vec![section(0.014, 0.014, 0.0), section(0.013, 0.013, 0.0), section(0.010, 0.010, 0.0)],
        caps: [0.012, 0.010],
    };
    Part::limb(loft, 0.018, Chain { first: side.arm[3], rest: vec![] })
}

fn neck(joints: &Joints) -> Part {
    let loft = Loft {
        start: DVec3::new(0.0, 1.29, -0.012),
        frame: DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::Z),
        length: 0.17,
        sections: vec![
            section(0.070, 0.055, 0.0),
            section(0.042, 0.042, 0.0),
            section(0.036, 0.038, 0.004),
            section(0.038, 0.042, 0.010),
        ],
        caps: [0.03, 0.03],
    };
    let chain = Chain { first: joints.chest, rest: vec![(joints.neck, 0.055, 0.04), (joints.head, 0.145, 0.035)] };
    Part::limb(loft, 0.05, chain)
}

fn head(joint: usize) -> Vec<Part> {
    vec![
        Part::blob(DVec3::new(0.0, 1.525, -0.004), DVec3::new(0.070, 0.082, 0.084), 0.02, joint),
        Part::blob(DVec3::new(0.0, 1.470, 0.030), DVec3::new(0.044, 0.056, 0.046), 0.05, joint),
        Part::blob(DVec3::new(0.0, 1.503, 0.070), DVec3::new(0.013, 0.032, 0.019), 0.04, joint),
        Part::blob(DVec3::new(0.0, 1.578, -0.072), DVec3::new(0.040, 0.040, 0.038), 0.025, joint),
    ]
}

fn hair(joints: &Joints) -> Part {
    let axis = hair_axis();
    let loft = Loft {
        start: HAIR_ROOT,
        frame: DMat3::from_cols(axis, DVec3::X, axis.cross(DVec3::X)),
        length: 0.33,
        sections: vec![
            section(0.020, 0.020, 0.0),
            section(0.028, 0.026, 0.0),
            section(0.034, 0.029, 0.0),
            section(0.032, 0.027, 0.0),
            section(0.024, 0.021, 0.0),
            section(0.009, 0.009, 0.0),
        ],
        caps: [0.02, 0.015],
    };
    let [first, second, third] = joints.hair;
    let chain =
        Chain { first: joints.head, rest: vec![(first, 0.015, 0.03), (second, 0.11, 0.07), (third, 0.22, 0.07)] };
    Part::limb(loft, 0.02, chain)
}

/// Height of waist and hem of the skirt, metres.
const WAIST: f64 = 1.00;
const HEM: f64 = 0.61;

/// Radius of the skirt at height `y` on the pleats' mean.
fn skirt_radius(y: f64) -> f64 {
    let t = ((WAIST - y) / (WAIST - HEM)).clamp(-0.1, 1.2);
    0.086 + 0.235 * t - 0.045 * t * t
}

/// A solid bell with nine pleats that deepen towards the hem, hollowed a little from below.
fn skirt_field(p: DVec3) -> f64 {
    let radius = (p.x * p.x + p.z * p.z).sqrt();
    let t = ((WAIST - p.y) / (WAIST - HEM)).clamp(0.0, 1.2);
    let (depth, fade) = (0.10 * t * t, radius * radius / (radius * radius + 0.002));
    let mean = skirt_radius(p.y);
    let bell = (radius - mean * (1.0 + depth * pleats(p) * fade)) * 0.85;
    let hollow = 0.035 * (1.0 - radius * radius / (0.27 * 0.27)).max(-0.5);
    let hem = (HEM + hollow - p.y) * 0.97;
    let top = p.y - 1.06;
    smooth_intersection(smooth_intersection(bell, hem, 0.07), top, 0.05)
}

/// Cosine of nine times the angle about the y axis, as the real part of a complex power.
fn pleats(p: DVec3) -> f64 {
    let radius = (p.x * p.x + p.z * p.z).sqrt().max(1e-9);
    let (c, s) = (p.z / radius, p.x / radius);
    let cube = |(a, b): (f64, f64)| (a * a * a - 3.0 * a * b * b, 3.0 * a * a * b - b * b * b);
    cube(cube((c, s))).0
}

fn skirt(joints: &Joints) -> Part {
    let joints = joints.clone();
    Part {
        bounds: [DVec3::new(-0.34, HEM - 0.05, -0.34), DVec3::new(0.34, 1.07, 0.34)],
        field: Box::new(skirt_field),
        blend: 0.05,
        influences: Box::new(move |p| skirt_influences(&joints, p)),
    }
}

/// The waist goes with hips and back, the cloth round a leg lies on it, the rest hangs from the four panels.
fn skirt_influences(joints: &Joints, p: DVec3) -> Influences {
    let Joints { hips, spine, sides, skirt, .. } = joints;
    let square = |x: f64| x.max(0.0) * x.max(0.0);
    let low = smooth_step(0.86, 0.67, p.y);
    let legs = sides.map(|side| {
        let from_axis = (square((p.x - LEG_X * side.sign).abs()) + p.z * p.z).sqrt();
        (side.skirt, low * smooth_step(0.21, 0.07, from_axis))
    });
    let crowd = (legs[0].1 + legs[1].1).max(1.0);
    let flat = DVec3::new(p.x, 0.0, p.z) / (p.x * p.x + p.z * p.z + 0.02).sqrt();
    let swing = smooth_step(0.95, 0.68, p.y) * (1.0 - (legs[0].1 + legs[1].1) / crowd);
    let panels = [
        (sides[0].skirt, swing * square(flat.x)),
        (sides[1].skirt, swing * square(-flat.x)),
        (skirt[0], swing * square(flat.z)),
        (skirt[1], swing * square(-flat.z)),
    ];
    let mut influences: Influences = legs.map(|(joint, weight)| (joint, weight / crowd)).to_vec();
    influences.extend(panels);
    let rest = 1.0 - influences.iter().map(|&(_, weight)| weight).sum::<f64>();
    let rise = 0.6 * smooth_step(0.95, 1.05, p.y);
    influences.extend([(*hips, rest * (1.0 - rise)), (*spine, rest * rise)]);
    influences
}

/// The rib cage widens and lifts.
fn breath(p: DVec3) -> DVec3 {
    let center = DVec3::new(0.0, 1.19, 0.03);
    let q = (p - center) / DVec3::new(0.16, 0.12, 0.14);
    let swell = smooth_step(1.0, 0.0, q.length());
    DVec3::new(0.10 * p.x, 0.008, 0.016 + 0.10 * p.z.max(0.0)) * swell
}

/// The hem swings outwards and its pleats open.
fn flare(p: DVec3) -> DVec3 {
    let radius = (p.x * p.x + p.z * p.z).sqrt().max(1e-9);
    let outwards = DVec3::new(p.x, 0.0, p.z) / radius;
    // The legs are spared: they keep within the hollow.
    let t = smooth_step(0.92, 0.58, p.y) * smooth_step(0.13, 0.26, radius) * smooth_step(0.50, 0.56, p.y);
    // Arms and hair hang nowhere near the skirt in the rest pose.
    (outwards * (0.075 - 0.02 * pleats(p)) + DVec3::Y * 0.05) * t
}
