//! `cargo xtask demo`: one looping clip with caustics, from nothing to `out/`.

use std::{fs, time::Instant};

use anyhow::{Context, Result};

use crate::{cargo, driver};

/// The shot that is exported.
const SHOT: &str = "animations/demo.ron";
/// Where the frames go, relative to the root.
const FRAMES: &str = "out/demo/frame_####.png";
/// All frames on one sheet.
const SHEET: &str = "out/demo/contact_sheet.png";
/// The film, where `ffmpeg` is installed.
const FILM: &str = "out/demo/demo.mp4";

/// Sees to a Vulkan driver, exports the demo's shot and says where to look.
///
/// # Errors
/// When no driver can be had, the program does not compile, or the export fails.
pub fn run() -> Result<()> {
    driver::ensure()?;
    let root = cargo::root();
    // Frames of an earlier, longer demo would otherwise stand among the new ones.
    let folder = root.join("out/demo");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} could not be emptied", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("{} could not be created", folder.display()))?;

    // The whole workspace is selected, as `cargo xtask test` does, so that features agree and nothing compiles twice.
    println!("building murano (the first time takes some minutes) ...");
    cargo::run(&["build", "--bin", "murano"])?;

    let film = driver::on_path("ffmpeg");
    let mut command = vec!["run", "--quiet", "--bin", "murano", "--"];
    command.extend(["export", SHOT, "-o", FRAMES, "--contact-sheet", SHEET]);
    if film {
        command.extend(["--video", FILM]);
    }
    let start = Instant::now();
    cargo::run(&command)?;

    println!("\nThe demo took {:.0} s. Look at:", start.elapsed().as_secs_f64());
    println!("  {}   every frame on one sheet", root.join(SHEET).display());
    println!("  {}   the frames", root.join(FRAMES).display());
    if film {
        println!("  {}   the film", root.join(FILM).display());
    } else {
        println!("  (no film: ffmpeg is not installed)");
    }
    Ok(())
}
