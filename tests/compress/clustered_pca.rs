//! Clustered principal components against the naive twin, and their own laws.

use std::sync::Mutex;

use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings, Distortion, Pca, PcaSettings};
use haarmonic::reference::compress as twin;
use haarmonic::strategies::clustered_rows;
use haarmonic::{Error, Progress, Real};
use proptest::prelude::*;

use crate::support::{Stream, cases, dot, flat, wide};

fn labels<T: Real>(coded: &ClusteredPca<T>) -> Vec<usize> {
    coded.labels().iter().map(|&label| label as usize).collect()
}

/// What rounding may change in a squared distance of rows that are `size` long: some ε of |x|², and of |x − m|².
fn noise<T: Real>(rows: &[Vec<f64>]) -> f64 {
    let square = rows.iter().map(|row| dot(row, row)).fold(0.0, f64::max);
    // Measured: up to an eighth of it in sums, a fifth in a row's distance.
    8.0 * T::epsilon().widen() * square
}

/// Everything that must hold of any result.
fn check_result<T: Real>(
    coded: &ClusteredPca<T>,
    matrix: &[T],
    settings: &ClusteredPcaSettings,
) -> Result<(), TestCaseError> {
    let (columns, k, eps) = (coded.columns(), coded.components(), T::epsilon().widen());
    let rows: Vec<Vec<f64>> = matrix.chunks(columns).map(wide).collect();
    let labels = labels(coded);
    prop_assert_eq!((labels.len(), coded.rows()), (rows.len(), rows.len()));
    prop_assert!((1..=settings.clusters.min(rows.len())).contains(&coded.clusters()));
    prop_assert!((0..coded.clusters()).all(|c| labels.contains(&c)), "an empty cluster");
    for c in 0..coded.clusters() {
        let components: Vec<Vec<f64>> = coded.cluster(c).1.chunks(columns).map(wide).collect();
        for i in 0..k {
            for j in 0..i {
                prop_assert!(dot(&components[i], &components[j]).abs() <= 32.0 * eps);
            }
            let square = dot(&components[i], &components[i]);
            prop_assert!(square == 0.0 || (square - 1.0).abs() <= 32.0 * eps, "length² {square}");
        }
    }
    // Each cluster has the components of its rows: no others lose less.
    let fitted = twin::fit_clusters(&rows, &labels, coded.clusters());
    let best = twin::total_error(&rows, &labels, &fitted, k);
    let n = rows.len() as f64;
    let got = coded.stats().distortion;
    let squares = got.rms.powi(2) * n * columns as f64;
    let rounding = (n * noise::<T>(&rows) * eps).sqrt();
    let tolerance = n * noise::<T>(&rows) * 0.1 + 2.0 * best.sqrt() * rounding + rounding * rounding;
    prop_assert!((squares - best).abs() <= tolerance, "{squares:e} {best:e} {tolerance:e}");
    // Weights and reconstruction by their formulas.
    let size = rows.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let mut back = vec![T::of(f64::NAN); matrix.len()];
    for (i, out) in back.chunks_mut(columns).enumerate() {
        coded.reconstruct(i, out);
        let (mean, components) = coded.cluster(labels[i]);
        let difference: Vec<f64> = rows[i].iter().zip(mean).map(|(x, m)| x - m.widen()).collect();
        let weights = wide(&coded.weights()[i * k..][..k]);
        for (j, weight) in weights.iter().enumerate() {
            let want = dot(&difference, &wide(&components[j * columns..][..columns]));
            prop_assert!((weight - want).abs() <= eps * (want.abs() + 1e-3 * size), "{weight} {want}");
        }
        for (c, out) in out.iter().enumerate() {
            let sum: f64 = (0..k).map(|j| weights[j] * components[j * columns + c].widen()).sum();
            prop_assert!((out.widen() - mean[c].widen() - sum).abs() <= 8.0 * eps * size);
        }
    }
    prop_assert_eq!(got, Distortion::between(matrix, &back));
    Ok(())
}

/// Drops components that are made of rounding, and says whether the first k of the others are determined: whether
/// variances stand apart where they are cut off.
fn drop_rounding(cluster: &mut twin::NaivePca, k: usize, noise: f64) -> bool {
    let v = &cluster.variances;
    let rank = v.iter().take_while(|&&x| x > 1e-9 * v[0] && x > 8e-3 * noise).count();
    let next = v.get(rank).map_or(0.0, |x| x.abs());
    let gap = if (1..rank).contains(&k) { v[k - 1] - v[k] } else { f64::INFINITY };
    let determined = next <= 1e-15 * v[0].max(noise * f64::EPSILON) && gap > 0.1 * v[0];
    cluster.components.truncate(rank);
    determined
}

fn one_round<T: Real>(rows: &[Vec<f64>], clusters: usize, k: usize) -> Result<(), TestCaseError> {
    let (columns, matrix) = (rows[0].len(), flat::<T>(rows));
    let rows: Vec<Vec<f64>> = matrix.chunks(columns).map(wide).collect();
    let clusters = clusters.min(rows.len());
    // Every label is there, so that none has to begin anew.
    let start: Vec<u32> = (0..rows.len()).map(|i| (i * 7 % clusters) as u32).collect();
    let before: Vec<usize> = (0..rows.len()).map(|i| i * 7 % clusters).collect();
    prop_assume!((0..clusters).all(|c| before.contains(&c)));
    let settings = ClusteredPcaSettings::new(clusters, k).with_iterations(1);
    let coded = ClusteredPca::from_labels(&matrix, columns, &start, &settings, &()).unwrap();
    check_result(&coded, &matrix, &settings)?;
    let mut fitted = twin::fit_clusters(&rows, &before, clusters);
    let determined = fitted.iter_mut().flatten().all(|cluster| drop_rounding(cluster, k, noise::<T>(&rows)));
    let want = twin::assign(&rows, &before, &fitted, k);
    // Clusters that lost all rows are gone: their numbers close up.
    let got = labels(&coded);
    let mut kept: Vec<usize> = want.clone();
    kept.sort_unstable();
    kept.dedup();
    // Where components are determined and no two clusters are as good as each other but for rounding, the labels are
    // the twin's.
    let clear = rows.iter().zip(&want).all(|(row, &label)| {
        let distances = twin::cluster_distances(row, &fitted, k);
        (0..clusters).all(|c| c == label || distances[c] > distances[label] + noise::<T>(&rows))
    });
    // More than half of the cases.
    if clear && determined {
        prop_assert_eq!(got, want.iter().map(|label| kept.binary_search(label).unwrap()).collect::<Vec<_>>());
    }
    Ok(())
}

/// Rows that a generic process makes: `groups` of their own mean and plane, in turn.
fn planted(rows: usize, columns: usize, groups: usize, plane: usize) -> Vec<f32> {
    let mut stream = Stream::new(11);
    let bases: Vec<f64> = (0..groups * (plane + 1) * columns).map(|_| stream.signed()).collect();
    let row = |i: usize| {
        let basis = &bases[i % groups * (plane + 1) * columns..];
        let weights: Vec<f64> = (0..plane).map(|_| stream.signed()).collect();
        let entry =
            |c: usize| (0..plane).fold(2.0 * basis[c], |sum, j| sum + weights[j] * basis[(j + 1) * columns + c]);
        (0..columns).map(|c| entry(c) as f32).collect::<Vec<f32>>()
    };
    (0..rows).flat_map(row).collect()
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn one_round_is_the_twins_f64(rows in clustered_rows(4, 12, 7), clusters in 1..5usize, k in 0..4usize) {
        one_round::<f64>(&rows, clusters, k)?;
    }

    #[test]
    fn one_round_is_the_twins_f32(rows in clustered_rows(4, 12, 7), clusters in 1..5usize, k in 0..4usize) {
        one_round::<f32>(&rows, clusters, k)?;
    }

    #[test]
    fn laws_hold(rows in clustered_rows(4, 12, 7), clusters in 1..8usize, k in 0..4usize, seed in any::<u64>()) {
        let (columns, matrix) = (rows[0].len(), flat::<f32>(&rows));
        let settings = ClusteredPcaSettings::new(clusters, k).with_seed(seed);
        let coded = ClusteredPca::new(&matrix, columns, &settings, &()).unwrap();
        check_result(&coded, &matrix, &settings)?;
        // One cluster is principal component analysis.
        if coded.clusters() == 1 {
            let pca = Pca::new(&matrix, columns, &PcaSettings::new(k).with_seed(seed)).unwrap();
            prop_assert_eq!(coded.cluster(0).0, pca.mean());
            prop_assert_eq!(&coded.cluster(0).1[..pca.components().len()], pca.components());
        }
        // Rows are encoded into a cluster that is as near as any.
        let mut codes = vec![u32::MAX; rows.len()];
        let mut weights = vec![f32::NAN; rows.len() * k];
        coded.encode(&matrix, &mut codes, &mut weights).unwrap();
        for (i, row) in matrix.chunks(columns).map(wide).enumerate() {
            let distance = |c: usize| {
                let (mean, components) = coded.cluster(c);
                let difference: Vec<f64> = row.iter().zip(mean).map(|(x, m)| x - m.widen()).collect();
                let squares = components.chunks(columns).map(|u| dot(&difference, &wide(u)).powi(2)).sum::<f64>();
                dot(&difference, &difference) - squares
            };
            let least = (0..coded.clusters()).map(distance).fold(f64::INFINITY, f64::min);
            prop_assert!(distance(codes[i] as usize) <= least + noise::<f32>(&rows));
            if codes[i] == coded.labels()[i] {
                prop_assert_eq!(&weights[i * k..][..k], &coded.weights()[i * k..][..k]);
            }
        }
    }

    #[test]
    fn products_are_those_of_the_decoded_rows(rows in clustered_rows(4, 12, 7), k in 0..4usize, sides in 0..6usize) {
        let (columns, matrix) = (rows[0].len(), flat::<f32>(&rows));
        let coded = ClusteredPca::new(&matrix, columns, &ClusteredPcaSettings::new(3, k), &()).unwrap();
        let x: Vec<f32> = (0..columns * sides).map(|i| ((i as f32 + 0.7) * 0.618_034).fract() * 3.0 - 1.0).collect();
        let mut got = vec![f32::NAN; rows.len() * sides];
        coded.multiply_batch(sides, &x, &mut got, &mut vec![0.0; coded.scratch_len(sides)]);
        let mut row = vec![0.0; columns];
        for i in 0..rows.len() {
            coded.reconstruct(i, &mut row);
            for s in 0..sides {
                let terms = || (0..columns).map(|c| f64::from(row[c]) * f64::from(x[c * sides + s]));
                let (want, size) = (terms().sum::<f64>(), 30.0 * columns as f64);
                prop_assert!((f64::from(got[i * sides + s]) - want).abs() <= 4.0 * f64::from(f32::EPSILON) * size);
            }
        }
    }

    #[test]
    fn more_rounds_are_never_worse(rows in clustered_rows(5, 12, 6), clusters in 1..6usize, k in 1..3usize) {
        let (columns, matrix) = (rows[0].len(), flat::<f64>(&rows));
        let start: Vec<u32> = (0..rows.len()).map(|i| (i % clusters.min(rows.len())) as u32).collect();
        let mut before = f64::INFINITY;
        for rounds in 0..6 {
            let settings = ClusteredPcaSettings::new(clusters, k).with_iterations(rounds).with_tolerance(0.0);
            let coded = ClusteredPca::from_labels(&matrix, columns, &start, &settings, &()).unwrap();
            let error = coded.stats().distortion.rms.powi(2);
            prop_assert!(error <= before + noise::<f64>(&rows), "{rounds}: {error} {before}");
            before = error;
        }
    }
}

#[test]
fn planted_planes_are_found() {
    let (columns, groups) = (40, 5);
    let matrix = planted(600, columns, groups, 3);
    let coded = ClusteredPca::new(&matrix, columns, &ClusteredPcaSettings::new(groups, 3), &()).unwrap();
    for i in 0..600 {
        assert_eq!(coded.labels()[i], coded.labels()[i % groups]);
    }
    let stats = coded.stats();
    assert!(stats.distortion.max < 4e-6, "{stats:?}");
    assert_eq!(stats.basis_bytes, groups * 4 * columns * 4);
    assert_eq!(stats.row_bytes, 600 * (3 * 4 + 4));
    assert_eq!(stats.matrix_bytes, 600 * columns * 4);
    let ratio = 600.0 * 160.0 / (5.0 * 640.0 + 600.0 * 16.0);
    assert!((stats.ratio() - ratio).abs() < 1e-12);
    // As many numbers in principal components of all rows lose far more.
    let pca = Pca::new(&matrix, columns, &PcaSettings::new(5)).unwrap();
    assert!(pca.bytes(600) > stats.basis_bytes + stats.row_bytes);
    assert!(pca.distortion(&matrix).rms > 1e4 * stats.distortion.rms);
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let matrix = planted(900, 70, 9, 4);
    let settings = ClusteredPcaSettings::new(12, 3);
    let run = || ClusteredPca::new(&matrix, 70, &settings, &()).unwrap();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let one = pool(1).install(run);
    assert_eq!(one, pool(4).install(run));
    let other = ClusteredPca::new(&matrix, 70, &settings.with_seed(1), &()).unwrap();
    assert_ne!(one.labels(), other.labels(), "the seed is used");
}

#[test]
fn degenerate_matrices() {
    let run = |matrix: &[f32], columns, clusters, k| {
        ClusteredPca::new(matrix, columns, &ClusteredPcaSettings::new(clusters, k), &()).unwrap()
    };
    // More clusters than rows, and than different rows.
    let coded = run(&[1.0, 2.0, 3.0, 5.0], 2, 10, 3);
    assert_eq!((coded.clusters(), coded.components(), coded.weights()), (2, 3, &[0.0; 6][..]));
    assert_eq!(coded.stats().distortion.max, 0.0);
    let coded = run(&[0.1, 0.7, 0.1, 0.7, 0.3, 0.2, 0.1, 0.7], 2, 4, 1);
    assert_eq!((coded.clusters(), coded.stats().distortion.max), (2, 0.0));
    assert!(coded.labels()[0] == coded.labels()[1] && coded.labels()[0] != coded.labels()[2]);
    // Zeros; one element; equal rows; less rows than components; constant columns.
    for (matrix, columns) in [(vec![0.0; 12], 3), (vec![-2.5], 1), (vec![0.3; 12], 3)] {
        let coded = run(&matrix, columns, 3, 2);
        assert_eq!((coded.clusters(), coded.stats().distortion.max), (1, 0.0));
        assert!(coded.cluster(0).1.iter().all(|&u| u == 0.0));
    }
    let coded = run(&[0.0, 0.0, 3.0, 4.0], 2, 1, 2);
    assert_eq!(coded.cluster(0).0, [1.5, 2.0]);
    assert!((coded.cluster(0).1[0] - 0.6).abs() < 1e-6 && coded.cluster(0).1[2..] == [0.0, 0.0]);
    // No components: k-means.
    let coded = run(&[0.0, 1.0, 10.0, 12.0], 1, 2, 0);
    assert_eq!((coded.cluster(coded.labels()[3] as usize).0, coded.weights().len()), (&[11.0][..], 0));
    assert_eq!(coded.stats().distortion.max, 1.0);
}

#[test]
fn what_is_refused() {
    let settings = ClusteredPcaSettings::new(2, 1);
    let run =
        |matrix: &[f32], columns, settings: &ClusteredPcaSettings| ClusteredPca::new(matrix, columns, settings, &());
    assert_eq!(run(&[], 2, &settings).unwrap_err(), Error::Empty { what: "matrix" });
    assert_eq!(run(&[1.0], 0, &settings).unwrap_err(), Error::Empty { what: "matrix" });
    assert_eq!(run(&[1.0; 3], 2, &settings).unwrap_err(), Error::Length { what: "matrix", expected: 4, got: 3 });
    let not_finite = Error::NotFinite { what: "matrix element", index: 1 };
    assert_eq!(run(&[1.0, f32::NAN], 2, &settings).unwrap_err(), not_finite);
    let none = run(&[1.0, 2.0], 2, &ClusteredPcaSettings::new(0, 1)).unwrap_err();
    assert_eq!(none, Error::OutOfRange { what: "clusters", got: 0.0, allowed: "at least 1" });
    for tolerance in [-1.0, f64::NAN] {
        let bad = run(&[1.0, 2.0], 2, &settings.with_tolerance(tolerance)).unwrap_err();
        assert!(matches!(bad, Error::OutOfRange { what: "tolerance", .. }));
    }
    let labelled =
        |labels: &[u32]| ClusteredPca::from_labels(&[1.0f32, 2.0, 3.0], 1, labels, &settings, &()).unwrap_err();
    assert_eq!(labelled(&[0, 1]), Error::Length { what: "labels", expected: 3, got: 2 });
    assert!(matches!(labelled(&[0, 1, 2]), Error::OutOfRange { what: "label", got: 2.0, .. }));
    let coded = run(&[1.0, 2.0], 2, &settings).unwrap();
    let infinite = coded.encode(&[1.0, f32::INFINITY], &mut [0], &mut [0.0]);
    assert_eq!(infinite, Err(Error::NotFinite { what: "row element", index: 1 }));
}

struct StopAfter {
    calls: Mutex<Vec<(usize, usize)>>,
    limit: usize,
}

impl Progress for StopAfter {
    fn advance(&self, done: usize, total: usize) {
        self.calls.lock().unwrap().push((done, total));
    }
    fn is_cancelled(&self) -> bool {
        self.calls.lock().unwrap().len() >= self.limit
    }
}

#[test]
fn progress_ends_at_the_total_and_cancels_anywhere() {
    let matrix = planted(900, 30, 5, 2);
    let settings = ClusteredPcaSettings::new(6, 2);
    let run = |limit| {
        let watch = StopAfter { calls: Mutex::new(Vec::new()), limit };
        let result = ClusteredPca::new(&matrix, 30, &settings, &watch);
        (result, watch.calls.into_inner().unwrap())
    };
    let (result, calls) = run(usize::MAX);
    assert_eq!(result.unwrap(), ClusteredPca::new(&matrix, 30, &settings, &()).unwrap());
    let total = 900 * (2 * settings.iterations + 1);
    assert!(calls.iter().all(|&(done, of)| done <= total && of == total));
    assert_eq!(calls.last(), Some(&(total, total)));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for limit in [0, 1, 7, calls.len() / 2, calls.len() - 2] {
        assert_eq!(run(limit).0, Err(Error::Cancelled), "{limit} of {}", calls.len());
        // On one thread nothing is under way that could still finish; one step may be left out as a whole.
        let (result, heard) = one.install(|| run(limit));
        assert_eq!(result, Err(Error::Cancelled), "{limit} of {}", calls.len());
        assert!((limit..=limit + 1).contains(&heard.len()), "{} calls for {limit}", heard.len());
    }
}
