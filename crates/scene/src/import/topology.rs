//! Triangle lists from strips and fans, and vertices of their own for flat shading.

use crate::Primitive;

/// How vertices make triangles (`mesh.primitive.mode`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    List,
    Strip,
    Fan,
}

/// Counter-clockwise triangles of a vertex sequence (glTF 2.0, section 3.7.2.1). The triangles without area by which
/// strips are stitched together are left out; a list keeps its own.
pub(super) fn triangulate(topology: Topology, sequence: &[u32]) -> Vec<[u32; 3]> {
    let stitched =
        |triangle: &[u32; 3]| triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0];
    match topology {
        Topology::List => sequence.as_chunks::<3>().0.to_vec(),
        Topology::Strip => sequence
            .array_windows::<3>()
            .enumerate()
            .map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] })
            .filter(stitched)
            .collect(),
        Topology::Fan => {
            let Some((&hub, rim)) = sequence.split_first() else { return Vec::new() };
            rim.array_windows::<2>().map(|&[a, b]| [a, b, hub]).filter(stitched).collect()
        }
    }
}

/// Gives each triangle its own vertices: `triangles[i]` becomes `[3i, 3i+1, 3i+2]`. Normals and tangents, which flat
/// shading makes anew, go.
pub(super) fn unweld(primitive: &mut Primitive) {
    let corners: Vec<usize> = primitive.triangles.iter().flatten().map(|&vertex| vertex as usize).collect();
    primitive.normals = None;
    primitive.tangents = None;
    gather(&mut primitive.positions, &corners);
    for set in &mut primitive.texcoords {
        gather(set, &corners);
    }
    if let Some(colors) = &mut primitive.colors {
        gather(colors, &corners);
    }
    for set in &mut primitive.joints {
        gather(set, &corners);
    }
    for set in &mut primitive.weights {
        gather(set, &corners);
    }
    for target in &mut primitive.targets {
        target.normals = None;
        target.tangents = None;
        if let Some(positions) = &mut target.positions {
            gather(positions, &corners);
        }
    }
    primitive.triangles = (0..primitive.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
}

/// Bytes that a primitive's vertices take once each triangle has its own.
pub(super) fn unwelded_size(primitive: &Primitive) -> u64 {
    let texcoords = 8 * primitive.texcoords.len();
    let colors = if primitive.colors.is_some() { 16 } else { 0 };
    let influences = (8 + 16) * primitive.joints.len();
    let targets = 12 * primitive.targets.iter().filter(|target| target.positions.is_some()).count();
    let vertex = 12 + texcoords + colors + influences + targets;
    3 * primitive.triangles.len() as u64 * vertex as u64
}

fn gather<T: Copy>(list: &mut Vec<T>, places: &[usize]) {
    *list = places.iter().map(|&place| list[place]).collect();
}
