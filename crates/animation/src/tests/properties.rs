//! Materials and lights under layers.

use murano_scene::{
    Clip, Interpolation, Light, LightKind, LightProperty, Material, MaterialProperty, Property, PropertyChannel,
    Sampler, Scene,
};

use crate::{Blend, Layer, Properties};

const DISTANCE: Property = Property::Material(0, MaterialProperty::AttenuationDistance);
const INNER: Property = Property::Light(0, LightProperty::InnerCone);
const OUTER: Property = Property::Light(0, LightProperty::OuterCone);

/// A material without attenuation and a spot, with clips that drive properties from one value to another in a second.
fn scene(clips: &[&[(Property, [f32; 2])]]) -> Scene {
    let spot = LightKind::Spot { inner: 0.25, outer: 0.5 };
    let light = Light { name: String::new(), kind: spot, color: glam::Vec3::ONE, intensity: 1.0, range: f32::INFINITY };
    let channel = |&(property, values): &(Property, [f32; 2])| PropertyChannel {
        property,
        sampler: Sampler {
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            width: 1,
            values: values.to_vec(),
        },
    };
    let clip = |driven: &&[(Property, [f32; 2])]| Clip {
        properties: driven.iter().map(channel).collect(),
        duration: 1.0,
        ..Clip::default()
    };
    Scene {
        materials: vec![Material::default()],
        lights: vec![light],
        clips: clips.iter().map(clip).collect(),
        ..Scene::default()
    }
}

#[test]
fn what_is_infinite_at_rest_stays_a_number() {
    let scene = scene(&[&[(DISTANCE, [1.0, 3.0])], &[(INNER, [0.1, 0.2])]]);
    assert_eq!(scene.materials[0].attenuation_distance, f32::INFINITY);
    let distance = |above: Layer| {
        let properties = Properties::sample(&scene, &[Layer::new(0, 0.5), above]);
        properties.materials[0].1.attenuation_distance
    };
    // The second clip says nothing of it: at rest it is infinite.
    let other = |weight: f64, blend: Blend| Layer { weight, blend, ..Layer::new(1, 0.5) };
    for without in [0.0, f64::NAN, f64::INFINITY] {
        assert_eq!(distance(other(without, Blend::Over)), 2.0, "over at {without}");
        assert_eq!(distance(other(without, Blend::Add)), 2.0, "added at {without}");
    }
    assert_eq!(distance(other(0.5, Blend::Add)), 2.0);
    assert_eq!([0.5, 1.0].map(|weight| distance(other(weight, Blend::Over))), [4.0, f32::INFINITY]);
    assert_eq!(distance(Layer { weight: 0.5, ..Layer::new(0, 1.0) }), 2.4);
}

#[test]
fn a_distance_that_is_not_above_zero_is_infinite_and_no_layer_makes_it_no_number() {
    let scene = scene(&[&[(DISTANCE, [2.0, 2.0])], &[(DISTANCE, [0.0, -2.0])]]);
    for (time, blend) in [(0.0, Blend::Over), (1.0, Blend::Over), (0.0, Blend::Add), (1.0, Blend::Add)] {
        let distance = |weight: f64| {
            let playing = [Layer::new(0, 0.0), Layer { weight, blend, ..Layer::new(1, time) }];
            Properties::sample(&scene, &playing).materials[0].1.attenuation_distance
        };
        let expected = if blend == Blend::Over { [2.0, 4.0, f32::INFINITY] } else { [2.0; 3] };
        assert_eq!([0.0, 0.5, 1.0].map(distance), expected, "{blend:?} at {time}");
    }
}

#[test]
fn an_inner_cone_is_held_to_the_outer_one_of_the_moment() {
    let [inner, outer] = [(INNER, [0.0, 0.8]), (OUTER, [0.5, 1.0])];
    for order in [[inner, outer], [outer, inner]] {
        let scene = scene(&[&order]);
        let properties = Properties::sample(&scene, &[Layer::new(0, 1.0)]);
        assert_eq!(properties.light(&scene, 0).kind, LightKind::Spot { inner: 0.8, outer: 1.0 });
    }
}
