//! A light in few bands: rings, windows, and what they do to irradiance.

use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::scene::{EnvironmentLight, ToneMap, percentile_peak};
use haarmonic::sh::{
    Basis, CubeProjection, CubeReconstruction, DeringBy, DeringWindow, Deringing, Extrema, LatLongReconstruction,
    TexelRule, Window, Zonal,
};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::args::Args;
use crate::support::Failure;
use crate::support::sheet::{Panel, Sheet};
use crate::support::table;

/// Size of a picture of the light.
const MAP: [usize; 2] = [256, 128];
type Rgb = Vector3<f64>;
type Coefficients = [Vec<f64>; 3];

/// One way to treat an expansion, and what came of it.
struct Treated {
    name: &'static str,
    bands: usize,
    light_error: f64,
    least: f64,
    irradiance_error: f64,
    darkest: f64,
    coefficients: Coefficients,
}

pub struct Study {
    name: String,
    light: CubeMap<Rgb>,
    normals: Vec<UnitVector3<f64>>,
    irradiance: Vec<Rgb>,
    treated: Vec<Treated>,
}

impl Study {
    pub fn new(args: &Args, (name, light): (String, EnvironmentLight)) -> Result<Self, Failure> {
        let light = light.to_cube(CubeGrid::new(args.resolution)?).map(|texel| texel.cast::<f64>());
        let normals = CubeGrid::new(16)?.directions();
        let irradiance = normals.par_iter().map(|n| irradiance_at(&light, n)).collect();
        let mut study = Self { name, light, normals, irradiance, treated: Vec::new() };
        for &bands in &args.bands {
            study.treat(bands)?;
        }
        Ok(study)
    }

    /// The expansion as it is, under a window of fixed width, and under the mildest two that keep it positive.
    fn treat(&mut self, bands: usize) -> Result<(), Failure> {
        let plain = CubeProjection::new(self.light.grid(), bands, TexelRule::Mean)?.project::<Rgb, 3>(&self.light);
        let mut hanning = plain.clone();
        hanning.iter_mut().for_each(|c| Window::Hanning { width: bands as f64 }.apply(c));
        let deringed = |family: DeringWindow| -> Result<Coefficients, Failure> {
            let mut c = plain.clone();
            let plan = Deringing::new(bands)?.with_window(family);
            plan.apply(c.each_mut().map(|c| &mut c[..]), 0.0, DeringBy::AllChannels)?;
            Ok(c)
        };
        let curvature = deringed(DeringWindow::Curvature)?;
        let heat = deringed(DeringWindow::Gaussian)?;
        let all = [("as it is", plain), ("Hanning", hanning), ("least curvature", curvature), ("flow of heat", heat)];
        for (name, coefficients) in all {
            let treated = self.measure(name, bands, coefficients)?;
            self.treated.push(treated);
        }
        Ok(())
    }

    fn measure(&self, name: &'static str, bands: usize, coefficients: Coefficients) -> Result<Treated, Failure> {
        let grid = self.light.grid();
        let seen: CubeMap<Rgb> =
            CubeReconstruction::new(grid, bands, TexelRule::Mean)?.reconstruct(slices(&coefficients));
        let energy = |map: &CubeMap<Rgb>| map.map(|texel| texel.norm_squared()).integral();
        let difference = self.light.zip_map(&seen, |a, b| a - b);
        let extrema = Extrema::new(bands)?;
        let mut least = f64::INFINITY;
        for channel in &coefficients {
            least = least.min(extrema.minimum(channel)?.value);
        }
        let (irradiance_error, darkest) = self.irradiance_error(bands, &coefficients)?;
        Ok(Treated {
            name,
            bands,
            light_error: (energy(&difference) / energy(&self.light)).sqrt(),
            least,
            irradiance_error,
            darkest,
            coefficients,
        })
    }

    /// Relative L² error over all normals, and the least irradiance of any channel.
    fn irradiance_error(&self, bands: usize, coefficients: &Coefficients) -> Result<(f64, f64), Failure> {
        let cosine = Zonal::clamped_cosine(bands)?;
        let basis = Basis::new(bands)?;
        let convolved = coefficients.clone().map(|mut c| {
            cosine.convolve(&mut c);
            c
        });
        let (mut wrong, mut whole, mut least) = (0.0, 0.0, f64::INFINITY);
        for (n, truth) in self.normals.iter().zip(&self.irradiance) {
            let e = Vector3::from([0, 1, 2].map(|c| basis.dot(&convolved[c], n)));
            wrong += (e - truth).norm_squared();
            whole += truth.norm_squared();
            least = least.min(e.min());
        }
        Ok(((wrong / whole).sqrt(), least))
    }

    pub fn table(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .treated
            .iter()
            .map(|t| {
                vec![
                    format!("{} bands, {}", t.bands, t.name),
                    format!("{}", t.bands * t.bands),
                    format!("{:.3}", t.light_error),
                    format!("{:+.3}", t.least),
                    format!("{:.4}", t.irradiance_error),
                    format!("{:+.3}", t.darkest),
                ]
            })
            .collect();
        table::format(
            &["", "coefficients", "error of light", "least radiance", "error of irradiance", "least irradiance"],
            &rows,
        )
    }

    pub fn report(&self) -> Vec<Value> {
        let row = |t: &Treated| {
            json!({
                "method": t.name, "bands": t.bands, "light_rel_l2": t.light_error, "least_radiance": t.least,
                "irradiance_rel_l2": t.irradiance_error, "least_irradiance": t.darkest,
            })
        };
        self.treated.iter().map(row).collect()
    }

    /// The light, then a row of pictures for each size.
    pub fn draw(&self) -> Result<Sheet, Failure> {
        let grid = LatLongGrid::new(MAP[0], MAP[1])?;
        let tone = ToneMap::with_white(0.5 * percentile_peak(self.light.texels())?);
        let panel = |caption: Vec<String>, radiance: &dyn Fn(usize) -> Rgb| {
            let pixels = (0..MAP[0] * MAP[1]).map(|i| show(tone, &radiance(i))).collect();
            Some(Panel { caption, width: MAP[0], height: MAP[1], pixels })
        };
        let whole = |i: usize| self.light.bilinear(&grid.direction(i));
        let mut rows = vec![vec![panel(vec![format!("{}, {} texels", self.name, self.light.texels().len())], &whole)]];
        for row in self.treated.chunks(4) {
            let mut panels = Vec::new();
            for t in row {
                let plan = LatLongReconstruction::new(grid, t.bands, TexelRule::Centre)?;
                let map = plan.reconstruct::<Rgb, 3>(slices(&t.coefficients));
                let figures = format!("error {:.3}, least {:+.2}", t.light_error, t.least).replace('-', "−");
                panels.push(panel(vec![format!("{} bands, {}", t.bands, t.name), figures], &|i| map.pixels()[i]));
            }
            rows.push(panels);
        }
        Ok(Sheet::new("A light in spherical harmonics; violet: negative radiance", &rows))
    }
}

fn slices(coefficients: &Coefficients) -> [&[f64]; 3] {
    coefficients.each_ref().map(|c| &c[..])
}

/// ∫ L max(n·ω, 0) dω over the texels.
fn irradiance_at(light: &CubeMap<Rgb>, normal: &UnitVector3<f64>) -> Rgb {
    let grid = light.grid();
    let (side, areas) = (grid.side(), grid.face_solid_angles());
    let texels = light.texels().iter().enumerate();
    texels.map(|(i, l)| l * (areas[i % (side * side)] * grid.direction(i).dot(normal).max(0.0))).sum()
}

/// Tone-mapped; violet where a channel is negative by more than a thousandth.
fn show(tone: ToneMap, radiance: &Rgb) -> [u8; 3] {
    let low = -radiance.min() * f64::from(tone.exposure());
    if low > 1e-3 {
        let depth = low.min(0.5) * 2.0;
        return [0.45 + 0.45 * depth, 0.1, 0.55 + 0.4 * depth].map(|c| (c * 255.0) as u8);
    }
    tone.apply(&radiance.cast())
}
