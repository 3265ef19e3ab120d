//! What is refused, what is empty, and what is not allocated.

use haarmonic::Error;
use haarmonic::backend::near_field::{
    BrdfScratch, BrdfTable, DirectionSampler, Incidence, LightSampler, LightWeight, Mixture, PlanarLight,
    ProductSampler, ProductSettings, Reflection, ShadingPoint, Window,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{BrdfFn, Lambert, LocalFrame};

use super::{brushed, discs, gold, points, up};

#[test]
fn constructors_refuse() {
    let (light, whole) = (discs(8, 1.0), ProductSettings { side: 8, ..ProductSettings::default() });
    let make = |settings| ProductSampler::new(&light, &up(), settings);
    for side in [1, 2, 1024] {
        assert!(make(ProductSettings { side, ..whole }).is_ok());
    }
    for side in [0, 3, 1000] {
        assert!(matches!(make(ProductSettings { side, ..whole }), Err(Error::NotPowerOfTwo { .. })), "{side}");
    }
    for side in [2048, usize::MAX] {
        assert!(matches!(make(ProductSettings { side, ..whole }), Err(Error::OutOfRange { .. })), "{side}");
    }
    for face in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::MAX] {
        assert!(matches!(make(ProductSettings { face, ..whole }), Err(Error::OutOfRange { .. })), "{face}");
    }
    for light_share in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(make(ProductSettings { light_share, ..whole }), Err(Error::OutOfRange { .. })),
            "{light_share}"
        );
        let empty = LightSampler::new(&light, &up(), LightWeight::Area).unwrap();
        let density = empty.density(&Vector3::zeros());
        assert!(matches!(Mixture::new(density, density, light_share), Err(Error::OutOfRange { .. })));
    }
    assert!([0.0, 1.0].iter().all(|&light_share| make(ProductSettings { light_share, ..whole }).is_ok()));
    for keep in [Keep::Fraction(f64::NAN), Keep::Fraction(1.5), Keep::Fraction(-0.1)] {
        assert!(matches!(make(ProductSettings { keep, ..whole }), Err(Error::OutOfRange { .. })));
    }
    assert_eq!(make(ProductSettings { keep: Keep::Terms(3), ..whole }).unwrap().terms(), 3);
    let from = Vector3::new(0.0, f64::NAN, 0.0);
    let refused = make(ProductSettings { incidence: Incidence::Distant(from), ..whole });
    assert!(matches!(refused, Err(Error::NotFinite { index: 1, .. })));
    for scale in [f32::NAN, f32::INFINITY, 0.0, 2.0] {
        let frame = LocalFrame { normal: up().normal * scale, ..up() };
        assert!(matches!(ProductSampler::new(&light, &frame, whole), Err(Error::OutOfRange { .. })), "{scale}");
        assert!(LightSampler::new(&light, &frame, LightWeight::Area).is_err());
    }
}

#[test]
fn tables_refuse() {
    let (gold, brushed) = (gold(), brushed());
    assert!(matches!(BrdfTable::new(&gold, 0, 8), Err(Error::OutOfRange { .. })));
    assert!(matches!(BrdfTable::new(&gold, usize::MAX, 8), Err(Error::OutOfRange { .. })));
    assert!(matches!(BrdfTable::new(&brushed, usize::MAX / 4, 8), Err(Error::OutOfRange { .. })));
    assert!(matches!(BrdfTable::new(&gold, 8, 4096), Err(Error::OutOfRange { .. })));
    assert!(
        [0, 3, usize::MAX].iter().all(|&n| matches!(BrdfTable::new(&gold, 8, n), Err(Error::NotPowerOfTwo { .. })))
    );
    let broken = BrdfFn::grey(|wi, _| if wi.x > 0.5 { f64::NAN } else { 1.0 });
    assert!(matches!(BrdfTable::new(&broken, 2, 8), Err(Error::NotFinite { .. })));
    let table = BrdfTable::new(&gold, 3, 2).unwrap();
    assert_eq!((table.views(), table.cells(), table.bytes()), ([3, 1], 2, 4 * 3 * 4));
    let table = BrdfTable::new(&brushed, 3, 2).unwrap();
    assert_eq!((table.views(), table.bytes()), ([3, 12], 4 * 36 * 4));
}

/// Where nothing arrives, or nothing is reflected, the results are defined.
#[test]
fn nothing_has_no_samples() {
    let (light, table, gold) = (discs(8, 1.0), BrdfTable::new(&gold(), 4, 8).unwrap(), gold());
    let numbers = || (0..16).map(|i| [(i % 4) as f64 / 4.0, (i / 4) as f64 / 4.0 + 0.1]);
    let zero = Vector3::zeros();
    let run = |light: &PlanarLight, point: ShadingPoint, window: Window| {
        let settings = ProductSettings { side: 8, window, ..ProductSettings::default() };
        let sampler = ProductSampler::new(light, &up(), settings).unwrap();
        let mut scratch = sampler.scratch();
        let density = sampler.density(&point, &table, &mut scratch);
        let reflection =
            Reflection { light: sampler.light(), brdf: &gold, point, occluders: None, start: point.position };
        let estimate = reflection.estimate(&density, numbers());
        (density.first().is_empty(), density.sample([0.3, 0.4]).is_some(), density.pdf(&Vector3::y()), estimate)
    };
    let whole = points()[0];
    let black = PlanarLight::uniform(Vector3::new(0.0, 1.0, 0.0), [1.0; 2], Vector3::zeros()).unwrap();
    for window in [Window::Face, Window::Light] {
        // In the light's plane, behind it, far out of any range, nowhere; and under a black light.
        for y in [1.0, 2.0, f64::NAN, f64::NEG_INFINITY] {
            let position = Vector3::new(0.0, y, 0.0);
            assert_eq!(run(&light, ShadingPoint { position, ..whole }, window), (true, false, 0.0, zero), "{y}");
        }
        assert_eq!(run(&black, whole, window), (true, false, 0.0, zero));
        // Seen from below, or with its back to the light: light sampling finds that nothing is reflected.
        for point in [
            ShadingPoint { wo: -whole.wo, ..whole },
            ShadingPoint { frame: LocalFrame::around(&-Vector3::y_axis()), wo: -Vector3::y(), ..whole },
        ] {
            let (is_empty, has_samples, _, estimate) = run(&light, point, window);
            assert_eq!((is_empty, has_samples, estimate), (true, true, zero));
        }
        // A viewer that is NaN stays it.
        let (is_empty, _, _, estimate) = run(&light, ShadingPoint { wo: Vector3::repeat(f64::NAN), ..whole }, window);
        assert!(is_empty && estimate.iter().all(|c| c.is_nan()));
    }
    // Just below the light's plane and very far from it.
    for position in [[0.0, 1.0 - 1e-12, 0.0], [0.0, -1e9, 0.0], [1e9, 0.0, 0.0]] {
        let (_, has_samples, pdf, estimate) =
            run(&light, ShadingPoint { position: position.into(), ..whole }, Window::Light);
        assert!(has_samples && pdf.is_finite() && estimate.iter().all(|c| c.is_finite()), "{position:?}");
    }
    // Black surfaces; and no numbers at all.
    let dark = BrdfTable::new(&Lambert::new([0.0; 3]).unwrap(), 2, 4).unwrap();
    let sampler = ProductSampler::new(&light, &up(), ProductSettings { side: 8, ..Default::default() }).unwrap();
    assert!(sampler.density(&whole, &dark, &mut sampler.scratch()).first().is_empty());
    let mut scratch = BrdfScratch::new();
    let density = dark.density(&whole, &mut scratch);
    assert!(density.is_empty() && density.sample([0.5; 2]).is_none() && density.pdf(&Vector3::y()) == 0.0);
    assert!(table.density(&ShadingPoint { wo: Vector3::repeat(f64::NAN), ..whole }, &mut scratch).is_empty());
    let reflection =
        Reflection { light: sampler.light(), brdf: &gold, point: whole, occluders: None, start: whole.position };
    assert_eq!(reflection.estimate(&sampler.light().density(&whole.position), []), zero);
}

/// Uniform numbers at their ends stay in the light, whose black texels are never drawn.
#[test]
fn ends_of_numbers_are_in_the_light() {
    let mut texture = vec![Vector3::zeros(); 9];
    texture[4] = Vector3::repeat(2.0);
    let light = PlanarLight::new(Vector3::new(0.0, 1.0, 0.0), [3.0; 2], 3, texture).unwrap();
    let sampler = LightSampler::new(&light, &up(), LightWeight::Radiance).unwrap();
    let density = sampler.density(&Vector3::zeros());
    for u in [0.0, 0.5, 1.0_f64.next_down()] {
        for v in [0.0, 0.5, 1.0_f64.next_down()] {
            let sample = density.sample([u, v]).unwrap();
            let at = sample.direction / sample.direction.y;
            assert!(at.x.abs() <= 0.5 + 1e-12 && at.z.abs() <= 0.5 + 1e-12, "{at}");
        }
    }
    // Straight up, a texel of area 1 at distance 1.
    assert!((density.pdf(&Vector3::y()) - 1.0).abs() < 1e-12);
    assert_eq!(density.pdf(&Vector3::new(0.6, 0.8, 0.0)), 0.0);
    let hit = sampler.hit(&Vector3::zeros(), &Vector3::new(0.0, 2.0, 0.0)).unwrap();
    assert_eq!((hit.radiance, hit.distance), (Vector3::repeat(2.0), 0.5));
    assert!(sampler.hit(&Vector3::zeros(), &-Vector3::y()).is_none());
    assert!(sampler.hit(&Vector3::zeros(), &Vector3::new(f64::NAN, 1.0, 0.0)).is_none());
    assert!(sampler.hit(&Vector3::zeros(), &Vector3::zeros()).is_none());
}

/// Mixtures of all and nothing are their densities, to the last bit.
#[test]
fn whole_shares_are_the_density_itself() {
    let light = discs(8, 1.0);
    let [area, radiance] =
        [LightWeight::Area, LightWeight::Radiance].map(|weight| LightSampler::new(&light, &up(), weight).unwrap());
    let place = Vector3::new(0.1, 0.0, 0.3);
    let (first, second) = (area.density(&place), radiance.density(&place));
    for k in 0..20 {
        let uniform = [k as f64 / 20.0, (k as f64 * 0.618).fract()];
        let none = Mixture::new(first, second, 0.0).unwrap();
        let all = Mixture::new(first, second, 1.0).unwrap();
        assert_eq!(none.sample(uniform), first.sample(uniform));
        assert_eq!(all.sample(uniform), second.sample(uniform));
        let direction = first.sample(uniform).unwrap().direction;
        assert_eq!((none.pdf(&direction), all.pdf(&direction)), (first.pdf(&direction), second.pdf(&direction)));
    }
}

#[test]
fn points_allocate_nothing() {
    let light = discs(16, 1.0);
    let tables = [BrdfTable::new(&gold(), 4, 16).unwrap(), BrdfTable::new(&brushed(), 4, 16).unwrap()];
    for window in [Window::Face, Window::Light] {
        let settings = ProductSettings { side: 16, window, ..ProductSettings::default() };
        let sampler = ProductSampler::new(&light, &up(), settings).unwrap();
        let (mut scratch, mut brdf_scratch) = (sampler.scratch(), BrdfScratch::new());
        let mut all = || {
            for point in points() {
                for table in &tables {
                    let density = sampler.density(&point, table, &mut scratch);
                    assert!(density.sample([0.3, 0.7]).is_some());
                    assert!(table.density(&point, &mut brdf_scratch).sample([0.3, 0.7]).is_some());
                }
            }
        };
        all();
        assert_eq!(allocation_counter::measure(&mut all).count_total, 0);
    }
}
