//! The environments that an option names: a built-in sky or a file.

use std::fmt::Display;
use std::path::Path;

use haarmonic::io;
use haarmonic::scene::{EnvironmentLight, Sky};

use super::Failure;

/// A name to show, and the light: "sky", "sunset", "studio" or a file.
pub fn environment(name: &str) -> Result<(String, EnvironmentLight), Failure> {
    let sky = match name {
        "sky" => Some(Sky::default()),
        "sunset" => Some(Sky::sunset()),
        "studio" => Some(Sky::studio()),
        _ => None,
    };
    match sky {
        Some(sky) => Ok((name.to_owned(), EnvironmentLight::from_sky(sky)?)),
        None => {
            let loaded = io::load_environment(name)?;
            loaded.warnings.iter().for_each(warn);
            Ok((file_name(Path::new(name)), loaded.value))
        }
    }
}

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A line on standard error.
pub fn warn(warning: &impl Display) {
    eprintln!("warning: {warning}");
}
