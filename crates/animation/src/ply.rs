//! Stanford PLY files of deformed bodies.

use std::io::{self, Write};

use glam::DVec3;

/// Writes a body as binary little-endian PLY: positions in f64 (so that a body far from the origin keeps its shape),
/// normals in f32, triangles as lists of int32.
///
/// A vertex without a normal gets a zero one. Give the triangles as [`crate::Geometry::oriented_triangles`] has them.
///
/// # Errors
/// Whatever the writer reports.
pub fn write_ply(
    out: &mut impl Write,
    positions: &[DVec3],
    normals: &[DVec3],
    triangles: &[[u32; 3]],
) -> io::Result<()> {
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property double {axis}")?;
    }
    for axis in ["nx", "ny", "nz"] {
        writeln!(out, "property float {axis}")?;
    }
    write!(out, "element face {}\nproperty list uchar int vertex_indices\nend_header\n", triangles.len())?;

    let normals = normals.iter().copied().chain(std::iter::repeat(DVec3::ZERO));
    let mut record = Vec::with_capacity(36);
    for (position, normal) in positions.iter().zip(normals) {
        record.clear();
        record.extend(position.to_array().into_iter().flat_map(f64::to_le_bytes));
        record.extend(normal.as_vec3().to_array().into_iter().flat_map(f32::to_le_bytes));
        out.write_all(&record)?;
    }
    for triangle in triangles {
        record.clear();
        record.push(3);
        record.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
        out.write_all(&record)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_describes_the_body() {
        let mut file = Vec::new();
        write_ply(&mut file, &[DVec3::X, DVec3::Y, DVec3::splat(1e9)], &[DVec3::Z; 3], &[[0, 1, 2]]).unwrap();
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                      property double z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
                      property list uchar int vertex_indices\nend_header\n";
        assert!(file.starts_with(header.as_bytes()));
        let body = &file[header.len()..];
        assert_eq!(body.len(), 3 * 36 + 13);
        assert_eq!(body[2 * 36..2 * 36 + 8], 1e9f64.to_le_bytes());
        assert_eq!(body[3 * 36..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    }
}
