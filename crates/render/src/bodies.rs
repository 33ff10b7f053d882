//! What a world is made of, sorted by how it is drawn: glass bodies one by one, everything opaque as one.

use std::{collections::BTreeSet, sync::OnceLock};

use glam::{DVec3, Vec3, Vec4};
use murano_animation::{Geometry, GeometryError, GeometryLeaves, Instance, Pose, deform_f64, shown_primitives};
use murano_caustics::Mirror;
use murano_gpu::Leaf;
use murano_refraction::{Glass, TriangleTree};
use murano_scene::{
    Local, Material, MaterialProperty, Mesh, Node, NodeIndex, Primitive, Property, PropertyChannel, Scene, Transform,
};

use crate::{
    Floor,
    compound::Compounds,
    looks::{Constant, constant},
};

/// Above this many nodes of glass, or of mirrors, bodies are formed by material rather than by node.
const MOST_BODIES: usize = 16;

/// One glass body: its own maps, its own caustics.
pub(crate) struct Body {
    pub(crate) geometry: Geometry,
    pub(crate) leaves: GeometryLeaves,
    /// What it is put together from.
    pub(crate) parts: Vec<Part>,
    /// Row in the table of materials of each triangle.
    pub(crate) triangle_materials: Vec<u32>,
    /// Whether it is made of facets.
    pub(crate) faceted: bool,
    /// Made when its surface is not the same everywhere.
    surface_buffers: OnceLock<[Constant; 3]>,
    /// Made when a method asks for it.
    tree: OnceLock<TriangleTree>,
    volume: OnceLock<f64>,
}

impl Body {
    /// Several surfaces as one body's.
    pub(crate) fn of_shells(scene: &Scene, shells: &[&[Part]]) -> Result<Self, GeometryError> {
        let geometry = Geometry::of_shells(scene, shells)?;
        let row = |&instance: &u32| row_of(scene, geometry.instances[instance as usize].material) as u32;
        let triangle_materials = geometry.triangle_instances.iter().map(row).collect();
        Ok(Self {
            leaves: GeometryLeaves::new(&geometry),
            faceted: is_faceted(&geometry),
            geometry,
            parts: shells.concat(),
            triangle_materials,
            surface_buffers: OnceLock::new(),
            tree: OnceLock::new(),
            volume: OnceLock::new(),
        })
    }

    /// How much it encloses in its rest pose, cubic metres.
    pub(crate) fn volume(&self, scene: &Scene) -> f64 {
        *self.volume.get_or_init(|| {
            let pose = Pose::rest(scene);
            let positions = deform_f64(&self.geometry, scene, &pose).positions;
            let triangles = self.geometry.oriented_triangles(&pose);
            let middle = self.geometry.posed_bounds(&pose).center();
            let sixth = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|vertex| positions[vertex as usize] - middle);
                a.dot(b.cross(c)) / 6.0
            };
            triangles.iter().map(sixth).sum::<f64>().abs()
        })
    }

    /// Texture coordinates, vertex colours and materials of its triangles.
    pub(crate) fn surface_buffers(&self) -> &[Constant; 3] {
        self.surface_buffers.get_or_init(|| {
            [
                constant("texcoords", Leaf::of(&self.geometry.texcoords)),
                constant("colors", Leaf::of(&self.geometry.colors)),
                constant("triangle_materials", Leaf::of(&self.triangle_materials)),
            ]
        })
    }

    /// How much larger a body that no joint and no morph target deforms is than in its rest pose; `None` for others.
    pub(crate) fn rigid_scale(&self, scene: &Scene, pose: &Pose) -> Option<f64> {
        let first = self.geometry.instances.first()?;
        let follows_node = |instance: &Instance| scene.nodes[instance.node].skin.is_none() && instance.targets == 0;
        let rigid =
            self.geometry.instances.iter().all(|instance| instance.node == first.node && follows_node(instance));
        let volume = |pose: &Pose| pose.world_from_node[first.node].determinant().abs();
        let ratio = volume(pose) / volume(&Pose::rest(scene));
        (rigid && ratio.is_finite()).then(|| ratio.cbrt())
    }

    /// The hierarchy of its triangles, from the rest pose: what was rendered before must not show.
    pub(crate) fn tree(&self, scene: &Scene) -> &TriangleTree {
        self.tree.get_or_init(|| {
            let rest = deform_f64(&self.geometry, scene, &Pose::rest(scene));
            TriangleTree::build(&rest.positions, &self.geometry.triangles)
        })
    }
}

/// A polished metal body: its shading is part of [`Opaque`]'s, its caustics are its own.
pub(crate) struct MirrorBody {
    pub(crate) geometry: Geometry,
    pub(crate) leaves: GeometryLeaves,
    /// One of its parts; all are of the same metal.
    pub(crate) part: Part,
    /// Whether it is made of facets.
    pub(crate) faceted: bool,
}

/// Everything that is shaded.
pub(crate) struct Opaque {
    pub(crate) geometry: Geometry,
    pub(crate) leaves: GeometryLeaves,
    /// Constant buffers by the names the opaque shader binds, but for the materials.
    pub(crate) buffers: [Constant; 3],
    /// Whether it may hide some of itself from a lamp: not where it is one plane.
    pub(crate) may_hide: bool,
}

/// Appends a floor to a scene as a node of its own and returns its material.
pub(crate) fn add_floor(scene: &mut Scene, floor: &Floor) -> usize {
    let half = floor.half_extent as f32;
    let corners = [[-half, -half], [-half, half], [half, half], [half, -half]];
    let material = scene.materials.len();
    scene.materials.push(Material {
        name: "floor".into(),
        base_color: Vec4::new(floor.albedo[0], floor.albedo[1], floor.albedo[2], 1.0),
        metallic: 0.0,
        roughness: 0.9,
        ..Material::default()
    });
    let mesh = scene.meshes.len();
    scene.meshes.push(Mesh {
        name: "floor".into(),
        primitives: vec![Primitive {
            positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec(),
            normals: Some(vec![Vec3::Y; 4]),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(material),
            ..Primitive::default()
        }],
    });
    scene.roots.push(scene.nodes.len());
    scene.nodes.push(Node {
        name: "floor".into(),
        parent: None,
        children: Vec::new(),
        local: Local::Trs(Transform {
            translation: DVec3::new(floor.center[0], floor.height, floor.center[1]),
            ..Transform::IDENTITY
        }),
        mesh: Some(mesh),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    });
    material
}

/// Index of a part's material.
pub(crate) fn material_of(scene: &Scene, node: NodeIndex, primitive: usize) -> Option<usize> {
    let mesh = &scene.meshes[scene.nodes[node].mesh?];
    mesh.primitives.get(primitive)?.material.filter(|&index| index < scene.materials.len())
}

/// What a scene shows, sorted.
pub(crate) struct Sorted {
    pub(crate) bodies: Vec<Body>,
    pub(crate) mirrors: Vec<MirrorBody>,
    pub(crate) opaque: Opaque,
    /// Bodies that are one for a while.
    pub(crate) compounds: Compounds,
}

/// Row in the table of materials; what has none has the one behind them.
fn row_of(scene: &Scene, material: Option<usize>) -> usize {
    material.unwrap_or(scene.materials.len())
}

/// Splits what a scene shows of these materials, which may not be its own, into glass bodies and the rest, and tells what of that is
/// polished metal.
pub(crate) fn sort(scene: &Scene, materials: &[Material]) -> Result<Sorted, GeometryError> {
    let driven = Driven::of(scene);
    let glass_of = |node, primitive| {
        let index = material_of(scene, node, primitive)?;
        let material = &materials[index];
        material.is_glass().then(|| (Glass::of(material), index))
    };
    let (glass, opaque): (Vec<_>, Vec<_>) =
        shown_primitives(scene).into_iter().partition(|&(node, primitive)| glass_of(node, primitive).is_some());
    // Primitives of one node that refract alike are one body: a closed surface may be cut into several materials.
    let groups = grouped(&glass, |node, primitive, by_node| {
        let (optics, index) = glass_of(node, primitive)?;
        let (optics, driven) = if by_node {
            (Glass { tint: [1.0; 3], roughness: 0.0, ..optics }, &driven.optics)
        } else {
            (optics, &driven.materials)
        };
        // What a clip drives may part from what is like it now; how bodies are sorted must not depend on the moment.
        Some((optics, driven.contains(&index).then_some(index)))
    });
    let polished = grouped(&opaque, |node, primitive, _| {
        let painted = scene.meshes[scene.nodes[node].mesh?].primitives.get(primitive)?.colors.is_some();
        let index = material_of(scene, node, primitive)?;
        let mirror = Mirror::of(&materials[index]).filter(|_| !painted)?;
        Some((mirror, driven.materials.contains(&index).then_some(index)))
    });
    let mirrors = polished
        .into_iter()
        .map(|members| {
            let geometry = Geometry::build(scene, &members)?;
            let faceted = is_faceted(&geometry);
            Ok(MirrorBody { leaves: GeometryLeaves::new(&geometry), geometry, part: members[0], faceted })
        })
        .collect::<Result<Vec<_>, GeometryError>>()?;
    let bodies =
        groups.iter().map(|parts| Body::of_shells(scene, &[parts])).collect::<Result<Vec<_>, GeometryError>>()?;
    let geometry = Geometry::build(scene, &opaque)?;
    let object = |&instance: &u32| {
        let row = row_of(scene, geometry.instances[instance as usize].material);
        // Objects beyond 16 bits share numbers: only the silhouette filter between two such would notice.
        (row as u32 & 0xffff) | (instance & 0x7fff) << 16
    };
    let objects: Vec<u32> = geometry.triangle_instances.iter().map(object).collect();
    let buffers = [
        constant("texcoords", Leaf::of(&geometry.texcoords)),
        constant("colors", Leaf::of(&geometry.colors)),
        constant("triangle_materials", Leaf::of(&objects)),
    ];
    let may_hide = !is_plane(scene, &geometry);
    let opaque = Opaque { leaves: GeometryLeaves::new(&geometry), geometry, buffers, may_hide };
    Ok(Sorted { bodies, mirrors, opaque, compounds: Compounds::default() })
}

/// Whether most triangles have one normal: none of their own, or three that are alike.
fn is_faceted(geometry: &Geometry) -> bool {
    let normal = |vertex: u32| Vec3::from(geometry.vertices[vertex as usize].normal);
    let is_facet = |&&[a, b, c]: &&[u32; 3]| {
        let [a, b, c] = [a, b, c].map(normal);
        a.distance_squared(b).max(a.distance_squared(c)) < 1e-6
    };
    2 * geometry.triangles.iter().filter(is_facet).count() > geometry.triangles.len()
}

/// Whether it is nothing, or one plane that nothing bends.
fn is_plane(scene: &Scene, geometry: &Geometry) -> bool {
    let [only] = &geometry.instances[..] else { return geometry.instances.is_empty() };
    if only.targets > 0 || scene.nodes[only.node].skin.is_some() {
        return false;
    }
    let place = |vertex: u32| Vec3::from(geometry.vertices[vertex as usize].position).as_dvec3();
    let size = geometry.vertices.iter().map(|vertex| Vec3::from(vertex.position).length()).fold(0.0, f32::max);
    let normals = geometry.triangles.iter().map(|&[a, b, c]| (place(b) - place(a)).cross(place(c) - place(a)));
    let Some(normal) = normals.max_by(|a, b| a.length().total_cmp(&b.length())) else { return true };
    let normal = normal.normalize_or_zero();
    let off = |vertex: u32| (place(vertex) - place(geometry.triangles[0][0])).dot(normal).abs();
    geometry.triangles.iter().flatten().all(|&vertex| off(vertex) <= 1e-6 * f64::from(size))
}

/// Materials that the clips of a scene drive.
#[derive(Default)]
struct Driven {
    /// Any property.
    materials: BTreeSet<usize>,
    /// One by which bodies of a node are told apart.
    optics: BTreeSet<usize>,
}

impl Driven {
    fn of(scene: &Scene) -> Self {
        use MaterialProperty as M;
        let mut driven = Self::default();
        for PropertyChannel { property, .. } in scene.clips.iter().flat_map(|clip| &clip.properties) {
            let Property::Material(index, property) = *property else { continue };
            driven.materials.insert(index);
            if matches!(property, M::Ior | M::Thickness | M::AttenuationDistance | M::AttenuationColor | M::Dispersion)
            {
                driven.optics.insert(index);
            }
        }
        driven
    }
}

/// How a material is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Glass,
    Mirror,
    Opaque,
}

impl Kind {
    /// Of a material.
    pub(crate) fn of(material: &Material) -> Self {
        match Mirror::of(material) {
            _ if material.is_glass() => Self::Glass,
            Some(_) => Self::Mirror,
            None => Self::Opaque,
        }
    }
}

/// A primitive of a node.
pub(crate) type Part = (NodeIndex, usize);

/// Sorts what has a kind by node and kind; by kind alone where there are too many nodes to draw one by one, which it tells `kind_of`.
fn grouped<K: PartialEq>(parts: &[Part], kind_of: impl Fn(NodeIndex, usize, bool) -> Option<K>) -> Vec<Vec<Part>> {
    let has_kind = |&&(node, primitive): &&Part| kind_of(node, primitive, true).is_some();
    let mut nodes: Vec<NodeIndex> = parts.iter().filter(has_kind).map(|&(node, _)| node).collect();
    nodes.dedup();
    let by_node = nodes.len() <= MOST_BODIES;
    let mut groups: Vec<(Option<NodeIndex>, K, Vec<Part>)> = Vec::new();
    for &(node, primitive) in parts {
        let Some(kind) = kind_of(node, primitive, by_node) else { continue };
        let own = by_node.then_some(node);
        match groups.iter_mut().find(|(other, like, _)| *other == own && *like == kind) {
            Some((.., members)) => members.push((node, primitive)),
            None => groups.push((own, kind, vec![(node, primitive)])),
        }
    }
    groups.into_iter().map(|(.., members)| members).collect()
}
