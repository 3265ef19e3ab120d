//! What is lit, and the lamps.

use std::sync::Arc;

use haarmonic::backend::near_field::{BakeSettings, PlanarLight};
use haarmonic::io;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    Brdf, BrdfSpec, Camera, Lambert, LocalLight, Materials, Mesh, Model, Occluders, Phong, Sum, View,
};

use crate::args::Args;
use crate::support::Failure;
use crate::support::environment::{file_name, warn};

/// The scene as the command line describes it.
pub struct Scene {
    pub name: String,
    pub mesh: Mesh,
    pub materials: Materials,
    pub camera: Camera,
    pub view: View,
    pub occluders: Arc<Occluders>,
    /// The lamps, where they start.
    pub lights: Vec<PlanarLight>,
    /// How far they go.
    pub travel: Vector3<f64>,
    pub radius: f64,
}

impl Scene {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let given = args.brdf.as_deref().map(|text| text.parse::<BrdfSpec>()?.build()).transpose()?;
        let (name, mesh, camera, materials) = match &args.mesh {
            Some(path) => {
                let loaded = io::load_mesh(path)?;
                loaded.warnings.iter().for_each(warn);
                let up = Vector3::y();
                let camera = Camera::framing(&loaded.value, &Vector3::new(0.35, 0.5, 1.0), &up, 0.6, 1.0)?;
                let brdf = given.unwrap_or(Arc::new(Lambert::new([0.8; 3])?));
                (file_name(path), loaded.value, camera, Materials::uniform_shared(brdf))
            }
            None => {
                let model = args.scene.procedural().build(args.vertices)?;
                let materials = match given {
                    Some(brdf) => Materials::uniform_shared(brdf),
                    None => palette(&model, true)?,
                };
                (args.scene.procedural().name().to_owned(), model.mesh, model.camera, materials)
            }
        };
        let bounds = mesh.bounds();
        let (centre, half) = (bounds.centre(), 0.5 * bounds.size().y);
        let radius = bounds.radius().min(3.0 * half.max(1e-9));
        let (size, height, travel) = args.lamp(centre.y - half, centre.y + half, radius);
        let (width, texture) = texture(&args.texture)?;
        let turn = args.rotate.to_radians();
        let lamp = |k: usize| -> Result<PlanarLight, Failure> {
            // The first over the middle, the others around it.
            let angle = 2.4 * k as f64;
            let off = if k == 0 { 0.0 } else { radius * (0.5 + 0.2 * k as f64) };
            let place = Vector3::new(centre.x + off * angle.cos(), height, centre.z + off * angle.sin()) - travel * 0.5;
            Ok(PlanarLight::new(place, size, width, texture.clone())?.with_rotation(turn)?)
        };
        let lights = (0..args.lights).map(lamp).collect::<Result<_, _>>()?;
        let (view, occluders) = (View::eye(camera.eye().cast())?, Arc::new(Occluders::of_mesh(&mesh)));
        Ok(Self { name, mesh, materials, camera, view, occluders, lights, travel, radius })
    }

    /// The lamps after a share of their way.
    pub fn lights_at(&self, share: f64) -> Result<Vec<PlanarLight>, Failure> {
        let moved = |light: &PlanarLight| -> Result<PlanarLight, Failure> {
            let mut light = light.clone();
            light.set_centre(light.centre() + self.travel * share)?;
            Ok(light)
        };
        self.lights.iter().map(moved).collect()
    }
}

/// Lamps for ground truth.
pub fn local(lights: &[PlanarLight]) -> Result<Vec<LocalLight>, Failure> {
    Ok(lights.iter().map(|light| light.to_local_light(&BakeSettings::default().frame)).collect::<Result<_, _>>()?)
}

/// A diffuse floor, and coloured objects on it, glossy or not.
pub fn palette(model: &Model, is_glossy: bool) -> Result<Materials, Failure> {
    let colours = [[0.75, 0.24, 0.12], [0.15, 0.35, 0.6], [0.6, 0.5, 0.2], [0.25, 0.5, 0.3]];
    let brdf = |(i, name): (usize, &&str)| -> Result<Arc<dyn Brdf>, Failure> {
        if *name == "floor" || model.part_names.len() == 1 {
            return Ok(Arc::new(Lambert::new([0.72, 0.7, 0.66])?));
        }
        let body: Arc<dyn Brdf> = Arc::new(Lambert::new(colours[i % colours.len()])?);
        if !is_glossy {
            return Ok(body);
        }
        let gloss: Arc<dyn Brdf> = Arc::new(Phong::new([0.2; 3], 30.0)?);
        Ok(Arc::new(Sum::new(vec![(1.0, body), (1.0, gloss)])?))
    };
    let brdfs = model.part_names.iter().enumerate().map(brdf).collect::<Result<_, _>>()?;
    Ok(Materials::new(brdfs, model.parts.iter().map(|&part| u32::from(part)).collect())?)
}

/// The names of the built-in textures, from smooth to rough.
pub const TEXTURES: [&str; 4] = ["gradient", "discs", "window", "noise"];

/// A built-in texture, or that of a file: its width and texels.
pub fn texture(name: &str) -> Result<(usize, Vec<Vector3<f32>>), Failure> {
    if !TEXTURES.contains(&name) {
        let loaded = io::load_image(name)?;
        loaded.warnings.iter().for_each(warn);
        let image = loaded.value;
        return Ok((image.width(), image.into_pixels()));
    }
    const SIDE: usize = 64;
    let texel = |i: usize| -> Vector3<f32> {
        let [u, v] = [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32);
        match name {
            "gradient" => Vector3::new(0.4 + 5.0 * u, 1.5, 5.4 - 5.0 * u) * (0.4 + v),
            "discs" => {
                let discs = [
                    ([0.3, 0.3], 0.2, [9.0, 2.0, 1.0]),
                    ([0.7, 0.4], 0.15, [1.0, 7.0, 2.0]),
                    ([0.5, 0.75], 0.18, [1.5, 2.5, 10.0]),
                ];
                let lit = |&&([x, y], r, _): &&([f32; 2], f32, [f32; 3])| (u - x).hypot(v - y) < r;
                discs.iter().find(lit).map_or(Vector3::repeat(0.2), |disc| disc.2.into())
            }
            "window" => {
                // Panes of coloured glass between bars.
                let [a, b] = [u, v].map(|x| (6.0 * x).fract());
                let pane = (6.0 * u) as usize * 7 + (6.0 * v) as usize * 4;
                let colours = [[8.0, 1.0, 0.6], [0.7, 2.0, 8.0], [7.0, 5.0, 0.8], [0.8, 6.0, 1.4], [5.0, 5.0, 5.5]];
                match a.min(b) < 0.12 {
                    true => Vector3::repeat(0.05),
                    false => Vector3::from(colours[pane % colours.len()]),
                }
            }
            _ => {
                let hash = |k: usize| ((i * 3 + k + 1).wrapping_mul(0x9e37_79b9) >> 7) as u16;
                Vector3::from_fn(|k, _| 6.0 * f32::from(hash(k)) / 65535.0)
            }
        }
    };
    Ok((SIDE, (0..SIDE * SIDE).map(texel).collect()))
}
