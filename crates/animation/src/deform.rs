//! The deform pass: a pose's palette and morph weights in, deformed positions and normals out, once per geometry.

use encase::ShaderType;
use glam::DVec3;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, Leaf, ShaderSpec, Work};
use murano_scene::Skinning;
use murano_scheduler::{Output, Plan, Stamp};

use crate::crowd::Block;
use crate::{Geometry, Pose};

/// Added to the instance of a pass about a frame before.
const BEFORE: u32 = 1 << 30;

/// A geometry's constant arrays, hashed once, ready to enter any plan.
pub struct GeometryLeaves {
    vertex_count: usize,
    triangle_count: usize,
    instance_count: usize,
    palette_rows: usize,
    skinning: Skinning,
    framed: bool,
    buffers: Vec<(&'static str, Stamp, Leaf)>,
    triangles: (Stamp, Leaf),
    neighbours: (Stamp, Leaf),
}

/// What the deform pass gives: render space is the world moved so that the frame's origin lies at zero.
#[derive(Clone, Copy, Debug)]
pub struct DeformedGeometry {
    /// `vec4f` a vertex: position in metres; w = 1 plus the number of the vertex's
    /// [shell](crate::Instance::shell), negative where the pose mirrors the mesh and its triangles turn.
    pub positions: Output,
    /// `vec4f` a vertex: unit normal, outwards (zero where the mesh collapses); w = 0.
    pub normals: Output,
    /// `vec4f` a vertex: unit tangent (zero where there is none) and the sign of the bitangent; for a geometry with
    /// [`Geometry::tangents`].
    pub tangents: Option<Output>,
    /// Three `u32` a triangle.
    pub triangles: Output,
    /// Three `u32` a triangle: [`Geometry::neighbours`].
    pub neighbours: Output,
    /// Vertices.
    pub vertex_count: usize,
    /// Triangles.
    pub triangle_count: usize,
}

#[derive(ShaderType)]
struct Params {
    vertex_count: u32,
    palette_rows: u32,
    instance_count: u32,
}

/// Matrices and weights of some characters of the same geometry, ready to enter any plan.
#[derive(Clone)]
pub(crate) struct PoseLeaves {
    pub palette: (Stamp, Leaf),
    pub active_targets: (Stamp, Leaf),
    pub active_ranges: (Stamp, Leaf),
}

impl GeometryLeaves {
    /// Hashes the arrays of a geometry.
    pub fn new(geometry: &Geometry) -> Self {
        let leaf = |name, (stamp, leaf)| (name, stamp, leaf);
        let framed = !geometry.tangents.is_empty();
        let tangents = framed.then(|| {
            [
                leaf("tangents_at_rest", Leaf::of(&geometry.tangents)),
                leaf("tangent_displacements", Leaf::of(&geometry.tangent_displacements)),
            ]
        });
        let mut constant = vec![
            leaf("vertices", Leaf::of(&geometry.vertices)),
            leaf("influence_offsets", Leaf::of(&geometry.influence_offsets)),
            leaf("influences", Leaf::of(&geometry.influences)),
            leaf("morph_words", Leaf::of(&geometry.morph_words)),
            leaf("displacements", Leaf::of(&geometry.displacements)),
        ];
        constant.extend(tangents.into_iter().flatten());
        Self {
            framed,
            vertex_count: geometry.vertices.len(),
            triangle_count: geometry.triangles.len(),
            instance_count: geometry.instances.len(),
            palette_rows: geometry.palette_rows(),
            skinning: geometry.skinning,
            buffers: constant,
            triangles: Leaf::of(&geometry.triangles),
            neighbours: Leaf::of(&geometry.neighbours()),
        }
    }

    /// Adds the pass `deform:instance`.
    ///
    /// # Errors
    /// [`GpuError`] if the shader or the plan is defective.
    pub fn deform(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        instance: u32,
        geometry: &Geometry,
        pose: &Pose,
        origin: DVec3,
    ) -> Result<DeformedGeometry, GpuError> {
        self.deform_about(gpu, plan, [instance; 2], geometry, pose, origin)
    }

    /// As [`GeometryLeaves::deform`] for the pose of a frame before: finds what that frame has left. A pass of its own,
    /// `deform:2^30 + instance`, unless the pose is the same.
    ///
    /// # Errors
    /// [`GpuError`] if the shader or the plan is defective.
    pub fn deform_as_before(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        instance: u32,
        geometry: &Geometry,
        pose: &Pose,
        origin: DVec3,
    ) -> Result<DeformedGeometry, GpuError> {
        self.deform_about(gpu, plan, [BEFORE + instance, instance], geometry, pose, origin)
    }

    fn deform_about(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        instance_and_subject: [u32; 2],
        geometry: &Geometry,
        pose: &Pose,
        origin: DVec3,
    ) -> Result<DeformedGeometry, GpuError> {
        let (mut targets, mut ranges) = (Vec::new(), Vec::new());
        geometry.push_active_targets(pose, &mut targets, &mut ranges);
        let posed = PoseLeaves {
            palette: Leaf::of(&geometry.palette(pose, origin)),
            active_targets: Leaf::of(&targets),
            active_ranges: Leaf::of(&ranges),
        };
        let outputs = self.add_pass(gpu, plan, instance_and_subject, &posed, 1)?;
        let (stamp, leaf) = &self.triangles;
        let (neighbours_stamp, neighbours) = &self.neighbours;
        Ok(DeformedGeometry {
            positions: outputs[0],
            normals: outputs[1],
            tangents: outputs.get(2).copied(),
            triangles: plan.leaf("triangles", *stamp, Work::Leaf(leaf.clone())),
            neighbours: plan.leaf("neighbours", *neighbours_stamp, Work::Leaf(neighbours.clone())),
            vertex_count: self.vertex_count,
            triangle_count: self.triangle_count,
        })
    }

    /// Adds the pass `deform:instance` for all characters of a block of a crowd, in one dispatch. Positions and normals as in
    /// [`DeformedGeometry`], character after character.
    ///
    /// # Errors
    /// [`GpuError`] if the shader or the plan is defective.
    pub fn deform_block(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        instance: u32,
        block: &Block,
    ) -> Result<[Output; 2], GpuError> {
        let outputs = self.add_pass(gpu, plan, [instance; 2], &block.leaves, block.len())?;
        Ok([outputs[0], outputs[1]])
    }

    fn add_pass(
        &self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        [instance, subject]: [u32; 2],
        posed: &PoseLeaves,
        characters: usize,
    ) -> Result<Vec<Output>, GpuError> {
        let dual = self.skinning == Skinning::DualQuaternion;
        let shader = gpu.shader(
            &ShaderSpec::new("animation::deform").feature("dual_quaternion", dual).feature("framed", self.framed),
        )?;
        let params = Params {
            vertex_count: self.vertex_count as u32,
            palette_rows: self.palette_rows as u32,
            instance_count: self.instance_count as u32,
        };
        let mut pass = ComputePass::new("deform", instance).about(subject).value("params", &params);
        let posed = [
            ("palette", &posed.palette),
            ("active_targets", &posed.active_targets),
            ("active_ranges", &posed.active_ranges),
        ];
        for (name, (stamp, leaf)) in posed {
            pass = pass.input(name, plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        }
        for (name, stamp, leaf) in &self.buffers {
            pass = pass.input(name, plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        }
        let Groups::Direct([x, y, _]) = Groups::linear(self.vertex_count, 64) else { unreachable!("known on the CPU") };
        let bytes = 16 * (self.vertex_count * characters) as u64;
        let mut pass = pass.output("positions", bytes).output("normals", bytes);
        if self.framed {
            pass = pass.output("tangents", bytes);
        }
        Ok(pass.dispatch(&shader, "main", Groups::Direct([x, y, characters as u32])).add_to(plan)?)
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, ShaderSpec, check_storage_layout, check_uniform_layout};

    use super::*;
    use crate::{ActiveRange, ActiveTarget, Influence, MorphWord, RestVertex};

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let deform = Shader::link(&ShaderSpec::new("animation::deform")).unwrap();
        check_uniform_layout!(deform, "Params", Params { vertex_count: 1, palette_rows: 2, instance_count: 3 })
            .unwrap();
        check_storage_layout!(deform, "RestVertex", RestVertex { position, instance, normal, corner }).unwrap();
        check_storage_layout!(deform, "Influence", Influence { entry, weight }).unwrap();
        check_storage_layout!(deform, "MorphWord", MorphWord { moved, first }).unwrap();
        check_storage_layout!(deform, "ActiveTarget", ActiveTarget { word, weight }).unwrap();
        check_storage_layout!(deform, "ActiveRange", ActiveRange { vertex, start, end, row }).unwrap();
    }
}
