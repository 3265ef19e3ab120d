//! Single elements of what principal components store, against decoded rows and the naive twin.

use haarmonic::Real;
use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings, Pca, PcaSettings};
use haarmonic::reference::compress::NaivePca;
use haarmonic::strategies::{clustered_rows, low_rank_rows};
use proptest::prelude::*;

use crate::support::{cases, flat, largest, wide};

/// Columns and rows in no order, some of them twice.
fn picks(count: usize, of: usize) -> Vec<usize> {
    (0..count).map(|i| (i * 7919 + 3) % of).collect()
}

fn entries_are_those_of_rows<T: Real>(rows: &[Vec<f64>], k: usize) -> Result<(), TestCaseError> {
    let (matrix, columns) = (flat::<T>(rows), rows[0].len());
    let pca = Pca::new(&matrix, columns, &PcaSettings::new(k)).unwrap();
    let (mut weights, mut decoded) = (vec![T::nan(); rows.len() * pca.len()], vec![T::nan(); matrix.len()]);
    pca.project(&matrix, &mut weights);
    pca.reconstruct(&weights, &mut decoded);
    let (mut places, mut all) = (Vec::new(), Vec::new());
    let mut scratch = vec![T::nan(); pca.len() + 1];
    for row in 0..rows.len() {
        let own = &weights[row * pca.len()..][..pca.len()];
        let (picked, mut out) = (picks(9, columns), [T::nan(); 9]);
        pca.row_entries(own, &picked, &mut out);
        for (column, out) in picked.into_iter().zip(out) {
            prop_assert_eq!(out, decoded[row * columns + column]);
            prop_assert_eq!(out, pca.entry(own, column));
            places.push((row, column));
            all.push(out);
        }
    }
    let mut out = vec![T::nan(); all.len()];
    pca.entries(&weights, &places, &mut out);
    prop_assert_eq!(out, all);
    for column in 0..columns {
        let mut out = vec![T::nan(); rows.len()];
        pca.column_entries(&weights, column, &mut out, &mut scratch);
        prop_assert!((0..rows.len()).all(|row| out[row] == decoded[row * columns + column]));
    }
    // The naive sum of what is stored.
    let naive = NaivePca {
        mean: wide(pca.mean()),
        components: pca.components().chunks_exact(columns).map(wide).collect(),
        variances: pca.variances().to_vec(),
    };
    for row in 0..rows.len() {
        let own = wide(&weights[row * pca.len()..][..pca.len()]);
        let terms: f64 = largest(&naive.mean) + own.iter().map(|w| w.abs()).sum::<f64>();
        for (column, want) in naive.reconstruct(&own).into_iter().enumerate() {
            let got = pca.entry(&weights[row * pca.len()..][..pca.len()], column).widen();
            let off = (got - want).abs() / (T::epsilon().widen() * terms.max(f64::MIN_POSITIVE));
            prop_assert!(off <= pca.len() as f64 + 1.0, "{}", off);
        }
    }
    Ok(())
}

fn clustered_entries_are_those_of_rows<T: Real>(rows: &[Vec<f64>], k: usize) -> Result<(), TestCaseError> {
    let (matrix, columns) = (flat::<T>(rows), rows[0].len());
    let coded = ClusteredPca::new(&matrix, columns, &ClusteredPcaSettings::new(3, k.min(columns)), &()).unwrap();
    let mut decoded = vec![T::nan(); matrix.len()];
    for (row, out) in decoded.chunks_exact_mut(columns).enumerate() {
        coded.reconstruct(row, out);
    }
    let mut scratch = vec![T::nan(); coded.scratch_len(1)];
    for column in 0..columns {
        let (picked, mut out) = (picks(rows.len() + 2, rows.len()), vec![T::nan(); rows.len() + 2]);
        coded.column_entries(column, &picked, &mut out, &mut scratch);
        let places: Vec<_> = picked.iter().map(|&row| (row, column)).collect();
        let mut same = out.clone();
        coded.entries(&places, &mut same);
        prop_assert_eq!(&same, &out);
        for (row, out) in picked.into_iter().zip(out) {
            prop_assert_eq!(out, decoded[row * columns + column]);
            prop_assert_eq!(out, coded.entry(row, column));
        }
    }
    for row in 0..rows.len() {
        let (picked, mut out) = (picks(5, columns), [T::nan(); 5]);
        coded.row_entries(row, &picked, &mut out);
        prop_assert!(picked.iter().zip(out).all(|(&column, out)| out == decoded[row * columns + column]));
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn entries_have_the_bits_of_rows(rows in low_rank_rows(20, 40), k in 0..9usize) {
        entries_are_those_of_rows::<f64>(&rows, k)?;
        entries_are_those_of_rows::<f32>(&rows, k)?;
    }

    #[test]
    fn entries_of_clusters_have_the_bits_of_rows(rows in clustered_rows(4, 12, 7), k in 0..4usize) {
        clustered_entries_are_those_of_rows::<f64>(&rows, k)?;
        clustered_entries_are_those_of_rows::<f32>(&rows, k)?;
    }
}

fn pca() -> Pca<f32> {
    Pca::from_parts(vec![1.0, 2.0], vec![0.6, 0.8], vec![1.0], 1.0).unwrap()
}

#[test]
fn nothing_is_asked_for() {
    pca().row_entries(&[1.0], &[], &mut []);
    pca().entries(&[], &[], &mut []);
    pca().column_entries(&[], 0, &mut [], &mut [0.0; 2]);
    let flat = Pca::from_parts(vec![1.0f32, 2.0], vec![], vec![], 1.0).unwrap();
    let mut out = [0.0; 2];
    flat.entries(&[], &[(5, 1), (0, 0)], &mut out);
    assert_eq!((out, flat.entry(&[], 1)), ([2.0, 1.0], 2.0));
}

#[test]
#[should_panic(expected = "column 2 of 2")]
fn a_column_beyond_the_last() {
    pca().entry(&[1.0], 2);
}

#[test]
#[should_panic(expected = "row 1 of 1")]
fn a_row_beyond_the_last() {
    pca().entries(&[1.0], &[(0, 0), (1, 0)], &mut [0.0; 2]);
}

#[test]
#[should_panic(expected = "weights: expected length 1, got 2")]
fn weights_of_another_length() {
    pca().row_entries(&[1.0, 2.0], &[0], &mut [0.0]);
}
