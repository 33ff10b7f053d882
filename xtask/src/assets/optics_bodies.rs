//! The bodies of the optics bench: closed, centred at the origin, with the exact normals of their closed forms.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::surface::Surface;
use super::trig::{cos, sin_cos};

/// Icosahedron edges are split this often in the unit sphere: no point of a triangle is 1e-4 off the true surface.
const SPHERE_FREQUENCY: u32 = 52;

/// Sphere of radius 1.
pub fn sphere() -> Surface {
    radial(SPHERE_FREQUENCY, |d| (d, d))
}

/// Prolate ellipsoid, semi-axis 1 along y. Its eccentricity is 1 / 1.5, so glass of index 1.5 brings rays that arrive
/// along y together in the far focus exactly (Descartes' ellipsoid).
pub fn ellipsoid() -> Surface {
    let minor = (1.0_f64 - 1.0 / (1.5 * 1.5)).sqrt();
    let axes = DVec3::new(minor, 1.0, minor);
    radial(32, |d| (d * axes, (d / axes).normalize()))
}

/// Sphere with bumps: radius 1 + 0.07 sin 5x sin 5y sin 5z, where (x, y, z) is the direction from the centre.
pub fn bumpy() -> Surface {
    const AMPLITUDE: f64 = 0.07;
    const FREQUENCY: f64 = 5.0;
    radial(36, |d| {
        let [(sx, cx), (sy, cy), (sz, cz)] = [d.x, d.y, d.z].map(|x| sin_cos(FREQUENCY * x));
        let radius = 1.0 + AMPLITUDE * sx * sy * sz;
        let slope = AMPLITUDE * FREQUENCY * DVec3::new(cx * sy * sz, sx * cy * sz, sx * sy * cz);
        // Gradient of |p| - radius(p / |p|) at |p| = radius: only the slope across d counts.
        let across = (slope - d * slope.dot(d)) / radius;
        (d * radius, (d - across).normalize())
    })
}

/// Plane-parallel plate of 2 x 0.4 x 2.
pub fn slab() -> Surface {
    let half = DVec3::new(1.0, 0.2, 1.0);
    let mut surface = Surface::default();
    for axis in 0..3 {
        let (u, v) = (DVec3::AXES[(axis + 1) % 3] * half, DVec3::AXES[(axis + 2) % 3] * half);
        let w = DVec3::AXES[axis] * half;
        surface.push_flat(&[w - u - v, w + u - v, w + u + v, w - u + v]);
        surface.push_flat(&[-w - u - v, -w - u + v, -w + u + v, -w + u - v]);
    }
    surface
}

/// Equilateral prism: edges of 1.2 in the xy plane, apex up, 1.6 long along z.
pub fn prism() -> Surface {
    let (edge, half_length) = (1.2, 0.8);
    let height = edge * 3.0_f64.sqrt() / 2.0;
    let corners = [
        DVec2::new(-edge / 2.0, -height / 3.0),
        DVec2::new(edge / 2.0, -height / 3.0),
        DVec2::new(0.0, height * 2.0 / 3.0),
    ];
    let front = corners.map(|c| c.extend(half_length));
    let back = corners.map(|c| c.extend(-half_length));
    let mut surface = Surface::default();
    surface.push_flat(&front);
    surface.push_flat(&[back[2], back[1], back[0]]);
    for i in 0..3 {
        let j = (i + 1) % 3;
        surface.push_flat(&[front[i], back[i], back[j], front[j]]);
    }
    surface
}

/// Thick biconvex lens on the y axis: spherical caps of radius 1.2, aperture radius 0.8, cylindrical rim 0.12 high.
pub fn lens() -> Surface {
    const RADIUS: f64 = 1.2;
    const APERTURE: f64 = 0.8;
    const HALF_RIM: f64 = 0.06;
    const RINGS: u32 = 36;
    const SECTORS: u32 = 144;
    let centre_to_rim = (RADIUS * RADIUS - APERTURE * APERTURE).sqrt();
    let circle: Vec<(f64, f64)> = (0..SECTORS).map(|i| sin_cos(TAU * f64::from(i) / f64::from(SECTORS))).collect();
    let mut surface = Surface::default();
    for side in [1.0, -1.0] {
        let cap = |sine: f64, cosine: f64, r: f64| {
            let above = (RADIUS * RADIUS - r * r).sqrt();
            let normal = DVec3::new(r * cosine, side * above, r * sine) / RADIUS;
            (DVec3::new(r * cosine, side * (HALF_RIM + above - centre_to_rim), r * sine), normal)
        };
        let (position, normal) = cap(0.0, 1.0, 0.0);
        let pole = surface.push(position, normal);
        for ring in 1..=RINGS {
            let r = APERTURE * f64::from(ring) / f64::from(RINGS);
            for &(sine, cosine) in &circle {
                let (position, normal) = cap(sine, cosine, r);
                surface.push(position, normal);
            }
        }
        let at = |ring: u32, i: u32| pole + 1 + (ring - 1) * SECTORS + i % SECTORS;
        for i in 0..SECTORS {
            let fan = [pole, at(1, i + 1), at(1, i)];
            surface.triangles.push(if side > 0.0 { fan } else { [fan[0], fan[2], fan[1]] });
            for ring in 1..RINGS {
                let mut quad = [at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)];
                if side < 0.0 {
                    quad.reverse();
                }
                surface.push_quad(quad);
            }
        }
    }
    let first = surface.positions.len() as u32;
    for &(sine, cosine) in &circle {
        for y in [HALF_RIM, -HALF_RIM] {
            // Written as the cap writes its last ring, so that the seam closes to the bit.
            surface.push(DVec3::new(APERTURE * cosine, y, APERTURE * sine), DVec3::new(cosine, 0.0, sine));
        }
    }
    for i in 0..SECTORS {
        let (a, b) = (first + 2 * i, first + 2 * ((i + 1) % SECTORS));
        surface.push_quad([a, b, b + 1, a + 1]);
    }
    surface
}

/// Ring about the y axis: walls of radius 1 and 1.08, 0.36 high, with flat rims.
pub fn ring() -> Surface {
    const SECTORS: u32 = 192;
    const HALF: f64 = 0.18;
    let [inner, outer] = [1.0, 1.08];
    // Radius and height of a side's two edges, and the side's normal: outwards and up.
    let sides = [
        ([(inner, -HALF), (inner, HALF)], [-1.0, 0.0]),
        ([(inner, HALF), (outer, HALF)], [0.0, 1.0]),
        ([(outer, HALF), (outer, -HALF)], [1.0, 0.0]),
        ([(outer, -HALF), (inner, -HALF)], [0.0, -1.0]),
    ];
    let mut surface = Surface::default();
    for (edges, [out, up]) in sides {
        let first = surface.positions.len() as u32;
        for i in 0..SECTORS {
            let (sine, cosine) = sin_cos(TAU * f64::from(i) / f64::from(SECTORS));
            let outwards = DVec3::new(cosine, 0.0, sine);
            for (radius, height) in edges {
                surface.push(outwards * radius + DVec3::Y * height, outwards * out + DVec3::Y * up);
            }
        }
        for i in 0..SECTORS {
            let (a, b) = (first + 2 * i, first + 2 * ((i + 1) % SECTORS));
            surface.push_quad([a, b, b + 1, a + 1]);
        }
    }
    surface
}

/// Torus about the y axis: ring radius 1, tube radius 0.4.
pub fn torus() -> Surface {
    torus_of(1.0, 0.4, 160, 72)
}

/// Torus about the y axis of these radii, of so many quads around the ring and around the tube.
pub fn torus_of(ring: f64, tube: f64, around: u32, across: u32) -> Surface {
    let mut surface = Surface::default();
    for i in 0..around {
        let (sine, cosine) = sin_cos(TAU * f64::from(i) / f64::from(around));
        let outwards = DVec3::new(cosine, 0.0, sine);
        for j in 0..across {
            let (up, out) = sin_cos(TAU * f64::from(j) / f64::from(across));
            let normal = outwards * out + DVec3::Y * up;
            surface.push(outwards * ring + normal * tube, normal);
        }
    }
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    for i in 0..around {
        for j in 0..across {
            surface.push_quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    surface
}

/// A star-shaped body: `place` gives position and unit normal for each direction of a geodesic sphere.
fn radial(frequency: u32, place: impl Fn(DVec3) -> (DVec3, DVec3)) -> Surface {
    let (directions, triangles) = geodesic(frequency);
    let (positions, normals) = directions.into_iter().map(place).unzip();
    Surface { positions, normals, triangles }
}

/// Directions and triangles of an icosahedron whose faces are split into `frequency`² triangles.
fn geodesic(frequency: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (corners, faces) = icosahedron();
    let mut directions = Vec::new();
    let mut triangles = Vec::new();
    // A lattice point is named by its weights on the icosahedron's corners, so faces share corner and edge points.
    let mut index_of: BTreeMap<Vec<(usize, u32)>, u32> = BTreeMap::new();
    for face in faces {
        let mut point = |i: u32, j: u32| {
            let weights = [frequency - i - j, i, j];
            let mut name: Vec<(usize, u32)> =
                face.iter().copied().zip(weights).filter(|&(_, weight)| weight > 0).collect();
            name.sort_unstable();
            *index_of.entry(name).or_insert_with_key(|name| {
                let sum: DVec3 = name
                    .iter()
                    .map(|&(corner, weight)| corners[corner] * spread(f64::from(weight) / f64::from(frequency)))
                    .sum();
                directions.push(sum.normalize());
                directions.len() as u32 - 1
            })
        };
        for i in 0..frequency {
            for j in 0..frequency - i {
                let (a, b, c) = (point(i, j), point(i + 1, j), point(i, j + 1));
                triangles.push([a, b, c]);
                if i + j + 1 < frequency {
                    triangles.push([b, point(i + 1, j + 1), c]);
                }
            }
        }
    }
    (directions, triangles)
}

/// Bends a barycentric weight so that projecting to the sphere leaves triangles of nearly one size: with this map an
/// edge of the icosahedron is split into equal angles.
fn spread(weight: f64) -> f64 {
    // Angle between neighbouring corners: cos = 1 / sqrt 5.
    const EDGE_ANGLE: f64 = 1.107_148_717_794_090_5;
    sin_cos(weight * EDGE_ANGLE).0
}

fn icosahedron() -> (Vec<DVec3>, Vec<[usize; 3]>) {
    // Pole, upper ring, lower ring, pole.
    let height = 1.0 / 5.0_f64.sqrt();
    let mut corners = vec![DVec3::Y];
    for (y, turn) in [(height, 0.0), (-height, 0.5)] {
        for i in 0..5 {
            let angle = TAU * (f64::from(i) + turn) / 5.0;
            let (x, z) = (2.0 * height * cos(angle), -2.0 * height * sin_cos(angle).0);
            corners.push(DVec3::new(x, y, z));
        }
    }
    corners.push(-DVec3::Y);
    let faces = (0..5).flat_map(|i| {
        let (upper, next_upper) = (1 + i, 1 + (i + 1) % 5);
        let (lower, next_lower) = (6 + i, 6 + (i + 1) % 5);
        [[0, upper, next_upper], [upper, lower, next_upper], [next_upper, lower, next_lower], [11, next_lower, lower]]
    });
    (corners, faces.collect())
}
