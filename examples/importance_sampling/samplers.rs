//! The rivals, and the reference.

use std::sync::Arc;

use haarmonic::Progress;
use haarmonic::backend::near_field::{
    BrdfScratch, BrdfTable, Incidence, LightSampler, LightWeight, Mixture, ProductSampler, ProductScratch,
    ProductSettings, Reflection, Window,
};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, LocalLight, Occluders};
use rayon::prelude::*;

use crate::args::{Args, Numbers};
use crate::scene::{Place, Scene};
use crate::support::Failure;
use crate::support::timer::seconds;

/// A way to draw directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    LightArea,
    LightRadiance,
    Brdf,
    Both,
    Distant,
    Face,
    Window,
}

impl Method {
    pub const ALL: [Self; 7] =
        [Self::LightArea, Self::LightRadiance, Self::Brdf, Self::Both, Self::Distant, Self::Face, Self::Window];

    pub fn name(self) -> &'static str {
        match self {
            Self::LightArea => "light, by area",
            Self::LightRadiance => "light, by radiance",
            Self::Brdf => "BRDF",
            Self::Both => "light and BRDF (MIS)",
            Self::Distant => "product, light distant",
            Self::Face => "product, whole face",
            Self::Window => "product, window on the light",
        }
    }
}

/// What all methods draw from, prepared once.
pub struct Samplers {
    area: LightSampler,
    radiance: LightSampler,
    /// Distant, whole face, window.
    products: [ProductSampler; 3],
    tables: [BrdfTable; 2],
    pub prepare_s: f64,
}

/// What a thread works with.
struct Scratch {
    products: [ProductScratch; 3],
    brdf: BrdfScratch,
}

impl Samplers {
    pub fn new(args: &Args, scene: &Scene) -> Result<Self, Failure> {
        let (samplers, prepare_s) = seconds(|| Self::prepare(args, scene));
        Ok(Self { prepare_s, ..samplers? })
    }

    fn prepare(args: &Args, scene: &Scene) -> Result<Self, Failure> {
        let (light, up) = (&scene.light, &scene.up);
        let whole = ProductSettings {
            side: args.order,
            keep: args.terms,
            light_share: args.share,
            ..ProductSettings::default()
        };
        // The middle of what is glossy stands for every place.
        let glossy: Vec<Vector3<f64>> =
            scene.places.iter().flatten().filter(|p| p.brdf == 1).map(|p| p.point.position).collect();
        let middle = glossy.iter().sum::<Vector3<f64>>() / glossy.len().max(1) as f64;
        let face = ProductSettings { window: Window::Face, ..whole };
        let distant = ProductSettings { incidence: Incidence::Distant(middle), ..whole };
        let product = |settings| ProductSampler::new(light, up, settings);
        let table = |brdf: &Arc<dyn Brdf>| BrdfTable::new(&**brdf, 32, 64);
        Ok(Self {
            area: LightSampler::new(light, up, LightWeight::Area)?,
            radiance: LightSampler::new(light, up, LightWeight::Radiance)?,
            products: [product(distant)?, product(face)?, product(whole)?],
            tables: [table(&scene.brdfs[0])?, table(&scene.brdfs[1])?],
            prepare_s: 0.0,
        })
    }

    /// An estimate of every pixel by one method, and microseconds a pixel on one thread.
    pub fn estimate(
        &self,
        method: Method,
        args: &Args,
        scene: &Scene,
        occluders: Option<&Occluders>,
        run: u32,
    ) -> (Vec<Vector3<f32>>, f64) {
        let scratch = || Scratch { products: [0, 1, 2].map(|k| self.products[k].scratch()), brdf: BrdfScratch::new() };
        let one = |scratch: &mut Scratch, (pixel, place): (usize, &Option<Place>)| {
            let Some(place) = place else { return Vector3::zeros() };
            let reflection = self.reflection(scene, place, occluders);
            let numbers = numbers(args.numbers, args.spp, pixel as u32, run);
            self.pixel(method, place, &reflection, numbers, scratch).cast()
        };
        let (pixels, seconds) = seconds(|| {
            scene.places.par_iter().enumerate().map_init(scratch, |scratch, place| one(scratch, place)).collect()
        });
        let places = scene.places.iter().flatten().count().max(1);
        (pixels, seconds * rayon::current_num_threads() as f64 / places as f64 * 1e6)
    }

    fn reflection<'a>(&'a self, scene: &'a Scene, place: &Place, occluders: Option<&'a Occluders>) -> Reflection<'a> {
        let brdf = &*scene.brdfs[place.brdf];
        Reflection { light: &self.radiance, brdf, point: place.point, occluders, start: place.start }
    }

    fn pixel(
        &self,
        method: Method,
        place: &Place,
        reflection: &Reflection<'_>,
        numbers: impl Iterator<Item = [f64; 2]>,
        scratch: &mut Scratch,
    ) -> Vector3<f64> {
        let (point, table) = (&place.point, &self.tables[place.brdf]);
        let product = |k: usize, scratch: &mut Scratch, numbers| {
            reflection.estimate(&self.products[k].density(point, table, &mut scratch.products[k]), numbers)
        };
        match method {
            Method::LightArea => reflection.estimate(&self.area.density(&point.position), numbers),
            Method::LightRadiance => reflection.estimate(&self.radiance.density(&point.position), numbers),
            Method::Brdf => reflection.estimate(&table.density(point, &mut scratch.brdf), numbers),
            Method::Both => {
                let by_brdf = table.density(point, &mut scratch.brdf);
                let both = Mixture::new(self.radiance.density(&point.position), by_brdf, 0.5);
                reflection.estimate(&both.expect("a half is a share"), numbers)
            }
            Method::Distant => product(0, scratch, numbers),
            Method::Face => product(1, scratch, numbers),
            Method::Window => product(2, scratch, numbers),
        }
    }

    /// The reference: the midpoint rule over parts of every texel of the lamp.
    pub fn truth(
        &self,
        scene: &Scene,
        occluders: Option<&Occluders>,
        samples: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Vector3<f32>>, Failure> {
        let light: LocalLight = scene.light.to_local_light(&scene.up)?;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let all = scene.places.len();
        let one = |place: &Option<Place>| {
            let mut sum = Vector3::zeros();
            if let Some(place) = place {
                let reflection = self.reflection(scene, place, occluders);
                light.sample(&place.point.position, samples, |part| {
                    // The integrand knows the light's radiance; of the part, only its solid angle is wanted.
                    let radiance = reflection.radiance(&part.direction);
                    if let Some(hit) = self.radiance.hit(&place.point.position, &part.direction) {
                        let channel = hit.radiance.imax();
                        sum += radiance * (part.irradiance[channel] / hit.radiance[channel]);
                    }
                });
            }
            let before = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if before % 1000 == 0 {
                progress.advance(before, all);
            }
            sum.cast()
        };
        Ok(scene.places.par_iter().map(one).collect())
    }
}

/// Pairs of uniform numbers of a pixel: the same for every method.
///
/// Stratified: the first two dimensions of Sobol's sequence, of which 2^k numbers lie one in each of 2^k equal
/// intervals, on either axis and in all oblong cells between; shifted by lot in every digit.
fn numbers(kind: Numbers, count: usize, pixel: u32, run: u32) -> impl Iterator<Item = [f64; 2]> {
    let seed = hash(pixel ^ hash(run));
    let unit = |bits: u32| f64::from(bits) / 2.0_f64.powi(32);
    let shift = [hash(seed), hash(seed ^ 0x9e37_79b9)];
    (0..count as u32).map(move |i| match kind {
        Numbers::Stratified => [unit(i.reverse_bits() ^ shift[0]), unit(second_dimension(i) ^ shift[1])],
        Numbers::Independent => [unit(hash(shift[0] ^ hash(2 * i))), unit(hash(shift[1] ^ hash(2 * i + 1)))],
    })
}

/// Sobol's second dimension: direction numbers v_k = v_{k−1} ⊕ v_{k−1}/2.
fn second_dimension(mut i: u32) -> u32 {
    let (mut bits, mut direction) = (0, 1_u32 << 31);
    while i > 0 {
        if i & 1 == 1 {
            bits ^= direction;
        }
        direction ^= direction >> 1;
        i >>= 1;
    }
    bits
}

/// Bits without a pattern.
fn hash(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}
