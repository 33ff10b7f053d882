//! Unit vectors in two numbers: the sphere folded onto a square by way of an octahedron.
//!
//! Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer 2014, "A Survey of Efficient Representations for Independent Unit
//! Vectors".

use glam::{DVec2, DVec3};

/// Maps a direction of any length but zero to [-1, 1]^2; zero maps to where +Z does.
pub fn octahedral_encode(direction: DVec3) -> DVec2 {
    let sum = direction.abs().element_sum();
    if sum == 0.0 {
        return DVec2::ZERO;
    }
    let p = direction / sum;
    if p.z >= 0.0 { p.truncate() } else { octahedral_fold(p.truncate()) }
}

/// The unit direction of a point of [-1, 1]^2.
pub fn octahedral_decode(e: DVec2) -> DVec3 {
    let z = 1.0 - e.abs().element_sum();
    if z >= 0.0 { e.extend(z).normalize() } else { octahedral_fold(e).extend(z).normalize() }
}

/// A direction as two snorm16, x in the low half: within 6.5e-5 radians.
pub fn octahedral_pack(direction: DVec3) -> u32 {
    let e = octahedral_encode(direction);
    let snorm = |x: f64| u32::from((0.5 + 32767.0 * x.clamp(-1.0, 1.0)).floor() as i16 as u16);
    snorm(e.x) | snorm(e.y) << 16
}

/// The unit direction of two snorm16.
pub fn octahedral_unpack(packed: u32) -> DVec3 {
    let number = |half: u32| (f64::from(half as u16 as i16) / 32767.0).max(-1.0);
    octahedral_decode(DVec2::new(number(packed), number(packed >> 16)))
}

/// Swaps the inner square with the corners, where the lower hemisphere lives; its own inverse on those.
fn octahedral_fold(e: DVec2) -> DVec2 {
    let side = |x: f64| if x >= 0.0 { 1.0 } else { -1.0 };
    DVec2::new((1.0 - e.y.abs()) * side(e.x), (1.0 - e.x.abs()) * side(e.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions spread evenly over the sphere (Fibonacci lattice), and the hostile ones.
    fn directions() -> impl Iterator<Item = DVec3> {
        let lattice = (0..200_000).map(|k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 200_000.0;
            let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * cos, radius * sin, z)
        });
        let signs = [-1.0, -0.0, 0.0, 1.0];
        let corners = signs.into_iter().flat_map(move |x| signs.map(move |y| (x, y)));
        let corners = corners.flat_map(move |(x, y)| signs.map(move |z| DVec3::new(x, y, z).normalize_or(DVec3::Z)));
        lattice.chain(corners)
    }

    #[test]
    fn decoding_inverts_encoding() {
        for direction in directions() {
            let e = octahedral_encode(direction);
            assert!(e.abs().max_element() <= 1.0);
            assert!(octahedral_decode(e).abs_diff_eq(direction, 1e-14), "{direction}");
        }
    }

    #[test]
    fn packing_keeps_the_angle() {
        let worst = directions()
            .map(|direction| octahedral_unpack(octahedral_pack(direction)).cross(direction).length())
            .fold(0.0, f64::max);
        assert!(worst < 6.5e-5, "{worst}");
    }

    #[test]
    fn packing_a_packed_direction_changes_nothing() {
        for direction in directions() {
            let packed = octahedral_pack(direction);
            let again = octahedral_pack(octahedral_unpack(packed));
            assert!(octahedral_unpack(again).abs_diff_eq(octahedral_unpack(packed), 1e-14), "{direction}");
        }
    }

    #[test]
    fn every_bit_pattern_is_a_unit_direction_and_zero_is_z() {
        for packed in (0..=u32::MAX).step_by(99_991).chain([0x8000_8000, 0x8001_8001, 0x7fff_7fff, u32::MAX]) {
            assert!((octahedral_unpack(packed).length() - 1.0).abs() < 1e-14);
        }
        assert_eq!(octahedral_unpack(octahedral_pack(DVec3::ZERO)), DVec3::Z);
    }
}
