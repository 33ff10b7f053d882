//! Files encoded and written beside the rendering.

use std::{
    path::Path,
    sync::mpsc::{Receiver, Sender, channel},
};

use anyhow::{Context, Result, bail};
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

use super::whole_file::write_whole;

/// Threads that write files. At most two files a thread wait: frames do not pile up in memory.
pub struct Writers {
    pool: rayon::ThreadPool,
    results: Receiver<Result<()>>,
    report: Sender<Result<()>>,
    waiting: usize,
}

impl Writers {
    /// Starts the threads.
    ///
    /// # Errors
    /// When the system gives none.
    pub fn new() -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new()
            .thread_name(|index| format!("writer {index}"))
            .build()
            .context("no threads to write files with")?;
        let (report, results) = channel();
        Ok(Self { pool, results, report, waiting: 0 })
    }

    /// Has a file written; waits for another one where too many are under way.
    ///
    /// # Errors
    /// Those of files submitted before.
    pub fn submit(&mut self, write: impl FnOnce() -> Result<()> + Send + 'static) -> Result<()> {
        while self.waiting >= 2 * self.pool.current_num_threads() {
            self.wait_for_one()?;
        }
        self.waiting += 1;
        let report = self.report.clone();
        self.pool.spawn(move || {
            // Nobody listens any more after the first error.
            let _ = report.send(write());
        });
        Ok(())
    }

    /// Waits until every file is written.
    ///
    /// # Errors
    /// The first that occurred.
    pub fn finish(mut self) -> Result<()> {
        while self.waiting > 0 {
            self.wait_for_one()?;
        }
        Ok(())
    }

    fn wait_for_one(&mut self) -> Result<()> {
        self.waiting -= 1;
        match self.results.recv() {
            Ok(result) => result,
            Err(_) => bail!("the threads that write files are gone"),
        }
    }
}

/// Writes 8-bit sRGB RGBA rows, top first.
///
/// # Errors
/// What the encoder or the system reports.
pub fn write_png(path: &Path, size: [u32; 2], rgba: &[u8]) -> Result<()> {
    write_whole(path, |file| {
        PngEncoder::new_with_quality(file, CompressionType::Fast, FilterType::Adaptive).write_image(
            rgba,
            size[0],
            size[1],
            ExtendedColorType::Rgba8,
        )?;
        Ok(())
    })
}
