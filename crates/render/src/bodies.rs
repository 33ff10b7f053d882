//! What a world is made of, sorted by how it is drawn: glass bodies one by one, everything opaque as one.

use std::sync::OnceLock;

use glam::{DVec3, Vec3, Vec4};
use murano_animation::{Geometry, GeometryError, GeometryLeaves, Instance, Pose, deform_f64, shown_primitives};
use murano_caustics::Mirror;
use murano_gpu::Leaf;
use murano_refraction::{Glass, TriangleTree};
use murano_scene::{Local, Material, Mesh, Node, NodeIndex, Primitive, Scene, Transform};
use murano_scheduler::Stamp;

use crate::{Floor, materials::MaterialTable};

/// Above this many nodes of glass, or of mirrors, bodies are formed by material rather than by node.
const MOST_BODIES: usize = 16;

/// One glass body: its own maps, its own caustics.
pub(crate) struct Body {
    pub(crate) geometry: Geometry,
    pub(crate) leaves: GeometryLeaves,
    pub(crate) glass: Glass,
    /// What its surface is sampled from, where that is not the same everywhere; `glass` then has the means of its materials'
    /// tints and roughnesses.
    pub(crate) surface: Option<SurfaceSource>,
    /// Whether any part of it is rough.
    pub(crate) rough: bool,
    /// Made when a method asks for it.
    tree: OnceLock<TriangleTree>,
}

/// What the surface of a glass body is sampled from.
pub(crate) struct SurfaceSource {
    /// Whether any of its materials has a texture.
    pub(crate) textured: bool,
    /// Whether any has a map of normals.
    pub(crate) bends: bool,
    /// Constant buffers by the names that `render::glass_surface` binds.
    pub(crate) buffers: Vec<Constant>,
}

/// A constant buffer: the name that shaders bind it by, its stamp, its content.
type Constant = (&'static str, Stamp, Leaf);

impl Body {
    /// Whether light passes as if there were nothing.
    pub(crate) fn is_invisible(&self) -> bool {
        self.surface.is_none() && self.glass.is_invisible()
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
    pub(crate) mirror: Mirror,
}

/// Everything that is shaded.
pub(crate) struct Opaque {
    pub(crate) geometry: Geometry,
    pub(crate) leaves: GeometryLeaves,
    /// Whether any material has a texture.
    pub(crate) textured: bool,
    /// Constant buffers by the names the opaque shader binds.
    pub(crate) buffers: Vec<Constant>,
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

fn material_of(scene: &Scene, node: NodeIndex, primitive: usize) -> Option<usize> {
    let mesh = &scene.meshes[scene.nodes[node].mesh?];
    mesh.primitives.get(primitive)?.material.filter(|&index| index < scene.materials.len())
}

/// What a scene shows, sorted.
pub(crate) struct Sorted {
    pub(crate) bodies: Vec<Body>,
    pub(crate) mirrors: Vec<MirrorBody>,
    pub(crate) opaque: Opaque,
}

/// Splits what a scene shows into glass bodies and the rest, and tells what of that is polished metal.
pub(crate) fn sort(scene: &Scene, floor: Option<(usize, &Floor)>) -> Result<Sorted, GeometryError> {
    let glass_of = |node, primitive| {
        let material = &scene.materials[material_of(scene, node, primitive)?];
        material.is_glass().then(|| Glass::of(material))
    };
    let (glass, opaque): (Vec<_>, Vec<_>) =
        shown_primitives(scene).into_iter().partition(|&(node, primitive)| glass_of(node, primitive).is_some());
    // Primitives of one node that refract alike are one body: a closed surface may be cut into several materials.
    let groups = grouped(&glass, |node, primitive, by_node| {
        let optics = glass_of(node, primitive)?;
        Some(if by_node { Glass { tint: [1.0; 3], roughness: 0.0, ..optics } } else { optics })
    });
    let polished = grouped(&opaque, |node, primitive, _| {
        let painted = scene.meshes[scene.nodes[node].mesh?].primitives.get(primitive)?.colors.is_some();
        Mirror::of(&scene.materials[material_of(scene, node, primitive)?]).filter(|_| !painted)
    });
    let mirrors = polished
        .into_iter()
        .map(|(mirror, members)| {
            let geometry = Geometry::build(scene, &members)?;
            Ok(MirrorBody { leaves: GeometryLeaves::new(&geometry), geometry, mirror })
        })
        .collect::<Result<Vec<_>, GeometryError>>()?;
    let mut table = MaterialTable::new(scene);
    if let Some((material, floor)) = floor {
        table.rows[material].fade_radius = floor.half_extent as f32;
    }
    let shared = material_buffers(&table);
    let bodies = groups
        .into_iter()
        .map(|(glass, members)| {
            let geometry = Geometry::build(scene, &members)?;
            let used: Vec<&Material> = members
                .iter()
                .filter_map(|&(node, primitive)| Some(&scene.materials[material_of(scene, node, primitive)?]))
                .collect();
            let surface = surface_of(&geometry, &used, &table, &shared);
            // A map of normals that is seen from afar is roughness too.
            let rough = used.iter().any(|material| material.roughness > 0.0 || material.normal_texture.is_some());
            let glass = with_means(glass, &used);
            Ok(Body { surface, rough, leaves: GeometryLeaves::new(&geometry), geometry, glass, tree: OnceLock::new() })
        })
        .collect::<Result<Vec<_>, GeometryError>>()?;
    let geometry = Geometry::build(scene, &opaque)?;
    Ok(Sorted { bodies, mirrors, opaque: opaque_of(geometry, &table, shared) })
}

/// A primitive of a node.
type Part = (NodeIndex, usize);

/// Sorts what has a kind by node and kind; by kind alone where there are too many nodes to draw one by one, which it tells `kind_of`.
fn grouped<K: PartialEq>(parts: &[Part], kind_of: impl Fn(NodeIndex, usize, bool) -> Option<K>) -> Vec<(K, Vec<Part>)> {
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
    groups.into_iter().map(|(_, kind, members)| (kind, members)).collect()
}

/// The table of materials and its textures, as shaders read them.
fn material_buffers(table: &MaterialTable) -> [Constant; 3] {
    [
        constant("materials", Leaf::of(&table.rows)),
        constant("texture_slots", Leaf::of(&table.slots)),
        constant("texels", Leaf::of(&table.texels)),
    ]
}

fn constant(name: &'static str, (stamp, leaf): (Stamp, Leaf)) -> Constant {
    (name, stamp, leaf)
}

/// A body's glass with the means of its materials' tints and roughnesses.
fn with_means(glass: Glass, materials: &[&Material]) -> Glass {
    let count = materials.len().max(1) as f32;
    let tint = materials.iter().map(|material| Vec3::from(Glass::of(material).tint)).sum::<Vec3>() / count;
    let roughness = materials.iter().map(|material| material.roughness).sum::<f32>() / count;
    Glass { tint: tint.to_array(), roughness, ..glass }
}

/// What a body's surface is sampled from, unless it is the same everywhere.
fn surface_of(
    geometry: &Geometry,
    materials: &[&Material],
    table: &MaterialTable,
    shared: &[Constant; 3],
) -> Option<SurfaceSource> {
    let textures = |material: &Material| {
        [
            material.base_color_texture,
            material.transmission_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
        ]
    };
    let textured = materials.iter().any(|material| textures(material).iter().any(Option::is_some));
    let coloured = geometry.colors.iter().any(|[r, g, b, _]| [*r, *g, *b] != [1.0; 3]);
    let of = |material: &Material| (Glass::of(material).tint, material.roughness);
    if !textured && !coloured && materials.windows(2).all(|pair| of(pair[0]) == of(pair[1])) {
        return None;
    }
    let triangle_materials: Vec<u32> = geometry
        .triangle_instances
        .iter()
        .map(|&instance| table.row_of(geometry.instances[instance as usize].material) as u32)
        .collect();
    let mut buffers = vec![
        constant("texcoords", Leaf::of(&geometry.texcoords)),
        constant("colors", Leaf::of(&geometry.colors)),
        constant("triangle_materials", Leaf::of(&triangle_materials)),
    ];
    // Textures are bound where they are sampled.
    buffers.extend(shared.iter().take(if textured { 3 } else { 1 }).cloned());
    let bends = materials.iter().any(|material| material.normal_texture.is_some());
    Some(SurfaceSource { textured, bends, buffers })
}

fn opaque_of(geometry: Geometry, table: &MaterialTable, shared: [Constant; 3]) -> Opaque {
    let triangle_materials: Vec<u32> = geometry
        .triangle_instances
        .iter()
        .map(|&instance| {
            let row = table.row_of(geometry.instances[instance as usize].material);
            // Objects beyond 16 bits share numbers: only the silhouette filter between two such would notice.
            (row as u32 & 0xffff) | (instance & 0x7fff) << 16
        })
        .collect();
    let mut buffers = vec![
        constant("texcoords", Leaf::of(&geometry.texcoords)),
        constant("colors", Leaf::of(&geometry.colors)),
        constant("triangle_materials", Leaf::of(&triangle_materials)),
    ];
    buffers.extend(shared);
    Opaque { leaves: GeometryLeaves::new(&geometry), geometry, textured: !table.slots.is_empty(), buffers }
}
