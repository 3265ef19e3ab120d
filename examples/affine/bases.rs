//! The complexities of several bases next to each other [Sun 2008, §4.4.3].

use haarmonic::affine::{AffineMap, Nonzeros1d, TripleNonzeros1d};
use haarmonic::reference::affine::fourier_basis::{fourier_coupling_nonzeros, fourier_tripling_count};
use haarmonic::reference::affine::pixel_basis::{pixel_coupling_nonzeros, pixel_tripling_nonzeros};
use serde_json::{Value, json};

use crate::support::Failure;
use crate::support::table;

/// s and o: anything, and an integer scale, for which alone the thesis' Fourier couplings hold.
const MAPS: [[f64; 2]; 2] = [[0.8437, 0.1013], [2.0, -0.5]];
const SIZES: [usize; 4] = [8, 16, 32, 64];

/// Counts the non-zero coefficients of a basis of N functions at a map.
type Count = fn(usize, AffineMap) -> haarmonic::Result<usize>;

/// What is counted: one line a basis and map; triplings in any order of the two targets. Fourier frequencies are
/// −N/2…N/2 − 1.
///
/// Pixels: Θ(N) both, a tripling only where both targets are one. Haar: Θ(N) couplings, Θ(N log N) triplings (thesis:
/// at most N log² N).
const BASES: [(&str, Count); 6] = [
    ("pixel, ACC", |n, map| Ok(pixel_coupling_nonzeros(n, map).count())),
    ("pixel, ATC", |n, map| Ok(pixel_tripling_nonzeros(n, map).count())),
    ("Fourier, ACC", |n, map| Ok(fourier_coupling_nonzeros(frequencies(n), map).count())),
    ("Fourier, ATC", |n, map| Ok(fourier_tripling_count(frequencies(n), map) as usize)),
    ("Haar, ACC", |n, map| Ok(Nonzeros1d::new(n)?.count(map))),
    ("Haar, ATC", |n, map| Ok(TripleNonzeros1d::new(n)?.ordered_count(map))),
];

fn frequencies(n: usize) -> std::ops::Range<i64> {
    let half = (n / 2) as i64;
    -half..half
}

/// The counts of each basis.
pub struct Bases {
    rows: Vec<Row>,
}

struct Row {
    basis: &'static str,
    map: [f64; 2],
    counts: Vec<usize>,
}

/// Counts them all.
pub fn count() -> Result<Bases, Failure> {
    let mut rows = Vec::new();
    for map in MAPS {
        for (basis, count) in BASES {
            let counts = SIZES.into_iter().map(|n| count(n, AffineMap::new(map[0], map[1])?));
            rows.push(Row { basis, map, counts: counts.collect::<haarmonic::Result<_>>()? });
        }
    }
    Ok(Bases { rows })
}

impl Bases {
    pub fn table(&self) -> String {
        let mut header = vec!["basis".to_owned(), "s, o".to_owned()];
        header.extend(SIZES.map(|n| format!("N = {n}")));
        let row = |r: &Row| {
            let name = vec![r.basis.to_owned(), format!("{}, {}", r.map[0], r.map[1])];
            [name, r.counts.iter().map(usize::to_string).collect()].concat()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(row).collect();
        table::format(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows)
    }

    pub fn report(&self) -> Value {
        let row = |r: &Row| json!({ "basis": r.basis, "s": r.map[0], "o": r.map[1], "nonzeros": r.counts });
        json!({ "sizes": SIZES, "bases": self.rows.iter().map(row).collect::<Vec<_>>() })
    }
}
