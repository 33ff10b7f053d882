//! What a pose says to the deformation: the palette of matrices and the morph weights.

use glam::{DMat3, DMat4, DVec3};
use murano_scene::Skinning;

use crate::geometry::{Geometry, Instance, PaletteEntry};
use crate::motion::Motion;
use crate::pose::Pose;

/// A row of the palette, `vec4f` in WGSL.
pub type PaletteRow = [f32; 4];

/// Rows of an entry: an affine 3x4 matrix, of which row `i` times `(x, y, z, 1)` is coordinate `i`; or for dual quaternions the real
/// and the dual part (x, y, z, w) of the rigid motion, then the three rows of the stretch before it.
fn rows_of_entry(skinning: Skinning) -> usize {
    match skinning {
        Skinning::Linear => 3,
        Skinning::DualQuaternion => 5,
    }
}

impl PaletteEntry {
    pub(crate) fn world_from_vertex(&self, pose: &Pose) -> DMat4 {
        pose.world_from_node[self.node] * self.node_from_vertex
    }
}

impl Geometry {
    /// Number of matrices in the palette.
    pub fn palette_len(&self) -> usize {
        self.palette_entries.len()
    }

    /// Rows of the palette.
    pub fn palette_rows(&self) -> usize {
        rows_of_entry(self.skinning) * self.palette_entries.len()
    }

    /// `render_from_vertex` of each palette entry, three rows each, or five for dual quaternions. Render space is world space minus
    /// `origin` (world, metres), and vertices are as stored in [`Geometry::vertices`]. Composed in f64 and rounded once, so that an
    /// `origin` near the body keeps its precision wherever in the world it stands. The own transform of a skinned mesh's node has no
    /// effect (glTF 2.0, 3.7.3.3).
    pub fn palette(&self, pose: &Pose, origin: DVec3) -> Vec<PaletteRow> {
        let mut palette = vec![PaletteRow::default(); self.palette_rows()];
        self.palette_into(pose, origin, &mut palette);
        palette
    }

    /// As [`Geometry::palette`], into a list of [`Geometry::palette_rows`] rows.
    pub fn palette_into(&self, pose: &Pose, origin: DVec3, palette: &mut [PaletteRow]) {
        for (rows, entry) in palette.chunks_exact_mut(rows_of_entry(self.skinning)).zip(&self.palette_entries) {
            let mut matrix = entry.world_from_vertex(pose);
            matrix.w_axis -= origin.extend(0.0);
            match self.skinning {
                Skinning::Linear => {
                    for (index, row) in rows.iter_mut().enumerate() {
                        *row = matrix.row(index).as_vec4().to_array();
                    }
                }
                Skinning::DualQuaternion => {
                    let Motion { real, dual, stretch } = Motion::of(&matrix);
                    let row = |index: usize| stretch.row(index).extend(0.0).as_vec4().to_array();
                    rows.copy_from_slice(&[
                        real.as_quat().to_array(),
                        dual.as_quat().to_array(),
                        row(0),
                        row(1),
                        row(2),
                    ]);
                }
            }
        }
    }

    /// Whether the pose mirrors each instance, so that its triangles are clockwise seen from outside (glTF 2.0, 3.7.2.1).
    /// A skinned instance is mirrored when most of its joints' matrices are.
    pub fn mirrored(&self, pose: &Pose) -> Vec<bool> {
        let is_mirrored = |instance: &Instance| {
            let entries = &self.palette_entries[instance.palette.start as usize..instance.palette.end as usize];
            let negative = |entry: &&PaletteEntry| DMat3::from_mat4(entry.world_from_vertex(pose)).determinant() < 0.0;
            2 * entries.iter().filter(negative).count() > entries.len()
        };
        self.instances.iter().map(is_mirrored).collect()
    }

    /// Triangles that are counter-clockwise seen from outside in this pose: [`Geometry::triangles`] with two corners
    /// exchanged where the instance is mirrored.
    pub fn oriented_triangles(&self, pose: &Pose) -> Vec<[u32; 3]> {
        let mirrored = self.mirrored(pose);
        let orient = |(&[a, b, c], &instance): (&[u32; 3], &u32)| {
            if mirrored[instance as usize] { [a, c, b] } else { [a, b, c] }
        };
        self.triangles.iter().zip(&self.triangle_instances).map(orient).collect()
    }
}
