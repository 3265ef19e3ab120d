//! The command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use haarmonic::backend::near_field::Route;
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Procedural;

use crate::support::Failure;
use crate::support::args::{Common, Folder};

/// A mesh lit by textured lamps that hang near it and move: near-field relighting next to ground truth.
///
/// Without arguments: the built-in scene under a stained window, a contact sheet in out/near_field.png. With --find: a
/// lamp found from one picture. With --figures: the figures 4.7, 4.10 and 4.11 of the thesis.
#[derive(Debug, Parser)]
#[command(version, name = "near_field")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB), y up; without it the built-in scene
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Built-in scene
    #[arg(long, value_enum, default_value = "spheres", conflicts_with = "mesh")]
    pub scene: BuiltIn,

    /// Vertices of the built-in scene
    #[arg(long, value_name = "N", default_value_t = 12_000)]
    pub vertices: usize,

    /// Reflectance, as of `relight`: phong:50+lambert:0.4. Without it: Lambert, and glossy on the built-in object
    #[arg(long, value_name = "SPEC")]
    pub brdf: Option<String>,

    /// Texture of the lamp (PNG, HDR, EXR), or the built-in `window`, `discs`, `gradient` or `noise`
    #[arg(long, value_name = "FILE", default_value = "window")]
    pub texture: String,

    /// Size of the lamp along x and z, in the units of the mesh (default: as wide as the scene's radius)
    #[arg(long, value_name = "W[,H]", value_parser = numbers::<2>)]
    pub light_size: Option<Numbers<2>>,

    /// Height of the lamp above the lowest point of the scene (default: a third above the highest)
    #[arg(long, value_name = "Y")]
    pub light_height: Option<f64>,

    /// How far the lamp moves in the frames along x and z (default: half of the scene's radius along both)
    #[arg(long = "move", value_name = "X,Z", value_parser = numbers::<2>, allow_hyphen_values = true)]
    pub travel: Option<Numbers<2>>,

    /// Turn of the lamp in its plane, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    pub rotate: f64,

    /// Lamps: more of them stand around the first
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub lights: usize,

    /// Wavelets along an axis of the lamp and of the top face (a power of two)
    #[arg(long, value_name = "N", default_value_t = 32)]
    pub order: usize,

    /// Wavelets of the lamp that are kept: a percentage, a count, or `all`
    #[arg(long, value_name = "TERMS", default_value = "1%")]
    pub source: Keep,

    /// Wavelets that are computed at a vertex, chosen by a constant light
    #[arg(long, value_name = "TERMS", default_value = "20%")]
    pub target: Keep,

    /// Edge of the top face at distance 1
    #[arg(long, value_name = "A", default_value_t = 4.0)]
    pub face: f64,

    /// Rays along an edge of a cell of the face
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub samples: usize,

    /// Only this route: automatic, couplings, stored-couplings, canonical-table, summed-area or pixels
    #[arg(long, value_name = "ROUTE", value_parser = route)]
    pub route: Option<Route>,

    /// Bake for any view: BRDFs become sums of products
    #[arg(long)]
    pub free_view: bool,

    /// Frames to time
    #[arg(long, value_name = "N", default_value_t = 9)]
    pub frames: usize,

    /// Samples along an edge of a texel for ground truth
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub truth_samples: usize,

    /// Find a lamp from one picture by the gradient of its error
    #[arg(long, conflicts_with = "figures")]
    pub find: bool,

    /// Draw the figures 4.7 and 4.10 of the thesis, and measure figure 4.11
    #[arg(long)]
    pub figures: bool,

    /// Vertices of the scenes of figure 4.11
    #[arg(long, value_name = "N,N,N", value_delimiter = ',', default_values_t = [39_391, 56_995, 68_046])]
    pub counts: Vec<usize>,

    /// Edge of each picture in pixels
    #[arg(long, value_name = "PX", default_value_t = 360)]
    pub size: usize,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BuiltIn {
    TorusKnot,
    Spheres,
    Table,
}

impl BuiltIn {
    pub fn procedural(self) -> Procedural {
        match self {
            Self::TorusKnot => Procedural::TorusKnotOnFloor,
            Self::Spheres => Procedural::StackedSpheres,
            Self::Table => Procedural::Table,
        }
    }
}

/// Numbers between commas; one stands for all.
#[derive(Debug, Clone, Copy)]
pub struct Numbers<const N: usize>(pub [f64; N]);

fn numbers<const N: usize>(text: &str) -> Result<Numbers<N>, String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    match parsed.as_deref() {
        Ok([one]) if one.is_finite() => Ok(Numbers([*one; N])),
        Ok(all) if all.len() == N && all.iter().all(|x| x.is_finite()) => Ok(Numbers(std::array::from_fn(|k| all[k]))),
        _ => Err(format!("give {N} numbers between commas, or one for all")),
    }
}

fn route(text: &str) -> Result<Route, String> {
    let names = Route::ALL.map(Route::name).join(", ");
    Route::from_name(text).ok_or_else(|| format!("the routes are {names}"))
}

impl Args {
    /// Refuses what no option can be.
    pub fn check(&self) -> Result<(), Failure> {
        if self.lights == 0 || self.frames == 0 {
            return Err("--lights and --frames must be at least 1".into());
        }
        if !(1..=64).contains(&self.truth_samples) {
            return Err(format!("--truth-samples must be from 1 to 64; got {}", self.truth_samples).into());
        }
        if self.figures && self.counts.iter().any(|n| !(2_000..=1_000_000).contains(n)) {
            return Err("--counts must be from 2000 to 1000000 vertices".into());
        }
        Ok(())
    }

    /// The lamp's size, height and travel in a scene of this ground, top and radius.
    pub fn lamp(&self, bottom: f64, top: f64, radius: f64) -> ([f64; 2], f64, Vector3<f64>) {
        let size = self.light_size.map_or([radius; 2], |size| size.0);
        let height = self.light_height.map_or(top + (top - bottom) / 3.0, |height| bottom + height);
        let travel = self.travel.map_or([0.5 * radius; 2], |travel| travel.0);
        (size, height, Vector3::new(travel[0], 0.0, travel[1]))
    }
}
