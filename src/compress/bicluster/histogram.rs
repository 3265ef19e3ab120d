//! How often each value occurs in one column of the current submatrix.

/// Counts of the non-zero values of a column over the chosen rows, and which of them are the most frequent.
#[derive(Debug, Clone, Default)]
pub(super) struct Histogram {
    /// (value, count) in order of first appearance: a column has few different values.
    counts: Vec<(i32, u32)>,
    /// The largest count; 0 if the column is empty.
    max: u32,
    /// How many values have it.
    modes: u32,
    /// How many rows have a non-zero value.
    total: u32,
}

impl Histogram {
    pub(super) fn max(&self) -> u32 {
        self.max
    }

    pub(super) fn total(&self) -> u32 {
        self.total
    }

    /// m + nnz: the larger, the more adding the column saves (2 (m + nnz − r − 1)).
    pub(super) fn key(&self) -> u32 {
        self.max + self.total
    }

    /// Whether no value is more frequent than this one.
    #[inline]
    pub(super) fn is_mode(&self, value: i32) -> bool {
        self.counts.iter().any(|&(v, count)| v == value && count == self.max) && self.max > 0
    }

    /// Whether every other value is less frequent.
    #[inline]
    pub(super) fn is_only_mode(&self, value: i32) -> bool {
        self.modes == 1 && self.is_mode(value)
    }

    /// The smallest of the most frequent values; `None` if the column is empty.
    pub(super) fn mode(&self) -> Option<i32> {
        self.counts.iter().filter(|&&(_, count)| count == self.max && count > 0).map(|&(v, _)| v).min()
    }

    /// Counts one more `value`. Returns whether the set of modes changed; `before` then holds the old one.
    pub(super) fn add(&mut self, value: i32, before: &mut Vec<i32>) -> bool {
        self.total += 1;
        let at = self.counts.iter().position(|&(v, _)| v == value).unwrap_or_else(|| {
            self.counts.push((value, 0));
            self.counts.len() - 1
        });
        let count = self.counts[at].1 + 1;
        let changed = count == self.max || (count > self.max && !(self.modes == 1 && count > 1));
        if changed {
            self.modes_into(before);
        }
        self.counts[at].1 = count;
        if count > self.max {
            (self.max, self.modes) = (count, 1);
        } else if count == self.max {
            self.modes += 1;
        }
        changed
    }

    /// Counts one `value` less, which must have been added. Returns whether the set of modes changed; `before` then
    /// holds the old one.
    pub(super) fn remove(&mut self, value: i32, before: &mut Vec<i32>) -> bool {
        self.total -= 1;
        let at = self.counts.iter().position(|&(v, _)| v == value).expect("only what was added is removed");
        let was_mode = self.counts[at].1 == self.max;
        if was_mode {
            self.modes_into(before);
        }
        self.counts[at].1 -= 1;
        if !was_mode {
            return false;
        }
        if self.modes > 1 {
            self.modes -= 1;
            return true;
        }
        self.max -= 1;
        self.modes = if self.max == 0 { 0 } else { self.counts.iter().filter(|c| c.1 == self.max).count() as u32 };
        self.modes != 1
    }

    pub(super) fn clear(&mut self) {
        self.counts.clear();
        (self.max, self.modes, self.total) = (0, 0, 0);
    }

    fn modes_into(&self, out: &mut Vec<i32>) {
        out.clear();
        out.extend(self.counts.iter().filter(|c| c.1 == self.max && self.max > 0).map(|c| c.0));
    }
}
