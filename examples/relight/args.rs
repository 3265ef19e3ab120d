//! The command line.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Parser, ValueEnum};
use haarmonic::haar::{Keep, Weighting};
use haarmonic::io::{MeshOptions, Up, Winding};
use haarmonic::nalgebra::Vector3;

use crate::methods::{Method, Methods, REFERENCE};
use crate::support::args::{Common, check_format};
use crate::support::environment::Light;

/// A mesh lit by an environment map: relighting by wavelets and by blocks next to ground truth.
///
/// Without arguments: the built-in scene under the built-in sky, all methods, a contact sheet in out/relight.png.
#[derive(Debug, Parser)]
#[command(version, name = "relight")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB); without it the built-in scene
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Axis of the mesh file that points up; the mesh is turned so that it does under the environment
    #[arg(long, value_name = "AXIS", value_enum, default_value = "y", requires = "mesh")]
    pub mesh_up: Axis,

    /// Faces of the mesh file that are wound the wrong way round
    #[arg(long, value_enum, default_value = "repair", requires = "mesh")]
    pub winding: Wound,

    /// Built-in scene
    #[arg(long, value_enum, default_value = "torus-knot", conflicts_with = "mesh")]
    pub scene: BuiltIn,

    /// Vertices of the built-in scene (a mesh file keeps its own) [default: 12000; with --paper 100000]
    #[arg(long, value_name = "N")]
    pub vertices: Option<usize>,

    /// The comparison of Inger 2013: wavelet-triple and block-product only; the table with its chairs, the floor
    /// Lambert and Phong exponents 10, 50, 100, 200 over Lambert on the rest
    #[arg(long, conflicts_with_all = ["mesh", "scene", "method", "brdf"])]
    pub paper: bool,

    #[command(flatten)]
    pub light: Light,

    /// Turn of the environment about +y, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    pub rotate_env: f64,

    /// Method
    #[arg(long, value_name = "METHOD", value_parser = names(), default_value = "all")]
    pub method: String,

    /// Reflectance: lambert:0.8, phong:50, blinn-phong:100, ward:0.2:0.5, ggx:0.3, ashikhmin:100:1000, merl:FILE, or a
    /// sum such as phong:50+lambert:0.4. Without it: Lambert, and glossy on the built-in scene's object
    #[arg(long, value_name = "SPEC")]
    pub brdf: Option<String>,

    /// Texels along an edge of a cube map's face (a power of two)
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub resolution: usize,

    /// Resolution of the ground truth (default: that of --resolution)
    #[arg(long, value_name = "R")]
    pub truth_resolution: Option<usize>,

    /// Terms that light (and, in the triple product, BRDF) keep: a percentage, a count, or `all`
    #[arg(long, value_name = "TERMS", default_value = "1%")]
    pub terms: Keep,

    /// How the kept terms are chosen
    #[arg(long, value_enum, default_value = "integral")]
    pub weighting: Choice,

    #[command(flatten)]
    pub methods: Methods,

    /// Frames to time; the environment turns by 360°/N each frame [default: 5; with --paper 3]
    #[arg(long, value_name = "N")]
    pub frames: Option<usize>,

    /// Where the viewer is, seen from the middle of the scene (a direction; default: the scene's own camera)
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub view: Option<Vector3<f64>>,

    /// Which way is up in the picture (for a mesh whose z axis points up see --mesh-up)
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "0,1,0")]
    pub up: Vector3<f64>,

    /// Edge of each picture in pixels
    #[arg(long, value_name = "PX", default_value_t = 400)]
    pub size: usize,

    /// Exposure of the pictures in stops (default: chosen so that the ground truth's bright parts are just below white)
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    pub exposure: Option<f64>,

    /// Contact sheet
    #[arg(long, value_name = "P.png", default_value = "out/relight.png")]
    pub out: PathBuf,

    /// Also write the first method's picture in linear RGB
    #[arg(long, value_name = "P.exr")]
    pub exr: Option<PathBuf>,

    /// Also write the mesh with the first method's radiance as float vertex colours
    #[arg(long, value_name = "P.ply")]
    pub out_ply: Option<PathBuf>,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// Makes the folders of the files to write, before any long work.
    pub fn make_folders(&self) -> Result<(), String> {
        let files = [Some(&self.out), self.exr.as_ref(), self.out_ply.as_ref(), self.common.report.as_ref()];
        for folder in files.into_iter().flatten().filter_map(|f| f.parent()).filter(|f| !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|e| format!("{}: cannot be made: {e}", folder.display()))?;
        }
        Ok(())
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        let files = [
            ("--out", Some(&self.out), "png"),
            ("--exr", self.exr.as_ref(), "exr"),
            ("--out-ply", self.out_ply.as_ref(), "ply"),
        ];
        for (option, path, format) in files {
            path.map_or(Ok(()), |path| check_format(option, path, format))?;
        }
        if self.frames == Some(0) {
            return Err("--frames must be at least 1".to_owned());
        }
        if !(16..=4096).contains(&self.size) {
            return Err(format!("--size must be in 16...4096 pixels, got {}", self.size));
        }
        if !self.resolution.is_power_of_two() || self.resolution > 256 {
            return Err(format!("--resolution must be a power of two of at most 256, got {}", self.resolution));
        }
        for method in self.methods.all().into_iter().filter(|method| self.wants(*method)) {
            method.check(self)?;
        }
        if !self.rotate_env.is_finite() || self.exposure.is_some_and(|e| !e.is_finite()) {
            return Err("--rotate-env and --exposure must be finite numbers".to_owned());
        }
        Ok(())
    }

    /// Whether a method is to be run.
    pub fn wants(&self, method: &dyn Method) -> bool {
        if self.paper { method.is_of_paper() } else { self.method == "all" || self.method == method.name() }
    }

    /// Whether the ground truth is a row of its own.
    pub fn wants_reference(&self) -> bool {
        !self.paper && (self.method == "all" || self.method == REFERENCE)
    }

    /// Vertices of the built-in scene.
    pub fn vertices(&self) -> usize {
        self.vertices.unwrap_or(if self.paper { 100_000 } else { 12_000 })
    }

    /// Frames to time.
    pub fn frames(&self) -> usize {
        self.frames.unwrap_or(if self.paper { 3 } else { 5 })
    }

    /// How the mesh file is to be taken.
    pub fn mesh_options(&self) -> MeshOptions {
        let up = match self.mesh_up {
            Axis::X => Up::X,
            Axis::Y => Up::Y,
            Axis::Z => Up::Z,
        };
        let winding = match self.winding {
            Wound::Repair => Winding::Repair,
            Wound::Keep => Winding::Keep,
        };
        MeshOptions::default().with_up(up).with_winding(winding)
    }
}

/// What `--method` takes.
fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(Methods::NAMES.into_iter().chain([REFERENCE, "all"]))
}

/// Axes that may point up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Axis {
    X,
    Y,
    Z,
}

/// Winding of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Wound {
    /// Turned where it is clear which side of a closed surface is outside
    Repair,
    /// As the file has them, for rooms that are seen from inside
    Keep,
}

/// Built-in scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BuiltIn {
    TorusKnot,
    Spheres,
    Table,
    BasRelief,
}

/// Selection of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Choice {
    Magnitude,
    Area,
    Integral,
}

impl From<Choice> for Weighting<'static, f32> {
    fn from(choice: Choice) -> Self {
        match choice {
            Choice::Magnitude => Self::Magnitude,
            Choice::Area => Self::Area,
            Choice::Integral => Self::Integral,
        }
    }
}

fn vector(text: &str) -> Result<Vector3<f64>, String> {
    let parts: Vec<f64> =
        text.split(',').map(|p| p.trim().parse().map_err(|_| wrong(text))).collect::<Result<_, _>>()?;
    let v = match parts[..] {
        [x, y, z] => Vector3::new(x, y, z),
        _ => return Err(wrong(text)),
    };
    if v.iter().all(|c| c.is_finite()) && v.norm() > 0.0 { Ok(v) } else { Err(wrong(text)) }
}

fn wrong(text: &str) -> String {
    format!("`{text}` is not a direction: give three numbers, not all zero, such as 0,1,0.5")
}
