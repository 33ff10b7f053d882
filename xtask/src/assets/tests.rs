//! What every generated file promises, read back from its bytes.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use glam::{Vec3, Vec4};
use serde_json::Value;

use super::{Asset, generate, radiance_hdr, trig};

static ASSETS: LazyLock<Vec<Asset>> = LazyLock::new(generate);

const CHARACTERS: [&str; 3] = ["dancer.glb", "octopus.glb", "swan.glb"];
const SMOOTH_BODIES: [&str; 4] = ["sphere.glb", "ellipsoid.glb", "torus.glb", "bumpy.glb"];

/// A .glb file taken apart: its JSON and its binary chunk.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn of(name: &str) -> Self {
        let asset = ASSETS.iter().find(|asset| asset.name == name).expect("a generated asset");
        let bytes = &asset.bytes;
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!(word(8), bytes.len(), "{name}: length in the header");
        let json_end = 20 + word(12);
        assert_eq!(json_end + 8 + word(json_end), bytes.len(), "{name}: two chunks");
        Self { json: serde_json::from_slice(&bytes[20..json_end]).unwrap(), binary: bytes[json_end + 8..].to_vec() }
    }

    fn all() -> impl Iterator<Item = (&'static str, Self)> {
        ASSETS.iter().filter(|asset| asset.bytes.starts_with(b"glTF")).map(|asset| (asset.name, Self::of(asset.name)))
    }

    fn bytes(&self, accessor: &Value) -> &[u8] {
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        &self.binary[start..start + view["byteLength"].as_u64().unwrap() as usize]
    }

    fn accessor(&self, index: &Value) -> &Value {
        &self.json["accessors"][index.as_u64().unwrap() as usize]
    }

    fn floats(&self, index: &Value) -> Vec<f32> {
        self.bytes(self.accessor(index)).chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn shorts(&self, index: &Value) -> Vec<u16> {
        self.bytes(self.accessor(index)).chunks(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn primitive(&self) -> &Value {
        &self.json["meshes"][0]["primitives"][0]
    }

    fn attribute(&self, name: &str) -> Vec<Vec3> {
        self.floats(&self.primitive()["attributes"][name]).chunks(3).map(Vec3::from_slice).collect()
    }

    fn triangles(&self) -> Vec<[usize; 3]> {
        self.shorts(&self.primitive()["indices"])
            .chunks(3)
            .map(|t| [t[0] as usize, t[1] as usize, t[2] as usize])
            .collect()
    }
}

#[test]
fn the_committed_files_are_what_the_source_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    for asset in &*ASSETS {
        let committed = std::fs::read(folder.join(asset.name)).unwrap_or_default();
        assert!(committed == asset.bytes, "assets/{} is out of date: run `cargo xtask assets`", asset.name);
    }
}

#[test]
fn files_stay_small() {
    for asset in &*ASSETS {
        assert!(asset.bytes.len() < 1_500_000, "{}: {} bytes", asset.name, asset.bytes.len());
    }
    assert!(ASSETS.iter().map(|asset| asset.bytes.len()).sum::<usize>() < 6_000_000);
}

#[test]
fn every_body_is_closed_and_faces_outwards() {
    for (name, glb) in Glb::all() {
        let positions = glb.attribute("POSITION");
        // Flat and rimmed bodies split vertices by normal, so edges are named by position.
        let mut vertex_at = BTreeMap::new();
        let welded: Vec<usize> = positions
            .iter()
            .map(|p| {
                let key = p.to_array().map(|x| (x + 0.0).to_bits());
                let next = vertex_at.len();
                *vertex_at.entry(key).or_insert(next)
            })
            .collect();
        let mut edges = BTreeMap::new();
        let mut volume = 0.0;
        for t in glb.triangles() {
            for i in 0..3 {
                *edges.entry((welded[t[i]], welded[t[(i + 1) % 3]])).or_insert(0) += 1;
            }
            let [a, b, c] = t.map(|i| positions[i].as_dvec3());
            volume += a.dot(b.cross(c)) / 6.0;
        }
        for (&(a, b), &count) in &edges {
            assert!(
                count == 1 && edges.get(&(b, a)) == Some(&1),
                "{name}: edge {a} {b} is not shared by two triangles"
            );
        }
        assert!(volume > 0.0, "{name}: inside out");
    }
}

/// Angle in degrees between each vertex normal and the area-weighted mean normal of the triangles round it.
fn normal_errors(glb: &Glb) -> Vec<f32> {
    let (positions, normals) = (glb.attribute("POSITION"), glb.attribute("NORMAL"));
    let mut means = vec![Vec3::ZERO; positions.len()];
    for t in glb.triangles() {
        let [a, b, c] = t.map(|i| positions[i]);
        for corner in t {
            means[corner] += (b - a).cross(c - a);
        }
    }
    normals.iter().zip(means).map(|(n, mean)| n.angle_between(mean).to_degrees()).collect()
}

#[test]
fn normals_are_those_of_the_surface() {
    for name in SMOOTH_BODIES {
        let worst = normal_errors(&Glb::of(name)).into_iter().fold(0.0, f32::max);
        assert!(worst < 1.0, "{name}: a normal is {worst} degrees off");
    }
    for name in CHARACTERS {
        let mut errors = normal_errors(&Glb::of(name));
        errors.sort_by(f32::total_cmp);
        let most = errors[errors.len() * 99 / 100];
        assert!(most < 5.0, "{name}: 1 % of the normals are more than {most} degrees off");
    }
}

#[test]
fn the_sphere_is_round() {
    let glb = Glb::of("sphere.glb");
    let positions = glb.attribute("POSITION");
    for t in glb.triangles() {
        let middle = t.iter().map(|&i| positions[i].as_dvec3()).sum::<glam::DVec3>() / 3.0;
        assert!((middle.length() - 1.0).abs() < 1e-4);
    }
}

#[test]
fn clips_end_where_they_begin() {
    for name in CHARACTERS {
        let glb = Glb::of(name);
        let animation = &glb.json["animations"][0];
        for channel in animation["channels"].as_array().unwrap() {
            let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
            let values = glb.floats(&sampler["output"]);
            let keys = glb.floats(&sampler["input"]).len();
            let (first, last) = (&values[..values.len() / keys], &values[values.len() - values.len() / keys..]);
            if channel["target"]["path"] == "rotation" {
                let (a, b) = (Vec4::from_slice(first), Vec4::from_slice(last));
                assert!(a.dot(b).abs() > 1.0 - 1e-6, "{name}: {channel}");
            } else {
                assert_eq!(first, last, "{name}: {channel}");
            }
        }
    }
}

#[test]
fn skin_weights_sum_to_one_and_name_joints() {
    for name in CHARACTERS {
        let glb = Glb::of(name);
        let attributes = &glb.primitive()["attributes"];
        for weights in glb.shorts(&attributes["WEIGHTS_0"]).chunks(4) {
            assert_eq!(weights.iter().map(|&w| u32::from(w)).sum::<u32>(), 65_535, "{name}");
        }
        let joints = glb.json["skins"][0]["joints"].as_array().unwrap().len();
        let indices = glb.bytes(glb.accessor(&attributes["JOINTS_0"]));
        assert!(indices.iter().all(|&joint| usize::from(joint) < joints), "{name}");
    }
}

#[test]
fn sine_and_cosine_agree_with_the_platform() {
    for i in -2000..2000 {
        let angle = f64::from(i) * 0.017;
        let (sine, cosine) = trig::sin_cos(angle);
        assert!((sine - angle.sin()).abs() < 2e-15 && (cosine - angle.cos()).abs() < 2e-15, "at {angle}");
    }
}

/// Reads one scanline of run-length coded bytes, four channels of `width`.
fn decode(mut coded: &[u8], width: usize) -> Vec<Vec<u8>> {
    assert_eq!(coded[..4], [2, 2, (width >> 8) as u8, width as u8]);
    coded = &coded[4..];
    let mut channels = Vec::new();
    for _ in 0..4 {
        let mut channel = Vec::new();
        while channel.len() < width {
            let count = usize::from(coded[0]);
            if count > 128 {
                channel.extend(std::iter::repeat_n(coded[1], count - 128));
                coded = &coded[2..];
            } else {
                channel.extend(&coded[1..=count]);
                coded = &coded[1 + count..];
            }
        }
        assert_eq!(channel.len(), width);
        channels.push(channel);
    }
    assert!(coded.is_empty());
    channels
}

#[test]
fn radiance_survives_the_hdr_file() {
    let pixels: Vec<Vec3> = (0..300)
        .map(|i| if i % 7 < 4 { Vec3::splat(0.25) } else { Vec3::new(0.001, 0.9, 1.0) * i as f32 })
        .chain([Vec3::ZERO, Vec3::splat(0.999_99), Vec3::splat(1e-3), Vec3::splat(12.5)])
        .collect();
    let file = radiance_hdr::encode(pixels.len(), &pixels);
    let header = b"\n\n-Y 1 +X 304\n";
    let start = file.windows(header.len()).position(|window| window == header).unwrap() + header.len();
    let channels = decode(&file[start..], pixels.len());
    for (i, pixel) in pixels.iter().enumerate() {
        let scale = 2.0_f32.powi(i32::from(channels[3][i]) - 136);
        let read = Vec3::from_array([0, 1, 2].map(|c| f32::from(channels[c][i]) * scale));
        assert!((read - *pixel).abs().max_element() <= pixel.max_element() / 250.0, "{pixel} came back as {read}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let error = super::run(&file.join("assets")).unwrap_err();
    assert!(error.to_string().contains("Cargo.toml"), "{error}");
}
