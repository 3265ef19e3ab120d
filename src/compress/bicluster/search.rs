//! The search for all biclusters of a matrix, group by group.

use super::super::random::Random;
use super::growth::{Grown, Growth};
use super::matrix::SparseMatrix;
use super::residual::{Entry, Residual};
use super::settings::{BiclusterSettings, Seeds};
use super::trace::{BiclusterMove, BiclusterStep, BiclusterTrace};
use crate::parallel::Watch;
use crate::{Progress, Result, parallel};

/// Whether to keep the moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tracing {
    Off,
    On,
}

/// The biclusters of one group, in the order found, rows and columns of the whole matrix.
pub(super) type Found = (Vec<Grown>, Vec<BiclusterTrace>);

/// Biclusters of each group of rows; the groups' rows ascend.
pub(super) fn search(
    matrix: &SparseMatrix,
    groups: &[Vec<u32>],
    settings: &BiclusterSettings,
    tracing: Tracing,
    progress: &dyn Progress,
) -> Result<Vec<Found>> {
    let watch = Watch::new(progress, matrix.nnz());
    let one = |index: usize, (): &mut ()| {
        let shuffle = match settings.seeds {
            Seeds::First => None,
            Seeds::Random(seed) => Some(Random::new(seed, index as u64)),
        };
        Group::new(matrix, &groups[index], shuffle).run(tracing, &watch)
    };
    parallel::try_map(groups.len(), || (), one)
}

/// Reports the non-zeros that were covered, some thousandths at a time.
fn covered(watch: &Watch, pending: &mut usize, last: bool) -> Result<()> {
    watch.check()?;
    if *pending > watch.total() / 512 || last {
        watch.advance(std::mem::take(pending));
    }
    Ok(())
}

/// Some rows of the matrix and the columns that they use, numbered from 0.
struct Group<'a> {
    rows: &'a [u32],
    columns: Vec<u32>,
    residual: Residual,
    /// Places to begin at, the last one first.
    seeds: Vec<(u32, u32)>,
    /// No row before this one has entries.
    first: usize,
}

impl<'a> Group<'a> {
    fn new(matrix: &SparseMatrix, rows: &'a [u32], shuffle: Option<Random>) -> Self {
        let mut columns: Vec<u32> = rows.iter().flat_map(|&row| matrix.row(row as usize).0).copied().collect();
        columns.sort_unstable();
        columns.dedup();
        let local = |&row: &u32| {
            let (indices, levels) = matrix.row(row as usize);
            let mut at = 0;
            let mut entry = |(column, &level): (&u32, &i32)| {
                at += columns[at..].partition_point(|c| c < column);
                Entry { index: at as u32, level }
            };
            indices.iter().zip(levels).map(&mut entry).collect()
        };
        let local_rows: Vec<Vec<Entry>> = rows.iter().map(local).collect();
        let mut seeds = Vec::new();
        if let Some(mut shuffle) = shuffle {
            let places = local_rows.iter().enumerate();
            seeds = places.flat_map(|(row, entries)| entries.iter().map(move |e| (row as u32, e.index))).collect();
            shuffle.shuffle(&mut seeds);
        }
        let residual = Residual::new(local_rows, columns.len());
        Self { rows, columns, residual, seeds, first: 0 }
    }

    /// Where the next bicluster begins; `None` if nothing is left.
    fn seed(&mut self) -> Option<(usize, usize)> {
        while let Some((row, column)) = self.seeds.pop() {
            if self.residual.level(row as usize, column as usize) != 0 {
                return Some((row as usize, column as usize));
            }
        }
        while self.residual.rows.get(self.first)?.is_empty() {
            self.first += 1;
        }
        Some((self.first, self.residual.rows[self.first][0].index as usize))
    }

    fn run(mut self, tracing: Tracing, watch: &Watch) -> Result<Found> {
        let mut growth = Growth::new(self.rows.len(), self.columns.len());
        let (mut found, mut traces) = (Vec::new(), Vec::new());
        let mut pending = 0;
        while let Some(seed) = self.seed() {
            covered(watch, &mut pending, false)?;
            let before = self.residual.nnz;
            let mut steps = Vec::new();
            let mut keep = |step| {
                if tracing == Tracing::On {
                    steps.push(self.global_step(step));
                }
            };
            let mut grown = growth.grow(&self.residual, seed, &mut keep);
            if self.residual.subtract(&grown.rows, &grown.columns, &grown.levels).is_err() {
                // Levels have doubled until they no longer fit: the element alone always does.
                steps.clear();
                let level = self.residual.level(seed.0, seed.1);
                let (rows, columns) = (vec![seed.0 as u32], vec![seed.1 as u32]);
                grown = Grown { rows, columns, levels: vec![level], saving: 0 };
                let subtracted = self.residual.subtract(&grown.rows, &grown.columns, &grown.levels);
                debug_assert!(subtracted.is_ok());
            }
            pending += before - self.residual.nnz;
            if tracing == Tracing::On {
                let seed = (self.rows[seed.0] as usize, self.columns[seed.1] as usize);
                traces.push(BiclusterTrace { seed, steps, saving: grown.saving });
            }
            found.push(self.global(grown));
        }
        covered(watch, &mut pending, true)?;
        Ok((found, traces))
    }

    fn global(&self, mut grown: Grown) -> Grown {
        grown.rows.iter_mut().for_each(|row| *row = self.rows[*row as usize]);
        grown.columns.iter_mut().for_each(|column| *column = self.columns[*column as usize]);
        grown
    }

    fn global_step(&self, step: BiclusterStep) -> BiclusterStep {
        let index = match step.kind {
            BiclusterMove::AddRow | BiclusterMove::DeleteRow => self.rows[step.index],
            BiclusterMove::AddColumn | BiclusterMove::DeleteColumn => self.columns[step.index],
        };
        BiclusterStep { index: index as usize, ..step }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_would_overflow_are_taken_one_by_one() {
        // Ten rows alike and one whose residual, −2 − i32::MAX, does not fit.
        let (fits, does_not) = ([5, i32::MAX], [5, -3]);
        let levels: Vec<[i32; 2]> = (0..11).map(|row| if row == 7 { does_not } else { fits }).collect();
        let entries = |l: &[i32; 2]| vec![Entry { index: 0, level: l[0] }, Entry { index: 1, level: l[1] }];
        let residual = Residual::new(levels.iter().map(entries).collect(), 2);
        let rows: Vec<u32> = (0..11).collect();
        let group = Group { rows: &rows, columns: vec![0, 1], residual, seeds: Vec::new(), first: 0 };
        let watch = Watch::new(&(), 22);
        let Ok((found, traces)) = group.run(Tracing::On, &watch) else { panic!("nobody cancels") };
        assert!(traces.len() == found.len() && found[0].saving == 0 && traces[0].steps.is_empty());
        let mut sum = [[0i64; 2]; 11];
        for b in &found {
            for &row in &b.rows {
                let columns = b.columns.iter().zip(&b.levels);
                columns.for_each(|(&k, &t)| sum[row as usize][k as usize] += i64::from(t));
            }
        }
        assert_eq!(sum.to_vec(), levels.iter().map(|l| l.map(i64::from)).collect::<Vec<_>>());
    }
}
