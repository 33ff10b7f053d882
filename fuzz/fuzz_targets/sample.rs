//! Any small scene that is imported, posed and deformed at any time by any layers: no panic, indices and lengths that
//! hold, and where its numbers are moderate, finite poses that are the same in f32 and f64 and boxes that hold the bodies.
//!
//! A first byte of 0x80 or more begins 16 bytes that choose layers; the model follows.

#![no_main]

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, DVec4};
use libfuzzer_sys::fuzz_target;
use murano_animation::{
    Blend, Geometry, Layer, Pose, Properties, Rig, Workspace, deform_f64, sample_weights, shown_primitives,
};
use murano_scene::{Channel, Interpolation, Local, Path, Property, Sampler, Scene, Skinning};

mod shared;

/// Bytes of layers before a model.
const CHOICES: usize = 16;
/// Clips that are looked at.
const MOST_CLIPS: usize = 4;
/// Numbers up to this are moderate.
const MODERATE: f64 = 1e6;
/// Error of an evaluated f32 curve, relative to its largest term.
const CURVE: f64 = 3e-6;

fuzz_target!(|bytes: &[u8]| {
    let (choices, model) = match bytes.first() {
        Some(0x80..) if bytes.len() > CHOICES => bytes.split_at(CHOICES),
        _ => (&[][..], bytes),
    };
    let Some(mut scene) = shared::imported(model).filter(is_small) else { return };
    let moderate = is_moderate(&scene);
    let rig = Rig::new(&scene);
    let poses = check_poses(&scene, &rig, moderate, choices);
    check_properties(&scene, moderate, choices);
    for skinning in [Skinning::Linear, Skinning::DualQuaternion] {
        scene.skinning = skinning;
        let geometry = Geometry::build(&scene, &shown_primitives(&scene)).expect("every primitive exists");
        check_geometry(&scene, &geometry);
        poses.iter().for_each(|pose| check_deformation(&scene, &geometry, pose, moderate));
    }
});

/// Whether nothing about a scene takes long.
fn is_small(scene: &Scene) -> bool {
    let shown = shown_primitives(scene);
    let primitives =
        shown.iter().filter_map(|&(node, index)| Some(&scene.meshes[scene.nodes[node].mesh?].primitives[index]));
    let (mut vertices, mut work) = (0, 0);
    for primitive in primitives {
        let own = primitive.positions.len().max(3 * primitive.triangles.len());
        vertices += own;
        work += own * (primitive.targets.len() + 4 * primitive.joints.len());
    }
    let channels = scene.clips.iter().map(|clip| clip.channels.len() + clip.properties.len()).sum::<usize>();
    let weights = scene.nodes.iter().map(|node| node.weights.len()).sum::<usize>();
    scene.nodes.len() <= 500 && vertices <= 20_000 && work <= 200_000 && channels <= 500 && weights <= 20_000
}

/// Whether all numbers that move vertices are of a size that models have.
fn is_moderate(scene: &Scene) -> bool {
    let small = |value: f64| value.abs() <= MODERATE;
    let matrix = |matrix: &DMat4| matrix.to_cols_array().into_iter().all(small);
    let fits = |sampler: &Sampler| sampler.times.iter().chain(&sampler.values).all(|&value| small(value.into()));
    let primitives = || scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let displacements = primitives().flat_map(|primitive| &primitive.targets).filter_map(|it| it.positions.as_ref());
    let mut positions = primitives().map(|primitive| &primitive.positions).chain(displacements).flatten();
    let mut clips = scene.clips.iter();
    scene.nodes.iter().all(|node| matrix(&node.local.matrix()) && node.weights.iter().all(|&weight| small(weight)))
        && scene.skins.iter().flat_map(|skin| &skin.inverse_bind).all(matrix)
        && positions.all(|position| small(position.abs().max_element().into()))
        && clips.all(|clip| {
            clip.channels.iter().all(|channel| fits(&channel.sampler))
                && clip.properties.iter().all(|channel| fits(&channel.sampler))
        })
}

/// Times of interest of a clip.
fn times(scene: &Scene, clip: usize) -> Vec<f64> {
    let mut times = vec![-1.0, 0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];
    let clip = &scene.clips[clip];
    let samplers = clip.channels.iter().map(|channel| &channel.sampler);
    for sampler in samplers.chain(clip.properties.iter().map(|channel| &channel.sampler)).take(2) {
        let keys: Vec<f64> = sampler.times.iter().take(3).copied().map(f64::from).collect();
        times.extend(&keys);
        times.extend(keys.windows(2).map(|pair| pair[0] + 0.3 * (pair[1] - pair[0])));
        times.extend(keys.first().map(|key| key.next_up()));
    }
    times.extend([clip.duration, clip.duration + 1.0]);
    times
}

/// Bytes that choose; zero behind the last.
struct Choices<'a>(std::slice::Iter<'a, u8>);

impl Choices<'_> {
    fn byte(&mut self) -> usize {
        self.0.next().copied().unwrap_or_default().into()
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.byte() % list.len()]
    }

    /// A layer of a clip, or of none.
    fn layer(&mut self, scene: &Scene) -> Layer {
        let clip = self.byte() % (scene.clips.len() + 1);
        let time = if clip < scene.clips.len() { self.of(&times(scene, clip)) } else { 0.5 };
        let weights = [0.3, 1.0, 0.0, 0.7, -0.5, 2.0, f64::NAN, f64::INFINITY];
        let mask = match self.byte() % 4 {
            0 => None,
            length => {
                let length = [0, scene.nodes.len() / 2, scene.nodes.len(), scene.nodes.len() + 3][length];
                Some((0..length).map(|node| [1.0, 0.0, 0.5][node % 3]).collect::<Arc<[f32]>>())
            }
        };
        Layer { clip, time, weight: self.of(&weights), blend: self.of(&[Blend::Over, Blend::Add]), mask }
    }
}

/// Layers that are chosen.
fn chosen(scene: &Scene, choices: &[u8]) -> Vec<Layer> {
    let mut choices = Choices(choices.iter());
    let count = choices.byte() % 4;
    (0..count).map(|_| choices.layer(scene)).collect()
}

/// Stacks of layers over a clip at a time.
fn stacks(scene: &Scene, clip: usize, time: f64) -> Vec<Vec<Layer>> {
    let last = scene.clips.len() - 1;
    let base = Layer::new(clip, time);
    let over = |weight: f64| Layer { weight, ..Layer::new(last, time) };
    let added = |weight: f64| Layer { blend: Blend::Add, ..over(weight) };
    let masked = |layer: Layer, length: usize| Layer { mask: Some(vec![0.75; length].into()), ..layer };
    let nodes = scene.nodes.len();
    vec![
        vec![over(0.3)],
        vec![base.clone(), over(0.3), added(0.5)],
        vec![base.clone(), masked(over(1.0), nodes / 2), masked(added(1.0), nodes + 2)],
        vec![added(1.0), over(0.6), Layer::new(scene.clips.len(), time)],
    ]
}

/// Poses every clip; returns a few poses.
fn check_poses(scene: &Scene, rig: &Rig, moderate: bool, choices: &[u8]) -> Vec<Pose> {
    let rest = Pose::rest(scene);
    check_lengths(scene, &rest);
    assert!(same(rig.rest(), &rest) && same(&rig.pose(&[]), &rest));
    let chosen = chosen(scene, choices);
    let (mut workspace, mut reused) = (Workspace::default(), rest.clone());
    let mut kept = vec![rest];
    for clip in 0..scene.clips.len().min(MOST_CLIPS) {
        for time in times(scene, clip) {
            let alone = [Layer::new(clip, time)];
            let (fast, exact) = (rig.pose(&alone), Pose::sample(scene, &alone));
            check_lengths(scene, &fast);
            check_lengths(scene, &exact);
            if moderate {
                agree(scene, clip, time, &fast, &exact);
            }
            rig.pose_into(&alone, &mut workspace, &mut reused);
            assert!(same(&fast, &reused), "a pose depends on the one before");

            let hidden: Vec<Layer> = chosen.iter().chain(&alone).cloned().collect();
            assert!(same(&fast, &rig.pose(&hidden)) && same(&exact, &Pose::sample(scene, &hidden)));
            let nothing = [alone[0].clone(), Layer::new(scene.clips.len(), time)];
            assert!(same(&exact, &Pose::sample(scene, &nothing)));
        }
        let time = 0.4 * scene.clips[clip].duration;
        kept.push(Pose::sample(scene, &[Layer::new(clip, time)]));
        for stack in stacks(scene, clip, time).into_iter().chain([chosen.clone()]) {
            let (fast, exact) = (rig.pose(&stack), Pose::sample(scene, &stack));
            check_lengths(scene, &fast);
            check_lengths(scene, &exact);
            rig.pose_into(&stack, &mut workspace, &mut reused);
            assert!(same(&fast, &reused), "a pose depends on the one before");
            let mean = |layer: &Layer| layer.blend == Blend::Over && (0.0..=1.0).contains(&layer.weight);
            if moderate && stack.iter().all(mean) {
                let extents = errors(scene, &exact, |_, _| true);
                for (node, extent) in extents.into_iter().enumerate() {
                    if extent.is_some_and(|error| error.size() < 1e30) {
                        assert!(fast.world_from_node[node].is_finite() && exact.world_from_node[node].is_finite());
                    }
                }
            }
        }
    }
    if !chosen.is_empty() {
        kept.push(rig.pose(&chosen));
    }
    kept.truncate(4);
    kept
}

fn check_lengths(scene: &Scene, pose: &Pose) {
    let nodes = scene.nodes.len();
    assert_eq!([pose.locals.len(), pose.weights.len(), pose.world_from_node.len()], [nodes; 3]);
    assert!(pose.weights.iter().zip(&scene.nodes).all(|(weights, node)| weights.len() == node.weights.len()));
}

/// Every number of a pose.
fn numbers(pose: &Pose) -> impl Iterator<Item = f64> + '_ {
    let locals = pose.locals.iter().map(Local::matrix);
    let matrices = locals.chain(pose.world_from_node.iter().copied()).flat_map(|matrix| matrix.to_cols_array());
    matrices.chain(pose.weights.iter().flatten().copied())
}

/// Whether two poses are the same; NaN is NaN.
fn same(a: &Pose, b: &Pose) -> bool {
    numbers(a).zip(numbers(b)).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

/// How far a node's world matrix may be off, and how large what it is made of.
#[derive(Clone, Copy, Default)]
struct Error {
    linear: f64,
    offset: f64,
    largest: f64,
}

impl Error {
    fn size(self) -> f64 {
        self.largest.max(self.linear).max(self.offset)
    }
}

/// What the curves of a node are made of: largest terms, and terms of the rotation over its length.
#[derive(Clone, Copy, Default)]
struct Terms {
    translation: f64,
    rotation: f64,
    scale: f64,
}

/// Bounds of the error of world matrices whose locals' errors are `CURVE` of their terms; `None` from a node on whose terms
/// are told to be too large for any.
fn errors(scene: &Scene, pose: &Pose, terms: impl Fn(usize, &mut Terms) -> bool) -> Vec<Option<Error>> {
    let mut errors: Vec<Option<Error>> = vec![None; scene.nodes.len()];
    let mut done = vec![false; scene.nodes.len()];
    let mut stack: Vec<usize> = (0..scene.nodes.len()).filter(|&node| scene.nodes[node].parent.is_none()).collect();
    while let Some(node) = stack.pop() {
        stack.extend(&scene.nodes[node].children);
        assert!(!std::mem::replace(&mut done[node], true));
        let above = scene.nodes[node].parent.map_or(Some((Error::default(), DMat4::IDENTITY)), |parent| {
            errors[parent].map(|error| (error, pose.world_from_node[parent]))
        });
        let Some((above, parent)) = above else { continue };
        let matrix = pose.locals[node].matrix();
        let translation = matrix.w_axis.truncate().length();
        let (mut own, linear, exact) = match &pose.locals[node] {
            Local::Trs(own) => {
                let scale = own.scale.abs().max_element();
                (Terms { translation, rotation: 1.0, scale }, scale, false)
            }
            Local::Matrix(_) => (Terms::default(), norm(&DMat3::from_mat4(matrix)), true),
        };
        if !exact && !terms(node, &mut own) {
            continue;
        }
        let across = norm(&DMat3::from_mat4(parent));
        let [linear_error, offset_error] = [own.scale.max(linear) * own.rotation, own.translation]
            .map(|term| if exact { 0.0 } else { 4.0 * CURVE * term });
        errors[node] = Some(Error {
            linear: above.linear * (linear + linear_error) + across * linear_error,
            offset: above.offset + above.linear * (translation + offset_error) + across * offset_error,
            largest: above.largest.max(own.translation).max(own.scale).max(largest_entry(&pose.world_from_node[node])),
        });
    }
    errors
}

fn norm(matrix: &DMat3) -> f64 {
    matrix.to_cols_array().iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

/// Largest magnitude of an entry; infinite with NaN.
fn largest_entry(matrix: &DMat4) -> f64 {
    let larger = |largest: f64, entry: f64| if entry.is_nan() { f64::INFINITY } else { largest.max(entry.abs()) };
    matrix.to_cols_array().into_iter().fold(0.0, larger)
}

/// Largest term of a curve: of a spline, tangents by the time between keys.
fn largest_term(sampler: &Sampler) -> f64 {
    let value = sampler.values.iter().fold(0.0, |largest: f64, &value| largest.max(value.abs().into()));
    if sampler.interpolation != Interpolation::CubicSpline {
        return value;
    }
    value * sampler.times.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0])).fold(1.0, f64::max)
}

/// Terms of a rotation curve at a time over the length of their sum; `None` between keys that are half a turn apart, and of
/// splines so small that f32 has few digits left.
fn rotation_terms(sampler: &Sampler, time: f64) -> Option<f64> {
    match sampler.interpolation {
        Interpolation::Linear => {
            let sides: Vec<_> = sampler.values.chunks_exact(4).map(unit).collect();
            let clear = |pair: &[[f64; 4]]| dot(pair[0], pair[1]).abs() > 1e-5;
            sides.windows(2).all(clear).then_some(1.0)
        }
        Interpolation::Step => Some(1.0),
        Interpolation::CubicSpline => {
            let raw = sample_weights(sampler, time).expect("a whole curve");
            let length = raw.iter().map(|value| value * value).sum::<f64>().sqrt();
            (length > 1e-30).then(|| (largest_term(sampler) / length).max(1.0))
        }
    }
}

fn unit(values: &[f32]) -> [f64; 4] {
    let values: [f64; 4] = std::array::from_fn(|axis| values[axis].into());
    let length = dot(values, values).sqrt();
    values.map(|value| if length > 0.0 { value / length } else { 0.5 })
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Holds the pose in f32 to the one in f64, a clip by itself.
fn agree(scene: &Scene, clip: usize, time: f64, fast: &Pose, exact: &Pose) {
    let channels = &scene.clips[clip].channels;
    let terms = |node: usize, own: &mut Terms| {
        for Channel { path, sampler, .. } in channels.iter().filter(|channel| channel.node == node) {
            match path {
                Path::Translation => own.translation = own.translation.max(2.0 * largest_term(sampler)),
                Path::Scale => own.scale = own.scale.max(2.0 * largest_term(sampler)),
                Path::Rotation => match rotation_terms(sampler, time).filter(|&terms| terms < 1e4) {
                    Some(terms) => own.rotation = terms,
                    None => return false,
                },
                Path::Weights => {}
            }
        }
        true
    };
    for (node, error) in errors(scene, exact, terms).into_iter().enumerate() {
        let Some(error) = error.filter(|error| error.size() < 1e30) else { continue };
        let (a, b) = (fast.world_from_node[node], exact.world_from_node[node]);
        assert!(a.is_finite() && b.is_finite(), "node {node} at {time}: {a} {b}");
        let difference = a - b;
        let offset = difference.w_axis.length();
        let linear = largest_entry(&DMat4 { w_axis: DVec4::ZERO, ..difference });
        let rounding = 1e-9 * error.largest + 1e-30;
        assert!(linear <= 2.0 * error.linear + rounding, "node {node} at {time}: {linear:e} of {:e}", error.linear);
        assert!(offset <= 2.0 * error.offset + rounding, "node {node} at {time}: {offset:e} of {:e}", error.offset);
    }
    let clip = &scene.clips[clip];
    for (node, (fast, exact)) in fast.weights.iter().zip(&exact.weights).enumerate() {
        let of_node =
            clip.channels.iter().filter(|it| it.node == node && it.path == Path::Weights).map(|it| &it.sampler);
        let single = clip.properties.iter().filter(|it| matches!(it.property, Property::Weight(of, _) if of == node));
        let largest = of_node.chain(single.map(|it| &it.sampler)).map(largest_term).fold(0.0, f64::max);
        for (&a, &b) in fast.iter().zip(exact) {
            assert!(a.is_finite() && b.is_finite());
            assert!(
                (a - b).abs() <= 4.0 * CURVE * largest.max(b.abs()) + 1e-30,
                "weights of node {node} at {time}: {a} {b}"
            );
        }
    }
}

/// What drives materials, lights and cameras.
fn check_properties(scene: &Scene, moderate: bool, choices: &[u8]) {
    let chosen = chosen(scene, choices);
    check_values(scene, &Properties::sample(scene, &chosen), moderate);
    for clip in 0..scene.clips.len().min(MOST_CLIPS) {
        for time in times(scene, clip) {
            let alone = Layer::new(clip, time);
            let properties = Properties::sample(scene, std::slice::from_ref(&alone));
            check_values(scene, &properties, moderate);
            let hidden: Vec<Layer> = chosen.iter().chain([&alone]).cloned().collect();
            check_values(scene, &Properties::sample(scene, &hidden), moderate);
            let beyond = Layer::new(scene.clips.len(), time);
            assert_eq!(properties, Properties::sample(scene, &[alone.clone(), beyond]));
            for other in 0..scene.clips.len().min(MOST_CLIPS) {
                for blend in [Blend::Over, Blend::Add] {
                    let without = Layer { weight: 0.0, blend, ..Layer::new(other, time) };
                    let found = Properties::sample(scene, &[alone.clone(), without]);
                    if moderate {
                        unchanged(scene, clip, &properties, &found);
                    }
                }
            }
        }
        for stack in stacks(scene, clip, 0.4 * scene.clips[clip].duration) {
            check_values(scene, &Properties::sample(scene, &stack), moderate);
        }
    }
}

/// The value of a property, where something has it.
fn value(scene: &Scene, properties: &Properties, property: Property) -> Option<Vec<f64>> {
    match property {
        Property::Material(index, property) => {
            let changed = properties.materials.iter().find(|(other, _)| *other == index).map(|(_, material)| material);
            property.get(changed.unwrap_or(&scene.materials[index]))
        }
        Property::Light(index, property) => property.get(properties.light(scene, index)),
        Property::Camera(index, property) => property.get(properties.camera(scene, index)),
        Property::Weight(..) => None,
    }
}

/// What a clip drives is the same with a layer of weight 0 above.
fn unchanged(scene: &Scene, clip: usize, alone: &Properties, found: &Properties) {
    for channel in &scene.clips[clip].properties {
        let [a, b] = [alone, found].map(|properties| value(scene, properties, channel.property));
        assert_eq!(a, b, "{:?} is changed by a layer of weight 0", channel.property);
    }
}

/// Numbers, and where moderate numbers made them, finite ones but for distances without end.
fn check_values(scene: &Scene, properties: &Properties, moderate: bool) {
    use murano_scene::{LightProperty, MaterialProperty};
    let (materials, lights, cameras) = (&properties.materials, &properties.lights, &properties.cameras);
    assert!(materials.iter().all(|(index, _)| *index < scene.materials.len()));
    assert!(lights.iter().all(|(index, _)| *index < scene.lights.len()));
    assert!(cameras.iter().all(|(index, _)| *index < scene.cameras.len()));
    for channel in scene.clips.iter().flat_map(|clip| &clip.properties) {
        let property = channel.property;
        let Some(values) = value(scene, properties, property) else { continue };
        assert_eq!(values.len(), property.width());
        let endless = matches!(
            property,
            Property::Material(_, MaterialProperty::AttenuationDistance) | Property::Light(_, LightProperty::Range)
        );
        for value in values {
            assert!(!value.is_nan(), "{property:?}");
            let rest = self::value(scene, &Properties::default(), property).unwrap_or_default();
            let was_finite = rest.iter().all(|value| value.abs() < 1e30);
            assert!(value.is_finite() || endless || !moderate || !was_finite, "{property:?}");
        }
    }
}

/// Follows every index of a geometry.
fn check_geometry(scene: &Scene, geometry: &Geometry) {
    let vertices = geometry.vertices.len();
    assert_eq!([geometry.texcoords.len(), geometry.colors.len()], [vertices; 2]);
    assert_eq!(geometry.influence_offsets.len(), vertices + 1);
    assert_eq!(*geometry.influence_offsets.last().expect("an end") as usize, geometry.influences.len());
    assert_eq!(geometry.triangles.len(), geometry.triangle_instances.len());
    assert_eq!(geometry.instances.len(), shown_primitives(scene).len());
    let (mut vertex, mut triangle, mut palette, mut words) = (0, 0, 0, 0);
    for (index, instance) in geometry.instances.iter().enumerate() {
        assert_eq!(
            [instance.vertices.start, instance.triangles.start, instance.palette.start],
            [vertex, triangle, palette]
        );
        assert_eq!(instance.morph_words, words);
        [vertex, triangle, palette] = [instance.vertices.end, instance.triangles.end, instance.palette.end];
        words += (instance.vertices.len().div_ceil(8) * instance.targets as usize) as u32;
        assert_eq!(scene.nodes[instance.node].mesh, Some(instance.mesh));
        assert!(instance.material.is_none_or(|material| material < scene.materials.len()));
        for corner in instance.triangles.clone() {
            assert_eq!(geometry.triangle_instances[corner as usize] as usize, index);
            assert!(geometry.triangles[corner as usize].iter().all(|vertex| instance.vertices.contains(vertex)));
        }
        for vertex in instance.vertices.clone() {
            let rest = geometry.vertices[vertex as usize];
            assert_eq!(rest.instance as usize, index);
            assert!(rest.position.iter().all(|value| value.is_finite()));
            assert!(if instance.flat_normals { (1..=3).contains(&rest.corner) } else { rest.corner == 0 });
            let span = &geometry.influence_offsets[vertex as usize..vertex as usize + 2];
            let influences = &geometry.influences[span[0] as usize..span[1] as usize];
            assert!(influences.iter().all(|it| it.weight > 0.0 && instance.palette.contains(&it.entry)));
            let total: f64 = influences.iter().map(|it| f64::from(it.weight)).sum();
            assert!((total - 1.0).abs() < 1e-5, "weights of vertex {vertex} sum to {total}");
        }
    }
    assert_eq!([vertex as usize, triangle as usize], [vertices, geometry.triangles.len()]);
    assert_eq!([palette as usize, words as usize], [geometry.palette_len(), geometry.morph_words.len()]);
    let mut displacements = 0;
    for word in &geometry.morph_words {
        assert!(word.moved < 256 && word.first == displacements);
        displacements += word.moved.count_ones();
    }
    assert_eq!(displacements as usize, geometry.displacements.len());
    let neighbours = geometry.neighbours();
    assert_eq!(neighbours.len(), geometry.triangles.len());
    assert!(neighbours.iter().flatten().all(|&triangle| triangle as usize <= neighbours.len()));
}

/// Deforms a geometry: lengths; where numbers are moderate, boxes hold it, and the palette makes of it what f64 makes.
fn check_deformation(scene: &Scene, geometry: &Geometry, pose: &Pose, moderate: bool) {
    let (mut targets, mut ranges) = (Vec::new(), Vec::new());
    geometry.push_active_targets(pose, &mut targets, &mut ranges);
    assert_eq!(ranges.len(), geometry.instances.len());
    let mut behind = 0;
    for (range, instance) in ranges.iter().zip(&geometry.instances) {
        assert_eq!([range.vertex, range.start, range.row], [instance.vertices.start, behind, instance.targets]);
        behind = range.end;
        let words = instance.morph_words..instance.morph_words + instance.targets;
        let active = &targets[range.start as usize..range.end as usize];
        assert!(active.iter().all(|target| words.contains(&target.word) && target.weight != 0.0));
    }
    assert_eq!(behind as usize, targets.len());

    let palette = geometry.palette(pose, DVec3::ZERO);
    assert_eq!(palette.len(), geometry.palette_rows());
    assert_eq!(geometry.mirrored(pose).len(), geometry.instances.len());
    assert_eq!(geometry.oriented_triangles(pose).len(), geometry.triangles.len());
    let deformed = deform_f64(geometry, scene, pose);
    assert_eq!([deformed.positions.len(), deformed.normals.len()], [geometry.vertices.len(); 2]);
    let boxes = geometry.posed_instance_bounds(pose);
    assert_eq!(boxes.len(), geometry.instances.len());
    let whole = geometry.posed_bounds(pose);

    for (instance, bounds) in geometry.instances.iter().zip(boxes) {
        let reach = reach(scene, pose, instance.node, instance.mesh, instance.primitive);
        if !moderate || reach >= 1e30 {
            continue;
        }
        for vertex in instance.vertices.clone().map(|vertex| vertex as usize) {
            let position = deformed.positions[vertex];
            assert!(position.is_finite() && deformed.normals[vertex].is_finite(), "vertex {vertex}");
            let roomy = bounds.widened(1e-10 * reach);
            assert!(roomy.contains(position), "vertex {vertex} at {position} is outside of {bounds:?}");
            assert!(whole.widened(1e-10 * reach).contains(position));
            if geometry.skinning == Skinning::Linear {
                let packed = packed(geometry, &palette, &targets[..], &ranges[..], vertex);
                assert!(packed.distance(position) <= 1e-5 * reach, "vertex {vertex}: {packed} is not {position}");
            }
        }
    }
}

/// How large the numbers are that a vertex of an instance is made of.
fn reach(scene: &Scene, pose: &Pose, node: usize, mesh: usize, primitive: usize) -> f64 {
    let primitive = &scene.meshes[mesh].primitives[primitive];
    let largest = |list: &[glam::Vec3]| list.iter().fold(0.0, |largest: f64, it| largest.max(it.as_dvec3().length()));
    let mut vertex = 1.0 + largest(&primitive.positions);
    for (target, weight) in primitive.targets.iter().zip(&pose.weights[node]) {
        vertex += weight.abs() * target.positions.as_deref().map_or(0.0, largest);
    }
    let of = |node: usize, inverse: &DMat4| {
        largest_entry(&pose.world_from_node[node]).max(1.0) * largest_entry(inverse).max(1.0)
    };
    let skin = scene.nodes[node].skin.map(|skin| &scene.skins[skin]);
    let joints = skin.into_iter().flat_map(|skin| skin.joints.iter().zip(&skin.inverse_bind));
    let matrices = joints.map(|(&joint, inverse)| of(joint, inverse));
    64.0 * vertex * matrices.chain([of(node, &DMat4::IDENTITY)]).fold(0.0, f64::max)
}

/// A vertex as the arrays of a geometry tell it.
fn packed(
    geometry: &Geometry,
    palette: &[[f32; 4]],
    targets: &[murano_animation::ActiveTarget],
    ranges: &[murano_animation::ActiveRange],
    vertex: usize,
) -> DVec3 {
    let rest = geometry.vertices[vertex];
    let mut position = DVec3::from_array(rest.position.map(f64::from));
    let range = &ranges[rest.instance as usize];
    let local = vertex as u32 - range.vertex;
    for target in &targets[range.start as usize..range.end as usize] {
        let word = geometry.morph_words[(target.word + local / 8 * range.row) as usize];
        let bit = 1 << (local % 8);
        if word.moved & bit != 0 {
            let index = word.first + (word.moved & (bit - 1)).count_ones();
            let [x, y, z, ..] = geometry.displacements[index as usize].map(f64::from);
            position += f64::from(target.weight) * DVec3::new(x, y, z);
        }
    }
    let span = &geometry.influence_offsets[vertex..vertex + 2];
    geometry.influences[span[0] as usize..span[1] as usize].iter().fold(DVec3::ZERO, |sum, influence| {
        let entry = 3 * influence.entry as usize;
        let row = |row: usize| {
            let [x, y, z, w] = palette[entry + row].map(f64::from);
            DVec3::new(x, y, z).dot(position) + w
        };
        sum + f64::from(influence.weight) * DVec3::new(row(0), row(1), row(2))
    })
}
