//! Rows that have much in common, together.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::matrix::SparseMatrix;

/// Rounds of reassignment; more change little.
const ROUNDS: usize = 3;

/// Groups of rows, each ascending, every row with entries in exactly one.
///
/// 1. The column with the most entries in rows without a group takes those rows, and so on.
/// 2. Some rounds, as in k-means: each column goes to the group in which it has most entries, then each row to the
///    group that most of its columns went to. The scraps that step 1 ends with dissolve into the groups around them.
/// 3. Groups above `group_rows` are cut into equal runs of consecutive rows; small ones are joined up to it.
///
/// Where supports are compact (a solid angle of directions), a row shares its columns with rows of its own group for
/// the most part. Time and memory: linear in the entries.
pub(super) fn by_shared_columns(matrix: &SparseMatrix, group_rows: usize) -> Vec<Vec<u32>> {
    let (labels, count) = labelled(matrix);
    let mut groups = vec![Vec::new(); count];
    let rows = (0..matrix.rows()).filter(|&row| labels[row] != NONE);
    rows.for_each(|row| groups[labels[row] as usize].push(row as u32));
    groups.retain(|group| !group.is_empty());
    resize(groups, group_rows)
}

/// Steps 1 and 2: the group of each row, and how many there are.
fn labelled(matrix: &SparseMatrix) -> (Vec<u32>, usize) {
    let by_column = rows_by_column(matrix);
    let (mut labels, count) = anchored(matrix, &by_column);
    let mut votes = Votes::new(count);
    for _ in 0..ROUNDS {
        let column_label = |rows: &Vec<u32>| votes.winner(rows.iter().map(|&row| labels[row as usize]));
        let column_labels: Vec<u32> = by_column.iter().map(column_label).collect();
        for row in 0..matrix.rows() {
            labels[row] = votes.winner(matrix.row(row).0.iter().map(|&column| column_labels[column as usize]));
        }
    }
    (labels, count)
}

/// The label of what has no entries.
const NONE: u32 = u32::MAX;

/// Step 1: the group of each row, and how many groups there are.
fn anchored(matrix: &SparseMatrix, by_column: &[Vec<u32>]) -> (Vec<u32>, usize) {
    let mut counts: Vec<usize> = by_column.iter().map(Vec::len).collect();
    // Counts only fall, so an entry of the heap is an upper bound: it goes back if it is not the true count.
    let mut heap: BinaryHeap<_> = counts.iter().enumerate().map(|(k, &n)| (n, Reverse(k))).collect();
    let mut labels = vec![NONE; matrix.rows()];
    let mut groups = 0;
    while let Some((bound, Reverse(column))) = heap.pop() {
        if counts[column] == 0 {
            continue;
        }
        if bound != counts[column] {
            heap.push((counts[column], Reverse(column)));
            continue;
        }
        for &row in &by_column[column] {
            if labels[row as usize] != NONE {
                continue;
            }
            labels[row as usize] = groups;
            matrix.row(row as usize).0.iter().for_each(|&k| counts[k as usize] -= 1);
        }
        groups += 1;
    }
    (labels, groups as usize)
}

/// Counts of labels.
struct Votes {
    counts: Vec<u32>,
    cast: Vec<u32>,
}

impl Votes {
    fn new(labels: usize) -> Self {
        Self { counts: vec![0; labels], cast: Vec::new() }
    }

    /// The most frequent label, the smallest of equals; `NONE` if there is none.
    fn winner(&mut self, labels: impl Iterator<Item = u32>) -> u32 {
        for label in labels {
            let count = &mut self.counts[label as usize];
            if *count == 0 {
                self.cast.push(label);
            }
            *count += 1;
        }
        let best = self.cast.iter().copied().max_by_key(|&label| (self.counts[label as usize], Reverse(label)));
        self.cast.drain(..).for_each(|label| self.counts[label as usize] = 0);
        best.unwrap_or(NONE)
    }
}

fn rows_by_column(matrix: &SparseMatrix) -> Vec<Vec<u32>> {
    let mut by_column = vec![Vec::new(); matrix.columns()];
    for row in 0..matrix.rows() {
        matrix.row(row).0.iter().for_each(|&column| by_column[column as usize].push(row as u32));
    }
    by_column
}

fn resize(groups: Vec<Vec<u32>>, group_rows: usize) -> Vec<Vec<u32>> {
    let mut sized: Vec<Vec<u32>> = Vec::new();
    for group in groups {
        match sized.last_mut() {
            Some(last) if last.len().saturating_add(group.len()) <= group_rows => {
                last.extend_from_slice(&group);
                last.sort_unstable();
            }
            _ => {
                let run = group.len().div_ceil(group.len().div_ceil(group_rows));
                sized.extend(group.chunks(run).map(<[u32]>::to_vec));
            }
        }
    }
    sized
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[usize]]) -> SparseMatrix {
        let places = rows.iter().enumerate().flat_map(|(j, row)| row.iter().map(move |&k| (j, k, 1)));
        SparseMatrix::from_triplets(rows.len(), 10, 1.0, places).unwrap()
    }

    #[test]
    fn scraps_join_the_group_around_them() {
        // Column 0 takes all rows but the third and the empty one; the third shares two of its three columns with them.
        let matrix = matrix(&[&[0, 1, 2], &[0, 1, 2], &[1, 2, 9], &[0, 1, 2], &[0], &[0, 1, 2], &[]]);
        assert_eq!(anchored(&matrix, &rows_by_column(&matrix)), (vec![0, 0, 1, 0, 0, 0, NONE], 2));
        assert_eq!(labelled(&matrix), (vec![0, 0, 0, 0, 0, 0, NONE], 2));
        assert_eq!(by_shared_columns(&matrix, 6), [[0, 1, 2, 3, 4, 5]]);
    }

    #[test]
    fn groups_are_cut_and_joined() {
        let matrix = matrix(&[&[0], &[1], &[0], &[2], &[0], &[0], &[0], &[0], &[0]]);
        assert_eq!(by_shared_columns(&matrix, 3), [vec![0, 2, 4], vec![5, 6, 7], vec![1, 3, 8]]);
        assert_eq!(by_shared_columns(&matrix, 4), [vec![0, 2, 4, 5], vec![1, 6, 7, 8], vec![3]]);
        assert_eq!(by_shared_columns(&matrix, usize::MAX).len(), 1);
    }
}
