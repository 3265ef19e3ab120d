//! The complexities of several bases next to each other [Sun 2008, §4.4.3].

use haarmonic::affine::{AffineMap, Nonzeros1d};
use serde_json::{Value, json};

use crate::Failure;
use crate::support::table;

/// s and o.
pub const MAP: [f64; 2] = [0.8437, 0.1013];
const SIZES: [usize; 4] = [8, 16, 32, 64];

/// Counts the non-zero coefficients of a basis of N functions at a map.
type Count = fn(usize, AffineMap) -> haarmonic::Result<usize>;

/// What is counted: one line a basis. The others' bases join here.
const BASES: [(&str, Count); 1] = [("Haar, ACC", |n, map| Ok(Nonzeros1d::new(n)?.count(map)))];

/// The counts of each basis.
pub struct Bases {
    rows: Vec<(&'static str, Vec<usize>)>,
}

/// Counts them all.
pub fn count() -> Result<Bases, Failure> {
    let map = AffineMap::new(MAP[0], MAP[1])?;
    let row = |(name, count): (&'static str, Count)| -> haarmonic::Result<_> {
        Ok((name, SIZES.into_iter().map(|n| count(n, map)).collect::<haarmonic::Result<Vec<_>>>()?))
    };
    Ok(Bases { rows: BASES.into_iter().map(row).collect::<haarmonic::Result<_>>()? })
}

impl Bases {
    pub fn table(&self) -> String {
        let mut header = vec!["basis".to_owned()];
        header.extend(SIZES.map(|n| format!("N = {n}")));
        let row = |(name, counts): &(&str, Vec<usize>)| {
            [vec![(*name).to_owned()], counts.iter().map(usize::to_string).collect()].concat()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(row).collect();
        table::format(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows)
    }

    pub fn report(&self) -> Value {
        let row = |(name, counts): &(&str, Vec<usize>)| json!({ "basis": name, "nonzeros": counts });
        json!({ "sizes": SIZES, "bases": self.rows.iter().map(row).collect::<Vec<_>>() })
    }
}
