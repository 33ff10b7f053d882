//! Unit normals and tangents from whatever a file stores.

use glam::{Vec3, Vec4};

/// Makes normals unit; one of zero length becomes the area-weighted mean of its triangles' normals. Returns how many
/// were replaced.
pub(super) fn normalize_normals(normals: &mut [Vec3], positions: &[Vec3], triangles: &[[u32; 3]]) -> usize {
    let mut missing = 0;
    for normal in normals.iter_mut() {
        *normal = unit(*normal);
        missing += usize::from(*normal == Vec3::ZERO);
    }
    if missing > 0 {
        let faces = vertex_normals(positions, triangles);
        for (normal, face) in normals.iter_mut().zip(faces).filter(|(normal, _)| **normal == Vec3::ZERO) {
            *normal = if face == Vec3::ZERO { Vec3::Y } else { face };
        }
    }
    missing
}

/// Makes the tangents' xyz unit and their w a sign; one of zero length becomes some direction in the surface.
pub(super) fn normalize_tangents(tangents: &mut [Vec4], normals: &[Vec3]) {
    for (tangent, normal) in tangents.iter_mut().zip(normals) {
        let direction = unit(tangent.truncate());
        let direction = if direction == Vec3::ZERO { normal.any_orthonormal_vector() } else { direction };
        *tangent = direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
}

/// Unit vector, or zero. In f64, so that no finite f32 over- or underflows.
fn unit(vector: Vec3) -> Vec3 {
    vector.as_dvec3().normalize_or_zero().as_vec3()
}

fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![glam::DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize].as_dvec3());
        let twice_area = (b - a).cross(c - a);
        for &vertex in triangle {
            sums[vertex as usize] += twice_area;
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3()).collect()
}
