//! `--heatmap`: pictures and maps of errors as PNG files.

use std::{io::Write, path::Path};

use anyhow::Result;
use murano_metrics::{
    heat_map::HeatMap,
    images::Picture,
    irradiance::IrradianceMap,
    scale::{Scale, Scaling},
};
use murano_refraction::Refraction;

use crate::{
    bench::angle_map,
    export::{prepare_folder, write_whole},
    trial::{CausticTrial, CausticTruth, RefractionTrial, Truth},
};

/// Writes `truth.png`, and for every method `NAME_STEPS.png`, `NAME_STEPS_angle.png` and `NAME_STEPS_flip.png`.
///
/// # Errors
/// If the folder cannot be written to.
pub fn write_refraction(folder: &Path, size: [u32; 2], truth: &Truth, trial: &RefractionTrial) -> Result<()> {
    let Refraction { method, steps, .. } = trial.refraction;
    let name = [&[method.name(), &steps.to_string()], &trial.refraction.variant()[..]].concat().join("_");
    if let Some(picture) = truth.picture() {
        write_picture(&folder.join("truth.png"), picture)?;
    }
    if let Some(picture) = &trial.picture {
        write_picture(&folder.join(format!("{name}.png")), picture)?;
    }
    let angles = angle_map(size, &trial.errors.paths.angles)?;
    write_picture(&folder.join(format!("{name}_angle.png")), &angles)?;
    if let Some(flip) = &trial.errors.flip {
        let scale = Scale::new(Scaling::Linear, 0.0, 1.0)?;
        let map = HeatMap { title: "FLIP", unit: "", size, values: &flip.map, scale }.draw()?;
        write_picture(&folder.join(format!("{name}_flip.png")), &map)?;
    }
    Ok(())
}

/// Writes `caustic_truth.png`, and for every method `NAME_PHOTONS.png`, `NAME_PHOTONS_error.png`, and `NAME_PHOTONS_range.png`: how much of
/// the range of fixed-point sums each texel takes where most of the light lands; one that took all of it would be the scale's end.
///
/// # Errors
/// If the folder cannot be written to.
pub fn write_caustics(folder: &Path, truth: &CausticTruth, trial: &CausticTrial) -> Result<()> {
    let name = format!("{}_{}", trial.caustics.method, trial.caustics.photons);
    let narrow = |map: &IrradianceMap| map.values().iter().map(|&value| value as f32).collect::<Vec<f32>>();
    let (exact, drawn) = (narrow(truth.map()), narrow(&trial.map));
    let off: Vec<f32> = exact.iter().zip(&drawn).map(|(a, b)| (a - b).abs()).collect();
    let size = truth.map().size();
    let scale = Scale::logarithmic_of(&exact);
    for (file, title, values) in [
        ("caustic_truth.png".to_owned(), "irradiance, traced", &exact),
        (format!("{name}.png"), "irradiance", &drawn),
        (format!("{name}_error.png"), "difference of irradiance", &off),
    ] {
        write_picture(&folder.join(file), &HeatMap { title, unit: "W/m²", size, values, scale }.draw()?)?;
    }
    let used = &trial.account.range[trial.account.map.len()..];
    let scale = Scale::new(Scaling::Logarithmic, 1e-9, 1.0)?;
    let size = [trial.caustics.map_size; 2];
    let range = HeatMap { title: "fixed-point range used", unit: "", size, values: used, scale }.draw()?;
    write_picture(&folder.join(format!("{name}_range.png")), &range)
}

fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    prepare_folder(path)?;
    let png = picture.to_png()?;
    write_whole(path, |file| Ok(file.write_all(&png)?))
}
