//! The file form of principal components.
//!
//! ```text
//! SIZE  bits of a number u8 (32, 64), columns u64, components u64
//! DATA  mean, components, variances f64, total variance f64
//! ```

use super::components::Pca;
use crate::store::field::Field;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer, check_bits};
use crate::{Real, Result};

impl<T: Real + Field> Parts for Pca<T> {
    const KIND: Kind = Kind::Pca;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"SIZE", |s| {
            s.field(8 * T::SIZE as u8);
            s.field(self.columns() as u64);
            s.field(self.len() as u64);
        })?;
        to.section(*b"DATA", |s| {
            s.array(self.mean());
            s.array(self.components());
            s.array(self.variances());
            s.field(self.total_variance());
        })
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        check_bits::<T>(&mut size)?;
        let (columns, components) = (size.count("columns")?, size.count("components")?);
        size.end()?;
        let mut data = from.section(*b"DATA")?;
        let mean = data.array("a mean", columns)?;
        // More than the section holds, if the product is.
        let elements = data.array("components", columns.saturating_mul(components))?;
        let variances = data.array("variances", components)?;
        let total = data.field("a variance")?;
        data.end()?;
        Self::from_parts(mean, elements, variances, total).map_err(|e| from.wrong(e.to_string()))
    }
}
