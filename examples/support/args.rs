//! Options that the examples have in common.

use std::path::{Path, PathBuf};

use clap::Parser;

use super::Failure;

/// What every example has.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Also write the figures as JSON
    #[arg(long, value_name = "R.json")]
    pub report: Option<PathBuf>,

    /// Threads (default: all cores)
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
}

impl Common {
    /// Refuses wrong values and limits the threads of the program.
    pub fn start(&self) -> Result<(), Failure> {
        match self.threads {
            None => Ok(()),
            Some(0) => Err("--threads must be at least 1".into()),
            Some(threads) => Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?),
        }
    }
}

/// Where an example puts several pictures.
#[derive(Debug, clap::Args)]
pub struct Folder {
    /// Folder of the pictures
    #[arg(long = "out", id = "out", value_name = "DIR", default_value = "out")]
    pub path: PathBuf,
}

impl Folder {
    /// Makes it. What is named like a picture is none: the examples write several, all PNG.
    pub fn make(&self) -> Result<(), Failure> {
        let folder = &self.path;
        let extension = folder.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if ["png", "jpg", "jpeg", "exr", "hdr", "bmp", "gif", "tif", "tiff", "webp"].contains(&extension.as_str()) {
            return Err(format!("--out is the folder of the pictures, which are PNG; got {}", folder.display()).into());
        }
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: cannot be made: {e}", folder.display()))?;
        Ok(())
    }

    /// Writes a sheet as a PNG.
    #[cfg(feature = "io")]
    pub fn save(&self, name: &str, sheet: &super::sheet::Sheet) -> Result<(), Failure> {
        Ok(haarmonic::io::save_png_srgb8(self.path.join(name), sheet.width, sheet.height, &sheet.pixels)?)
    }
}

/// The command line, where some shared options (by name) have defaults of the example's own.
pub fn parse<A: Parser>(defaults: &[(&'static str, &'static str)]) -> A {
    let with = |command: clap::Command, &(option, value): &(&'static str, &'static str)| {
        command.mut_arg(option, |arg| arg.default_value(value))
    };
    let matches = defaults.iter().fold(A::command(), with).get_matches();
    A::from_arg_matches(&matches).unwrap_or_else(|failure| failure.exit())
}

/// Refuses a file whose name says another format than the one that an option writes.
pub fn check_format(option: &str, path: &Path, format: &str) -> Result<(), String> {
    match path.extension() {
        Some(extension) if !extension.eq_ignore_ascii_case(format) => {
            Err(format!("{option} writes {} only; got {}", format.to_ascii_uppercase(), path.display()))
        }
        _ => Ok(()),
    }
}
