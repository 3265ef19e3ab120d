//! Clustered components from their parts, and their file form.
//!
//! ```text
//! SIZE  bits of a number u8 (32, 64), rows u64, columns u64, clusters u64, components u64
//! BASE  for each cluster its mean and its components
//! ROWS  label of each row u32, weights
//! DIST  distortion: max f64, rms f64, relative f64
//! ```

use super::bases::Bases;
use super::coded::ClusteredPca;
use crate::compress::Distortion;
use crate::store::field::Field;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer, check_bits};
use crate::{Error, Real, Result};

impl<T: Real> ClusteredPca<T> {
    /// From a mean and `components` components for each cluster, one after the other, a label and weights for each row,
    /// and how far rows are from what is stored of them (the default, if that is not known): for those that were
    /// stored, or quantised.
    ///
    /// Shapes: bases `[(cluster·(components + 1) + j)·columns + c]`, j = 0 the mean; weights `[row·components + j]`.
    ///
    /// # Errors
    /// [`Error::Empty`] without rows or columns; [`Error::Length`] unless bases are whole and there are weights for
    /// each row; [`Error::Index`] for a label without a cluster; [`Error::NotFinite`]; [`Error::OutOfRange`] for a
    /// distortion that is NaN or below 0.
    pub fn from_parts(
        columns: usize,
        components: usize,
        bases: Vec<T>,
        labels: Vec<u32>,
        weights: Vec<T>,
        distortion: Distortion,
    ) -> Result<Self> {
        distortion.check()?;
        for (what, len) in [("columns", columns), ("labels", labels.len()), ("bases", bases.len())] {
            if len == 0 {
                return Err(Error::Empty { what });
            }
        }
        let basis = components.saturating_add(1).saturating_mul(columns);
        if bases.len() % basis != 0 {
            let expected = bases.len().div_ceil(basis).saturating_mul(basis);
            return Err(Error::Length { what: "bases", expected, got: bases.len() });
        }
        let expected = labels.len().saturating_mul(components);
        if weights.len() != expected {
            return Err(Error::Length { what: "weights", expected, got: weights.len() });
        }
        let mut sizes = vec![0; bases.len() / basis];
        for (at, &label) in labels.iter().enumerate() {
            let count = sizes.len();
            let wrong = Error::Index { what: "cluster of row", at, got: label as usize, count };
            *sizes.get_mut(label as usize).ok_or(wrong)? += 1;
        }
        for (what, numbers) in [("base", &bases), ("weight", &weights)] {
            if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
                return Err(Error::NotFinite { what, index });
            }
        }
        Ok(Self { bases: Bases { columns, components, data: bases, sizes }, labels, weights, distortion })
    }
}

impl<T: Real + Field> Parts for ClusteredPca<T> {
    const KIND: Kind = Kind::ClusteredPca;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"SIZE", |s| {
            s.field(8 * T::SIZE as u8);
            for size in [self.rows(), self.columns(), self.clusters(), self.components()] {
                s.field(size as u64);
            }
        })?;
        to.section(*b"BASE", |s| s.array(&self.bases.data))?;
        to.section(*b"ROWS", |s| {
            s.array(&self.labels);
            s.array(&self.weights);
        })?;
        self.distortion.write(to)
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        check_bits::<T>(&mut size)?;
        let (rows, columns) = (size.count("rows")?, size.count("columns")?);
        let (clusters, components) = (size.count("clusters")?, size.count("components")?);
        size.end()?;
        let mut section = from.section(*b"BASE")?;
        let basis = components.saturating_add(1).saturating_mul(columns);
        let bases = section.array("bases", clusters.saturating_mul(basis))?;
        section.end()?;
        let mut section = from.section(*b"ROWS")?;
        let labels = section.array("labels", rows)?;
        let weights = section.array("weights", rows.saturating_mul(components))?;
        section.end()?;
        let distortion = Distortion::read(from)?;
        Self::from_parts(columns, components, bases, labels, weights, distortion).map_err(|e| from.wrong(e.to_string()))
    }
}
