//! Emission and deposit: two passes with keys of their own, so that a moved receiver costs a deposit and a camera nothing.

use encase::ShaderType;
use glam::{Mat4, UVec2, Vec3};
use murano_animation::Bounds;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{
    FrameViewpoint, Glass, InterfaceMap, Interfaces, Refraction, Spectrum, Viewpoint, texels, traced, with_maps,
};
use murano_scheduler::{Output, Plan};

use crate::{Caster, Caustics, Lamp, Method};

/// Bytes of a photon: origin, flux, direction, length.
const PHOTON_BYTES: u64 = 32;
/// Bytes of a photon's differential: entry and cell, bounces, a 3x2 matrix of points and one of directions.
const DIFFERENTIAL_BYTES: u64 = 96;
/// Bins of the light along both axes of the lamp's view.
const MARGINAL_BYTES: u64 = 2 * 4 * 256;
/// Interfaces that a photon may meet: light that is reflected many times still counts where it lands.
const MOST_INTERFACES: u32 = 64;
/// Levels of a caustic map.
const LEVELS: u64 = 2;
/// Of levels coarser than those, each by a factor of two, in which soft footprints are laid down: what brings it down to the next finer.
const REFINEMENTS: [&str; 3] = ["refine_first", "refine_second", "refine_third"];
/// Sums of each, over 1 to 32 texels along a side.
const MIPS: u32 = 6;
/// Bytes of a landing: texel, what part of it lands, a 2x2 matrix.
const LANDING_BYTES: u64 = 32;
/// Fixed-point units that the whole grid may carry.
const CAPACITY: u64 = 1 << 30;
// Even if all of it met in one texel, with what rounding adds to each of the most photons that can be counted, u32 could hold it.
const _: () = assert!(CAPACITY + u32::MAX as u64 / 2 < u32::MAX as u64);

#[derive(ShaderType)]
struct EmitParams {
    render_from_view: Mat4,
    ior: f32,
    photons: u32,
    mirrored: u32,
    branches: u32,
    two_only: u32,
}

#[derive(ShaderType)]
struct LandingParams {
    receivers_from_caster: Mat4,
    photon_count: u32,
    units: f32,
    reach: f32,
    photons: u32,
    mirrored: u32,
    part_of_wave: f32,
    layer: u32,
}

#[derive(ShaderType)]
struct DepositParams {
    absorption: Vec3,
    photons: u32,
    tint: Vec3,
    units: f32,
    size: UVec2,
    grids: u32,
    mirrored: u32,
    branches: u32,
    map_size: u32,
}

#[derive(ShaderType)]
struct DetailParams {
    size: UVec2,
}

#[derive(ShaderType)]
struct ComposeParams {
    size: UVec2,
}

#[derive(ShaderType)]
struct PyramidParams {
    size: UVec2,
}

#[derive(ShaderType)]
struct ResolveParams {
    size: UVec2,
    watts: f32,
}

#[derive(ShaderType)]
struct Kernel {
    size: UVec2,
    watts: f32,
    sigma: f32,
}

/// One caster under one lamp.
pub struct Cast<'a> {
    /// Tells the pairs apart in the plan.
    pub instance: u32,
    /// The lamp.
    pub lamp: &'a Lamp,
    /// The lamp's view of the caster.
    pub viewpoint: &'a FrameViewpoint,
    /// The caster's map from there.
    pub map: &'a InterfaceMap,
    /// The posed caster's bounds in the world.
    pub bounds: &'a Bounds,
    /// What it is made of.
    pub caster: &'a Caster,
    /// Two `vec4f` a texel of the map, of its first interface: linear RGB factor of what it transmits, in place of the glass's, and
    /// roughness; outward normal in view space, zero where no map bends it.
    pub surface: Option<Output>,
    /// What other casters leave of the lamp's light on it ([`shield`](crate::shield)), where any may stand in that.
    pub shielded: Option<Output>,
    /// Whether any map bends its normals.
    pub bends: bool,
    /// Whether its surface is made of facets, whose light has steps.
    pub faceted: bool,
}

impl Cast<'_> {
    /// The lamp's view of the receivers.
    pub(crate) fn receivers(&self) -> FrameViewpoint {
        self.lamp.receivers.in_frame(self.viewpoint.origin)
    }
}

/// What a lamp sees of all that is opaque, and what that hides from it.
#[derive(Clone, Copy, Debug)]
pub struct Receivers {
    /// `vec4f` a texel: normal in the lamp's view space, depth.
    pub seen: Output,
    /// Behind it ([`Layers::Behind`](murano_refraction::Layers::Behind)): the next front, as `seen`, and the next back.
    pub hidden: Option<[Output; 2]>,
}

/// Some of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surfaces {
    /// Those that the lamp sees.
    Seen,
    /// Those that these hide, where [`Receivers::hidden`] knows them.
    Hidden,
}

/// What the pass `emit` provides.
#[derive(Clone, Copy, Debug)]
pub struct Photons {
    /// `caustics::photon::Photon`, a cell of a grid each, grid after grid.
    rays: Output,
    /// `caustics::photon::PhotonDifferential` of each, where the method wants them.
    differentials: Option<Output>,
    /// `vec4f` of each: linear RGB that the glass leaves of it, where it may be of several bodies.
    colours: Option<Output>,
    grids: Grids,
}

impl Photons {
    /// One grid of photons whose paths are known: `caustics::photon::Photon`, row after row, and as many
    /// `caustics::photon::PhotonDifferential`, for beams and footprints.
    pub fn followed_elsewhere(rays: Output, differentials: Option<Output>) -> Self {
        let grids = Grids { mirrored: 0, branches: 1, spectrum: None, rest: 0 };
        Self { rays, differentials, colours: None, grids }
    }
}

/// The grids of photons: what light of a cell becomes.
#[derive(Clone, Copy, Debug)]
struct Grids {
    /// 1 where the first is of what the first interface mirrors.
    mirrored: u32,
    /// Of each wavelength.
    branches: u32,
    spectrum: Option<Spectrum>,
    /// 1 where the last is of what the wavelengths leave aside, of one of them a cell.
    rest: u32,
}

impl Grids {
    fn of(caster: &Caster, caustics: &Caustics, refraction: &Refraction) -> Self {
        match caster {
            Caster::Glass(glass) => Self::of_glass(glass, caustics, refraction),
            Caster::Mirror(_) => Self { mirrored: 1, branches: 0, spectrum: None, rest: 0 },
        }
    }

    fn of_glass(glass: &Glass, caustics: &Caustics, refraction: &Refraction) -> Self {
        let all = caustics.interfaces == Interfaces::All;
        let spectrum = Spectrum::of(glass, refraction);
        let branches = if all { refraction.branches_followed() } else { 1 };
        let mirrored = u32::from(all && refraction.reflection);
        match spectrum {
            None => Self { mirrored, branches, spectrum, rest: 0 },
            // A grid of each of 16 wavelengths is as much as the smallest adapters' buffers hold.
            Some(_) => Self { mirrored, branches: 1, spectrum, rest: u32::from(branches > 1 && !glass.thin) },
        }
    }

    /// Whether the last path of a cell goes by chance.
    fn end_by_chance(&self) -> bool {
        self.branches > 1 || self.rest > 0
    }

    fn count(&self) -> u32 {
        self.mirrored + self.branches * self.waves() + self.rest
    }

    fn waves(&self) -> u32 {
        self.spectrum.map_or(1, |spectrum| spectrum.count)
    }
}

/// Deposited caustics of one cast.
#[derive(Clone, Copy, Debug)]
pub struct CausticMap {
    /// Watts a texel for a lamp of intensity 1, as [`watts`](Self::watts) reads them. Of the lamp's receiver viewpoint, then of as many
    /// texels the part of it where the light lands. Each is followed by its sums over 2 to 32 texels along a side ([`level_texels`] in
    /// all).
    pub flux: Output,
    /// Whether all channels are equal: nothing that the light meets is coloured.
    pub monochrome: bool,
    /// `f32` a texel of both, first: the part of the range of fixed-point sums that its fullest channel takes.
    pub range: Output,
    /// Where that part lies, four `f32`: its corner in texels of the whole view, and its texels over those of the whole view.
    pub detail: Output,
    /// Two `u32`: fixed-point flux sent out of the glass and landed, before absorption.
    pub account: Output,
    /// Watts per fixed-point unit of `account`.
    pub watts_per_unit: f64,
}

impl CausticMap {
    /// RGB of a texel in the words of [`flux`](Self::flux): one `f32` where all channels are equal; else their sum, `f32`, and 16 bits
    /// each for the shares of red and green in it.
    pub fn watts(&self, words: &[u32], texel: usize) -> [f32; 3] {
        if self.monochrome {
            return [f32::from_bits(words[texel]); 3];
        }
        let shares = words[2 * texel + 1];
        let [red, green] = [shares & 0xffff, shares >> 16].map(|share| share as f32 / 65535.0);
        [red, green, (1.0 - red - green).max(0.0)].map(|share| share * f32::from_bits(words[2 * texel]))
    }
}

/// Texels a side of the light's interface map: a multiple of the photons, so that each photon's ray goes through the centre of a
/// texel, fine enough for the search.
pub fn light_map_size(photons: u32) -> u32 {
    photons * 320_u32.div_ceil(photons)
}

/// Texels of one level of a caustic map with its sums.
pub fn level_texels(size: [u32; 2]) -> u64 {
    texels_before(size, MIPS)
}

/// Texels of one level before its sums over 2^mip texels along a side.
pub(crate) fn texels_before(size: [u32; 2], mip: u32) -> u64 {
    (0..mip.min(MIPS)).map(|mip| texels(size.map(|side| side.div_ceil(1 << mip)))).sum()
}

/// Texels along the sides of a level that is coarser by 2^shift, with a ring around the view.
fn coarse_size(size: [u32; 2], shift: u32) -> [u32; 2] {
    size.map(|side| side.div_ceil(1 << shift) + 2)
}

/// Texels of all coarser levels.
fn coarse_texels(size: [u32; 2]) -> u64 {
    (1..).zip(REFINEMENTS).map(|(shift, _)| texels(coarse_size(size, shift))).sum()
}

/// The most flux that a viewpoint's picture can carry for a lamp of intensity 1, watts.
fn most_flux(viewpoint: &Viewpoint) -> f64 {
    4.0 * viewpoint.half_extent.x * viewpoint.half_extent.y
}

/// Adds the pass `emit:instance`: photons that left the glass. Neither receivers nor the camera nor the light's colour
/// are among its inputs.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn emit(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    cast: &Cast<'_>,
    caustics: &Caustics,
    refraction: &Refraction,
) -> Result<Photons, GpuError> {
    let differentials = caustics.method.wants_differentials();
    let (thin, ior, mirror) = match cast.caster {
        Caster::Glass(glass) => (glass.thin, glass.ior, false),
        Caster::Mirror(_) => (false, 1.0, true),
    };
    let spec = traced("caustics::emit", refraction, thin, cast.map.features());
    let grids = Grids::of(cast.caster, caustics, refraction);
    let spec = spec.feature("differentials", differentials).feature("dispersive", grids.spectrum.is_some());
    let spec = spec.feature("by_chance", !mirror && !thin && grids.end_by_chance());
    let media = cast.map.media.is_some();
    let bent = cast.surface.filter(|_| cast.bends || media);
    let spec = spec.feature("mirror", mirror).feature("surface_map", bent.is_some());
    let spec = spec.feature("shielded", cast.shielded.is_some());
    let shader = gpu.shader(&spec)?;
    let params = EmitParams {
        render_from_view: cast.viewpoint.viewpoint.view_from_render(cast.viewpoint.origin).inverse().as_mat4(),
        ior: ior as f32,
        photons: caustics.photons,
        mirrored: grids.mirrored,
        branches: grids.branches,
        two_only: u32::from(caustics.interfaces == Interfaces::Two),
    };
    let count = u64::from(grids.count()) * texels([caustics.photons; 2]);
    let mut pass = ComputePass::new("emit", cast.instance)
        .value("params", &params)
        .value("lamp", &cast.lamp.emission(&cast.viewpoint.viewpoint))
        .output("photons", PHOTON_BYTES * count);
    if differentials {
        pass = pass.cleared_output("differentials", DIFFERENTIAL_BYTES * count);
    }
    if media {
        pass = pass.cleared_output("colours", 16 * count);
    }
    if let Some(shielded) = cast.shielded {
        pass = pass.input("shielded", shielded);
    }
    if let Some(bent) = bent {
        pass = pass.input("glass_surface", bent);
    }
    if let Some(spectrum) = &grids.spectrum {
        pass = pass.value("spectrum", spectrum);
    }
    // Of a photon's cell little: its differential tells the rest.
    let sampled = 0.25 * cast.viewpoint.viewpoint.size[0] as f32 / caustics.photons as f32;
    let outputs = with_maps(pass, cast.map, cast.viewpoint, cast.bounds, refraction, MOST_INTERFACES, sampled)
        .dispatch(&shader, "main", Groups::tiles([caustics.photons; 2]))
        .add_to(plan)?;
    let (colours, rest) = if media {
        outputs.split_last().map_or((None, &[][..]), |(last, rest)| (Some(*last), rest))
    } else {
        (None, &outputs[..])
    };
    Ok(Photons { rays: rest[0], differentials: rest.get(1).copied(), colours, grids })
}

/// Adds the pass `deposit:instance`, or `deposit_hidden:instance`: lands the photons on the receivers that the lamp sees, or on those that
/// these hide, and sums their flux.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn deposit(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    cast: &Cast<'_>,
    caustics: &Caustics,
    photons: Photons,
    (receivers, on): (&Receivers, Surfaces),
    reach: f64,
) -> Result<CausticMap, GpuError> {
    let viewpoint = &cast.lamp.receivers;
    let grids = photons.grids;
    // More than u32 counts fit no device, which says so when it is asked for their buffer.
    let photons_asked = u64::from(grids.count()) * texels([caustics.photons; 2]);
    let photon_count = u32::try_from(photons_asked).unwrap_or(u32::MAX);
    let units = CAPACITY as f64 / most_flux(&cast.viewpoint.viewpoint);
    let size = UVec2::from_array(viewpoint.size);
    let footprints = caustics.method == Method::Footprint;
    let count = texels(viewpoint.size);
    let coarse = if footprints { coarse_texels(viewpoint.size) } else { 0 };
    let receivers_from_caster = viewpoint.world_from_view.inverse() * cast.viewpoint.viewpoint.world_from_view;
    let grey = |[red, green, blue]: [f32; 3]| red == green && green == blue;
    let dispersive = grids.spectrum.is_some();
    let (absorption, tint, mirror) = match *cast.caster {
        Caster::Glass(glass) => (glass.absorption, glass.tint, false),
        Caster::Mirror(mirror) => ([0.0; 3], mirror.reflectance, true),
    };
    let monochrome =
        grey(absorption) && grey(tint) && !dispersive && cast.surface.is_none() && photons.colours.is_none();
    let (texel, held) = if monochrome { (4, 4) } else { (16, 8) };
    let spec = |root: &'static str| {
        let spec = ShaderSpec::new(root).feature("differentials", photons.differentials.is_some());
        spec.feature("monochrome", monochrome)
            .feature("faceted", cast.faceted)
            .feature("dispersive", dispersive)
            .feature("mirror", mirror)
            .feature("media", photons.colours.is_some())
            .feature("surface_map", cast.surface.is_some())
    };
    let shader = |root: &'static str| gpu.shader(&spec(root));
    let over_photons = Groups::linear(photon_count as usize, 64);
    let over_map = Groups::Direct([size.x.div_ceil(8), size.y.div_ceil(8), LEVELS as u32]);
    let name = match on {
        Surfaces::Seen => "deposit",
        Surfaces::Hidden => "deposit_hidden",
    };
    let pass = cast.viewpoint.tell(ComputePass::new(name, cast.instance), "caster_viewpoint");
    let mut pass = cast
        .receivers()
        .tell(pass, "receiver_viewpoint")
        .value(
            "landing_params",
            &LandingParams {
                receivers_from_caster: receivers_from_caster.as_mat4(),
                photon_count,
                units: units as f32,
                reach: reach as f32,
                photons: caustics.photons,
                mirrored: grids.mirrored,
                part_of_wave: 1.0 / grids.waves() as f32,
                layer: u32::from(on == Surfaces::Hidden),
            },
        )
        .value(
            "params",
            &DepositParams {
                absorption: absorption.into(),
                photons: caustics.photons,
                tint: tint.into(),
                units: units as f32,
                size,
                grids: grids.count(),
                mirrored: grids.mirrored,
                branches: grids.branches,
                map_size: cast.viewpoint.viewpoint.size[0],
            },
        )
        .input("photons", photons.rays)
        .input("receivers", receivers.seen)
        .input("front", cast.map.front)
        .workspace("landings", LANDING_BYTES * photons_asked)
        .value("detail_params", &DetailParams { size })
        .value("compose_params", &ComposeParams { size })
        .value("pyramid_params", &PyramidParams { size })
        .scratch("marginals", MARGINAL_BYTES)
        .scratch("flux", (LEVELS * count + coarse) * if monochrome { 4 } else { 12 })
        .workspace("laid", texel * (LEVELS * count + coarse))
        .output("caustic_map", held * LEVELS * level_texels(viewpoint.size))
        .cleared_output("account", 8)
        .output("detail", 16)
        .output("range", 4 * (LEVELS * count + coarse));
    if let Some(differentials) = photons.differentials {
        pass = pass.input("differentials", differentials);
    }
    if let Some(colours) = photons.colours {
        pass = pass.input("colours", colours);
    }
    if let Some(surface) = cast.surface {
        pass = pass.input("glass_surface", surface);
    }
    if let Some(spectrum) = &grids.spectrum {
        pass = pass.value("spectrum", spectrum);
    }
    let shah = caustics.method == Method::Shah;
    let hidden = receivers.hidden.filter(|_| caustics.method.follows_hidden());
    if let Some([next, back]) = hidden {
        pass = pass.input("hidden", next).input("inner", back);
    }
    let sheet = cast.map.back.filter(|_| matches!(cast.caster, Caster::Glass(glass) if glass.thin));
    if let Some(back) = sheet {
        pass = pass.input("back", back);
    }
    let land = spec("caustics::land")
        .feature("iterated", shah)
        .feature("thin", sheet.is_some())
        .feature("layered", hidden.is_some());
    let land = gpu.shader(&land)?;
    pass = pass.dispatch(&land, "main", over_photons);
    pass = pass.dispatch(&shader("caustics::detail")?, "main", Groups::Direct([1; 3]));
    let watts = (1.0 / units) as f32;
    pass = match caustics.method {
        Method::Splat => {
            let filter = shader("caustics::filter")?;
            // With the variance of a quadratic B-spline that of a tent and 1.75: half of the 7x7 kernel, smooth enough that single
            // photons do not show, narrow enough to end within it.
            pass.value("kernel", &Kernel { size, watts, sigma: 1.726 })
                .workspace("rows", texel * LEVELS * count)
                .dispatch(&shader("caustics::splat")?, "main", over_photons)
                .dispatch(&filter, "horizontal", over_map)
                .dispatch(&filter, "vertical", over_map)
        }
        Method::Shah => pass
            .value("resolve_params", &ResolveParams { size, watts })
            .dispatch(&gpu.shader(&spec("caustics::splat").feature("linear", true))?, "main", over_photons)
            .dispatch(&shader("caustics::resolve")?, "main", over_map),
        Method::Beams | Method::Footprint => {
            // Both triangles of a cell, or one parallelogram.
            let (cover, shapes) = match caustics.method {
                Method::Beams => ("caustics::beams", 2),
                _ => ("caustics::footprint", 1),
            };
            let lay = gpu.shader(&spec("caustics::lay").alias("caustics::cover", cover))?;
            let resolve = gpu.shader(&spec("caustics::resolve").feature("coarse", footprints))?;
            pass = pass.value("resolve_params", &ResolveParams { size, watts }).dispatch(
                &lay,
                "main",
                Groups::linear(photon_count as usize * shapes, 64),
            );
            if footprints {
                // The coarsest first.
                for (finer, entry) in REFINEMENTS.into_iter().enumerate().rev() {
                    pass = pass.dispatch(&resolve, entry, Groups::tiles(coarse_size(viewpoint.size, finer as u32 + 1)));
                }
            }
            pass.dispatch(&resolve, "main", over_map)
        }
    };
    let [blocks_x, blocks_y] = viewpoint.size.map(|side| side.div_ceil(32));
    let blocks = Groups::Direct([blocks_x, blocks_y, LEVELS as u32]);
    pass = pass.dispatch(&shader("caustics::compose")?, "main", over_map);
    let outputs = pass.dispatch(&shader("caustics::pyramid")?, "main", blocks).add_to(plan)?;
    Ok(CausticMap {
        flux: outputs[0],
        monochrome,
        account: outputs[1],
        detail: outputs[2],
        range: outputs[3],
        watts_per_unit: 1.0 / units,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mirror;
    use murano_gpu::{Shader, check_uniform_layout};
    use murano_refraction::{MapFeatures, TirPolicy};

    /// With everything that a caster and the settings may ask for at once.
    #[test]
    fn no_shader_needs_more_buffers_than_there_may_be() {
        let refraction = Refraction {
            method: murano_refraction::Method::Layers,
            tir: TirPolicy::Trace,
            interfaces: Interfaces::All,
            ..Refraction::default()
        };
        let map = MapFeatures { relief: true, framed: true, media: true, ..MapFeatures::default() };
        let spec = ["differentials", "dispersive", "by_chance", "surface_map", "shielded"]
            .into_iter()
            .fold(traced("caustics::emit", &refraction, false, map), |spec, feature| spec.feature(feature, true));
        if let Err(error) = Shader::link(&spec) {
            panic!("{error}");
        }
    }

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let emit =
            Shader::link(&traced("caustics::emit", &Refraction::default(), false, MapFeatures::default())).unwrap();
        check_uniform_layout!(
            emit,
            "Params",
            EmitParams {
                render_from_view: Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0)),
                ior: 1.0,
                photons: 2,
                mirrored: 3,
                branches: 4,
                two_only: 5,
            }
        )
        .unwrap();
        let off_mirrors = traced("caustics::emit", &Mirror::refraction(), false, MapFeatures::default())
            .feature("differentials", true);
        Shader::link(&off_mirrors.feature("mirror", true)).unwrap();
        let photon = emit.structs.iter().find(|layout| layout.name == "Photon").unwrap();
        assert_eq!(u64::from(photon.size), PHOTON_BYTES);
        let land = Shader::link(&ShaderSpec::new("caustics::land").feature("differentials", true)).unwrap();
        check_uniform_layout!(
            land,
            "Params",
            LandingParams {
                receivers_from_caster: Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0)),
                photon_count: 1,
                units: 2.0,
                reach: 3.0,
                photons: 4,
                mirrored: 5,
                part_of_wave: 6.0,
                layer: 7,
            }
        )
        .unwrap();
        let bytes = |name: &str| {
            let layout = land.structs.iter().find(|layout| layout.name == name).unwrap();
            u64::from(layout.size)
        };
        assert_eq!(bytes("Landing"), LANDING_BYTES);
        assert_eq!(bytes("PhotonDifferential"), DIFFERENTIAL_BYTES);
        let deposit = Shader::link(&ShaderSpec::new("caustics::splat")).unwrap();
        check_uniform_layout!(
            deposit,
            "Params",
            DepositParams {
                absorption: Vec3::new(1.0, 2.0, 3.0),
                photons: 4,
                tint: Vec3::new(5.0, 6.0, 7.0),
                units: 8.0,
                size: UVec2::new(9, 10),
                grids: 11,
                mirrored: 12,
                branches: 13,
                map_size: 14,
            }
        )
        .unwrap();
        let detail = Shader::link(&ShaderSpec::new("caustics::detail")).unwrap();
        check_uniform_layout!(detail, "Params", DetailParams { size: UVec2::new(1, 2) }).unwrap();
        let compose = Shader::link(&ShaderSpec::new("caustics::compose")).unwrap();
        check_uniform_layout!(compose, "Params", ComposeParams { size: UVec2::new(1, 2) }).unwrap();
        let pyramid = Shader::link(&ShaderSpec::new("caustics::pyramid")).unwrap();
        check_uniform_layout!(pyramid, "Params", PyramidParams { size: UVec2::new(1, 2) }).unwrap();
        let resolve = Shader::link(&ShaderSpec::new("caustics::resolve")).unwrap();
        check_uniform_layout!(resolve, "Params", ResolveParams { size: UVec2::new(1, 2), watts: 3.0 }).unwrap();
        let filter = Shader::link(&ShaderSpec::new("caustics::filter")).unwrap();
        check_uniform_layout!(filter, "Kernel", Kernel { size: UVec2::new(1, 2), watts: 3.0, sigma: 4.0 }).unwrap();
    }
}
