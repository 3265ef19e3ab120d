//! Values of a binary body, of either byte order.

use super::Body;
use super::header::{Element, Scalar};
use crate::io::report::excerpt;

pub(super) struct Binary<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
    pub(super) big: bool,
}

impl Binary<'_> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let chunk = self.bytes[self.at..].first_chunk::<N>().ok_or("the file ends here")?;
        self.at += N;
        let mut chunk = *chunk;
        if self.big {
            chunk.reverse();
        }
        Ok(chunk)
    }
}

impl Body for Binary<'_> {
    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn least(&self, element: &Element) -> usize {
        element.properties.iter().map(|p| p.count.unwrap_or(p.scalar).size()).sum()
    }

    fn start_row(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn end_row(&mut self) {}

    #[inline]
    fn value(&mut self, scalar: Scalar) -> Result<f64, String> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn skip(&mut self, scalar: Scalar, n: usize) -> Result<(), String> {
        let bytes = self.least_values(scalar, n);
        if bytes > self.left() {
            return Err("the file ends here".into());
        }
        self.at += bytes;
        Ok(())
    }

    fn least_values(&self, scalar: Scalar, n: usize) -> usize {
        n.saturating_mul(scalar.size())
    }

    fn place(&self, element: &Element, index: usize) -> String {
        format!("{} {index} (byte {})", excerpt(element.name.as_bytes()), self.at)
    }
}
