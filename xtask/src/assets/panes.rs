//! The two scenes of screen-space refraction (GPU Gems 2, chapter 19): a pool whose surface four waves travel over, and a leaded
//! window of uneven coloured glass.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use super::{
    flatten,
    glb::{Document, Shape, Target},
    material::Glass,
    trig::{cos, sin},
};

/// Vertices with flat or given normals, triangles, and colours where there are any.
#[derive(Default)]
struct Mesh {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    colours: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A parallelogram of `cells` quads with sides `u` and `v`, seen counter-clockwise from the side that u x v points to.
    fn grid(&mut self, corner: DVec3, [u, v]: [DVec3; 2], cells: [u32; 2], colour: DVec3) {
        let first = self.positions.len() as u32;
        let row = cells[0] + 1;
        for j in 0..=cells[1] {
            for i in 0..row {
                let [s, t] = [f64::from(i) / f64::from(cells[0]), f64::from(j) / f64::from(cells[1])];
                self.positions.push(corner + s * u + t * v);
                self.normals.push(u.cross(v).normalize());
                self.colours.push(colour);
            }
        }
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let a = first + j * row + i;
                self.triangles.extend([[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]);
            }
        }
    }

    /// The six sides of a box, cut into so many quads along each axis.
    fn cuboid(&mut self, low: DVec3, high: DVec3, cells: [u32; 3], colour: DVec3) {
        let size = high - low;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * size);
        for axis in 0..3 {
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            self.grid(low + axes[axis], [axes[a], axes[b]], [cells[a], cells[b]], colour);
            self.grid(low, [axes[b], axes[a]], [cells[b], cells[a]], colour);
        }
    }

    /// Adds it to a document as a mesh of one primitive, and a node that shows it. Returns the node.
    fn add_to(&self, document: &mut Document, name: &str, material: usize, targets: &[Value]) -> usize {
        let vertices = Some(Target::Vertices);
        let mut attributes = json!({
            "POSITION": document.floats(&flatten(&self.positions), Shape::Vec3, vertices, true),
            "NORMAL": document.floats(&flatten(&self.normals), Shape::Vec3, vertices, false),
        });
        if self.colours.iter().any(|&colour| colour != DVec3::ONE) {
            attributes["COLOR_0"] = json!(document.floats(&flatten(&self.colours), Shape::Vec3, vertices, false));
        }
        let indices = document.indices(&self.triangles);
        let mut primitive = json!({ "attributes": attributes, "indices": indices, "material": material });
        let mut mesh = json!({ "name": name });
        if !targets.is_empty() {
            primitive["targets"] = json!(targets);
            mesh["weights"] = json!(vec![0.0; targets.len()]);
        }
        mesh["primitives"] = json!([primitive]);
        let mesh = document.push("meshes", mesh);
        document.push("nodes", json!({ "name": name, "mesh": mesh }))
    }
}

fn matte(document: &mut Document, name: &str, colour: [f64; 4], roughness: f64) -> usize {
    let pbr = json!({ "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": roughness });
    document.push("materials", json!({ "name": name, "pbrMetallicRoughness": pbr }))
}

/// A number from 0 to 1 that looks drawn by lot.
fn lot(a: u32, b: u32) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ 0x27d4_eb2f;
    x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d);
    x = (x ^ (x >> 12)).wrapping_mul(0x297a_2d39);
    f64::from((x ^ (x >> 15)) >> 8) / f64::from(1_u32 << 24)
}

/// One of the waves that travel over the pool.
struct Wave {
    /// Metres from crest to crest.
    length: f64,
    /// Of its way over the water, turns.
    heading: f64,
    /// Metres.
    amplitude: f64,
    /// Crests that pass a point in one loop of the clip.
    crests: u32,
}

const WAVES: [Wave; 4] = [
    Wave { length: 1.10, heading: 0.06, amplitude: 0.016, crests: 3 },
    Wave { length: 0.68, heading: 0.31, amplitude: 0.009, crests: 4 },
    Wave { length: 0.45, heading: 0.83, amplitude: 0.0055, crests: 5 },
    Wave { length: 0.31, heading: 0.55, amplitude: 0.0035, crests: 6 },
];

/// Half the pool's side, metres.
const HALF: f64 = 1.0;
const DEPTH: f64 = 0.4;
const LOOP: f64 = 4.0;
const KEYS: usize = 96;

impl Wave {
    /// Wave vector, radians a metre, over (x, z).
    fn vector(&self) -> DVec2 {
        let turn = TAU * self.heading;
        TAU / self.length * DVec2::new(cos(turn), sin(turn))
    }

    /// Two morph targets, a quarter of a wave apart: a cos(k p) and a sin(k p). Turning from the one into the other makes it travel.
    fn targets(&self, document: &mut Document, mesh: &Mesh) -> [Value; 2] {
        let k = self.vector();
        [0.0, 0.25 * TAU].map(|shift| {
            let (mut positions, mut normals) = (Vec::new(), Vec::new());
            for (&p, &normal) in mesh.positions.iter().zip(&mesh.normals) {
                let phase = k.dot(DVec2::new(p.x, p.z)) - shift;
                let rise = if p.y > 0.5 * DEPTH { self.amplitude * cos(phase) } else { 0.0 };
                let slope = if normal.y > 0.5 { -self.amplitude * sin(phase) * k } else { DVec2::ZERO };
                positions.push(DVec3::new(0.0, rise, 0.0).as_vec3().to_array());
                normals.push(DVec3::new(-slope.x, 0.0, -slope.y).as_vec3().to_array());
            }
            json!({ "POSITION": document.sparse_vec3(&positions), "NORMAL": document.sparse_vec3(&normals) })
        })
    }
}

/// A pool of water, 2 x 0.4 x 2, on tiles; the clip `ripple` lets four waves travel over it.
pub fn pool() -> Vec<u8> {
    let mut document = Document::default();
    let water = Glass { name: "Water", ior: 1.333, thickness: DEPTH, attenuation: Some(([0.62, 0.9, 0.92], 0.8)) };
    let water = water.add_to(&mut document);
    let mut body = Mesh::default();
    let corner = DVec3::new(HALF, 0.0, HALF);
    body.cuboid(-corner, corner + DEPTH * DVec3::Y, [28, 1, 28], DVec3::ONE);
    let targets: Vec<Value> = WAVES.iter().flat_map(|wave| wave.targets(&mut document, &body)).collect();
    let node = body.add_to(&mut document, "Water", water, &targets);
    // The tiles stand a hair below the water.
    let glaze = matte(&mut document, "Tiles", [1.0; 4], 0.4);
    let mut tiles = Mesh::default();
    let (count, side, joint) = (14, 0.175, 0.006);
    for i in 0..count {
        for j in 0..count {
            let [x, z] = [i, j].map(|at| side * (f64::from(at) - 0.5 * f64::from(count)));
            let shade = 0.75 + 0.35 * lot(i, j);
            let colour = if (i + j) % 2 == 0 { DVec3::new(0.09, 0.33, 0.42) } else { DVec3::new(0.72, 0.76, 0.70) };
            let size = side - joint;
            let along = [size * DVec3::Z, size * DVec3::X];
            tiles.grid(DVec3::new(x, -0.004, z), along, [1, 1], (shade * colour).min(DVec3::ONE));
        }
    }
    let bed = 0.5 * side * f64::from(count);
    let along = [2.0 * bed * DVec3::Z, 2.0 * bed * DVec3::X];
    tiles.grid(DVec3::new(-bed, -0.006, -bed), along, [1, 1], DVec3::splat(0.3));
    let floor = tiles.add_to(&mut document, "Tiles", glaze, &[]);
    let times: Vec<f32> = (0..=KEYS).map(|key| (LOOP * key as f64 / KEYS as f64) as f32).collect();
    let weights: Vec<f32> = (0..=KEYS)
        .flat_map(|key| {
            WAVES.iter().flat_map(move |wave| {
                let turn = TAU * f64::from(wave.crests) * (key % KEYS) as f64 / KEYS as f64;
                [cos(turn) as f32, sin(turn) as f32]
            })
        })
        .collect();
    let input = document.floats(&times, Shape::Scalar, None, true);
    let output = document.floats(&weights, Shape::Scalar, None, false);
    document.push(
        "animations",
        json!({
            "name": "ripple",
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
            "channels": [{ "sampler": 0, "target": { "node": node, "path": "weights" } }],
        }),
    );
    document.finish(&[node, floor])
}

const COLUMNS: u32 = 5;
const ROWS: u32 = 7;
const PANE: f64 = 0.24;
/// Quads along a side of a pane.
const CUTS: u32 = 5;
const PALETTE: [DVec3; 6] = [
    DVec3::new(0.85, 0.12, 0.10),
    DVec3::new(0.95, 0.62, 0.12),
    DVec3::new(0.12, 0.35, 0.80),
    DVec3::new(0.10, 0.62, 0.38),
    DVec3::new(0.90, 0.86, 0.74),
    DVec3::new(0.52, 0.20, 0.66),
];

/// Slope of the window's uneven front.
fn unevenness(p: DVec3) -> DVec2 {
    let waves = [(19.0, 7.0, 0.30), (-11.0, 23.0, 1.70), (25.0, -14.0, 4.10), (29.0, 21.0, 2.60)];
    waves.iter().map(|&(kx, ky, phase)| 0.035 * cos(kx * p.x + ky * p.y + phase) * DVec2::new(kx, ky).normalize()).sum()
}

/// A window of 5 x 7 coloured panes, 1.2 x 1.68 and 0.02 thick, in leads.
pub fn window() -> Vec<u8> {
    let mut document = Document::default();
    let glass = Glass { name: "Cathedral glass", ior: 1.5, thickness: 0.02, attenuation: None }.add_to(&mut document);
    let size = DVec2::new(f64::from(COLUMNS), f64::from(ROWS)) * PANE;
    let (left, depth) = (-0.5 * size.x, 0.01);
    let mut panes = Mesh::default();
    for column in 0..COLUMNS {
        for row in 0..ROWS {
            let corner = DVec3::new(left + PANE * f64::from(column), PANE * f64::from(row), 0.0);
            let nearest_ring = column.min(COLUMNS - 1 - column).min(row.min(ROWS - 1 - row));
            let pick = (2 * nearest_ring + (column + row) % 2 + 3 * (lot(column, row) * 1.3) as u32) as usize;
            let colour = PALETTE[pick % PALETTE.len()];
            let [u, v] = [PANE * DVec3::X, PANE * DVec3::Y];
            panes.grid(corner + depth * DVec3::Z, [u, v], [CUTS; 2], colour);
            panes.grid(corner - depth * DVec3::Z, [v, u], [CUTS; 2], colour);
        }
    }
    for (&p, normal) in panes.positions.iter().zip(&mut panes.normals) {
        if normal.z > 0.5 {
            *normal = (DVec3::Z - unevenness(p).extend(0.0)).normalize();
        }
    }
    let [wide, tall] = [CUTS * COLUMNS, CUTS * ROWS];
    let low = DVec3::new(left, 0.0, -depth);
    let [x, y, z] = [size.x * DVec3::X, size.y * DVec3::Y, 2.0 * depth * DVec3::Z];
    panes.grid(low, [x, z], [wide, 1], DVec3::ONE);
    panes.grid(low + y, [z, x], [1, wide], DVec3::ONE);
    panes.grid(low, [z, y], [1, tall], DVec3::ONE);
    panes.grid(low + x, [y, z], [tall, 1], DVec3::ONE);
    let node = panes.add_to(&mut document, "Panes", glass, &[]);
    let lead = matte(&mut document, "Lead", [0.04, 0.04, 0.045, 1.0], 0.55);
    let mut leads = Mesh::default();
    let (half, out) = (0.009, 0.022);
    for column in 0..=COLUMNS {
        let at = left + PANE * f64::from(column);
        let [low, high] = [DVec3::new(at - half, -half, -out), DVec3::new(at + half, size.y + half, out)];
        leads.cuboid(low, high, [1; 3], DVec3::ONE);
    }
    for row in 0..=ROWS {
        let at = PANE * f64::from(row);
        let [low, high] = [DVec3::new(left - half, at - half, -out), DVec3::new(left + size.x + half, at + half, out)];
        leads.cuboid(low, high, [1; 3], DVec3::ONE);
    }
    let leads = leads.add_to(&mut document, "Leads", lead, &[]);
    document.finish(&[node, leads])
}
