//! Samples against the density that they say, by counts.

use haarmonic::backend::near_field::{
    BrdfScratch, BrdfTable, DirectionSampler, Incidence, LightSampler, LightWeight, Mixture, ProductSampler,
    ProductSettings, Window,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::LocalFrame;

use super::{brushed, discs, gold, points, up};
use crate::support::noise;

/// Bins of equal solid angle about an axis, each cut into `FINE`² parts for its integral.
const RINGS: usize = 16;
const AROUND: usize = 32;
const FINE: usize = 32;
const SAMPLES: usize = 20_000;

/// How many standard deviations Pearson's statistic lies above its mean [Wilson & Hilferty 1931], and the integral of
/// the density over the hemisphere of `frame`; bins of fewer than 5 samples are one.
fn fit(sampler: &dyn DirectionSampler, frame: &LocalFrame, seed: usize) -> (f64, f64) {
    let bins = RINGS * AROUND;
    let direction = |z: f64, around: f64| {
        let (flat, angle) = ((1.0 - z * z).max(0.0).sqrt(), around * std::f64::consts::TAU);
        frame.to_world(&Vector3::new(flat * angle.cos(), flat * angle.sin(), z))
    };
    let part = std::f64::consts::TAU / (bins * FINE * FINE) as f64;
    let expected: Vec<f64> = (0..bins)
        .map(|bin| {
            let at = |i: usize, of: usize, cells: usize| (of as f64 + (i as f64 + 0.5) / FINE as f64) / cells as f64;
            let values = (0..FINE * FINE).map(|i| {
                sampler.pdf(&direction(at(i / FINE, bin / AROUND, RINGS), at(i % FINE, bin % AROUND, AROUND)))
            });
            values.sum::<f64>() * part
        })
        .collect();
    let integral: f64 = expected.iter().sum();
    let mut counts = vec![0.0; bins];
    for i in 0..SAMPLES {
        let sample = sampler.sample([noise(seed + 2 * i), noise(seed + 2 * i + 1)]).unwrap();
        let local = frame.to_local(&sample.direction);
        let ring = ((local.z * RINGS as f64) as usize).min(RINGS - 1);
        let angle = (local.y.atan2(local.x) / std::f64::consts::TAU).rem_euclid(1.0);
        counts[ring * AROUND + ((angle * AROUND as f64) as usize).min(AROUND - 1)] += 1.0;
    }
    let (mut statistic, mut terms, mut rest) = (0.0, 0, [0.0; 2]);
    for (count, share) in counts.iter().zip(&expected) {
        let expected = share / integral * SAMPLES as f64;
        if expected < 5.0 {
            rest = [rest[0] + count, rest[1] + expected];
        } else {
            statistic += (count - expected) * (count - expected) / expected;
            terms += 1;
        }
    }
    if rest[1] > 0.0 {
        statistic += (rest[0] - rest[1]).powi(2) / rest[1].max(1.0);
        terms += 1;
    }
    let freedom = f64::from(terms - 1).max(1.0);
    let spread = 2.0 / (9.0 * freedom);
    (((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt(), integral)
}

/// Pearson's test at a significance of 0.0005 a case, and the integral of every density.
#[test]
fn counts_fit_every_density() {
    let near = discs(16, 0.5).with_rotation(0.4).unwrap();
    let mut scratch = BrdfScratch::new();
    let check = |what: &str, sampler: &dyn DirectionSampler, frame: &LocalFrame| {
        let (deviations, integral) = fit(sampler, frame, 1234);
        // The normal distribution's quantile of 0.9995.
        assert!(deviations < 3.29, "{what}: {deviations}");
        // The quadrature's error at the borders of cells.
        assert!((integral - 1.0).abs() < 0.005, "{what}: {integral}");
    };
    let [first, tilted, ..] = points();
    for weight in [LightWeight::Area, LightWeight::Radiance] {
        let light = LightSampler::new(&near, &up(), weight).unwrap();
        check(&format!("{weight:?}"), &light.density(&first.position), &up());
    }
    let (gold, brushed) = (BrdfTable::new(&gold(), 16, 32).unwrap(), BrdfTable::new(&brushed(), 8, 32).unwrap());
    for (what, table) in [("gold", &gold), ("brushed", &brushed)] {
        check(what, &table.density(&tilted, &mut scratch), &tilted.frame);
    }
    let whole = ProductSettings::default();
    let settings = [
        ("product", whole),
        ("face", ProductSettings { window: Window::Face, side: 32, ..whole }),
        ("truncated", ProductSettings { keep: Keep::Terms(12), window: Window::Face, side: 32, ..whole }),
        ("distant", ProductSettings { incidence: Incidence::Distant(Vector3::new(0.5, 0.1, 0.1)), ..whole }),
        ("no light sampling", ProductSettings { light_share: 0.0, ..whole }),
    ];
    for (what, settings) in settings {
        let sampler = ProductSampler::new(&near, &up(), settings).unwrap();
        let mut scratch = sampler.scratch();
        check(what, &sampler.density(&first, &gold, &mut scratch), &up());
    }
    let light = LightSampler::new(&near, &up(), LightWeight::Radiance).unwrap();
    let both = Mixture::new(light.density(&first.position), gold.density(&first, &mut scratch), 0.5).unwrap();
    check("multiple importance sampling", &both, &up());
}
