//! A film of the frames, encoded by `ffmpeg`.

use std::{
    fs,
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};

use anyhow::{Context, Result, bail};
use murano_render::Frame;

use super::{destination::prepare_folder, whole_file::partial};

/// An `ffmpeg` that is fed frames.
pub struct Video {
    path: PathBuf,
    partial: PathBuf,
    /// `None` once it has ended.
    encoder: Option<Child>,
}

impl Video {
    /// Starts the encoder: H.264, 4:2:0, what every player and browser shows.
    ///
    /// # Errors
    /// When `ffmpeg` is not installed, or the folder cannot be written to.
    pub fn open(path: &Path, size: [u32; 2], fps: f64) -> Result<Self> {
        prepare_folder(path)?;
        let partial = partial(path);
        let encoder = Command::new("ffmpeg")
            .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
            .args(["-s", &format!("{}x{}", size[0], size[1]), "-r", &fps.to_string(), "-i", "-"])
            // 4:2:0 halves the sides: odd ones are extended by a pixel.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(&partial)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn();
        match encoder {
            Ok(encoder) => Ok(Self { path: path.into(), partial, encoder: Some(encoder) }),
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "--video needs ffmpeg, which is not installed (Debian/Ubuntu: apt-get install ffmpeg, macOS: brew install \
                 ffmpeg, Windows: winget install ffmpeg); or leave --video out and keep the frames of -o"
            ),
            Err(error) => Err(error).context("ffmpeg cannot be started"),
        }
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When the encoder ended; it says why on stderr.
    pub fn add(&mut self, frame: &Frame) -> Result<()> {
        let input = self.encoder.as_mut().and_then(|encoder| encoder.stdin.as_mut());
        let input = input.context("ffmpeg takes no frames")?;
        input.write_all(&frame.rgba).context("ffmpeg ended early; what it said stands above")
    }

    /// Ends the film and gives it its name.
    ///
    /// # Errors
    /// When the encoder failed or the file cannot be renamed.
    pub fn finish(mut self) -> Result<()> {
        let Some(mut encoder) = self.encoder.take() else { return Ok(()) };
        drop(encoder.stdin.take());
        let status = encoder.wait().context("ffmpeg cannot be waited for")?;
        let renamed = if status.success() { fs::rename(&self.partial, &self.path) } else { Ok(()) };
        if !status.success() || renamed.is_err() {
            let _ = fs::remove_file(&self.partial);
        }
        if !status.success() {
            bail!("ffmpeg failed with {status}; what it said stands above");
        }
        renamed.with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

impl Drop for Video {
    /// An export that ends early leaves no half film.
    fn drop(&mut self) {
        if let Some(mut encoder) = self.encoder.take() {
            let _ = encoder.kill();
            let _ = encoder.wait();
            let _ = fs::remove_file(&self.partial);
        }
    }
}
