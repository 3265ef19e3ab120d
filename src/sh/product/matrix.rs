//! The matrix of the product with one factor.

use crate::Real;
use crate::sh::gamma::{check_degrees, partners};

/// Entries of one element of the matrix and its mirror image: M_kj = Σ a_i Γ_ijk.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Element {
    /// k · columns + j and its mirror image j · columns + k, the same if there is none.
    places: [u32; 2],
    end: u32,
}

/// The non-zero elements, and of each its entries.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MatrixTable<T> {
    elements: Vec<Element>,
    entries: Vec<(u32, T)>,
}

impl<T: Real> MatrixTable<T> {
    pub fn new(bands: [usize; 3]) -> Self {
        let [_, columns, _] = bands.map(|n| n * n);
        let [bands_a, bands_b, bands_out] = check_degrees(bands).expect("checked by the plan");
        let symmetric = bands[1] == bands[2];
        let mut table = Self { elements: Vec::new(), entries: Vec::new() };
        for k in 0..bands_out * bands_out {
            for j in 0..if symmetric { k + 1 } else { bands_b * bands_b } {
                let before = table.entries.len();
                partners(j, k, bands_a, |i, gamma| {
                    if gamma != 0.0 {
                        table.entries.push((i as u32, T::of(gamma)));
                    }
                });
                if table.entries.len() > before {
                    let place = k * columns + j;
                    let mirror = if symmetric { j * columns + k } else { place };
                    let places = [place, mirror].map(|place| place as u32);
                    table.elements.push(Element { places, end: table.entries.len() as u32 });
                }
            }
        }
        table
    }

    pub fn fill(&self, a: &[T], matrix: &mut [T]) {
        matrix.fill(T::zero());
        let mut entry = 0;
        for element in &self.elements {
            let mut sum = T::zero();
            for &(i, gamma) in &self.entries[entry..element.end as usize] {
                sum += a[i as usize] * gamma;
            }
            entry = element.end as usize;
            element.places.into_iter().for_each(|place| matrix[place as usize] = sum);
        }
    }
}
