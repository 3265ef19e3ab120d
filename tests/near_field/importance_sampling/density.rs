//! Densities against their twin, and what holds of all of them.

use haarmonic::backend::near_field::{
    BrdfScratch, BrdfTable, DirectionSampler, LightSampler, LightWeight, PlanarLight, ProductSampler, ProductSettings,
    ShadingPoint, Window,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::backend::near_field_sampling::{Light, product_density};
use haarmonic::scene::{Brdf, Lambert, Phong};
use proptest::prelude::*;

use super::{brushed, discs, frame, gold, points, up};
use crate::support::{cases, noise};

/// The corners of the window in the plane above a point, and the light's centre seen from there.
fn window_of(light: &PlanarLight, settings: &ProductSettings, point: &ShadingPoint) -> ([[f64; 2]; 2], Vector3<f64>) {
    let (to, half) = (up().to_local(&(light.centre() - point.position)), 0.5 * settings.face);
    let seen = [-0.5, 0.5].map(|end| [0, 1].map(|k| (to[k] + end * light.extent()[k]) / to.z));
    let clipped = seen.map(|end| end.map(|v| v.clamp(-half, half)));
    let window = match settings.window {
        Window::Face => [[-half; 2], [half; 2]],
        Window::Light if clipped[0][0] < clipped[1][0] && clipped[0][1] < clipped[1][1] => clipped,
        Window::Light => seen,
    };
    (window, to)
}

/// The middle of a cell of the window, at distance 1 along z, and the cell's solid angle by the midpoint rule.
fn cell(window: &[[f64; 2]; 2], side: usize, i: usize) -> (Vector3<f64>, f64) {
    let middle = |k: usize, i: usize| window[0][k] + (window[1][k] - window[0][k]) * (i as f64 + 0.5) / side as f64;
    let d = Vector3::new(middle(0, i % side), middle(1, i / side), 1.0);
    let area = (window[1][0] - window[0][0]) * (window[1][1] - window[0][1]) / (side * side) as f64;
    (up().to_world(&d.normalize()), area / d.norm().powi(3))
}

/// The largest difference from the twin over the cells of the window, relative to the largest density.
fn off_twin(
    light: &PlanarLight,
    settings: ProductSettings,
    point: &ShadingPoint,
    brdf: &dyn Brdf,
    table: &BrdfTable,
) -> f64 {
    let (frame, side) = (up(), settings.side);
    let sampler = ProductSampler::new(light, &frame, settings).unwrap();
    let mut scratch = sampler.scratch();
    let density = sampler.density(point, table, &mut scratch);
    let [width, height] = light.texture_size();
    let largest = light.texture().iter().map(|l| l.amax()).fold(0.0, f32::max);
    let cells: Vec<f64> = (0..width * height).map(|i| f64::from(light.radiance(i).norm() / largest)).collect();
    let (window, to) = window_of(light, &settings, point);
    let twin = Light { side: width, cells: &cells, extent: light.size(), centre: to.into() };
    let wo = point.frame.to_local(&point.wo);
    let want = product_density(&twin, window, side, |direction| {
        let wi = point.frame.to_local(&frame.to_world(direction));
        if wi.z > 0.0 { brdf.eval(&wi, &wo).norm() * wi.z } else { 0.0 }
    });
    let largest = want.iter().copied().fold(0.0, f64::max);
    let off = |i: usize| (density.first().pdf(&cell(&window, side, i).0) - want[i]).abs();
    (0..side * side).map(off).fold(0.0, f64::max) / largest
}

/// With all terms the density is the product, whatever is between the light's texels and the window's cells; a table of
/// Lambert's law is exact, and so the rest of the way is judged to rounding.
#[test]
fn densities_are_the_product() {
    let lambert = Lambert::new([0.7, 0.5, 0.2]).unwrap();
    let exact = BrdfTable::new(&lambert, 1, 1).unwrap();
    let phong = Phong::new([0.7, 0.5, 0.2], 20.0).unwrap();
    let fine = BrdfTable::new(&phong, 256, 128).unwrap();
    // The last face cuts the light off: what is seen of it may be dim, and its rounding is that of the brightest texel.
    let cases = [(Window::Face, 10.0, 1.5e-6), (Window::Light, 10.0, 1.5e-6), (Window::Light, 0.9, 1.3e-5)];
    for (window, face, rounding) in cases {
        let settings = ProductSettings { side: 32, window, face, ..ProductSettings::default() };
        let mut worst = [0.0_f64; 2];
        for (light, point) in [16, 32].into_iter().flat_map(|side| points().map(|point| (discs(side, 1.1), point))) {
            if window == Window::Face && point.position.x > 5.0 {
                continue; // the face does not meet the light
            }
            worst[0] = worst[0].max(off_twin(&light, settings, &point, &lambert, &exact));
            worst[1] = worst[1].max(off_twin(&light, settings, &point, &phong, &fine));
        }
        // Rounding of f32; the table of Phong's lobe between its entries.
        assert!(worst[0] < rounding && worst[1] < 1.7e-2, "{window:?}: {worst:?}");
    }
}

/// The density integrates to 1 over the window whatever was truncated: over a cell it times solid angle is constant.
#[test]
fn densities_of_cells_sum_to_one() {
    let (light, table) = (discs(16, 0.9), BrdfTable::new(&gold(), 16, 32).unwrap());
    for window in [Window::Face, Window::Light] {
        for keep in [Keep::Terms(1), Keep::Terms(5), Keep::Fraction(0.1), Keep::Fraction(1.0)] {
            let settings = ProductSettings { side: 16, keep, window, ..ProductSettings::default() };
            let sampler = ProductSampler::new(&light, &up(), settings).unwrap();
            let mut scratch = sampler.scratch();
            for point in points() {
                let density = sampler.density(&point, &table, &mut scratch);
                if density.first().is_empty() {
                    assert!(density.share() == 1.0 && window == Window::Face && point.position.x > 5.0);
                    continue;
                }
                let (corners, _) = window_of(&light, &settings, &point);
                let share = |i: usize| {
                    let (direction, solid_angle) = cell(&corners, 16, i);
                    density.first().pdf(&direction) * solid_angle
                };
                let integral: f64 = (0..256).map(share).sum();
                assert!((integral - 1.0).abs() < 1e-12, "{settings:?}, {}: {integral}", point.position);
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(48))]

    /// A sample's density is the density at the sample, but for the borders of cells, which rounding crosses.
    #[test]
    fn samples_say_their_density(seed in 0..100_000_usize, keep in 1..300_usize, rotation in -3.0..3.0_f64) {
        let light = discs(16, 1.0).with_rotation(rotation).unwrap();
        let windows = [Window::Face, Window::Light];
        let settings =
            ProductSettings { side: 16, keep: Keep::Terms(keep), window: windows[seed % 2], ..ProductSettings::default() };
        let sampler = ProductSampler::new(&light, &up(), settings).unwrap();
        let area = LightSampler::new(&light, &up(), LightWeight::Area).unwrap();
        let tables = [BrdfTable::new(&gold(), 8, 16).unwrap(), BrdfTable::new(&brushed(), 4, 16).unwrap()];
        let (mut scratch, mut brdf_scratch) = (sampler.scratch(), BrdfScratch::new());
        let point = points()[seed % 4];
        let table = &tables[seed / 2 % 2];
        let density = sampler.density(&point, table, &mut scratch);
        let (light, brdf) = (area.density(&point.position), table.density(&point, &mut brdf_scratch));
        let all: [&dyn DirectionSampler; 4] = [&density, density.second(), &light, &brdf];
        for (k, sampler) in all.into_iter().enumerate() {
            let uniform = [noise(seed + 7 * k), noise(seed + 7 * k + 1)];
            let sample = sampler.sample(uniform).unwrap();
            prop_assert!((sample.direction.norm() - 1.0).abs() < 1e-12 && sample.pdf > 0.0 && sample.pdf.is_finite());
            let pdf = sampler.pdf(&sample.direction);
            prop_assert!((pdf / sample.pdf - 1.0).abs() < 1e-9, "{k}: {pdf} against {}", sample.pdf);
        }
    }
}

/// Radiance may be of any size: only its shape counts.
#[test]
fn densities_do_not_depend_on_units() {
    let table = BrdfTable::new(&gold(), 16, 32).unwrap();
    let point = points()[1];
    let densities = [1.0_f32, 1e-30, 1e30].map(|unit| {
        let mut light = discs(16, 1.1);
        let scaled: Vec<_> = light.texture().iter().map(|l| l * unit).collect();
        light.set_texture(&scaled).unwrap();
        let sampler = ProductSampler::new(&light, &up(), ProductSettings::default()).unwrap();
        let mut scratch = sampler.scratch();
        let density = sampler.density(&point, &table, &mut scratch);
        (0..50).map(|i| density.sample([noise(i), noise(i + 50)]).unwrap().pdf).collect::<Vec<_>>()
    });
    for other in &densities[1..] {
        for (a, b) in densities[0].iter().zip(other) {
            assert!((a / b - 1.0).abs() < 1e-4, "{a} against {b}");
        }
    }
}

/// The table interpolates: between two views an isotropic BRDF is looked up turned, an anisotropic one among azimuths.
#[test]
fn brdf_sampling_follows_the_brdf() {
    // Cells in which the density is constant, mostly.
    for (brdf, views, cells, bound) in [(&gold() as &dyn Brdf, 32, 256, 0.055), (&brushed(), 16, 64, 0.2)] {
        let table = BrdfTable::new(brdf, views, cells).unwrap();
        let mut scratch = BrdfScratch::new();
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for k in 0..6 {
            let frame = frame([noise(k) - 0.5, noise(k + 9) - 0.2, 0.3]);
            let (angle, height) = (std::f64::consts::TAU * noise(k + 20), 0.3 + 0.6 * noise(k + 30));
            let flat = (1.0_f64 - height * height).sqrt();
            let wo = Vector3::new(flat * angle.cos(), flat * angle.sin(), height);
            let point = ShadingPoint { position: Vector3::zeros(), frame, wo: frame.to_world(&wo) };
            let density = table.density(&point, &mut scratch);
            // The integral of the norm of the BRDF times the cosine, by quadrature.
            let n = 300;
            let direction = |i: usize| {
                let (z, a) = ((i / n) as f64 + 0.5, (i % n) as f64 + 0.5);
                let (z, a) = (z / n as f64, a / n as f64 * std::f64::consts::TAU);
                let flat = (1.0 - z * z).sqrt();
                Vector3::new(flat * a.cos(), flat * a.sin(), z)
            };
            let value = |d: &Vector3<f64>| brdf.eval(d, &wo).norm() * d.z;
            let total = (0..n * n).map(|i| value(&direction(i))).sum::<f64>() * std::f64::consts::TAU / (n * n) as f64;
            for i in (0..n * n).step_by(37) {
                let d = direction(i);
                let want = value(&d) / total;
                worst = worst.max((density.pdf(&frame.to_world(&d)) - want).abs());
                largest = largest.max(want);
            }
        }
        assert!(worst < bound * largest, "{views} views: {}", worst / largest);
    }
}
