//! What coded maps cost.

/// Counts and sizes of coded maps, as the papers tabulate them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct RunStats {
    /// Maps.
    pub maps: usize,
    /// Maps that are 0 everywhere.
    pub all_zero: usize,
    /// Maps that are 1 everywhere (a gray map: its top level).
    pub all_one: usize,
    /// Changes of all maps.
    pub changes: usize,
    /// Changes of the maps that are not constant.
    pub changes_of_mixed: usize,
    /// Changes of the map that has most.
    pub most_changes: usize,
    /// Bytes in memory: places, levels and offsets.
    pub bytes_in_memory: usize,
    /// Bytes of `to_bytes`.
    pub bytes_in_file: usize,
}

impl RunStats {
    /// Changes a map that is not constant; 0 if all are. The "coefficients" of table 3 [Inger 2013].
    pub fn mean_changes_of_mixed(&self) -> f64 {
        let mixed = self.maps - self.all_zero - self.all_one;
        if mixed == 0 { 0.0 } else { self.changes_of_mixed as f64 / mixed as f64 }
    }

    /// Bytes in the file a map; 0 without maps.
    pub fn mean_bytes_in_file(&self) -> f64 {
        if self.maps == 0 { 0.0 } else { self.bytes_in_file as f64 / self.maps as f64 }
    }

    pub(super) fn count(&mut self, changes: usize, all_one: bool) {
        self.maps += 1;
        self.changes += changes;
        self.most_changes = self.most_changes.max(changes);
        match changes {
            0 => self.all_zero += 1,
            _ if all_one => self.all_one += 1,
            _ => self.changes_of_mixed += changes,
        }
    }
}
