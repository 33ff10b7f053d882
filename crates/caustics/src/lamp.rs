//! A lamp as a viewpoint: what it sees of a caster, what it sees of the receivers.

use std::f64::consts::FRAC_PI_2;

use encase::ShaderType;
use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, Vec3};
use murano_animation::Bounds;
use murano_refraction::Viewpoint;
use murano_scene::{LightKind, PlacedLight};

/// Widest half-angle that one picture of a lamp covers, radians.
const WIDEST: f64 = 1.3;
/// The sun's view follows its casters in steps of whole texels, this part of its picture: nothing that it shows shifts against its texels.
const STEPS: u32 = 8;

/// A light, or what of a point light shines to one side, with the viewpoints that its passes need.
#[derive(Clone, Debug)]
pub struct Lamp {
    placed: PlacedLight,
    /// Sees every receiver that matters: the caustic map is a picture of this viewpoint.
    pub receivers: Viewpoint,
}

/// A light to all sides where something throws caustics or shadows.
#[derive(Clone, Debug)]
pub struct Lamps {
    /// One; of a point light among its casters up to six.
    pub sides: Vec<Lamp>,
    /// Side of each caster.
    pub side_of: Vec<usize>,
}

impl Lamps {
    /// A light that shines on casters and receivers within `scene` (all in the world); its maps have `map_size` texels a side. A point
    /// light whose casters do not fit one view has one for those behind each side of a cube about it.
    pub fn new(placed: &PlacedLight, casters: &[Bounds], scene: &Bounds, map_size: u32) -> Self {
        let all = casters.iter().fold(Bounds::EMPTY, |all, caster| all.union(*caster));
        let common = Lamp::new(placed, if casters.is_empty() { scene } else { &all }, scene, map_size);
        let position = placed.world_from_light.w_axis.truncate();
        let axis = -common.receivers.world_from_view.z_axis.truncate();
        if placed.light.kind != LightKind::Point || casters.iter().all(|caster| sees(position, axis, caster)) {
            return Self { sides: vec![common], side_of: vec![0; casters.len()] };
        }
        let face_of: Vec<usize> =
            casters.iter().map(|caster| face_before(&placed.world_from_light, caster.center())).collect();
        let mut faces: Vec<usize> = Vec::new();
        for face in &face_of {
            if !faces.contains(face) {
                faces.push(*face);
            }
        }
        let behind = |face: usize| {
            let own = casters.iter().zip(&face_of).filter(|(_, of)| **of == face);
            own.fold(Bounds::EMPTY, |all, (caster, _)| all.union(*caster))
        };
        Self {
            sides: faces.iter().map(|face| Lamp::new(placed, &behind(*face), scene, map_size)).collect(),
            side_of: face_of.iter().map(|of| faces.iter().position(|face| face == of).unwrap_or(0)).collect(),
        }
    }
}

/// Directions of the sides of a cube in a light's space.
const FACES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// The side of a cube about a light that a place lies behind.
fn face_before(world_from_light: &DMat4, place: DVec3) -> usize {
    let to = world_from_light.inverse().transform_point3(place);
    (0..FACES.len()).fold(0, |best, face| if to.dot(FACES[face]) > to.dot(FACES[best]) { face } else { best })
}

/// Whether a picture about an axis can hold the ball around a caster.
fn sees(position: DVec3, axis: DVec3, caster: &Bounds) -> bool {
    let to = caster.center() - position;
    let radius = 0.5 * caster.diameter();
    to.angle_between(axis) + (radius / to.length().max(radius).max(1e-12)).asin() <= WIDEST
}

/// What a lamp sends into its view (`caustics::photon::Emission`).
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct Emission {
    cos_outer: f32,
    cos_inner: f32,
    axis: Vec3,
}

/// Cosines of a light's outer and inner half-angles; both -1 without a cone.
pub fn cone_cosines(kind: LightKind) -> (f32, f32) {
    match kind {
        LightKind::Spot { inner, outer } => (outer.cos(), inner.min(outer).cos()),
        LightKind::Directional | LightKind::Point => (-1.0, -1.0),
    }
}

impl Lamp {
    /// A light that shines on casters within `casters` and receivers within `scene` (both in the world); its map has
    /// `map_size` texels a side. One view: [`Lamps`] has as many as a light needs.
    pub fn new(placed: &PlacedLight, casters: &Bounds, scene: &Bounds, map_size: u32) -> Self {
        let position = placed.world_from_light.w_axis.truncate();
        let axis = placed.world_from_light.transform_vector3(DVec3::NEG_Z);
        let radius = (0.5 * casters.diameter()).max(1e-12);
        let size = [map_size, map_size];
        let receivers = match placed.light.kind {
            LightKind::Directional => {
                // Behind everything, so that all depths are positive.
                let reach = 0.5 * scene.diameter() + casters.center().distance(scene.center()) + radius;
                let reach = reach.log2().ceil().exp2();
                // Wide enough for what the casters throw, in steps, so that one of them that moves does not change what the lamp sees.
                let half = 4.0 * (0.125 * (8.0 * radius.log2()).ceil()).exp2();
                let upright = turned(&placed.world_from_light, DVec3::ZERO, axis);
                let step = f64::from(map_size / STEPS) * 2.0 * half / f64::from(map_size.max(1));
                let middle = match step {
                    0.0 => casters.center(),
                    step => {
                        let steps = upright.transpose().transform_vector3(casters.center()) / step;
                        upright.transform_vector3(steps.round() * step)
                    }
                };
                Viewpoint {
                    world_from_view: turned(&placed.world_from_light, middle - axis * 2.0 * reach, axis),
                    perspective: false,
                    half_extent: DVec2::splat(half),
                    center: DVec2::ZERO,
                    size,
                    near: 1e-3 * reach,
                }
            }
            LightKind::Spot { outer, .. } => Viewpoint {
                world_from_view: placed.world_from_light,
                perspective: true,
                half_extent: DVec2::splat(f64::from(outer).clamp(1e-3, WIDEST).tan()),
                center: DVec2::ZERO,
                size,
                near: near(position, casters),
            },
            LightKind::Point => {
                let to = casters.center() - position;
                let half = (3.0 * (radius / to.length().max(radius)).asin()).clamp(0.7, WIDEST);
                Viewpoint {
                    world_from_view: turned(&placed.world_from_light, position, to),
                    perspective: true,
                    half_extent: DVec2::splat(half.tan()),
                    center: DVec2::ZERO,
                    size,
                    near: near(position, casters),
                }
            }
        };
        Self { placed: placed.clone(), receivers }
    }

    /// The light itself.
    pub fn placed(&self) -> &PlacedLight {
        &self.placed
    }

    /// A viewpoint of `size` texels a side fitted to a caster, or why there is none.
    ///
    /// # Errors
    /// The reason, for the schedule.
    pub fn caster_viewpoint(&self, caster: &Bounds, size: u32) -> Result<Viewpoint, &'static str> {
        let position = self.placed.world_from_light.w_axis.truncate();
        let axis = self.placed.world_from_light.transform_vector3(DVec3::NEG_Z);
        let radius = 0.5 * caster.diameter();
        let to = caster.center() - position;
        let base = Viewpoint { size: [size, size], ..self.receivers };
        let seen_from = &self.receivers.world_from_view;
        let viewpoint = match self.placed.light.kind {
            LightKind::Directional => Viewpoint {
                world_from_view: turned(seen_from, caster.center() - axis * 2.0 * radius.max(1e-12), axis),
                near: 1e-3 * radius.max(1e-12),
                ..base
            },
            LightKind::Spot { outer, .. } => {
                let outside = to.angle_between(axis) - (radius / to.length().max(radius)).asin();
                if outside > f64::from(outer) {
                    return Err("the caster is outside the light's cone");
                }
                Viewpoint { world_from_view: turned(seen_from, position, to), ..base }
            }
            LightKind::Point => Viewpoint { world_from_view: turned(seen_from, position, to), ..base },
        };
        let fitted = viewpoint.fitted(caster, 1.02).ok_or("the light is inside the caster's bounds")?;
        match self.placed.light.kind {
            // What the cone leaves dark is not worth a photon.
            LightKind::Spot { outer, .. } => {
                let axis = fitted.world_from_view.inverse().transform_vector3(axis).normalize_or(DVec3::NEG_Z);
                cone_on_plane(axis, f64::from(outer))
                    .map_or(Ok(fitted), |cone| fitted.cut(cone).ok_or("the caster is outside the light's cone"))
            }
            LightKind::Directional | LightKind::Point => Ok(fitted),
        }
    }

    /// Emission into a viewpoint of this lamp.
    pub(crate) fn emission(&self, viewpoint: &Viewpoint) -> Emission {
        let axis = self.placed.world_from_light.transform_vector3(DVec3::NEG_Z);
        let (cos_outer, cos_inner) = cone_cosines(self.placed.light.kind);
        Emission {
            cos_outer,
            cos_inner,
            axis: viewpoint.world_from_view.inverse().transform_vector3(axis).normalize_or(DVec3::NEG_Z).as_vec3(),
        }
    }
}

/// The rectangle, lowest and highest, around a cone about a unit axis where it meets the image plane at depth 1; `None` where it
/// does not meet it all around. A plane through the eye and a line x = k of the image plane touches the cone where its distance from
/// the axis is that of the cone: (a.x + k a.z)^2 = (1 + k^2) sin^2.
fn cone_on_plane(axis: DVec3, half_angle: f64) -> Option<[DVec2; 2]> {
    let sine = half_angle.sin();
    let (along, square) = (axis.z * axis.z - sine * sine, sine * sine);
    if half_angle >= FRAC_PI_2 || axis.z >= 0.0 || along <= 0.0 {
        return None;
    }
    let middle = axis.truncate() * -axis.z;
    let spread = axis.truncate().map(|a| (a * a * axis.z * axis.z - along * (a * a - square)).max(0.0).sqrt());
    Some([(middle - spread) / along, (middle + spread) / along])
}

/// A view from a place along a direction, turned from another view by the shortest way: as light or body move about, its picture
/// does not spin, as it would about the zenith if it were kept upright.
fn turned(from: &DMat4, position: DVec3, forward: DVec3) -> DMat4 {
    let back = from.z_axis.truncate().normalize_or(DVec3::Z);
    let up = from.y_axis.truncate().reject_from_normalized(back).normalize_or(back.any_orthonormal_vector());
    let rotation = DQuat::from_mat3(&DMat3::from_cols(up.cross(back), up, back));
    let turn = DQuat::from_rotation_arc(-back, forward.normalize_or(-back));
    DMat4::from_rotation_translation(turn * rotation, position)
}

/// Nearest depth of interest: a small part of the distance to the casters, a power of two so that a body moving about
/// does not change what the lamp sees of everything else.
fn near(position: DVec3, casters: &Bounds) -> f64 {
    (1e-4 * position.distance(casters.center()).max(casters.diameter()).max(1e-12)).log2().floor().exp2()
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};
    use murano_refraction::{MapFeatures, Refraction, traced};

    use super::*;

    #[test]
    fn a_cone_touches_its_rectangle() {
        let half_angle = 0.4_f64;
        for axis in [DVec3::NEG_Z, DVec3::new(0.3, -0.5, -1.0), DVec3::new(-1.0, 0.2, -1.1)].map(DVec3::normalize) {
            let [low, high] = cone_on_plane(axis, half_angle).expect("in front");
            let (right, up) = axis.any_orthonormal_pair();
            let on_plane = |turn: f64| {
                let side = right * turn.cos() + up * turn.sin();
                let ray = axis * half_angle.cos() + side * half_angle.sin();
                ray.truncate() / -ray.z
            };
            let rim = || (0..100_000).map(|i| on_plane(f64::from(i) * 1e-5 * std::f64::consts::TAU));
            let (lowest, highest) = (rim().reduce(DVec2::min).unwrap(), rim().reduce(DVec2::max).unwrap());
            assert!(lowest.distance(low) < 1e-6 && highest.distance(high) < 1e-6, "{low} {lowest} {high} {highest}");
        }
        assert_eq!(cone_on_plane(DVec3::new(1.0, 0.0, -0.1).normalize(), half_angle), None);
        assert_eq!(cone_on_plane(DVec3::Z, half_angle), None);
    }

    #[test]
    fn a_point_light_among_casters_looks_at_all_of_them() {
        let placed = PlacedLight {
            world_from_light: murano_scene::look_along(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -1.0, 0.2)),
            light: murano_scene::Light {
                name: String::new(),
                kind: LightKind::Point,
                color: Vec3::ONE,
                intensity: 1.0,
                range: f32::INFINITY,
            },
        };
        let ball = |to: DVec3| {
            let center = DVec3::new(1.0, 2.0, 3.0) + to;
            Bounds { min: center - 0.3, max: center + 0.3 }
        };
        let looks = |casters: &[Bounds]| {
            let scene = casters.iter().fold(Bounds::EMPTY, |all, caster| all.union(*caster));
            let lamps = Lamps::new(&placed, casters, &scene, 64);
            for (caster, side) in casters.iter().zip(&lamps.side_of) {
                let lamp = &lamps.sides[*side];
                let corner = caster.max - 0.01;
                assert!(lamp.receivers.sees(&Bounds { min: corner, max: corner }), "{caster:?} by {lamp:?}");
                assert!(lamp.caster_viewpoint(caster, 64).is_ok());
            }
            lamps.sides.len()
        };
        assert_eq!(looks(&[ball(DVec3::NEG_Y * 2.0), ball(DVec3::new(0.5, -2.0, 0.5))]), 1);
        let around = FACES.map(|axis| ball(2.0 * placed.world_from_light.transform_vector3(axis)));
        assert_eq!(looks(&around), 6);
        assert_eq!(looks(&around[..2]), 2);
        let turned: Vec<Bounds> =
            (1..9).map(|i| ball(1.5 * DVec3::from_array([1.0, 2.0, 4.0].map(|k| (k * f64::from(i)).sin())))).collect();
        assert!(looks(&turned) > 1);
        assert_eq!(looks(&[]), 1);
    }

    #[test]
    fn a_spot_sees_no_more_of_a_caster_than_it_lights() {
        let placed = PlacedLight {
            world_from_light: murano_scene::look_along(DVec3::Y * 5.0, DVec3::NEG_Y),
            light: murano_scene::Light {
                name: String::new(),
                kind: LightKind::Spot { inner: 0.1, outer: 0.1 },
                color: Vec3::ONE,
                intensity: 1.0,
                range: f32::INFINITY,
            },
        };
        let seen = |center: DVec3| {
            let caster = Bounds { min: center - 1.0, max: center + 1.0 };
            Lamp::new(&placed, &caster, &caster, 64).caster_viewpoint(&caster, 64)
        };
        let under = seen(DVec3::ZERO).expect("it is lit");
        assert!((under.half_extent - 0.1_f64.tan()).abs().max_element() < 1e-6, "{under:?}");
        let beside = seen(DVec3::X * 1.2).expect("its border is lit");
        assert!(beside.half_extent.x < 0.9 * under.half_extent.x, "{beside:?}");
        assert!(seen(DVec3::X * 4.0).is_err());
    }

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let shader =
            Shader::link(&traced("caustics::emit", &Refraction::default(), false, MapFeatures::default())).unwrap();
        let axis = Vec3::new(3.0, 4.0, 5.0);
        check_uniform_layout!(shader, "Emission", Emission { cos_outer: 1.0, cos_inner: 2.0, axis: axis }).unwrap();
    }
}
