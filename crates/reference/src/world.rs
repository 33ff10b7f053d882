//! What is traced.

use glam::DVec3;
use murano_animation::{Geometry, GeometryError, Pose, deform_f64, shown_primitives};
use murano_optics::absorption_coefficient;
use murano_scene::{Material, NodeIndex, Scene};

use crate::{Departure, Facing, GlassSurface, Hit, InvalidMesh, Ray, Shape, SurfaceData, TriangleMesh, Within};

/// A body of clear or coloured glass.
pub struct GlassBody {
    /// Its surface.
    pub shape: Shape,
    /// Index of refraction relative to air, positive.
    pub ior: f64,
    /// Absorption per metre, linear RGB.
    pub absorption: DVec3,
    /// Factor on what is transmitted, linear RGB, in the mean over the body.
    pub tint: DVec3,
    /// Perceptual roughness of its surface, GGX, in the mean over the body; only the path tracer looks at it.
    pub roughness: f64,
    /// Whether its surface is a sheet of glass around nothing.
    pub thin: bool,
    /// Where tint, roughness and normals are not the same everywhere.
    pub surface: Option<GlassSurface>,
}

impl GlassBody {
    /// Clear glass.
    pub fn clear(shape: Shape, ior: f64) -> Self {
        Self { shape, ior, absorption: DVec3::ZERO, tint: DVec3::ONE, roughness: 0.0, thin: false, surface: None }
    }

    /// The nearest place where the ray meets the surface from the wanted side within `farthest` metres, its normal bent by a map of normals
    /// if there is one.
    pub fn nearest(&self, ray: &Ray, from: Departure, facing: Option<Facing>, farthest: f64) -> Option<Hit> {
        let hit = self.shape.nearest(ray, from, facing, farthest)?;
        match (&self.surface, &self.shape) {
            (Some(surface), Shape::Mesh(mesh)) => {
                Some(surface.bend(hit, ray.direction, mesh.triangle(hit.element as usize)))
            }
            _ => Some(hit),
        }
    }

    /// Linear RGB factor on what enters at a hit.
    pub fn tint_at(&self, hit: &Hit) -> DVec3 {
        self.surface.as_ref().map_or(self.tint, |surface| surface.tint(hit))
    }

    /// Perceptual roughness at a hit.
    pub fn roughness_at(&self, hit: &Hit) -> f64 {
        self.surface.as_ref().map_or(self.roughness, |surface| surface.roughness(hit))
    }
}

/// Everything that is shaded, as one mesh.
pub struct Opaque {
    /// Triangles.
    pub mesh: TriangleMesh,
    /// What it is sampled from; materials and images are the scene's.
    pub data: SurfaceData,
}

/// A ray met a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// An index into [`World::bodies`].
    pub body: usize,
    /// Where.
    pub hit: Hit,
}

/// Glass bodies and opaque things.
#[derive(Default)]
pub struct World {
    /// Glass.
    pub bodies: Vec<GlassBody>,
    /// Opaque things; `None` when there are none.
    pub opaque: Option<Opaque>,
}

/// Why a scene cannot be traced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// Too many vertices.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A deformed mesh that cannot be traced.
    #[error("in this pose {0}")]
    Mesh(#[from] InvalidMesh),
}

impl World {
    /// A world of one body.
    pub fn of_body(body: GlassBody) -> Self {
        Self { bodies: vec![body], opaque: None }
    }

    /// What a scene shows in a pose, deformed in f64. Primitives of one node that refract and absorb alike are one body; where
    /// their colours or roughnesses differ, or textures change them, the body has a [`GlassSurface`].
    ///
    /// # Errors
    /// [`WorldError`] when the scene is too large or the pose is not finite.
    pub fn of_scene(scene: &Scene, pose: &Pose) -> Result<Self, WorldError> {
        type Part = (NodeIndex, usize);
        let mut groups: Vec<(NodeIndex, &Material, Vec<Part>)> = Vec::new();
        let mut opaque: Vec<Part> = Vec::new();
        for (node, primitive) in shown_primitives(scene) {
            let glass = material_of(scene, node, primitive).filter(|material| material.is_glass());
            let Some(material) = glass else {
                opaque.push((node, primitive));
                continue;
            };
            let same =
                |(other, filed, _): &&mut (NodeIndex, &Material, _)| *other == node && same_glass(filed, material);
            match groups.iter_mut().find(same) {
                Some((_, _, parts)) => parts.push((node, primitive)),
                None => groups.push((node, material, vec![(node, primitive)])),
            }
        }
        let bodies = groups
            .into_iter()
            .map(|(_, material, parts)| {
                let Opaque { mesh, data } = traced(scene, pose, &parts)?;
                let used: Vec<&Material> =
                    parts.iter().filter_map(|&(node, primitive)| material_of(scene, node, primitive)).collect();
                let tints = used.iter().map(|it| it.base_color.truncate().as_dvec3() * f64::from(it.transmission));
                let roughness = used.iter().map(|it| f64::from(it.roughness)).sum::<f64>();
                Ok(GlassBody {
                    shape: Shape::Mesh(mesh),
                    ior: material.ior,
                    absorption: absorption_coefficient(
                        material.attenuation_color.as_dvec3(),
                        f64::from(material.attenuation_distance),
                    ),
                    tint: tints.sum::<DVec3>() / parts.len() as f64,
                    roughness: roughness / parts.len() as f64,
                    thin: material.thickness == 0.0,
                    surface: varies(&data, &used).then(|| GlassSurface {
                        data,
                        materials: scene.materials.clone(),
                        images: scene.images.clone(),
                    }),
                })
            })
            .collect::<Result<_, WorldError>>()?;
        let opaque = if opaque.is_empty() { None } else { Some(traced(scene, pose, &opaque)?) };
        Ok(Self { bodies, opaque })
    }

    /// The first front face of glass that the ray meets, or either of a thin body's, unless something opaque is in front of it.
    pub fn first_glass(&self, ray: &Ray) -> Option<Contact> {
        let mut nearest: Option<Contact> = None;
        for (body, glass) in self.bodies.iter().enumerate() {
            let farthest = nearest.map_or(f64::INFINITY, |contact| contact.hit.t);
            let facing = (!glass.thin).then_some(Facing::Front);
            if let Some(hit) = glass.nearest(ray, Departure::Free, facing, farthest) {
                nearest = nearest.filter(|contact| contact.hit.t <= hit.t).or(Some(Contact { body, hit }));
            }
        }
        nearest.filter(|contact| !self.blocked(ray, contact.hit.t))
    }

    /// The next face of glass, of either side, that a ray meets which leaves `element` of body `from`. Opaque things do not count.
    pub fn next_glass(&self, ray: &Ray, from: usize, element: Departure) -> Option<Contact> {
        let mut nearest: Option<Contact> = None;
        for (body, glass) in self.bodies.iter().enumerate() {
            let departure = if body == from { element } else { Departure::Free };
            let farthest = nearest.map_or(f64::INFINITY, |contact| contact.hit.t);
            if let Some(hit) = glass.nearest(ray, departure, None, farthest) {
                nearest = nearest.filter(|contact| contact.hit.t <= hit.t).or(Some(Contact { body, hit }));
            }
        }
        nearest
    }

    /// The body whose glass light runs in: of those that it is within the one of the least volume, as a thing in water displaces it;
    /// of equal ones the first. `None` is air.
    pub fn medium(&self, within: &Within) -> Option<usize> {
        // Of what rounding alone tells apart, the first.
        let volume = |body: usize| self.bodies[body].shape.volume() as f32;
        let order = |a: &usize, b: &usize| volume(*a).total_cmp(&volume(*b)).then(a.cmp(b));
        within.bodies().min_by(order)
    }

    /// What light runs in before and behind a face that it meets, and the bodies that it is within there; `None` where the face is no
    /// interface, as another body displaces its own on both sides or is of the same glass.
    pub fn interface(&self, [here, beyond]: [Within; 2]) -> Option<[Option<usize>; 2]> {
        let media = [here, beyond].map(|within| self.medium(&within));
        let glass = media.map(|medium| {
            medium.map(|body| {
                let GlassBody { ior, absorption, tint, .. } = self.bodies[body];
                (ior, absorption, tint)
            })
        });
        (glass[0] != glass[1]).then_some(media)
    }

    /// Index of refraction of what light runs in.
    pub fn ior(&self, medium: Option<usize>) -> f64 {
        medium.map_or(1.0, |body| self.bodies[body].ior)
    }

    /// Whether something opaque lies on the ray within `farthest` metres.
    pub fn blocked(&self, ray: &Ray, farthest: f64) -> bool {
        self.opaque.as_ref().is_some_and(|opaque| opaque.mesh.blocks(ray, Departure::Free, farthest))
    }
}

fn material_of(scene: &Scene, node: NodeIndex, primitive: usize) -> Option<&Material> {
    let mesh = &scene.meshes[scene.nodes[node].mesh?];
    scene.materials.get(mesh.primitives.get(primitive)?.material?)
}

fn same_glass(a: &Material, b: &Material) -> bool {
    a.ior == b.ior
        && a.attenuation_color == b.attenuation_color
        && a.attenuation_distance == b.attenuation_distance
        && a.dispersion == b.dispersion
        && (a.thickness == 0.0) == (b.thickness == 0.0)
}

fn traced(scene: &Scene, pose: &Pose, parts: &[(NodeIndex, usize)]) -> Result<Opaque, WorldError> {
    let geometry = Geometry::build(scene, parts)?;
    let deformed = deform_f64(&geometry, scene, pose);
    let triangles = geometry.oriented_triangles(pose);
    let mesh = TriangleMesh::of(&deformed, &triangles)?;
    Ok(Opaque { mesh, data: SurfaceData { geometry, triangles, tangents: deformed.tangents } })
}

/// Whether the surface of a body of these materials is not the same everywhere.
fn varies(data: &SurfaceData, materials: &[&Material]) -> bool {
    let textures = |it: &Material| {
        [it.base_color_texture, it.transmission_texture, it.metallic_roughness_texture, it.normal_texture]
    };
    let of = |it: &Material| (it.base_color.truncate() * it.transmission, it.roughness);
    materials.iter().any(|material| textures(material).iter().any(Option::is_some))
        || data.geometry.colors.iter().any(|[r, g, b, _]| [*r, *g, *b] != [1.0; 3])
        || materials.windows(2).any(|pair| of(pair[0]) != of(pair[1]))
}
