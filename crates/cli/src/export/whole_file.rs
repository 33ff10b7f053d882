//! Files that are whole or not there.

use std::{
    ffi::OsString,
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};

/// The name under which `path` is written before it is whole: in the same folder, so that the renaming is atomic.
pub fn partial(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".part{}", std::process::id()));
    path.with_file_name(name)
}

/// Writes a file under another name and gives it its own when it is whole; on failure nothing is left.
///
/// # Errors
/// What `write` or the system reports; the message names the file.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    // A link keeps pointing at what is written; a device or a pipe is no place to rename a file over.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.exists() && !target.is_file() {
        bail!("{} is not a regular file; name a file to be written", path.display());
    }
    let partial = partial(&target);
    write_and_rename(&partial, &target, write)
        .inspect_err(|_| {
            // Nothing more can be done about a file that was not even created.
            let _ = fs::remove_file(&partial);
        })
        .with_context(|| format!("{} cannot be written; is the disk full?", path.display()))
}

fn write_and_rename(partial: &Path, path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let mut file = BufWriter::new(File::create(partial)?);
    write(&mut file)?;
    file.flush()?;
    drop(file);
    Ok(fs::rename(partial, path)?)
}
