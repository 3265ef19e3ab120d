pub(super) const TABLES: [(&[f64], &[f64]); 0] = [];
