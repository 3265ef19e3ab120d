//! Lights at the ends of what `f32` can say.

use std::sync::Arc;

use haarmonic::backend::block_product::{BlockAngle, LightForms, Rule, SampleBasis, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, BrdfFn, CookTorrance, Lambert, Phong, Sum, Ward};

use super::support::{above, constant, frame, in_turn, layout, lobe, patchwork, view};
use crate::support::{noisy, soup};

const RULES: [Rule; 4] = [
    Rule::Pixels,
    Rule::Fixed { angle: BlockAngle::Nearest },
    Rule::Bounded { tolerance: 0.1 },
    Rule::Bounded { tolerance: 0.0 },
];

fn lobes() -> Vec<Arc<dyn Brdf>> {
    let rgb = [0.9, 0.5, 0.2];
    let lambert = lobe(Lambert::new(rgb).unwrap());
    let both = vec![(0.5, lambert.clone()), (0.5, lobe(Phong::new(rgb, 20.0).unwrap()))];
    vec![
        lambert,
        lobe(Phong::new(rgb, 50.0).unwrap()),
        lobe(Ward::isotropic(rgb, 0.3).unwrap()),
        lobe(CookTorrance::isotropic(rgb, 0.3).unwrap()),
        lobe(BrdfFn::new(|_: &Vector3<f64>, _: &Vector3<f64>| Vector3::repeat(0.3))),
        lobe(Sum::new(both).unwrap()),
    ]
}

/// A light times a power of two gives radiance times that power, wherever both are ordinary numbers.
#[test]
fn light_may_be_of_any_size() {
    let mesh = soup(30);
    let materials = in_turn(&lobes(), mesh.positions().len());
    let maps = above(&mesh, 32, patchwork(32, 16, 3));
    let transport = Transport::from_binary(&mesh, &maps, &layout(32, 16, ScanOrder::Serpentine)).unwrap();
    for light in [constant(32, 1.0), noisy(32, 8)] {
        for rule in RULES {
            let settings = Settings { rule, ..Settings::default() };
            let of = |power: i32| {
                let factor = f64::from(power).exp2();
                let light = light.map(|l| l.map(|x| (f64::from(x) * factor) as f32));
                let radiance = frame((&mesh, &transport), settings, &light, &view(), &materials);
                assert!(radiance.iter().all(|l| l.iter().all(|x| x.is_finite())), "{rule:?}, 2^{power}");
                radiance.iter().map(|l| l.cast::<f64>() / factor).collect::<Vec<_>>()
            };
            let expected = of(0);
            let largest = expected.iter().map(|l| l.amax()).fold(0.0, f64::max);
            assert!(largest > 0.0);
            // The last is half of the largest number; noise reaches 5 and lobes 4 times that.
            for power in [-100, -60, -41, -40, 87, 90, 91, 120, 123] {
                assert_eq!(of(power), expected, "{rule:?}, 2^{power}");
            }
            // Denormal: texels of the noise have a few bits left of 24, radiance has too.
            for power in [-130, -140] {
                let steps = 2.0_f64.powi(-149 - power);
                for (got, want) in of(power).iter().zip(&expected) {
                    // A light that is rounded by half a step, through lobes of albedo 1 that see up to all of it twice.
                    let off = (got - want).amax();
                    assert!(off <= 4.0 * steps, "{rule:?}, 2^{power}: {got:?} for {want:?}");
                }
            }
        }
    }
}

/// Radiance that fits is exact at the largest number, what does not is held there.
#[test]
fn a_constant_light_of_the_largest_number() {
    let mesh = soup(30);
    let maps = above(&mesh, 32, |_, _| true);
    let transport = Transport::from_binary(&mesh, &maps, &layout(32, 16, ScanOrder::Serpentine)).unwrap();
    let white = Lambert::new([1.0, 0.5, 0.25]).unwrap();
    let bright = BrdfFn::new(|_: &Vector3<f64>, _: &Vector3<f64>| Vector3::new(5.0, -5.0, 0.0));
    let materials = in_turn(&[lobe(white), lobe(bright)], mesh.positions().len());
    for rule in RULES {
        let settings = Settings { rule, ..Settings::default() };
        let of = |light: f32| frame((&mesh, &transport), settings, &constant(32, light), &view(), &materials);
        let (ones, got) = (of(1.0), of(f32::MAX));
        let mut is_held = false;
        for (one, got) in ones.iter().zip(&got) {
            for (one, got) in one.iter().zip(got) {
                let want = (f64::from(*one) * f64::from(f32::MAX)).clamp(f64::from(f32::MIN), f64::from(f32::MAX));
                is_held |= want.abs() == f64::from(f32::MAX) && one.abs() > 2.0;
                // MAX is a rounding short of a power of two.
                assert!((f64::from(*got) - want).abs() <= 3e-7 * want.abs(), "{rule:?}: {got:e} for {want:e}");
            }
        }
        assert!(is_held);
    }
}

#[test]
fn the_smallest_lights_are_light() {
    let mesh = soup(10);
    let maps = above(&mesh, 16, |_, _| true);
    let transport = Transport::from_binary(&mesh, &maps, &layout(16, 8, ScanOrder::Serpentine)).unwrap();
    let materials = in_turn(&[lobe(Lambert::new([1.0; 3]).unwrap())], mesh.positions().len());
    for rule in RULES {
        let settings = Settings { rule, ..Settings::default() };
        for light in [f32::from_bits(1), f32::from_bits(2), f32::MIN_POSITIVE] {
            let radiance = frame((&mesh, &transport), settings, &constant(16, light), &view(), &materials);
            let largest = radiance.iter().map(|l| l.x).fold(0.0, f32::max);
            // White under a constant light, all of it seen: as bright.
            assert!(largest >= 0.97 * light && largest <= 1.03 * light, "{rule:?}: {largest:e} for {light:e}");
        }
    }
}

#[test]
fn a_scale_is_said() {
    let layout = layout(16, 8, ScanOrder::Serpentine);
    let mut forms = LightForms::new(&layout, SampleBasis::default()).unwrap();
    for (largest, scale) in [
        (0.0, 1.0),
        (1.0, 1.0),
        (2.0_f32.powi(-40), 1.0),
        (2.0_f32.powi(-41), 0.5),
        (2.0_f32.powi(90) * 1.9, 1.0),
        (2.0_f32.powi(91), 2.0),
        (f32::MAX, 2.0_f64.powi(37)),
        (f32::from_bits(1), 2.0_f64.powi(-109)),
    ] {
        forms.set(&constant(16, largest)).unwrap();
        assert_eq!(forms.scale(), scale, "{largest:e}");
        let sum: f64 = (0..24).map(|block| f64::from(forms.weights(0, block)[0])).sum::<f64>() * scale;
        let want = f64::from(largest) * 4.0 * std::f64::consts::PI;
        assert!((sum - want).abs() <= 1e-6 * want, "{largest:e}: {sum:e}");
    }
}
