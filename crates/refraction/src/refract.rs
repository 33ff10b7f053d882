//! The refract pass, and what every pass that traces paths through a body needs.

use encase::ShaderType;
use glam::{DVec3, Mat4, Vec3, Vec4};
use murano_animation::Bounds;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, Leaf, ShaderSpec, Work, value_bytes};
use murano_optics::{Ior, absorption_coefficient, dispersed_ior, visible_spectrum};
use murano_scene::Material;
use murano_scheduler::{Output, Plan};

use crate::{
    FrameViewpoint, InterfaceMap, LISTED_TILES, MOST_INTERFACES, MOST_WAVELENGTHS, Media, Method, NormalDistance,
    Refraction, TirPolicy, over_listed_tiles, texels, tile_threads,
};

/// The optical constants of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Index of refraction relative to what is around: air, for files and the command line; below 1 in denser surroundings.
    pub ior: f64,
    /// Absorption per metre, linear RGB (KHR_materials_volume: -ln(colour) / distance).
    pub absorption: [f32; 3],
    /// Factor on what is transmitted, linear RGB.
    pub tint: [f32; 3],
    /// 20 over the Abbe number (KHR_materials_dispersion); `ior` is the index at the Fraunhofer d line.
    pub dispersion: f64,
    /// Perceptual roughness of the surface; GGX's alpha is its square.
    pub roughness: f32,
    /// Whether the body is a sheet of glass around nothing: light goes straight on through its walls (KHR_materials_transmission
    /// without the thickness of KHR_materials_volume).
    pub thin: bool,
}

impl Glass {
    /// The constants of a material.
    pub fn of(material: &Material) -> Self {
        Self {
            ior: material.ior.max(1e-3),
            // Finite, so that no length at all absorbs nothing even in opaque glass.
            absorption: absorption_coefficient(
                material.attenuation_color.as_dvec3(),
                f64::from(material.attenuation_distance),
            )
            .min(DVec3::splat(1e9))
            .as_vec3()
            .to_array(),
            tint: (material.base_color.truncate() * material.transmission).to_array(),
            dispersion: f64::from(material.dispersion),
            roughness: material.roughness,
            thin: material.thickness == 0.0,
        }
    }

    /// The index of refraction at each of the wavelengths that a picture or a caustic is made of.
    fn dispersed(&self, wavelengths: u32) -> Vec<f64> {
        let bands = visible_spectrum(wavelengths as usize);
        let n_d = Ior::new(self.ior).ok().filter(|_| self.dispersion > 0.0 && self.ior > 1.0);
        bands
            .into_iter()
            .map(|band| n_d.map_or(self.ior, |n_d| dispersed_ior(n_d, self.dispersion, band.wavelength).get()))
            .collect()
    }

    /// Whether light passes as if there were nothing.
    pub fn is_invisible(&self) -> bool {
        self.ior == 1.0 && self.absorption == [0.0; 3] && self.tint == [1.0; 3]
    }
}

#[derive(ShaderType)]
struct Search {
    bounds: Vec4,
    steps: u32,
    tir: u32,
    most_interfaces: u32,
    sample_width: f32,
    bodies: u32,
}

/// A body of several that are mapped as one (`refraction::media::Medium`).
#[derive(ShaderType)]
struct Medium {
    absorption: Vec3,
    ior: f32,
    tint: Vec3,
}

#[derive(ShaderType)]
struct Params {
    absorption: Vec3,
    ior: f32,
    tint: Vec3,
    reflection: f32,
    object: u32,
    branches: u32,
    roughness: f32,
    sample_width: f32,
    sample: u32,
    bodies: u32,
    rank: u32,
}

/// Wavelengths and what each adds to the picture (`refraction::spectrum::Spectrum`).
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct Spectrum {
    /// How many.
    pub count: u32,
    /// RGB weight; w: index of refraction.
    samples: [Vec4; MOST_WAVELENGTHS as usize],
}

impl Spectrum {
    /// `None` where all wavelengths go the same way.
    pub fn of(glass: &Glass, refraction: &Refraction) -> Option<Self> {
        let n_d = Ior::new(glass.ior).ok().filter(|_| glass.dispersion > 0.0)?;
        let count = refraction.wavelengths.min(MOST_WAVELENGTHS);
        // What is thinner than its surroundings has no formula, and the picture only one colour of each texel.
        if count <= 1 || glass.ior <= 1.0 || glass.thin || refraction.method == Method::Screen {
            return None;
        }
        let mut samples = [Vec4::ZERO; MOST_WAVELENGTHS as usize];
        for (sample, band) in samples.iter_mut().zip(visible_spectrum(count as usize)) {
            let ior = dispersed_ior(n_d, glass.dispersion, band.wavelength).get();
            *sample = DVec3::from(band.weight).extend(ior).as_vec4();
        }
        Some(Self { count, samples })
    }
}

#[derive(ShaderType)]
struct OpaqueBox {
    render_from_view: Mat4,
    low: Vec3,
    high: Vec3,
}

impl Method {
    /// The shader module that finds the second interface.
    fn module(self) -> &'static str {
        match self {
            // The picture's texels have no second interface either.
            Self::Sir | Self::Screen => "refraction::methods::sir",
            Self::Isr => "refraction::methods::isr",
            Self::Dir => "refraction::methods::dir",
            Self::Newton => "refraction::methods::newton",
            Self::Walk | Self::Layers => "refraction::methods::layers",
            Self::Exact => "refraction::methods::exact",
        }
    }
}

/// What a body's maps hold beyond what its method asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MapFeatures {
    /// [`InterfaceMap::thickness`].
    pub thickness: bool,
    /// [`InterfaceMap::relief`], and triangles to look it up on.
    pub relief: bool,
    /// And the file's own tangents.
    pub framed: bool,
    /// Whether it is of several bodies ([`Media`]).
    pub media: bool,
}

impl InterfaceMap {
    /// What it holds.
    pub fn features(&self) -> MapFeatures {
        let relief = self.relief.is_some() && (self.layer_lists.is_some() || self.tree.is_some());
        MapFeatures {
            thickness: self.thickness.is_some(),
            relief,
            framed: relief && self.geometry.tangents.is_some(),
            media: self.media.is_some(),
        }
    }
}

impl Media {
    /// Of these bodies, for passes of these settings.
    pub fn new(plan: &mut Plan<Work>, bodies: &[Glass], refraction: &Refraction) -> Self {
        let waves = refraction.wavelengths.min(MOST_WAVELENGTHS);
        let dispersed: Vec<Vec<f64>> = bodies.iter().map(|glass| glass.dispersed(waves)).collect();
        let medium = |glass: &Glass, ior: f64| Medium {
            absorption: glass.absorption.into(),
            ior: ior as f32,
            tint: glass.tint.into(),
        };
        let row = |wave: usize| bodies.iter().zip(&dispersed).map(move |(glass, iors)| medium(glass, iors[wave]));
        let plain = bodies.iter().map(|glass| medium(glass, glass.ior));
        let rows: Vec<Medium> = plain.chain((0..waves as usize).flat_map(row)).collect();
        let (stamp, leaf) = Leaf::of(&value_bytes(&rows));
        Self { rows: plan.leaf("media", stamp, Work::Leaf(leaf)), bodies: bodies.len() as u32 }
    }
}

/// The shader of a root module that imports `package::refraction::path`, with these settings' method in place.
///
/// `thin` is whether the body is a sheet ([`Glass::thin`]).
pub fn traced(root: &'static str, refraction: &Refraction, thin: bool, map: MapFeatures) -> ShaderSpec {
    ShaderSpec::new(root)
        .alias("refraction::method", refraction.method.module())
        .feature("thin", thin)
        .feature("thickness", map.thickness)
        .feature("relief", map.relief)
        .feature("framed", map.framed)
        .feature("media", map.media && refraction.reenters())
        .feature("follow", refraction.follows())
        .feature("all_interfaces", refraction.reenters())
        .feature("tree", refraction.method.traces())
        .feature("meshed", refraction.method.knows_triangles())
        .feature("view_distance", refraction.normal_distance == NormalDistance::View)
        .feature("uncorrected", refraction.uncorrected)
}

/// Gives a pass the body's maps and the search's settings, under the names that `package::refraction::maps` reads. Paths that are
/// followed on end at `most_interfaces`; a ray samples so wide a part of its texel, texels.
pub fn with_maps(
    pass: ComputePass,
    map: &InterfaceMap,
    viewpoint: &FrameViewpoint,
    bounds: &Bounds,
    refraction: &Refraction,
    most_interfaces: u32,
    sample_width: f32,
) -> ComputePass {
    let tir = match refraction.tir {
        TirPolicy::Pass => 0,
        TirPolicy::Clamp => 1,
        TirPolicy::Reflect => 2,
        TirPolicy::Trace => 3,
    };
    let search = Search {
        bounds: viewpoint.viewpoint.sphere(bounds).as_vec4(),
        steps: refraction.steps,
        tir,
        most_interfaces,
        sample_width,
        bodies: map.media.map_or(1, |media| media.bodies),
    };
    let mut pass = viewpoint.tell(pass, "map_viewpoint").value("search", &search).input("front", map.front);
    if let Some(back) = map.back {
        pass = pass.input("back", back);
    }
    if let Some(range) = map.depth_range {
        pass = pass.input("depth_range", range);
    }
    if map.layer_lists.is_some() || map.tree.is_some() {
        pass = pass
            .input("mesh_positions", map.geometry.positions)
            .input("mesh_normals", map.geometry.normals)
            .input("mesh_triangles", map.geometry.triangles);
    }
    if let (Some(media), Some(front_triangles), true) = (map.media, map.front_triangles, refraction.reenters()) {
        pass = pass.input("media", media.rows);
        if map.layer_lists.is_none() {
            pass = pass.input("front_triangles", front_triangles);
        }
    }
    if let Some(relief) = map.relief.filter(|_| map.features().relief) {
        pass = pass
            .input("texcoords", relief.texcoords)
            .input("relief_rows", relief.rows)
            .input("texture_slots", relief.texture_slots)
            .input("texels", relief.texels);
        if let Some(tangents) = map.geometry.tangents {
            pass = pass.input("tangents", tangents);
        }
    }
    if let Some(thickness) = map.thickness {
        pass = pass.input("thickness_map", thickness);
    }
    if let Some(tree) = map.tree {
        pass =
            pass.input("tree_children", tree.children).input("tree_order", tree.order).input("tree_boxes", tree.boxes);
    }
    if let Some(lists) = map.layer_lists {
        pass = pass
            .input("lists", lists.lists)
            .input("layers", lists.layers)
            .input("neighbours", map.geometry.neighbours)
            .input("cores", lists.cores);
        if let Some(hulls) = lists.hulls {
            pass = pass.input("hulls", hulls);
        }
    }
    pass
}

/// What a picture shows so far: radiance and depth, and the object of each pixel.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// `vec4f` a pixel: linear radiance, depth in metres (0: background).
    pub colour: Output,
    /// `u32` a pixel: 0 for background, else an object's number.
    pub cover: Output,
}

/// What the refract pass is told besides its maps.
pub struct RefractRequest<'a> {
    /// Tells bodies, and the times that one is drawn, apart in the plan.
    pub instance: u32,
    /// The body's number among all objects.
    pub object: u32,
    /// The eye.
    pub viewpoint: &'a FrameViewpoint,
    /// The posed body's bounds in the world.
    pub bounds: &'a Bounds,
    /// Its glass.
    pub glass: &'a Glass,
    /// Settings.
    pub refraction: &'a Refraction,
    /// Bounds of everything drawn so far: where rays that left the glass look for it.
    pub drawn: &'a Bounds,
    /// The body's nearest back faces (`InterfaceMap::back`), where the method's own map holds others and the eye may be
    /// inside the body.
    pub inside_map: Option<Output>,
    /// Two `vec4f` a pixel, of its first interface, in place of the glass's own: linear RGB factor of what it transmits, perceptual
    /// roughness; outward normal in view space, zero where no map bends it.
    pub surface: Option<Output>,
    /// Whether any part of the body is rough.
    pub rough: bool,
    /// Side of what a ray samples of its pixel, pixels: 1 where it is the pixel's only one.
    pub sample_width: f32,
    /// Which of the pixel's samples it is, from 0; `None` for the only one. Of several, the last of the paths that are followed carries
    /// all light that is left and goes one way at each interface, by chance.
    pub sample: Option<u32>,
    /// The body's turn among others; `None` where it is in front of all that is drawn before it.
    pub turn: Option<Turn>,
    /// Whether to write the paths.
    pub aov: bool,
}

/// How far the first interfaces of some bodies lie.
#[derive(Clone, Copy, Debug)]
pub struct Firsts {
    /// `f32` a pixel and body, a pixel's side by side: depth, metres; 0 where it has none.
    depths: Output,
    /// How many.
    bodies: u32,
}

/// Of bodies that have no order but each pixel's own, one is drawn into those pixels where it is the farthest that is still to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Of all of them.
    pub firsts: Firsts,
    /// Which one, in the order of `firsts`.
    pub rank: u32,
}

/// Adds the pass `firsts:instance`: how far a body's first interface lies, beside those of others `before` it; by a unit in the last place
/// nearer than one of theirs in place of as far.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn first_interfaces(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    map: &InterfaceMap,
    before: Option<Firsts>,
    request: &RefractRequest<'_>,
) -> Result<Firsts, GpuError> {
    let spec = ShaderSpec::new("refraction::firsts")
        .feature("thin", request.glass.thin)
        .feature("inside_map", request.inside_map.is_some())
        .feature("has_before", before.is_some());
    let shader = gpu.shader(&spec)?;
    let size = request.viewpoint.viewpoint.size;
    let bodies = before.map_or(0, |before| before.bodies);
    let mut pass = ComputePass::new("firsts", request.instance)
        .value("bodies_before", &bodies)
        .output("firsts", 4 * u64::from(bodies + 1) * texels(size));
    if let Some(before) = before {
        pass = pass.input("firsts_before", before.depths);
    }
    if let Some(inside_map) = request.inside_map {
        pass = pass.input("inside_map", inside_map);
    }
    let ball = request.viewpoint.viewpoint.sphere(request.bounds).as_vec4();
    let mut pass = request
        .viewpoint
        .tell(pass, "map_viewpoint")
        .value("search", &Search { bounds: ball, steps: 0, tir: 0, most_interfaces: 0, sample_width: 1.0, bodies: 1 })
        .input("front", map.front);
    if let Some(back) = map.back {
        pass = pass.input("back", back);
    }
    let depths = pass.dispatch(&shader, "main", Groups::tiles(size)).add_to(plan)?[0];
    Ok(Firsts { depths, bodies: bodies + 1 })
}

/// `vec4f` rows a pixel of the paths output.
pub const PATH_ROWS: usize = 7;

/// Adds the pass `refract:instance`: draws a body over what lies behind it. Returns the new picture and, where asked for,
/// the paths: [`PATH_ROWS`] rows of `vec4f` a pixel, positions relative to the origin.
///
/// A ray that begins inside the body (the eye is in the glass, or the near plane cuts it) meets one interface, exactly. Its
/// path begins on the near plane and has no first normal. An eye outside that meets the body from behind, because it is open
/// or turned inside out, finds the status "lost" unless the path it followed ends on a surface that the map shows.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn refract(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    map: &InterfaceMap,
    behind: Layered,
    environment: Output,
    request: &RefractRequest<'_>,
) -> Result<(Layered, Option<Output>), GpuError> {
    let spectrum = Spectrum::of(request.glass, request.refraction);
    let spec = traced("refraction::refract", request.refraction, request.glass.thin, map.features())
        .feature("screen", request.refraction.method == Method::Screen)
        .feature("dispersive", spectrum.is_some())
        .feature("surface_map", request.surface.is_some())
        .feature("rough", request.rough && request.refraction.method != Method::Screen)
        .feature("aov", request.aov)
        .feature("inside_map", request.inside_map.is_some())
        .feature("among", request.turn.is_some())
        .feature(
            "by_chance",
            request.sample.is_some() && !request.glass.thin && request.refraction.branches_followed() > 1,
        );
    let shader = gpu.shader(&spec)?;
    let FrameViewpoint { viewpoint, origin, .. } = request.viewpoint;
    let margin = DVec3::splat(1e-3 * request.drawn.diameter().min(request.bounds.diameter()));
    let opaque_box = OpaqueBox {
        render_from_view: viewpoint.view_from_render(*origin).inverse().as_mat4(),
        low: (request.drawn.min - margin - origin).as_vec3(),
        high: (request.drawn.max + margin - origin).as_vec3(),
    };
    let params = Params {
        absorption: request.glass.absorption.into(),
        ior: request.glass.ior as f32,
        tint: request.glass.tint.into(),
        reflection: f32::from(u8::from(request.refraction.reflection)),
        object: request.object,
        branches: request.refraction.branches_followed(),
        roughness: request.glass.roughness,
        sample_width: request.sample_width,
        sample: request.sample.unwrap_or(0),
        bodies: request.turn.map_or(0, |turn| turn.firsts.bodies),
        rank: request.turn.map_or(0, |turn| turn.rank),
    };
    let count = texels(viewpoint.size);
    let pass = ComputePass::new("refract", request.instance)
        .value("params", &params)
        .value("opaque_box", &opaque_box)
        .input("behind", behind.colour)
        .input("cover_behind", behind.cover)
        .input("environment", environment)
        .output("colour", 16 * count)
        .output("cover", 4 * count);
    let most_interfaces = request.refraction.most_interfaces.clamp(2, MOST_INTERFACES);
    let mut pass = with_maps(
        pass,
        map,
        request.viewpoint,
        request.bounds,
        request.refraction,
        most_interfaces,
        request.sample_width,
    );
    if let Some(surface) = request.surface {
        pass = pass.input("glass_surface", surface);
    }
    if let Some(spectrum) = &spectrum {
        pass = pass.value("spectrum", spectrum);
    }
    if let Some(inside_map) = request.inside_map {
        pass = pass.input("inside_map", inside_map);
    }
    if let Some(turn) = &request.turn {
        pass = pass.input("firsts", turn.firsts.depths);
    }
    if request.aov {
        pass = pass.cleared_output("paths", 16 * PATH_ROWS as u64 * count);
    }
    pass = over_listed_tiles(pass, viewpoint.size).dispatch(&shader, "list", tile_threads(viewpoint.size)).dispatch(
        &shader,
        "main",
        LISTED_TILES,
    );
    if request.refraction.follows() {
        let chaos = gpu.shader(&ShaderSpec::new("refraction::chaos"))?;
        pass = pass
            .value("sample_width", &request.sample_width)
            .scratch("looked", 32 * count)
            .dispatch(&chaos, "find_chaos", LISTED_TILES)
            .dispatch(&chaos, "settle", LISTED_TILES);
    }
    let outputs = pass.add_to(plan)?;
    Ok((Layered { colour: outputs[0], cover: outputs[1] }, outputs.get(2).copied()))
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;
    use crate::Interfaces;

    /// With everything that a body, its glass and the settings may ask for at once.
    #[test]
    fn no_shader_needs_more_buffers_than_there_may_be() {
        for method in Method::ALL {
            let refraction =
                Refraction { method, tir: TirPolicy::Trace, interfaces: Interfaces::All, ..Refraction::default() };
            let relief = method.knows_triangles();
            let map = MapFeatures { thickness: refraction.bakes(), relief, framed: relief, media: relief };
            let spec = traced("refraction::refract", &refraction, false, map)
                .feature("dispersive", method != Method::Screen)
                .feature("screen", method == Method::Screen)
                .feature("surface_map", true)
                .feature("rough", method != Method::Screen)
                .feature("aov", true)
                .feature("among", true)
                .feature("inside_map", !relief)
                .feature("by_chance", refraction.branches_followed() > 1);
            if let Err(error) = Shader::link(&spec) {
                panic!("{}: {error}", method.name());
            }
        }
    }

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let combinations = Method::ALL.into_iter().flat_map(|method| {
            let with = move |tir, interfaces| Refraction { method, tir, interfaces, ..Refraction::default() };
            [
                (TirPolicy::Pass, Interfaces::Two),
                (TirPolicy::Trace, Interfaces::Two),
                (TirPolicy::Trace, Interfaces::All),
            ]
            .map(|(tir, interfaces)| with(tir, interfaces))
        });
        for refraction in combinations {
            let map = MapFeatures { thickness: refraction.bakes(), ..MapFeatures::default() };
            let spec = traced("refraction::refract", &refraction, false, map)
                .feature("screen", refraction.method == Method::Screen)
                .feature("dispersive", refraction.method != Method::Screen);
            let shader = Shader::link(&spec).unwrap();
            if refraction.method != Method::Screen {
                let samples = std::array::from_fn(|i| Vec4::splat(i as f32 + 2.0));
                check_uniform_layout!(shader, "Spectrum", Spectrum { count: 1, samples: samples }).unwrap();
            }
            check_uniform_layout!(
                shader,
                "Search",
                Search {
                    bounds: Vec4::new(1.0, 2.0, 3.0, 4.0),
                    steps: 5,
                    tir: 6,
                    most_interfaces: 7,
                    sample_width: 8.0,
                    bodies: 9,
                }
            )
            .unwrap();
            if refraction.reenters() && refraction.method.knows_triangles() {
                let map = MapFeatures { media: true, ..map };
                let shader = Shader::link(&traced("refraction::refract", &refraction, false, map)).unwrap();
                let (absorption, tint) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(5.0, 6.0, 7.0));
                check_uniform_layout!(shader, "Medium", Medium { absorption: absorption, ior: 4.0, tint: tint })
                    .unwrap();
            }
            check_uniform_layout!(
                shader,
                "Params",
                Params {
                    absorption: Vec3::new(1.0, 2.0, 3.0),
                    ior: 4.0,
                    tint: Vec3::new(5.0, 6.0, 7.0),
                    reflection: 8.0,
                    object: 9,
                    branches: 10,
                    roughness: 11.0,
                    sample_width: 12.0,
                    sample: 13,
                    bodies: 14,
                    rank: 15,
                }
            )
            .unwrap();
            check_uniform_layout!(
                shader,
                "OpaqueBox",
                OpaqueBox {
                    render_from_view: Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0)),
                    low: Vec3::new(1.0, 2.0, 3.0),
                    high: Vec3::new(4.0, 5.0, 6.0),
                }
            )
            .unwrap();
        }
    }
}
