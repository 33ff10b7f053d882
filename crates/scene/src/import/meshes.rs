//! Meshes: attributes, indices, morph targets.

use glam::{Vec2, Vec3};

use super::accessors::{Accessors, Integers};
use super::document::{self, Attributes, Document, ElementType, get, label};
use super::error::ImportProblem;
use super::extensions::{DRACO, unsupported};
use super::normals::{normalize_normals, normalize_tangents};
use super::topology::{Topology, triangulate, unweld, unwelded_size};
use super::variants;
use crate::{Mesh, MorphTarget, Primitive};

/// Imports every mesh. Primitives that are not triangles are dropped with a warning.
pub(super) fn import(
    document: &Document,
    accessors: &Accessors,
    warnings: &mut Vec<String>,
) -> Result<Vec<Mesh>, ImportProblem> {
    document
        .meshes
        .iter()
        .enumerate()
        .map(|(index, mesh)| import_mesh(document, accessors, index, mesh, warnings))
        .collect()
}

fn import_mesh(
    document: &Document,
    accessors: &Accessors,
    index: usize,
    source: &document::Mesh,
    warnings: &mut Vec<String>,
) -> Result<Mesh, ImportProblem> {
    let mesh_label = label("meshes", index, source.name.as_deref());
    let mut mesh = Mesh { name: source.name.clone().unwrap_or_default(), primitives: Vec::new() };
    for (index, primitive) in source.primitives.iter().enumerate() {
        let at = format!("{mesh_label}.primitives[{index}]");
        let reader = PrimitiveReader { document, accessors, source: primitive, at: &at };
        match reader.read(warnings)? {
            Ok(primitive) => mesh.primitives.push(primitive),
            Err(reason) => warnings.push(format!("{at} dropped: {reason}")),
        }
    }
    equalize_targets(&mut mesh, accessors, &mesh_label, warnings)?;
    Ok(mesh)
}

/// A mesh has one list of morph weights, so every primitive gets the longest list of targets.
fn equalize_targets(
    mesh: &mut Mesh,
    accessors: &Accessors,
    mesh_label: &str,
    warnings: &mut Vec<String>,
) -> Result<(), ImportProblem> {
    let most = mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0);
    if mesh.primitives.iter().any(|primitive| primitive.targets.len() < most) {
        let size = mesh.primitives.len() as u64 * (most * size_of::<MorphTarget>()) as u64;
        accessors.reserve(size, || mesh_label.to_owned())?;
        warnings
            .push(format!("{mesh_label}: its primitives have different numbers of morph targets; empty ones added"));
        for primitive in &mut mesh.primitives {
            primitive.targets.resize_with(most, MorphTarget::default);
        }
    }
    Ok(())
}

struct PrimitiveReader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    source: &'a document::Primitive,
    at: &'a str,
}

impl PrimitiveReader<'_> {
    /// The primitive, or why it is none that can be shown.
    fn read(&self, warnings: &mut Vec<String>) -> Result<Result<Primitive, &'static str>, ImportProblem> {
        let topology = match self.source.mode {
            4 => Topology::List,
            5 => Topology::Strip,
            6 => Topology::Fan,
            0 => return Ok(Err("points are not rendered")),
            1..=3 => return Ok(Err("lines are not rendered")),
            mode => {
                let problem = format!("unknown mode {mode}");
                return Err(ImportProblem::Schema { at: self.at.to_owned(), problem });
            }
        };
        let Some(&position_accessor) = self.source.attributes.get("POSITION") else {
            return Ok(Err("it has no POSITION"));
        };
        self.refuse_draco(position_accessor)?;
        if let Some(material) = self.source.material {
            get(&self.document.materials, material, "materials", self.at)?;
        }

        let positions = self.vectors(position_accessor, "POSITION")?;
        let triangles = self.triangles(topology, positions.len(), warnings)?;
        if triangles.is_empty() {
            return Ok(Err("it has no triangle"));
        }
        let (joints, weights) = self.influences(positions.len(), warnings)?;
        let mut primitive = Primitive {
            normals: self.attribute("NORMAL", positions.len(), |accessor, user| {
                self.accessors.floats(accessor, Integers::AsFlagged, user)
            })?,
            tangents: self.attribute("TANGENT", positions.len(), |accessor, user| {
                self.accessors.floats(accessor, Integers::AsFlagged, user)
            })?,
            texcoords: self.texcoords(positions.len())?,
            colors: self.attribute("COLOR_0", positions.len(), |accessor, user| self.colors(accessor, user))?,
            joints,
            weights,
            targets: self.targets(positions.len())?,
            material: self.source.material,
            variant_materials: variants::materials(self.document, self.accessors, self.source, self.at, warnings)?,
            positions,
            triangles,
        };
        if let Some(normals) = &mut primitive.normals {
            let replaced = normalize_normals(normals, &primitive.positions, &primitive.triangles);
            if replaced > 0 {
                warnings
                    .push(format!("{}: {replaced} normals of zero length replaced by those of the triangles", self.at));
            }
            if let Some(tangents) = &mut primitive.tangents {
                normalize_tangents(tangents, normals);
            }
        } else {
            self.accessors.reserve(unwelded_size(&primitive), || self.at.to_owned())?;
            unweld(&mut primitive);
        }
        Ok(Ok(primitive))
    }

    /// A Draco primitive is fine as long as its accessors also hold the uncompressed data.
    fn refuse_draco(&self, position_accessor: usize) -> Result<(), ImportProblem> {
        let accessor = get(&self.document.accessors, position_accessor, "accessors", self.at)?;
        if self.source.extensions.contains_key(DRACO) && accessor.buffer_view.is_none() {
            return Err(unsupported(DRACO));
        }
        Ok(())
    }

    fn vectors(&self, accessor: usize, name: &str) -> Result<Vec<Vec3>, ImportProblem> {
        let values = self.accessors.floats(accessor, Integers::AsFlagged, &self.user(name))?;
        Ok(values.into_iter().map(Vec3::from_array).collect())
    }

    fn user(&self, name: &str) -> String {
        format!("{} {name}", self.at)
    }

    /// One attribute if present, with as many elements as there are vertices.
    fn attribute<const N: usize, T: From<[f32; N]>>(
        &self,
        name: &str,
        vertices: usize,
        read: impl Fn(usize, &str) -> Result<Vec<[f32; N]>, ImportProblem>,
    ) -> Result<Option<Vec<T>>, ImportProblem> {
        let Some(&accessor) = self.source.attributes.get(name) else { return Ok(None) };
        let user = self.user(name);
        self.expect_count(accessor, vertices, &user)?;
        Ok(Some(read(accessor, &user)?.into_iter().map(T::from).collect()))
    }

    fn expect_count(&self, accessor: usize, vertices: usize, user: &str) -> Result<(), ImportProblem> {
        let count = self.accessors.count(accessor, user)?;
        if count == vertices as u64 {
            return Ok(());
        }
        Err(ImportProblem::Accessor {
            at: format!("accessors[{accessor}] ({user})"),
            problem: format!("it has {count} elements, POSITION has {vertices}"),
        })
    }

    fn texcoords(&self, vertices: usize) -> Result<Vec<Vec<Vec2>>, ImportProblem> {
        let mut sets = Vec::new();
        while let Some(set) = self.attribute(&format!("TEXCOORD_{}", sets.len()), vertices, |accessor, user| {
            self.accessors.floats(accessor, Integers::AsFlagged, user)
        })? {
            sets.push(set);
        }
        Ok(sets)
    }

    fn colors(&self, accessor: usize, user: &str) -> Result<Vec<[f32; 4]>, ImportProblem> {
        if self.accessors.element_type(accessor, user)? == ElementType::Vec3 {
            let opaque = self.accessors.floats(accessor, Integers::Fractions, user)?;
            return Ok(opaque.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect());
        }
        self.accessors.floats(accessor, Integers::Fractions, user)
    }

    /// All sets of joints and weights. Where a weight is zero, the joint, which may be anything, becomes 0.
    #[expect(clippy::type_complexity, reason = "the two lists of a Primitive")]
    fn influences(
        &self,
        vertices: usize,
        warnings: &mut Vec<String>,
    ) -> Result<(Vec<Vec<[u16; 4]>>, Vec<Vec<[f32; 4]>>), ImportProblem> {
        let (mut all_joints, mut all_weights) = (Vec::new(), Vec::new());
        loop {
            let set = all_joints.len();
            let name = format!("JOINTS_{set}");
            let weights = self.attribute(&format!("WEIGHTS_{set}"), vertices, |accessor, user| {
                self.accessors.floats(accessor, Integers::Fractions, user)
            })?;
            let (Some(weights), Some(&accessor)) = (&weights, self.source.attributes.get(&name)) else {
                if weights.is_some() || self.source.attributes.contains_key(&name) {
                    warnings
                        .push(format!("{}: JOINTS_{set} and WEIGHTS_{set} do not come as a pair; ignored", self.at));
                }
                return Ok((all_joints, all_weights));
            };
            let user = self.user(&name);
            self.expect_count(accessor, vertices, &user)?;
            let joints = self.accessors.unsigned(accessor, &user)?;
            all_joints.push(used_joints(&joints, weights, &user)?);
            all_weights.push(weights.clone());
        }
    }

    fn triangles(
        &self,
        topology: Topology,
        vertices: usize,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<[u32; 3]>, ImportProblem> {
        let sequence: Vec<u32> = match self.source.indices {
            Some(accessor) => {
                let user = self.user("indices");
                let indices = self.accessors.unsigned::<1>(accessor, &user)?;
                if let Some([index]) = indices.iter().find(|[index]| *index as usize >= vertices) {
                    return Err(ImportProblem::BadIndex {
                        at: format!("accessors[{accessor}] ({user})"),
                        list: "vertices".to_owned(),
                        index: u64::from(*index),
                        count: vertices,
                    });
                }
                indices.into_iter().flatten().collect()
            }
            None => (0..vertices as u32).collect(),
        };
        if topology == Topology::List && !sequence.len().is_multiple_of(3) {
            warnings.push(format!("{}: {} indices are not a multiple of 3; the rest ignored", self.at, sequence.len()));
        }
        Ok(triangulate(topology, &sequence))
    }

    fn targets(&self, vertices: usize) -> Result<Vec<MorphTarget>, ImportProblem> {
        self.source.targets.iter().enumerate().map(|(index, target)| self.target(index, target, vertices)).collect()
    }

    fn target(&self, index: usize, target: &Attributes, vertices: usize) -> Result<MorphTarget, ImportProblem> {
        let displacement = |name: &str| -> Result<Option<Vec<Vec3>>, ImportProblem> {
            let Some(&accessor) = target.get(name) else { return Ok(None) };
            let name = format!("targets[{index}] {name}");
            self.expect_count(accessor, vertices, &self.user(&name))?;
            self.vectors(accessor, &name).map(Some)
        };
        Ok(MorphTarget {
            positions: displacement("POSITION")?,
            normals: displacement("NORMAL")?,
            tangents: displacement("TANGENT")?,
        })
    }
}

fn used_joints(joints: &[[u32; 4]], weights: &[[f32; 4]], user: &str) -> Result<Vec<[u16; 4]>, ImportProblem> {
    let mut used = vec![[0; 4]; joints.len()];
    for ((used, joints), weights) in used.iter_mut().zip(joints).zip(weights) {
        for slot in (0..4).filter(|&slot| weights[slot] != 0.0) {
            used[slot] = u16::try_from(joints[slot]).map_err(|_| ImportProblem::BadIndex {
                at: user.to_owned(),
                list: "joints".to_owned(),
                index: u64::from(joints[slot]),
                count: usize::from(u16::MAX) + 1,
            })?;
        }
    }
    Ok(used)
}
