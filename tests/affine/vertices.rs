//! One source, many vertices with targets of their own: against single calls, the twin, transposes and differences.

use crate::frames::allocations;
use crate::support::{assert_close, map, random};
use haarmonic::affine::{
    AffineMap, LightField, LightFieldTerm, Propagation, PropagationScratch, PropagationSource, TargetLists, Targets,
};
use haarmonic::haar::{Decomposition, SparseVector, forward_2d};
use haarmonic::reference::affine as naive;

const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];

/// Maps of so many vertices; the light is out of sight of some.
fn places(count: usize) -> Vec<[AffineMap; 2]> {
    let place = |k: usize| {
        let t = (k as f64 * 0.618_034).fract();
        let s = (0.4 + 2.1 * t) * if k % 5 == 3 { -1.0 } else { 1.0 };
        [map(s, 0.5 - 0.5 * s + 0.7 * (t - 0.4)), map(0.6 + t, -0.9 + 1.9 * (k as f64 * 0.414_214).fract())]
    };
    (0..count).map(place).collect()
}

/// Lists of no, one, a few and many targets.
fn lists(side: usize, basis: Decomposition, vertices: usize) -> (TargetLists, Vec<Vec<u32>>) {
    let area = (side * side) as u32;
    let wanted: Vec<Vec<u32>> = (0..vertices as u32)
        .map(|v| (0..area).filter(|k| v % 4 != 1 && (k * 7 + v * 3) % (1 + (v % 3) * 11) == 0).collect())
        .collect();
    let offsets: Vec<usize> = std::iter::once(0)
        .chain(wanted.iter().scan(0, |end, list| {
            *end += list.len();
            Some(*end)
        }))
        .collect();
    (TargetLists::new(side, basis, &offsets, &wanted.concat()).unwrap(), wanted)
}

fn source(side: usize, basis: Decomposition) -> ([Vec<f64>; 3], PropagationSource<f64, 3>) {
    let coefs = [21, 22, 23].map(|seed| random(side * side, seed));
    let source = PropagationSource::from_dense(side, basis, coefs.each_ref().map(Vec::as_slice)).unwrap();
    (coefs, source)
}

fn all_of(side: usize, basis: Decomposition, vertices: usize) -> (TargetLists, Vec<Vec<u32>>) {
    let every: Vec<u32> = (0..(side * side) as u32).collect();
    (TargetLists::all(side, basis, vertices).unwrap(), vec![every; vertices])
}

#[test]
fn lists_are_one_by_one_to_the_bit() {
    for basis in BASES {
        for [from, side] in [[8, 8], [16, 4], [2, 8]] {
            let (_, source) = source(from, basis);
            let plan = Propagation::between(from, side, basis).unwrap();
            for vertices in [0, 1, 63, 64, 65, 200] {
                let maps = places(vertices);
                for (lists, wanted) in [lists(side, basis, vertices), all_of(side, basis, vertices)] {
                    let transport = random(lists.len(), 5);
                    let mut out = vec![f64::NAN; 3 * lists.len()];
                    let mut products = vec![[f64::NAN; 3]; vertices];
                    plan.apply_lists(&source, &maps, &lists, &mut out);
                    plan.inner_products(&source, &maps, &lists, &transport, &mut products);
                    let mut scratch = PropagationScratch::new();
                    for v in 0..vertices {
                        let (range, targets) = (lists.range(v), Targets::new(side, basis, &wanted[v]).unwrap());
                        assert_eq!(range.len(), wanted[v].len());
                        let mut want = [(); 3].map(|()| vec![0.0; wanted[v].len()]);
                        let planes = want.each_mut().map(Vec::as_mut_slice);
                        if wanted[v].len() == side * side {
                            let all = Targets::all(side, basis).unwrap();
                            // Of all targets, a list and its absence are summed differently.
                            let one =
                                if lists == TargetLists::all(side, basis, vertices).unwrap() { &all } else { &targets };
                            plan.apply(&source, maps[v], one, planes, &mut scratch);
                        } else {
                            plan.apply(&source, maps[v], &targets, planes, &mut scratch);
                        }
                        assert_eq!(out[3 * range.start..3 * range.end], want.concat(), "{basis:?}, vertex {v}");
                        for c in 0..3 {
                            let sum: f64 = transport[range.clone()].iter().zip(&want[c]).map(|(t, l)| t * l).sum();
                            let size: f64 =
                                transport[range.clone()].iter().zip(&want[c]).map(|(t, l)| (t * l).abs()).sum();
                            assert_close(products[v][c], sum, 4.0 * f64::EPSILON * size, &format!("{basis:?}, {v}"));
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn inner_products_are_those_of_the_twin() {
    let [from, side] = [8, 16];
    for basis in BASES {
        let image = random(from * from, 7);
        let narrow: Vec<f32> = image.iter().map(|&x| x as f32).collect();
        let image: Vec<f64> = narrow.iter().map(|&x| f64::from(x)).collect();
        let source = PropagationSource::from_pixels(from, basis, [&narrow]).unwrap();
        let plan = Propagation::<f32>::between(from, side, basis).unwrap();
        let maps = places(20);
        for (lists, wanted) in [lists(side, basis, 20), all_of(side, basis, 20)] {
            let transport: Vec<f32> = random(lists.len(), 9).iter().map(|&x| x as f32).collect();
            let mut out = vec![[f32::NAN]; 20];
            plan.inner_products(&source, &maps, &lists, &transport, &mut out);
            for v in 0..20 {
                let seen = naive::resample_between_2d(&image, from, [side; 2], maps[v]);
                let seen = forward_2d(&seen, side, side, basis).unwrap();
                let terms = wanted[v].iter().zip(&transport[lists.range(v)]);
                let (mut want, mut size) = (0.0, 0.0);
                for (&k, &t) in terms {
                    want += f64::from(t) * seen[k as usize];
                    size += f64::from(t).powi(2);
                }
                // Worst seen: .04 ε of the transport's norm.
                let tolerance = 0.1 * f64::from(f32::EPSILON) * f64::sqrt(size);
                assert_close(f64::from(out[v][0]), want, tolerance, &format!("{basis:?}, vertex {v}"));
            }
        }
    }
}

#[test]
fn adjoints_of_lists_are_transposes() {
    for basis in BASES {
        for [from, side] in [[8, 8], [4, 16], [16, 4]] {
            let (coefs, source) = source(from, basis);
            let plan = Propagation::between(from, side, basis).unwrap();
            for vertices in [0, 1, 3, 130] {
                let maps = places(vertices);
                for (lists, _) in [lists(side, basis, vertices), all_of(side, basis, vertices)] {
                    let (g, transport) = (random(3 * lists.len(), 31), random(lists.len(), 33));
                    let y: Vec<[f64; 3]> = random(3 * vertices, 35).as_chunks().0.to_vec();
                    let (mut l, mut products) = (vec![0.0; g.len()], vec![[0.0; 3]; vertices]);
                    plan.apply_lists(&source, &maps, &lists, &mut l);
                    plan.inner_products(&source, &maps, &lists, &transport, &mut products);
                    let mut back = [(); 3].map(|()| vec![f64::NAN; from * from]);
                    let check = |want: f64, size: f64, back: &[Vec<f64>; 3], what: &str| {
                        let terms = || coefs.iter().flatten().zip(back.iter().flatten()).map(|(f, g)| f * g);
                        let size = size + terms().map(f64::abs).sum::<f64>();
                        let what = format!("{what}, {basis:?}, {from} to {side}, {vertices} vertices");
                        assert_close(terms().sum(), want, 8.0 * f64::EPSILON * size, &what);
                    };
                    plan.adjoint_lists(&maps, &lists, &g, back.each_mut().map(Vec::as_mut_slice));
                    let terms = || l.iter().zip(&g).map(|(l, g)| l * g);
                    check(terms().sum(), terms().map(f64::abs).sum(), &back, "lists");
                    plan.inner_products_adjoint(&maps, &lists, &transport, &y, back.each_mut().map(Vec::as_mut_slice));
                    let terms = || products.iter().flatten().zip(y.iter().flatten()).map(|(a, b)| a * b);
                    check(terms().sum(), terms().map(f64::abs).sum(), &back, "products");
                }
            }
        }
    }
}

#[test]
fn gradients_of_vertices_are_differences() {
    let ([from, side], vertices, h) = ([8, 4], 9, 1e-6);
    for basis in BASES {
        let (_, source) = source(from, basis);
        let (plan, maps) = (Propagation::between(from, side, basis).unwrap(), places(vertices));
        let (lists, _) = lists(side, basis, vertices);
        let transport = random(lists.len(), 51);
        let y: Vec<[f64; 3]> = random(3 * vertices, 53).as_chunks().0.to_vec();
        let mut got = vec![[[f64::NAN; 2]; 2]; vertices];
        plan.inner_products_gradient(&source, &maps, &lists, (&transport, &y), &mut got);
        // The same, from the cotangents of L.
        let mut cotangent = Vec::new();
        for v in 0..vertices {
            y[v].iter().for_each(|y| cotangent.extend(transport[lists.range(v)].iter().map(|t| y * t)));
        }
        let mut by_lists = vec![[[f64::NAN; 2]; 2]; vertices];
        plan.gradient_lists(&source, &maps, &lists, &cotangent, &mut by_lists);
        assert_eq!(got, by_lists);
        let loss = |maps: &[[AffineMap; 2]], v: usize| -> f64 {
            let mut out = vec![[0.0; 3]; vertices];
            plan.inner_products(&source, maps, &lists, &transport, &mut out);
            out[v].iter().zip(y[v]).map(|(a, b)| a * b).sum()
        };
        for axis in 0..2 {
            for parameter in 0..2 {
                let moved = |h: f64| -> Vec<[AffineMap; 2]> {
                    let step = |mut maps: [AffineMap; 2]| {
                        let (s, o) = (maps[axis].scale(), maps[axis].offset());
                        maps[axis] = if parameter == 0 { map(s + h, o) } else { map(s, o + h) };
                        maps
                    };
                    maps.iter().copied().map(step).collect()
                };
                let [one, two] = [moved(h), moved(2.0 * h)];
                for v in 0..vertices {
                    let want = (4.0 * loss(&one, v) - loss(&two, v) - 3.0 * loss(&maps, v)) / (2.0 * h);
                    assert_close(got[v][axis][parameter], want, 4e-9, &format!("{basis:?}, {v}, {axis}, {parameter}"));
                }
            }
        }
    }
}

#[test]
fn vertices_take_no_memory_and_threads_no_part() {
    let (side, basis) = (16, Decomposition::Standard);
    let (_, source) = source(side, basis);
    let plan = Propagation::new(side, basis).unwrap();
    let run = |vertices: usize| {
        let (maps, (lists, _)) = (places(vertices), lists(side, basis, vertices));
        let (transport, mut out) = (random(lists.len(), 3), vec![[0.0; 3]; vertices]);
        let mut planes = vec![0.0; 3 * lists.len()];
        let mut sum = [(); 3].map(|()| vec![0.0; side * side]);
        let count = allocations(|| {
            plan.apply_lists(&source, &maps, &lists, &mut planes);
            plan.inner_products(&source, &maps, &lists, &transport, &mut out);
        });
        plan.inner_products_adjoint(&maps, &lists, &transport, &out, sum.each_mut().map(Vec::as_mut_slice));
        let mut back = [(); 3].map(|()| vec![0.0; side * side]);
        plan.adjoint_lists(&maps, &lists, &planes, back.each_mut().map(Vec::as_mut_slice));
        (count, out, planes, sum, back)
    };
    let on = |threads: usize, vertices: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(vertices))
    };
    let (few, many) = (on(1, 600), on(1, 3000));
    // A thread's memory is made anew for each piece that rayon cuts, not for each vertex.
    assert!(many.0 < few.0 + 600, "{} and {} allocations", few.0, many.0);
    for threads in [2, 5] {
        let other = on(threads, 600);
        assert_eq!((other.1, other.2, other.3, other.4), (few.1.clone(), few.2.clone(), few.3.clone(), few.4.clone()));
    }
}

#[test]
fn lists_that_do_not_fit_are_refused() {
    let new = |offsets: &[usize], indices: &[u32]| TargetLists::new(4, Decomposition::Standard, offsets, indices);
    assert!(new(&[0], &[]).is_ok_and(|lists| lists.vertices() == 0 && lists.is_empty()));
    assert!(new(&[0, 0, 0], &[]).is_ok_and(|lists| lists.vertices() == 2 && lists.is_empty()));
    assert!(new(&[0, 2, 3], &[3, 15, 3]).is_ok());
    for (offsets, indices) in [
        (&[][..], &[][..]),
        (&[1, 1], &[0]),
        (&[0, 2, 1], &[0, 1]),
        (&[0, 1], &[0, 1]),
        (&[0, 3], &[0, 1]),
        (&[0, 1, usize::MAX], &[0]),
        (&[0, 2], &[1, 1]),
        (&[0, 2], &[2, 1]),
        (&[0, 1], &[16]),
    ] {
        assert!(new(offsets, indices).is_err(), "{offsets:?} {indices:?}");
    }
    assert!(TargetLists::new(3, Decomposition::Standard, &[0], &[]).is_err());
    assert!(TargetLists::all(8192, Decomposition::Standard, 1).is_err());
    assert!(TargetLists::all(4, Decomposition::Standard, usize::MAX).is_err());
}

#[test]
#[should_panic(expected = "pairs of maps")]
fn a_vertex_without_maps_panics() {
    let (_, source) = source(4, Decomposition::Standard);
    let plan = Propagation::new(4, Decomposition::Standard).unwrap();
    let lists = TargetLists::all(4, Decomposition::Standard, 2).unwrap();
    plan.apply_lists(&source, &places(1), &lists, &mut [0.0; 96]);
}

#[test]
fn batches_of_light_fields_are_one_by_one_to_the_bit() {
    for size in [1usize, 2, 16] {
        let plan = LightField::new(size).unwrap();
        let field = SparseVector::from_dense(&random(size * size, 61));
        let terms: Vec<LightFieldTerm<f64, 3>> = (0..30u32)
            .map(|n| {
                let index = |k: u32| (n * k + 1) % size as u32;
                let value = [0, 1, 2].map(|c| f64::from(n * 7 % 5) - f64::from(c));
                LightFieldTerm { plane: [index(3), index(5)], direction: [index(7), index(11)], value }
            })
            .collect();
        for count in [0, 1, 15, 16, 17, 100] {
            let maps = places(count);
            let along: Vec<AffineMap> = maps.iter().map(|maps| maps[0]).collect();
            let mut got = vec![f64::NAN; count * size];
            plan.propagate_batch(&field, &along, &mut got);
            let mut in_space = vec![[f64::NAN; 3]; count * size * size];
            plan.propagate_in_space_batch(&terms, &maps, &mut in_space);
            for v in 0..count {
                let (mut want, mut want_in_space) = (vec![0.0; size], vec![[0.0; 3]; size * size]);
                plan.propagate(&field, along[v], &mut want);
                plan.propagate_in_space(&terms, maps[v], &mut want_in_space);
                assert_eq!(got[v * size..][..size], want, "{size}, {count}, {v}");
                assert_eq!(in_space[v * size * size..][..size * size], want_in_space, "{size}, {count}, {v}");
            }
            assert!(count < 15 || got.iter().any(|l| *l != 0.0) && in_space.iter().flatten().any(|l| *l != 0.0));
        }
    }
}

#[test]
#[should_panic(expected = "is not below 8")]
fn a_term_outside_of_a_light_field_panics_in_a_batch() {
    let outside = LightFieldTerm { plane: [0, 0], direction: [0, 8], value: [1.0] };
    LightField::new(8).unwrap().propagate_in_space_batch(&[outside], &places(1), &mut [[0.0]; 64]);
}
