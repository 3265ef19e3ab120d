//! What is lit, by what, and how it reflects.

use std::sync::Arc;

use haarmonic::io;
use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::scene::{Brdf, BrdfSpec, Camera, EnvironmentLight, Lambert, Materials, Mesh, Phong, Procedural, Sum};

use crate::args::{Args, BuiltIn};
use crate::support::Failure;
use crate::support::environment::{file_name, warn};

/// The scene as the command line describes it.
pub struct Scene {
    pub name: String,
    pub mesh: Mesh,
    pub materials: Materials,
    pub brdf: String,
    pub camera: Camera,
    pub light_name: String,
    pub light: EnvironmentLight,
}

impl Scene {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let given = args.brdf.as_deref().map(|text| text.parse::<BrdfSpec>()?.build()).transpose()?;
        let (name, mesh, camera, materials) = match &args.mesh {
            Some(path) => {
                let loaded = io::load_mesh_with(path, &args.mesh_options())?;
                loaded.warnings.iter().for_each(warn);
                let view = args.view.unwrap_or(Vector3::new(0.35, 0.3, 1.0));
                let camera = Camera::framing(&loaded.value, &view, &args.up, FIELD_OF_VIEW, 1.0)?;
                let materials = given.unwrap_or_else(|| Arc::new(diffuse()));
                (file_name(path), loaded.value, camera, Materials::uniform_shared(materials))
            }
            None => {
                let scene = match args.scene {
                    _ if args.paper => Procedural::Table,
                    BuiltIn::TorusKnot => Procedural::TorusKnotOnFloor,
                    BuiltIn::Spheres => Procedural::StackedSpheres,
                    BuiltIn::Table => Procedural::Table,
                    BuiltIn::BasRelief => Procedural::BasRelief,
                };
                let model = scene.build(args.vertices())?;
                let camera = match args.view {
                    Some(view) => Camera::framing(&model.mesh, &view, &args.up, FIELD_OF_VIEW, 1.0)?,
                    None => model.camera,
                };
                let materials = match given {
                    Some(brdf) => Materials::uniform_shared(brdf),
                    None => {
                        let exponents: &[f64] = if args.paper { &PAPER } else { &[40.0] };
                        let parts = model.parts.iter().map(|&p| u32::from(p)).collect();
                        palette(model.part_names, parts, exponents)?
                    }
                };
                (scene.name().to_owned(), model.mesh, camera, materials)
            }
        };
        let brdf = args.brdf.as_deref().unwrap_or(match args.mesh {
            Some(_) => "lambert:0.8",
            None if args.paper => "phong:10, 50, 100, 200 over lambert",
            None => "built-in",
        });
        let brdf = brdf.to_owned();
        let (light_name, light) = args.light.load()?;
        let light = light.with_rotation(turn(args.rotate_env));
        Ok(Self { name, mesh, materials, brdf, camera, light_name, light })
    }
}

/// A turn about +y.
pub fn turn(degrees: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), degrees.to_radians())
}

const FIELD_OF_VIEW: f64 = 0.6;

/// Phong exponents of the paper's comparison: table, chairs, railing, fruit.
const PAPER: [f64; 4] = [10.0, 50.0, 100.0, 200.0];

fn diffuse() -> Lambert {
    Lambert::new(Vector3::repeat(0.8)).expect("an albedo below 1 is allowed")
}

/// The built-in scene's look: a diffuse floor, what stands on it glossy and coloured; the parts take turns with the
/// exponents.
fn palette(names: &[&str], parts: Vec<u32>, exponents: &[f64]) -> Result<Materials, Failure> {
    let colours: [[f64; 3]; 4] = [[0.75, 0.24, 0.12], [0.15, 0.35, 0.6], [0.6, 0.5, 0.2], [0.25, 0.5, 0.3]];
    let brdf = |(i, name): (usize, &&str)| -> Result<Arc<dyn Brdf>, Failure> {
        if *name == "floor" || names.len() == 1 {
            return Ok(Arc::new(Lambert::new(Vector3::new(0.72, 0.7, 0.66))?));
        }
        let body: Arc<dyn Brdf> = Arc::new(Lambert::new(colours[i % colours.len()])?);
        // The floor comes first and has none.
        let exponent = exponents[(i - 1) % exponents.len()];
        let gloss: Arc<dyn Brdf> = Arc::new(Phong::new(Vector3::repeat(0.2), exponent)?);
        Ok(Arc::new(Sum::new(vec![(1.0, body), (1.0, gloss)])?))
    };
    Ok(Materials::new(names.iter().enumerate().map(brdf).collect::<Result<_, _>>()?, parts)?)
}
