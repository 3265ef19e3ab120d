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

/// The light of an example.
#[derive(Debug, clap::Args)]
pub struct Light {
    /// Environment: a file (HDR, EXR, PNG; see --env-layout), or the built-in `sky`, `sunset` or `studio`
    #[arg(long, value_name = "FILE|NAME", default_value = "sky")]
    pub env: String,

    /// How directions lie in the picture of --env
    #[arg(long, value_enum, default_value = "auto")]
    pub env_layout: Layout,
}

impl Light {
    /// A name to show, and the light.
    pub fn load(&self) -> Result<(String, EnvironmentLight), Failure> {
        let sky = match self.env.as_str() {
            "sky" => Some(Sky::default()),
            "sunset" => Some(Sky::sunset()),
            "studio" => Some(Sky::studio()),
            _ => None,
        };
        match sky {
            Some(sky) => Ok((self.env.clone(), EnvironmentLight::from_sky(sky)?)),
            None => {
                let loaded = io::load_environment_with(&self.env, self.env_layout.into())?;
                loaded.warnings.iter().for_each(warn);
                Ok((file_name(Path::new(&self.env)), loaded.value))
            }
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
