//! Principal components against the naive twin, and their own laws.

use haarmonic::compress::{Centre, Pca, PcaMethod, PcaSettings};
use haarmonic::reference::compress::NaivePca;
use haarmonic::strategies::low_rank_rows;
use haarmonic::{Error, Real};
use proptest::prelude::*;

use crate::support::{Stream, cases, dot, flat, wide};

/// Sketches as wide as the matrices below, which are not approximate.
fn settings() -> impl Strategy<Value = PcaSettings> {
    let centre = prop_oneof![2 => Just(Centre::Mean), 1 => Just(Centre::Origin)];
    let method = prop_oneof![Just(PcaMethod::Exact), Just(PcaMethod::Randomised), Just(PcaMethod::Auto)];
    (0..12usize, centre, method, any::<u64>()).prop_map(|(k, centre, method, seed)| {
        PcaSettings::new(k).with_oversampling(12).with_centre(centre).with_method(method).with_seed(seed)
    })
}

/// The laws that hold whatever the method, and the comparison with the twin, for rows that `T` holds exactly.
fn check<T: Real>(rows: &[Vec<f64>], settings: &PcaSettings) -> Result<(), TestCaseError> {
    let columns = rows[0].len();
    let matrix: Vec<T> = flat(rows);
    let rows: Vec<Vec<f64>> = matrix.chunks(columns).map(wide).collect();
    let zeros = vec![0.0; columns];
    let pca = Pca::new(&matrix, columns, settings).unwrap();
    let twin = NaivePca::new(&rows, (settings.centre == Centre::Origin).then_some(&zeros[..]));
    let eps = T::epsilon().widen();
    let size = rows.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    // Ours is rounded once; the twin's is a plain sum in f64.
    for (got, want) in pca.mean().iter().zip(&twin.mean) {
        prop_assert!((got.widen() - want).abs() <= (eps + rows.len() as f64 * f64::EPSILON) * size);
    }
    // The twin's variances and ours are off by ε of sums of up to 25 squares; a component that is dropped is as small.
    let total: f64 = twin.variances.iter().sum();
    let noise = 32.0 * eps * total + 64.0 * (eps * size).powi(2);
    // About the first row, which may be as far from the mean as all others together.
    let cancelled = 4.0 * rows.len() as f64 * f64::EPSILON * total;
    prop_assert!((pca.total_variance() - total).abs() <= noise + cancelled, "{} {total}", pca.total_variance());
    prop_assert!(pca.len() <= settings.components.min(columns).min(rows.len()));
    prop_assert!(pca.variances().is_sorted_by(|a, b| a >= b));
    for j in 0..settings.components.min(columns) {
        let got = pca.variances().get(j).copied().unwrap_or(0.0);
        let dropped = if j < pca.len() { 0.0 } else { (64.0 * eps).powi(2).max(128.0 * f64::EPSILON) * total };
        prop_assert!((got - twin.variances[j]).abs() <= noise + dropped, "{j}: {got:e} {:e}", twin.variances[j]);
    }
    for j in 0..pca.len() {
        let u = wide(pca.component(j));
        for i in 0..=j {
            let product = dot(&u, &wide(pca.component(i)));
            // Each of some hundred rotations rounds: measured up to 10 ε.
            prop_assert!((product - f64::from(i == j)).abs() <= 32.0 * eps, "{i} {j}: {product}");
        }
        let largest = u.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        prop_assert!(u.contains(&largest), "sign of component {j}");
        // u is the twin's where its variance stands apart: an error e of the matrix turns it by e/gap.
        let v = &twin.variances;
        let gap = if j > 0 { v[j - 1] - v[j] } else { f64::INFINITY };
        let gap = gap.min(v.get(j + 1).map_or(f64::INFINITY, |next| v[j] - next));
        let cos = dot(&u, &twin.components[j]).abs();
        prop_assert!(
            gap <= 0.0 || 1.0 - cos <= 2.0 * (noise / gap).powi(2) + 32.0 * eps,
            "component {j}: {cos} {gap:e}"
        );
    }
    // No subspace of the dimension is nearer.
    let mut weights = vec![T::zero(); rows.len() * pca.len()];
    pca.project(&matrix, &mut weights);
    let mut back = vec![T::of(f64::NAN); matrix.len()];
    pca.reconstruct(&weights, &mut back);
    let squares: f64 = wide(&back).iter().zip(rows.iter().flatten()).map(|(a, b)| (a - b) * (a - b)).sum();
    let best: f64 = rows.iter().map(|row| twin.squared_distance(row, pca.len())).sum();
    let n = rows.len() as f64;
    // Reconstruction rounds each element by a few ε: (r + δ)² − r² = 2rδ + δ².
    let rounding = 4.0 * eps * size * (n * columns as f64).sqrt();
    let tolerance = n * noise + 2.0 * best.sqrt() * rounding + rounding * rounding;
    prop_assert!((squares - best).abs() <= tolerance, "{squares:e} {best:e}");
    let distortion = pca.distortion(&matrix);
    prop_assert!((distortion.rms.powi(2) * (n * columns as f64) - squares).abs() <= 1e-12 * squares + 1e-300);
    // Weights: those of the same components in f64, and their mean squares are the variances.
    for (row, weights) in rows.iter().zip(weights.chunks(pca.len().max(1))) {
        let mean = wide(pca.mean());
        let difference: Vec<f64> = row.iter().zip(&mean).map(|(x, m)| x - m).collect();
        for (j, weight) in weights.iter().enumerate() {
            let want = dot(&difference, &wide(pca.component(j)));
            prop_assert!((weight.widen() - want).abs() <= columns as f64 * eps * 2.0 * size, "{weight} {want}");
        }
    }
    for j in 0..pca.len() {
        let mean_square = (0..rows.len()).map(|i| weights[i * pca.len() + j].widen().powi(2)).sum::<f64>() / n;
        prop_assert!((mean_square - pca.variances()[j]).abs() <= 2.0 * noise);
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn f64_is_the_twin(rows in low_rank_rows(25, 12), settings in settings()) {
        check::<f64>(&rows, &settings)?;
    }

    #[test]
    fn f32_is_the_twin(rows in low_rank_rows(25, 12), settings in settings()) {
        check::<f32>(&rows, &settings)?;
    }

    #[test]
    fn a_row_has_the_same_bits_alone(rows in low_rank_rows(120, 40), k in 0..20usize) {
        let columns = rows[0].len();
        let matrix: Vec<f32> = flat(&rows);
        let pca = Pca::new(&matrix, columns, &PcaSettings::new(k)).unwrap();
        let mut weights = vec![0.0; rows.len() * pca.len()];
        pca.project(&matrix, &mut weights);
        let mut back = vec![0.0; matrix.len()];
        pca.reconstruct(&weights, &mut back);
        for (i, row) in matrix.chunks(columns).enumerate() {
            let weights = &weights[i * pca.len()..][..pca.len()];
            let (mut alone, mut out) = (vec![f32::NAN; pca.len()], vec![f32::NAN; columns]);
            pca.project(row, &mut alone);
            pca.reconstruct(&alone, &mut out);
            prop_assert_eq!(&alone, weights);
            prop_assert_eq!(&out, &back[i * columns..][..columns]);
        }
    }

    /// Scaling by powers of two, up to where numbers squared would leave f32, changes nothing but the exponents.
    #[test]
    fn huge_and_tiny_rows(rows in low_rank_rows(30, 10), exponent in prop_oneof![-60..-40i32, 80..120i32], settings in settings()) {
        let columns = rows[0].len();
        let factor = f64::from(exponent).exp2();
        let small: Vec<f32> = flat(&rows);
        // Nothing that becomes subnormal.
        prop_assume!(small.iter().all(|x| *x == 0.0 || x.abs() > 1e-12));
        let scaled: Vec<f32> = small.iter().map(|x| x * factor as f32).collect();
        let (a, b) = (Pca::new(&small, columns, &settings).unwrap(), Pca::new(&scaled, columns, &settings).unwrap());
        prop_assert_eq!(a.components(), b.components());
        let variances: Vec<f64> = a.variances().iter().map(|v| v * factor * factor).collect();
        prop_assert_eq!(&variances[..], b.variances());
    }
}

/// Rows = Σ_j 2^{−j/2}·(random)·direction_j + 1e-3 noise; more rows and columns than any tile or task takes at once.
fn large<T: Real>(rows: usize, columns: usize) -> Vec<T> {
    let mut stream = Stream::new(7);
    let directions: Vec<f64> = (0..12 * columns).map(|_| stream.signed()).collect();
    let mut out = Vec::with_capacity(rows * columns);
    for _ in 0..rows {
        let weights: Vec<f64> = (0..12).map(|j| stream.signed() * (-0.5 * f64::from(j)).exp2()).collect();
        for c in 0..columns {
            let sum: f64 = weights.iter().enumerate().map(|(j, w)| w * directions[j * columns + c]).sum();
            out.push(T::of(3.0 + sum + 1e-3 * stream.signed()));
        }
    }
    out
}

/// Beyond every block of the products, tall and wide: the randomised method has the exact one's variances, and both
/// hold what they promise.
fn both_methods_agree<T: Real>(rows: usize, columns: usize, tolerance: f64) {
    let matrix = large::<T>(rows, columns);
    for centre in [Centre::Mean, Centre::Origin] {
        let settings = PcaSettings::new(10).with_centre(centre);
        let exact = Pca::new(&matrix, columns, &settings.with_method(PcaMethod::Exact)).unwrap();
        let random = Pca::new(&matrix, columns, &settings.with_method(PcaMethod::Randomised)).unwrap();
        assert_eq!((exact.len(), random.len()), (10, 10));
        assert_eq!(exact.mean(), random.mean());
        for j in 0..10 {
            let (a, b) = (exact.variances()[j], random.variances()[j]);
            assert!((a - b).abs() <= tolerance * exact.variances()[0], "{rows}x{columns} {j}: {a:e} {b:e}");
            let cos = dot(&wide(exact.component(j)), &wide(random.component(j)));
            assert!((cos - 1.0).abs() <= 100.0 * tolerance, "{rows}x{columns} {j}: {cos}");
        }
        // Parseval, with the variance from the matrix itself.
        let left = exact.total_variance() - exact.variances().iter().sum::<f64>();
        let rms = exact.distortion(&matrix).rms;
        let relative = (rms * rms * columns as f64 / left - 1.0).abs();
        assert!(relative <= 100.0 * tolerance * exact.total_variance() / left, "{relative:e}");
    }
}

#[test]
fn methods_agree_on_large_matrices() {
    // Variances to ε of the largest, eigenvectors by the gap between neighbours (a factor of 2).
    both_methods_agree::<f64>(700, 150, 1e-13);
    both_methods_agree::<f64>(150, 700, 1e-13);
    both_methods_agree::<f32>(700, 300, 1e-6);
    both_methods_agree::<f32>(90, 1030, 1e-6);
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let matrix = large::<f32>(700, 300);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let four = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    for method in [PcaMethod::Exact, PcaMethod::Randomised] {
        let run = || Pca::new(&matrix, 300, &PcaSettings::new(8).with_method(method)).unwrap();
        assert_eq!(one.install(run), four.install(run));
    }
    let run = |seed| Pca::new(&matrix, 300, &PcaSettings::new(8).with_seed(seed)).unwrap();
    assert_ne!(run(1).components(), run(2).components(), "the seed is used");
}

#[test]
fn degenerate_matrices() {
    let all = PcaSettings::new(9);
    for method in [PcaMethod::Exact, PcaMethod::Randomised] {
        let all = all.with_method(method);
        // One element; equal rows, of numbers whose mean rounds; zeros.
        for matrix in [vec![0.1], vec![0.1; 3], vec![0.1, 0.7, 0.1, 0.7, 0.1, 0.7], vec![0.0; 6]] {
            let columns = matrix.len().div_ceil(3);
            let pca = Pca::<f64>::new(&matrix, columns, &all).unwrap();
            assert!(pca.is_empty());
            assert_eq!(pca.total_variance(), 0.0);
            let mut back = vec![f64::NAN; matrix.len()];
            pca.project(&matrix, &mut []);
            pca.reconstruct(&[], &mut back);
            assert_eq!(back, matrix);
        }
        let origin = all.with_centre(Centre::Origin);
        let pca = Pca::<f32>::new(&[-3.0], 1, &origin).unwrap();
        assert_eq!((pca.components(), pca.variances(), pca.mean()), (&[1.0][..], &[9.0][..], &[0.0][..]));
        assert!(Pca::<f32>::new(&[0.0; 4], 2, &origin).unwrap().is_empty());
        // Rank 1 of 3.
        let pca =
            Pca::<f64>::new(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, -1.0, -2.0, -3.0, 0.0, 0.0, 0.0], 3, &origin).unwrap();
        assert_eq!(pca.len(), 1);
        assert!((pca.variances()[0] - 21.0).abs() < 1e-13);
    }
    assert!(Pca::<f32>::new(&[1.0, 2.0, 3.0, 5.0], 2, &PcaSettings::new(0)).unwrap().is_empty());
    assert_eq!(Pca::<f32>::new(&[], 2, &all), Err(Error::Empty { what: "matrix" }));
    assert_eq!(Pca::<f32>::new(&[1.0], 0, &all), Err(Error::Empty { what: "matrix" }));
    assert_eq!(Pca::<f32>::new(&[1.0; 5], 2, &all), Err(Error::Length { what: "matrix", expected: 6, got: 5 }));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let not_finite = Err(Error::NotFinite { what: "matrix element", index: 3 });
        assert_eq!(Pca::new(&[1.0, 2.0, 3.0, bad, 1.0, 1.0], 2, &all), not_finite);
    }
    let large = Pca::new(&[1e141, 0.0], 1, &all);
    assert!(matches!(large, Err(Error::OutOfRange { got: 1e141, .. })));
}

/// Of entries of one magnitude the first is positive, whatever sign the method found.
#[test]
fn the_first_of_equal_entries_is_positive() {
    for method in [PcaMethod::Exact, PcaMethod::Randomised] {
        for sign in [1.0, -1.0] {
            // Tall and wide: x and −x for some vectors of ±1.
            for row in [&[1.0, -1.0][..], &[-1.0, 1.0, 1.0, -1.0, -1.0]] {
                let matrix: Vec<f64> = [sign, -sign].iter().flat_map(|s| row.iter().map(move |x| s * x)).collect();
                let settings = PcaSettings::new(1).with_method(method);
                let pca = Pca::new(&matrix, row.len(), &settings).unwrap();
                let component = pca.component(0);
                assert!(component.iter().all(|x| x.abs() == component[0].abs()), "equal: {component:?}");
                assert!(component[0] > 0.0, "{method:?}: {component:?}");
            }
        }
    }
}

/// Exact up to a smaller side of twice the sketch, randomised beyond.
#[test]
fn the_method_goes_by_size() {
    let settings = PcaSettings::new(3).with_oversampling(2);
    for (rows, columns) in [(40, 10), (10, 40), (40, 11), (11, 40)] {
        let matrix = large::<f64>(rows, columns);
        let by = |method| Pca::new(&matrix, columns, &settings.with_method(method)).unwrap();
        let (chosen, exact, random) = (by(PcaMethod::Auto), by(PcaMethod::Exact), by(PcaMethod::Randomised));
        assert_ne!(exact, random, "{rows} × {columns}: no choice to see");
        assert!(chosen == if rows.min(columns) == 10 { exact } else { random }, "{rows} × {columns}");
    }
}

#[test]
fn parts_make_the_same() {
    let matrix = large::<f32>(60, 40);
    let pca = Pca::new(&matrix, 40, &PcaSettings::new(5)).unwrap();
    let parts =
        |total| Pca::from_parts(pca.mean().to_vec(), pca.components().to_vec(), pca.variances().to_vec(), total);
    assert_eq!(parts(pca.total_variance()).unwrap(), pca);
    assert_eq!(parts(f64::NAN), Err(Error::NotFinite { what: "variance", index: 5 }));
    assert_eq!(
        Pca::from_parts(vec![0.0f32; 3], vec![0.0; 4], vec![1.0], 1.0),
        Err(Error::Length { what: "components", expected: 3, got: 4 })
    );
    assert_eq!(pca.bytes(60), (40 + 5 * 40 + 60 * 5) * 4);
}

#[test]
fn nan_stays_in_its_row() {
    let matrix = large::<f32>(60, 40);
    let pca = Pca::new(&matrix, 40, &PcaSettings::new(5)).unwrap();
    let mut rows = matrix[..7 * 40].to_vec();
    rows[3 * 40 + 2] = f32::NAN;
    let mut weights = [0.0; 35];
    pca.project(&rows, &mut weights);
    for (i, w) in weights.chunks(5).enumerate() {
        assert!(w.iter().all(|w| w.is_nan() == (i == 3)));
    }
}

#[test]
#[should_panic(expected = "weights: expected length 10, got 9")]
fn weights_have_one_length() {
    let pca = Pca::new(&large::<f32>(60, 40), 40, &PcaSettings::new(5)).unwrap();
    pca.project(&[0.0; 80], &mut [0.0; 9]);
}
