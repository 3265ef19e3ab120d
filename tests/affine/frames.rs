//! What a renderer does in every frame: targets and sources replaced in place, and nothing allocated.

use crate::support::{map, random};
use haarmonic::affine::{
    AffineMap, Heuristic, MapGrid, Prediction, Propagation, PropagationRoute, PropagationScratch, PropagationSource,
    Targets,
};
use haarmonic::haar::{Decomposition, Keep, Selection, SparseVector};

const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];

pub fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

/// Places near and far, and some that see nothing.
fn places() -> Vec<[AffineMap; 2]> {
    (0..200)
        .map(|k| {
            let t = 0.005 * f64::from(k);
            let s = 0.3 + 3.0 * t;
            [map(s, 0.5 - 0.5 * s + 0.9 * (t - 0.5)), map(s, -0.4 + 1.7 * t)]
        })
        .collect()
}

#[test]
fn targets_that_are_set_are_new_ones() {
    let lists: [&[u32]; 6] = [&[], &[0], &[3, 9, 10, 63], &[63], &[0, 1, 2, 3, 8, 9, 17, 40, 41, 42, 43, 44], &[]];
    for basis in BASES {
        let mut targets = Targets::all(8, basis).unwrap();
        for list in lists {
            targets.set(list).unwrap();
            assert_eq!(targets, Targets::new(8, basis, list).unwrap(), "{basis:?}");
            for wrong in [&[64][..], &[3, 3], &[4, 2], &[0, u32::MAX]] {
                assert!(targets.set(wrong).is_err());
                assert_eq!(targets, Targets::new(8, basis, list).unwrap(), "after an error, {basis:?}");
            }
        }
    }
}

#[test]
fn predicted_targets_take_no_memory() {
    let grid = MapGrid::new([0.25, 4.0], [6, 8]).unwrap();
    let light = random(1024, 3);
    let places = places();
    for basis in BASES {
        let heuristic = Heuristic::Light(&light);
        let prediction = Prediction::<2>::new(32, basis, heuristic, grid, Keep::Fraction(0.2)).unwrap();
        let source = PropagationSource::<f32, 1>::from_pixels(32, basis, [&[1.0; 1024]]).unwrap();
        let plan = Propagation::between(32, 32, basis).unwrap();
        let (mut targets, mut scratch) = (Targets::new(32, basis, &[]).unwrap(), PropagationScratch::new());
        let mut out = vec![0.0; 1024];
        let mut frame = || {
            let mut sum = 0;
            for &maps in &places {
                prediction.set_targets(maps, &mut targets);
                plan.apply(&source, maps, &targets, [&mut out[..targets.len()]], &mut scratch);
                sum += targets.len();
            }
            sum
        };
        assert!(frame() > 50 * 100);
        let allocated = allocations(|| {
            std::hint::black_box(frame());
        });
        assert_eq!(allocated, 0, "{basis:?}");
        let mut lengths = std::collections::BTreeSet::new();
        for &maps in &places {
            prediction.set_targets(maps, &mut targets);
            assert_eq!(targets, Targets::new(32, basis, prediction.targets(maps)).unwrap(), "{basis:?}, {maps:?}");
            lengths.insert(targets.len());
        }
        assert!(lengths.contains(&0) && lengths.len() > 1, "{lengths:?}");
    }
}

#[test]
#[should_panic(expected = "the prediction's basis")]
fn targets_of_another_basis_panic() {
    let grid = MapGrid::new([0.25, 4.0], [2, 2]).unwrap();
    let standard = Decomposition::Standard;
    let prediction = Prediction::<2>::new(4, standard, Heuristic::Constant, grid, Keep::Terms(2)).unwrap();
    let mut targets = Targets::new(4, Decomposition::Nonstandard, &[]).unwrap();
    prediction.set_targets([AffineMap::IDENTITY; 2], &mut targets);
}

/// All that a source says of itself: by every route, to the bit, and the choice between them.
fn seen(source: &PropagationSource<f64, 3>, side: usize, basis: Decomposition) -> Vec<u64> {
    let (plan, all) = (Propagation::new(side, basis).unwrap(), Targets::all(side, basis).unwrap());
    let mut bits = vec![source.terms() as u64];
    for maps in [[map(0.7, 0.1), map(-1.3, 1.1)], [map(1.0, 0.0), map(2.1, -0.4)]] {
        bits.push(plan.route(source, maps, &all) as u64);
        for route in PropagationRoute::ALL {
            let mut out = [(); 3].map(|()| vec![f64::NAN; side * side]);
            let planes = out.each_mut().map(Vec::as_mut_slice);
            plan.apply_by(route, source, maps, &all, planes, &mut PropagationScratch::new());
            bits.extend(out.as_flattened_bits());
        }
    }
    bits
}

trait Bits {
    fn as_flattened_bits(&self) -> Vec<u64>;
}

impl Bits for [Vec<f64>; 3] {
    fn as_flattened_bits(&self) -> Vec<u64> {
        self.iter().flatten().map(|x| x.to_bits()).collect()
    }
}

fn lights(side: usize, seed: u64, terms: usize) -> [SparseVector<f64>; 3] {
    [0, 1, 2].map(|c| Selection::new(Keep::Terms(terms)).apply(&random(side * side, seed + c)).unwrap())
}

#[test]
fn a_source_that_is_set_is_a_new_one_to_the_bit() {
    for side in [1, 2, 16, 32] {
        for basis in BASES {
            let (area, mut scratch) = (side * side, PropagationScratch::new());
            let dense = [0, 1, 2].map(|c| random(area, 70 + c));
            let channels = dense.each_ref().map(Vec::as_slice);
            let mut source = PropagationSource::from_dense(side, basis, channels).unwrap();
            for (seed, terms) in [(1, area / 3), (5, 0), (9, 1), (14, area)] {
                let light = lights(side, seed, terms);
                source.set(light.each_ref(), &mut scratch);
                let new = PropagationSource::new(side, basis, light.each_ref()).unwrap();
                assert_eq!(seen(&source, side, basis), seen(&new, side, basis), "{side}, {basis:?}, {terms} terms");
                source.set_pixels(channels, &mut scratch);
                let new = PropagationSource::from_pixels(side, basis, channels).unwrap();
                assert_eq!(seen(&source, side, basis), seen(&new, side, basis), "{side}, {basis:?}, pixels");
                source.set_dense(channels, &mut scratch);
                let new = PropagationSource::from_dense(side, basis, channels).unwrap();
                assert_eq!(seen(&source, side, basis), seen(&new, side, basis), "{side}, {basis:?}, dense");
            }
        }
    }
}

#[test]
fn a_light_that_is_painted_anew_takes_no_memory() {
    for basis in BASES {
        let mut scratch = PropagationScratch::new();
        let frames = [3, 17].map(|seed| lights(32, seed, 300));
        let pixels = [0, 1, 2].map(|c| random(1024, 90 + c));
        let channels = pixels.each_ref().map(Vec::as_slice);
        let mut source = PropagationSource::new(32, basis, frames[0].each_ref()).unwrap();
        source.set_pixels(channels, &mut scratch);
        let count = allocations(|| {
            for light in &frames {
                source.set(light.each_ref(), &mut scratch);
                source.set_dense(channels, &mut scratch);
                source.set_pixels(channels, &mut scratch);
            }
        });
        assert_eq!(count, 0, "{basis:?}");
    }
}

#[test]
fn sources_of_wrong_length_are_refused() {
    let standard = Decomposition::Standard;
    assert!(PropagationSource::from_pixels(4, standard, [&[0.0f32; 15]]).is_err());
    assert!(PropagationSource::from_pixels(3, standard, [&[0.0f32; 9]]).is_err());
    assert!(PropagationSource::from_dense(4, standard, [&[0.0f32; 17]]).is_err());
    let mut source = PropagationSource::from_pixels(4, standard, [&[0.0f32; 16]]).unwrap();
    for wrong in [0, 15, 17] {
        let pixels = vec![0.0; wrong];
        let panics = |work: &mut dyn FnMut()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).is_err();
        let mut scratch = PropagationScratch::new();
        assert!(panics(&mut || source.set_pixels([&pixels], &mut scratch)));
        assert!(panics(&mut || source.set_dense([&pixels], &mut scratch)));
        assert!(panics(&mut || source.set([&SparseVector::from_dense(&pixels)], &mut scratch)));
    }
}
