//! The deform pass: a pose's palette and morph weights in, deformed positions and normals out, once per geometry.

use encase::ShaderType;
use glam::DVec3;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, Leaf, ShaderSpec, Work};
use murano_scheduler::{Output, Plan, Stamp};

use crate::{Geometry, Pose};

/// A geometry's constant arrays, hashed once, ready to enter any plan.
pub struct GeometryLeaves {
    vertex_count: usize,
    triangle_count: usize,
    buffers: Vec<(&'static str, Stamp, Leaf)>,
    triangles: (Stamp, Leaf),
    neighbours: (Stamp, Leaf),
}

/// What the deform pass gives: render space is the world moved so that the frame's origin lies at zero.
#[derive(Clone, Copy, Debug)]
pub struct DeformedGeometry {
    /// `vec4f` a vertex: position in metres; w = 1, or -1 where the pose mirrors the mesh and its triangles turn.
    pub positions: Output,
    /// `vec4f` a vertex: unit normal, outwards (zero where the mesh collapses); w = 0.
    pub normals: Output,
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
}

impl GeometryLeaves {
    /// Hashes the arrays of a geometry.
    pub fn new(geometry: &Geometry) -> Self {
        let leaf = |name, (stamp, leaf)| (name, stamp, leaf);
        Self {
            vertex_count: geometry.vertices.len(),
            triangle_count: geometry.triangles.len(),
            buffers: vec![
                leaf("vertices", Leaf::of(&geometry.vertices)),
                leaf("influence_offsets", Leaf::of(&geometry.influence_offsets)),
                leaf("influences", Leaf::of(&geometry.influences)),
                leaf("morph_offsets", Leaf::of(&geometry.morph_offsets)),
                leaf("morphs", Leaf::of(&geometry.morphs)),
            ],
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
        let shader = gpu.shader(&ShaderSpec::new("animation::deform"))?;
        let mut pass =
            ComputePass::new("deform", instance).value("params", &Params { vertex_count: self.vertex_count as u32 });
        let (stamp, leaf) = Leaf::of(&geometry.palette(pose, origin));
        pass = pass.input("palette", plan.leaf("palette", stamp, Work::Leaf(leaf)));
        let (stamp, leaf) = Leaf::of(&geometry.morph_weights(pose));
        pass = pass.input("morph_weights", plan.leaf("morph_weights", stamp, Work::Leaf(leaf)));
        for (name, stamp, leaf) in &self.buffers {
            pass = pass.input(name, plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        }
        let bytes = 16 * self.vertex_count as u64;
        let outputs = pass
            .output("positions", bytes)
            .output("normals", bytes)
            .dispatch(&shader, "main", Groups::linear(self.vertex_count, 64))
            .add_to(plan)?;
        let (stamp, leaf) = &self.triangles;
        let (neighbours_stamp, neighbours) = &self.neighbours;
        Ok(DeformedGeometry {
            positions: outputs[0],
            normals: outputs[1],
            triangles: plan.leaf("triangles", *stamp, Work::Leaf(leaf.clone())),
            neighbours: plan.leaf("neighbours", *neighbours_stamp, Work::Leaf(neighbours.clone())),
            vertex_count: self.vertex_count,
            triangle_count: self.triangle_count,
        })
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, ShaderSpec, check_storage_layout, check_uniform_layout};

    use super::*;
    use crate::{Influence, MorphDelta, RestVertex};

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let deform = Shader::link(&ShaderSpec::new("animation::deform")).unwrap();
        check_uniform_layout!(deform, "Params", Params { vertex_count: 1 }).unwrap();
        check_storage_layout!(deform, "RestVertex", RestVertex { position, instance, normal, corner }).unwrap();
        check_storage_layout!(deform, "Influence", Influence { entry, weight }).unwrap();
        check_storage_layout!(deform, "MorphDelta", MorphDelta { position, weight, normal, padding }).unwrap();
    }
}
