//! Products of biclusters with vectors.

use super::clusters::Biclustering;
use crate::error::check_length;
use crate::{Real, parallel};

/// T·x from the biclusters of T, for one or several right-hand sides.
///
/// ```text
/// p_i = Σ_{k∈C_i} t_ik x_k,   (T x)_j = Σ_{i: j∈R_i} p_i                     [bi-scale radiance transfer, algorithm 2]
/// ```
///
/// All products first, then each row gathers those of the biclusters that it is in: two passes that read their lists
/// from front to back.
///
/// Accuracy: each row is a sum of rounded sums, off by at most n·ε·Σ_i Σ_k |t_ik x_k|, n the terms of its longest chain
/// (columns of a bicluster and biclusters of the row). Residuals cancel: the sum of magnitudes may exceed that of the
/// matrix's own entries. NaN or infinity in x_k reaches every row of a bicluster with column k, also of those where a
/// residual takes the column back. The same bits for any number of threads, and for each right-hand side alone or with
/// others.
#[derive(Debug, Clone)]
pub struct BiclusterMultiplier<T> {
    rows: usize,
    columns: usize,
    column_offsets: Vec<u32>,
    column_indices: Vec<u32>,
    weights: Vec<T>,
    row_offsets: Vec<u32>,
    /// For each row the biclusters that it is in, ascending.
    members: Vec<u32>,
}

impl Biclustering {
    /// A plan for products with vectors.
    pub fn multiplier<T: Real>(&self) -> BiclusterMultiplier<T> {
        BiclusterMultiplier::new(self)
    }
}

impl<T: Real> BiclusterMultiplier<T> {
    /// Biclusters and rows that a task takes at a time.
    const CHUNK: usize = 512;

    pub(super) fn new(biclusters: &Biclustering) -> Self {
        let narrow = |n: usize| u32::try_from(n).expect("biclusters with less than 2^32 entries");
        let mut plan = Self {
            rows: biclusters.rows(),
            columns: biclusters.columns(),
            column_offsets: vec![0],
            column_indices: Vec::new(),
            weights: Vec::new(),
            row_offsets: vec![0; biclusters.rows() + 1],
            members: Vec::new(),
        };
        for b in biclusters.iter() {
            plan.column_indices.extend_from_slice(b.columns);
            plan.weights.extend(b.levels.iter().map(|&level| T::of(biclusters.scale() * f64::from(level))));
            plan.column_offsets.push(narrow(plan.column_indices.len()));
            b.rows.iter().for_each(|&row| plan.row_offsets[row as usize + 1] += 1);
        }
        let total: usize = plan.row_offsets.iter().map(|&n| n as usize).sum();
        narrow(total);
        for row in 0..plan.rows {
            plan.row_offsets[row + 1] += plan.row_offsets[row];
        }
        plan.members.resize(total, 0);
        let mut next = plan.row_offsets.clone();
        for (i, b) in biclusters.iter().enumerate() {
            for &row in b.rows {
                plan.members[next[row as usize] as usize] = i as u32;
                next[row as usize] += 1;
            }
        }
        plan
    }

    /// Rows of the matrix: the length of a product.
    #[inline]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the matrix: the length of a right-hand side.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Length of the scratch of a product with `count` right-hand sides: a number for each bicluster and side.
    #[inline]
    pub fn scratch_len(&self, count: usize) -> usize {
        (self.column_offsets.len() - 1).saturating_mul(count)
    }

    /// T·x. On all threads (feature `rayon`).
    ///
    /// # Panics
    /// If `x.len()` is not the number of columns, `out.len()` not that of rows, or `scratch` not
    /// [`scratch_len(1)`](Self::scratch_len) long.
    #[track_caller]
    pub fn multiply(&self, x: &[T], out: &mut [T], scratch: &mut [T]) {
        self.multiply_batch(1, x, out, scratch);
    }

    #[track_caller]
    fn check_sides(&self, sides: usize, x: &[T], out: &[T]) {
        check_length("right-hand sides", self.columns.saturating_mul(sides), x.len());
        check_length("product", self.rows.saturating_mul(sides), out.len());
    }

    /// T·x for `count` right-hand sides at once (RGB, several lights): number k of side s is `x[k · count + s]`.
    ///
    /// # Panics
    /// If `x.len()` is not columns · `count`, `out.len()` not rows · `count`, or `scratch` not
    /// [`scratch_len`](Self::scratch_len) long.
    #[track_caller]
    pub fn multiply_batch(&self, count: usize, x: &[T], out: &mut [T], scratch: &mut [T]) {
        self.check_sides(count, x, out);
        check_length("scratch", self.scratch_len(count), scratch.len());
        match count {
            1 => self.run::<1>(x, out, scratch),
            2 => self.run::<2>(x, out, scratch),
            3 => self.run::<3>(x, out, scratch),
            4 => self.run::<4>(x, out, scratch),
            8 => self.run::<8>(x, out, scratch),
            16 => self.run::<16>(x, out, scratch),
            _ => self.run_any(x, count, out, scratch),
        }
    }

    fn run<const S: usize>(&self, x: &[T], out: &mut [T], scratch: &mut [T]) {
        let (x, _) = x.as_chunks::<S>();
        parallel::rows(scratch, S, Self::CHUNK, |i, out| {
            let range = self.column_offsets[i] as usize..self.column_offsets[i + 1] as usize;
            let mut sums = [T::zero(); S];
            for (&column, &weight) in self.column_indices[range.clone()].iter().zip(&self.weights[range]) {
                let x = &x[column as usize];
                (0..S).for_each(|s| sums[s] += weight * x[s]);
            }
            out.copy_from_slice(&sums);
        });
        let (products, _) = scratch.as_chunks::<S>();
        parallel::rows(out, S, Self::CHUNK, |row, out| {
            let mut sums = [T::zero(); S];
            for &i in &self.members[self.row_offsets[row] as usize..self.row_offsets[row + 1] as usize] {
                let product = &products[i as usize];
                (0..S).for_each(|s| sums[s] += product[s]);
            }
            out.copy_from_slice(&sums);
        });
    }

    fn run_any(&self, x: &[T], sides: usize, out: &mut [T], scratch: &mut [T]) {
        parallel::rows(scratch, sides, Self::CHUNK, |i, sums| {
            let range = self.column_offsets[i] as usize..self.column_offsets[i + 1] as usize;
            sums.fill(T::zero());
            for (&column, &weight) in self.column_indices[range.clone()].iter().zip(&self.weights[range]) {
                let x = &x[column as usize * sides..][..sides];
                sums.iter_mut().zip(x).for_each(|(sum, &x)| *sum += weight * x);
            }
        });
        let products = &*scratch;
        parallel::rows(out, sides, Self::CHUNK, |row, sums| {
            sums.fill(T::zero());
            for &i in &self.members[self.row_offsets[row] as usize..self.row_offsets[row + 1] as usize] {
                let product = &products[i as usize * sides..][..sides];
                sums.iter_mut().zip(product).for_each(|(sum, &p)| *sum += p);
            }
        });
    }
}
