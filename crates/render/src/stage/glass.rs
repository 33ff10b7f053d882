//! What a shot says about glass, applied to a model's materials.

use glam::{Vec3, Vec4};
use murano_scene::{GlassBodies, Material, MaterialProperty, Primitive, Property, Scene, ShotGlass};

/// Turns materials into glass and gives every glass the shot's values, at all times: clips drive no longer what the shot says.
///
/// # Errors
/// The name of a material that the model does not have.
pub fn apply(glass: &ShotGlass, scene: &mut Scene) -> Result<(), String> {
    let filed: Vec<bool> = scene.materials.iter().map(Material::is_glass).collect();
    match &glass.bodies {
        GlassBodies::AsFiled => {}
        GlassBodies::All => {
            name_the_default_material(scene);
            remove_paint(scene, |_| true);
            scene.materials.iter_mut().for_each(make_glass);
        }
        GlassBodies::Named(names) => {
            remove_paint(scene, |material| names.contains(&material.name));
            for name in names {
                let mut named = scene.materials.iter_mut().filter(|material| &material.name == name).peekable();
                if named.peek().is_none() {
                    return Err(name.clone());
                }
                named.for_each(make_glass);
            }
        }
    }
    let at_times = glass_at_times(scene);
    let glassy =
        scene.materials.iter_mut().zip(&at_times).filter(|(material, at_times)| material.is_glass() || **at_times);
    for (material, _) in glassy {
        material.ior = glass.ior.unwrap_or(material.ior);
        material.attenuation_color = glass.attenuation_color.map_or(material.attenuation_color, Vec3::from_array);
        material.attenuation_distance = glass.attenuation_distance.unwrap_or(material.attenuation_distance);
        material.dispersion = glass.dispersion.unwrap_or(material.dispersion);
        if let Some(roughness) = glass.roughness {
            material.roughness = roughness;
            material.metallic_roughness_texture = None;
        }
        if let Some(thin) = glass.thin {
            // Only whether it is 0 matters: bodies are as thick as they are.
            material.thickness = if thin { 0.0 } else { material.thickness.max(1.0) };
        }
    }
    release(glass, scene, &filed);
    Ok(())
}

/// Which materials some clip makes glass.
fn glass_at_times(scene: &Scene) -> Vec<bool> {
    let mut glass = vec![false; scene.materials.len()];
    for channel in scene.clips.iter().flat_map(|clip| &clip.properties) {
        if let Property::Material(index, MaterialProperty::Transmission) = channel.property {
            glass[index] |= channel.sampler.values.iter().any(|value| *value > 0.0);
        }
    }
    glass
}

/// Takes from the clips what the shot sets of glass, and of what it has made glass all that was painted on it. `filed` tells what was
/// glass before.
fn release(glass: &ShotGlass, scene: &mut Scene, filed: &[bool]) {
    use MaterialProperty as M;
    let at_times = glass_at_times(scene);
    let is_glass: Vec<bool> =
        scene.materials.iter().zip(at_times).map(|(material, at_times)| material.is_glass() || at_times).collect();
    let set = |property: MaterialProperty| match property {
        M::Ior => glass.ior.is_some(),
        M::AttenuationColor => glass.attenuation_color.is_some(),
        M::AttenuationDistance => glass.attenuation_distance.is_some(),
        M::Dispersion => glass.dispersion.is_some(),
        M::Roughness => glass.roughness.is_some(),
        M::Thickness => glass.thin.is_some(),
        _ => false,
    };
    let painted = |property: MaterialProperty| {
        !matches!(property, M::Ior | M::AttenuationColor | M::AttenuationDistance | M::Dispersion | M::NormalScale)
    };
    for clip in &mut scene.clips {
        clip.properties.retain(|channel| {
            let Property::Material(index, property) = channel.property else { return true };
            let made = scene.materials[index].is_glass() && !filed.get(index).copied().unwrap_or(false);
            !(is_glass[index] && set(property) || made && painted(property))
        });
    }
}

/// Puts the material that primitives without one use into the list, so that it can be changed.
fn name_the_default_material(scene: &mut Scene) {
    let default = scene.materials.len();
    let primitives = scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives);
    let without: Vec<_> = primitives.filter(|primitive| primitive.material.is_none()).collect();
    if without.is_empty() {
        return;
    }
    for primitive in without {
        primitive.material = Some(default);
    }
    scene.materials.push(Material::default());
}

/// Removes the vertex colours of what is opaque so far and is to become glass.
fn remove_paint(scene: &mut Scene, becomes_glass: impl Fn(&Material) -> bool) {
    let materials = &scene.materials;
    let painted = |primitive: &&mut Primitive| {
        let material = primitive.material.and_then(|index| materials.get(index));
        material.is_some_and(|material| !material.is_glass() && becomes_glass(material))
    };
    let primitives = scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives);
    primitives.filter(painted).for_each(|primitive| primitive.colors = None);
}

/// An opaque material's own look would hide the refraction: what was painted on it goes, its name, normal map and index
/// of refraction stay. A material that transmits light already is left as filed.
fn make_glass(material: &mut Material) {
    if material.is_glass() {
        return;
    }
    *material = Material {
        name: material.name.clone(),
        normal_texture: material.normal_texture,
        normal_scale: material.normal_scale,
        base_color: Vec4::ONE,
        ..Material::glass(material.ior)
    };
}

#[cfg(test)]
mod tests {
    use murano_scene::{Clip, Interpolation, Mesh, PropertyChannel, Sampler};

    use super::*;

    fn scene() -> Scene {
        let primitive = |material| Primitive { material, ..Primitive::default() };
        let material = |name: &str| Material { name: name.into(), ..Material::default() };
        Scene {
            materials: vec![material("fur"), Material { ior: 1.3, ..Material::glass(1.3) }],
            meshes: vec![Mesh { primitives: vec![primitive(Some(0)), primitive(None)], ..Mesh::default() }],
            ..Scene::default()
        }
    }

    #[test]
    fn all_bodies_become_glass_even_without_a_material() {
        let mut scene = scene();
        apply(&ShotGlass { bodies: GlassBodies::All, ior: Some(1.7), ..ShotGlass::default() }, &mut scene).unwrap();
        assert!(scene.materials.iter().all(|material| material.is_glass() && material.ior == 1.7));
        assert_eq!(scene.meshes[0].primitives[1].material, Some(2));
        assert_eq!(scene.materials[0].name, "fur");
    }

    #[test]
    fn only_the_named_become_glass() {
        let mut scene = scene();
        let named = |name: &str| ShotGlass { bodies: GlassBodies::Named(vec![name.into()]), ..ShotGlass::default() };
        assert_eq!(apply(&named("wood"), &mut scene), Err("wood".into()));
        apply(&named("fur"), &mut scene).unwrap();
        assert!(scene.materials[0].is_glass());
        assert_eq!(scene.materials.len(), 2);
    }

    #[test]
    fn clips_drive_no_longer_what_the_shot_sets() {
        use MaterialProperty as M;
        let driven = |glass: ShotGlass| {
            let mut scene = scene();
            let sampler =
                || Sampler { interpolation: Interpolation::Step, times: vec![0.0], width: 1, values: vec![0.5] };
            let channel = |(index, property)| PropertyChannel {
                property: Property::Material(index, property),
                sampler: sampler(),
            };
            let all = [(0, M::BaseColor), (0, M::Ior), (1, M::BaseColor), (1, M::Ior), (1, M::Roughness)];
            scene.clips = vec![Clip { properties: all.map(channel).into(), ..Clip::default() }];
            apply(&glass, &mut scene).unwrap();
            scene.clips[0].properties.iter().map(|channel| channel.property).collect::<Vec<_>>()
        };
        let all = [(0, M::BaseColor), (0, M::Ior), (1, M::BaseColor), (1, M::Ior), (1, M::Roughness)];
        let of = |places: &[usize]| places.iter().map(|&k| Property::Material(all[k].0, all[k].1)).collect::<Vec<_>>();
        assert_eq!(driven(ShotGlass::default()), of(&[0, 1, 2, 3, 4]));
        assert_eq!(driven(ShotGlass { ior: Some(1.7), ..ShotGlass::default() }), of(&[0, 1, 2, 4]));
        assert_eq!(driven(ShotGlass { bodies: GlassBodies::All, ..ShotGlass::default() }), of(&[1, 2, 3, 4]));
    }

    #[test]
    fn filed_glass_keeps_its_index_unless_told() {
        let mut scene = scene();
        apply(&ShotGlass::default(), &mut scene).unwrap();
        assert_eq!(scene.materials[1].ior, 1.3);
        assert!(!scene.materials[0].is_glass());
    }
}
