//! File names of a sequence.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// What a frame's own file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB.
    Png,
    /// f32 layers.
    Exr,
}

/// A file name with at most one place for the frame's number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destination {
    before: String,
    /// Digits at least, padded with zeros; `None` where the name has no place for a number.
    digits: Option<usize>,
    after: String,
    format: Format,
}

impl Destination {
    /// Reads a name with `####` or `{frame:04}` (or `{frame}`) in it, or without.
    ///
    /// # Errors
    /// When the name has several such places, or does not end in .png or .exr.
    pub fn parse(output: &str) -> Result<Self> {
        let extension = Path::new(output).extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let format = match extension.as_deref() {
            Some("png") => Format::Png,
            Some("exr") => Format::Exr,
            _ => bail!("-o {output}: frames are .png or .exr; name them e.g. out/frame_####.png"),
        };
        let places = places(output);
        if places.len() > 1 {
            bail!("-o {output}: there is more than one place for the frame's number; keep one #### or {{frame:04}}");
        }
        let (before, digits, after) = match places.first() {
            Some(&(start, end, digits)) => (&output[..start], Some(digits), &output[end..]),
            None => (output, None, ""),
        };
        Ok(Self { before: before.into(), digits, after: after.into(), format })
    }

    /// What a frame's own file is.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        match self.digits {
            Some(digits) => format!("{}{frame:0digits$}{}", self.before, self.after).into(),
            None => self.before.clone().into(),
        }
    }

    /// Makes the folder.
    ///
    /// # Errors
    /// When several frames would overwrite one another, or the folder cannot be made or written to.
    pub fn prepare(&self, frames: u32) -> Result<()> {
        if frames > 1 && self.digits.is_none() {
            bail!(
                "-o {}: {frames} frames would overwrite one another; put #### into the name, or render one with --frames 0",
                self.before
            );
        }
        prepare_folder(&self.path(0))
    }
}

/// Makes the folder in which `file` is to be written, and tries it.
///
/// # Errors
/// When it cannot be made or written to; the message names it.
pub fn prepare_folder(file: &Path) -> Result<()> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let advice = || format!("{} cannot be written to; choose another place for {}", folder.display(), file.display());
    std::fs::create_dir_all(folder).with_context(advice)?;
    if file.is_dir() {
        bail!("{} is a folder; give a file name", file.display());
    }
    let trial = folder.join(format!(".murano-{}", std::process::id()));
    std::fs::write(&trial, []).and_then(|()| std::fs::remove_file(&trial)).with_context(advice)
}

/// Start, end and digits of every place for a number.
fn places(name: &str) -> Vec<(usize, usize, usize)> {
    let mut places = Vec::new();
    let mut at = 0;
    while let Some(offset) = name[at..].find(['#', '{']) {
        let start = at + offset;
        let rest = &name[start..];
        let hashes = rest.len() - rest.trim_start_matches('#').len();
        if hashes > 0 {
            at = start + hashes;
            places.push((start, at, hashes));
        } else if let Some((length, digits)) = braced(rest) {
            at = start + length;
            places.push((start, at, digits));
        } else {
            at = start + 1;
        }
    }
    places
}

/// Length and digits of a leading `{frame}` or `{frame:04}`.
fn braced(text: &str) -> Option<(usize, usize)> {
    /// More than any frame number has; a file name has a limit.
    const MOST_DIGITS: usize = 20;
    let end = text.find('}')?;
    let inside = text[1..end].strip_prefix("frame")?;
    let digits = match inside.strip_prefix(':') {
        Some(digits) => digits.parse().ok().filter(|digits| *digits <= MOST_DIGITS)?,
        None if inside.is_empty() => 1,
        None => return None,
    };
    Some((end + 1, digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(output: &str, frame: u32) -> String {
        Destination::parse(output).unwrap().path(frame).display().to_string()
    }

    #[test]
    fn numbers_are_put_where_they_belong() {
        assert_eq!(path("out/a_####.png", 7), "out/a_0007.png");
        assert_eq!(path("out/a_##.png", 1234), "out/a_1234.png");
        assert_eq!(path("{frame:03}.exr", 7), "007.exr");
        assert_eq!(path("a{frame}b.png", 7), "a7b.png");
        assert_eq!(path("still.PNG", 7), "still.PNG");
        assert_eq!(path("{other}_#.png", 7), "{other}_7.png");
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for wrong in ["a.jpg", "a_####", "##_##.png", "#{frame}.png", ""] {
            assert!(Destination::parse(wrong).is_err(), "{wrong}");
        }
        let still = Destination::parse("still.png").unwrap();
        assert!(still.prepare(2).unwrap_err().to_string().contains("####"));
    }
}
