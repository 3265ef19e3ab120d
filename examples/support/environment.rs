//! The environments that an option names: a built-in sky or a file.

use std::fmt::Display;
use std::path::Path;

use clap::ValueEnum;
use haarmonic::io::{self, EnvironmentLayout};
use haarmonic::scene::{EnvironmentLight, Sky};

use super::Failure;

/// How directions lie in a file's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// By the file and its proportions
    Auto,
    /// Latitude-longitude map
    LatLong,
    /// Unfolded cube, 4:3 or 3:4
    Cross,
    /// Six faces in a row or column, as OpenGL orients them
    CubeStrip,
    /// Six faces in a column, as OpenEXR orients them
    OpenexrCube,
    /// Light probe: a square, angles from the centre
    AngularMap,
    /// Photograph of a mirror ball
    MirrorBall,
}

impl From<Layout> for EnvironmentLayout {
    fn from(layout: Layout) -> Self {
        match layout {
            Layout::Auto => Self::Auto,
            Layout::LatLong => Self::LatLong,
            Layout::Cross => Self::Cross,
            Layout::CubeStrip => Self::CubeStrip,
            Layout::OpenexrCube => Self::OpenExrCube,
            Layout::AngularMap => Self::AngularMap,
            Layout::MirrorBall => Self::MirrorBall,
        }
    }
}

/// A name to show, and the light: "sky", "sunset", "studio" or a file.
pub fn environment(name: &str) -> Result<(String, EnvironmentLight), Failure> {
    environment_with(name, Layout::Auto)
}

/// The same, the picture of a file having a given layout.
pub fn environment_with(name: &str, layout: Layout) -> Result<(String, EnvironmentLight), Failure> {
    let sky = match name {
        "sky" => Some(Sky::default()),
        "sunset" => Some(Sky::sunset()),
        "studio" => Some(Sky::studio()),
        _ => None,
    };
    match sky {
        Some(sky) => Ok((name.to_owned(), EnvironmentLight::from_sky(sky)?)),
        None => {
            let loaded = io::load_environment_with(name, layout.into())?;
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
