//! A scene and its light.

use std::time::Instant;

use haarmonic::Result;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    Bvh, Convergence, Fog, Interreflection, Lambert, LocalLight, LocalTruth, Materials, Mesh, Outgoing, Phase, Picture,
    PixelSample, RectangleLight, Stage, Staged, ToneMap, View, percentile_peak,
};

use crate::support::progress::Bar;
use crate::support::sheet::Panel;

/// A scene, its objects as one mesh, and the radiance of every vertex.
pub struct Lit {
    stage: Stage,
    pub staged: Staged,
    pub mesh: Mesh,
    lights: Vec<LocalLight>,
    fog: Option<Fog>,
    radiance: Vec<Vector3<f32>>,
    pub lamps: usize,
    /// Samples, and how far the result moved from half as many.
    pub steps: Vec<(usize, f64)>,
    pub seconds: f64,
}

/// Lights a scene by its lamps and a panel at the side of the camera.
pub fn light(stage: Stage, vertices: usize, phase: f64, samples: usize) -> Result<Lit> {
    let staged = stage.build(vertices, phase)?;
    let (mesh, occluders) = (staged.merged()?, staged.occluders()?);
    let mut lights = staged.lights.clone();
    let lamps = lights.len();
    // Scenes without lamps of their own have the panel alone; where there are some, it fills the shadows.
    let radiance = if lamps == 0 { 14.0 } else { 0.7 };
    lights.push(LocalLight::Rectangle(panel(&staged, radiance)?));
    let fog = (stage == Stage::Street)
        .then(|| Fog::new(Vector3::new(0.03, 0.033, 0.036), Vector3::repeat(0.004), Phase::HenyeyGreenstein(0.4)))
        .transpose()?;
    let albedo = Vector3::new(0.72, 0.68, 0.62);
    let (materials, view) = (Materials::uniform(Lambert::new(albedo)?), View::towards(Vector3::y())?);
    let truth = LocalTruth {
        mesh: &mesh,
        materials: &materials,
        view: &view,
        lights: &lights,
        occluders: Some(&occluders),
        fog: None,
    };
    let start = Instant::now();
    let found = Convergence::by_doubling(samples, 4 * samples, 0.0, |n| {
        let bar = Bar::new(stage.name());
        let radiance = truth.radiance(n, &bar);
        bar.finish();
        radiance
    })?;
    let mut radiance = found.values;
    if stage == Stage::Temple {
        let bvh = Bvh::new(&mesh);
        let more = Interreflection { mesh: &mesh, bvh: &bvh, materials: &materials, view: &view };
        let bar = Bar::new("temple, reflections");
        let reflected = more.radiance(&Outgoing::Diffuse(radiance.clone()), 2, 8, &bar)?;
        bar.finish();
        radiance.iter_mut().zip(reflected).for_each(|(sum, more)| *sum += more);
    }
    Ok(Lit {
        stage,
        staged,
        mesh,
        lights,
        fog,
        radiance: radiance.iter().map(|l| l.cast()).collect(),
        lamps,
        steps: found.steps,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// A panel above the left shoulder of the viewer that faces the middle of the scene.
fn panel(staged: &Staged, radiance: f32) -> Result<RectangleLight> {
    let eye = staged.camera.eye();
    let middle = Vector3::new(0.0, 0.5, 0.0);
    let across = Vector3::y().cross(&(eye - middle)).normalize();
    let distance = 0.8 * (eye - middle).norm();
    let centre = middle + (eye - middle) * 0.35 - across * (0.75 * distance) + Vector3::y() * (0.9 * distance);
    let to_scene = (middle - centre).normalize();
    let u = Vector3::y().cross(&to_scene).normalize();
    let v = to_scene.cross(&u);
    RectangleLight::uniform(centre, u * (0.16 * distance), v * (0.16 * distance), Vector3::repeat(radiance))
}

impl Lit {
    /// A picture of it with a caption.
    pub fn panel(&self, size: usize) -> Result<Panel> {
        let camera = &self.staged.camera;
        let picture = Picture::new(&self.mesh, &Bvh::new(&self.mesh), camera, [size, size], 3)?;
        let sky = Vector3::new(0.03, 0.035, 0.045);
        let clear = |sample: &PixelSample| sample.hit.map_or(sky, |hit| hit.interpolate(&self.mesh, &self.radiance));
        let pixels = picture.shade_samples(|sample| {
            let Some(fog) = &self.fog else { return clear(sample) };
            // What is left of the surface, and what the fog adds on the way to the eye.
            let depth = sample.hit.map_or(40.0, |hit| f64::from(hit.depth));
            let airlight = fog.airlight(&camera.eye(), &sample.direction, depth, &self.lights, None, 12);
            clear(sample).component_mul(&fog.transmittance(depth).cast()) + airlight.cast()
        });
        let tone = ToneMap::with_white(percentile_peak(&pixels)?);
        let objects = self.staged.objects.len();
        let what = match self.stage {
            Stage::Temple => ", two reflections",
            Stage::Street => ", in fog",
            _ => "",
        };
        Ok(Panel {
            caption: vec![format!("{}: {objects} objects{what}", self.stage.name())],
            width: size,
            height: size,
            pixels: pixels.iter().map(|pixel| tone.apply(pixel)).collect(),
        })
    }
}
