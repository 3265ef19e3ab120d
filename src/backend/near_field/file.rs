//! The file form of a transport.
//!
//! ```text
//! FACE  size f64, cells u64; tangent, bitangent and normal of the frame f32 each; view u8 (0 any, 1 from an eye point,
//!       2 from a direction), x, y, z f64 of that; u8 1 if the view is free
//! POSN  x, y, z f32 of each vertex
//! FREE  if it is: list of parts u64 (cells, products; 0, 0 for none); lists of numbers f64 for each that has some;
//!       part u32 of each vertex; normal and tangent f32 of each
//! ROWS  lists of ends of vertices u32, of weights f32 (three a row), of products u16, of ends of rows u64, of wavelets
//!       u16; bits of a value u8 (32, 16); values
//! ```

use nalgebra::Vector3;

use super::rows::{Rows, Values};
use super::transport::{FreeView, Transport};
use crate::Result;
use crate::scene::{FactoredBrdf, LocalFrame, View};
use crate::sphere::TopFace;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, SectionReader, Writer};

fn flat(vectors: &[Vector3<f32>]) -> Vec<f32> {
    vectors.iter().flat_map(|v| <[f32; 3]>::from(*v)).collect()
}

fn vectors(section: &SectionReader, numbers: &[f32]) -> Result<Vec<Vector3<f32>>> {
    let (vectors, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() || !numbers.iter().all(|x| x.is_finite()) {
        return Err(section.wrong("vectors are cut, or NaN or infinite"));
    }
    Ok(vectors.iter().map(|&v| v.into()).collect())
}

impl Parts for Transport {
    const KIND: Kind = Kind::NearField;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"FACE", |s| {
            s.field(self.face.size());
            s.field(self.face.cells() as u64);
            s.array(&flat(&[self.frame.tangent, self.frame.bitangent, self.frame.normal]));
            View::write(self.view, s);
            s.field(u8::from(self.free.is_some()));
        })?;
        to.section(*b"POSN", |s| s.list(&flat(&self.positions)))?;
        if let Some(free) = &self.free {
            to.section(*b"FREE", |s| {
                let numbers = free.factors.iter().map(|f| f.as_ref().map(FactoredBrdf::to_numbers)).collect::<Vec<_>>();
                let sizes = numbers.iter().map(|n| n.as_ref().map_or([0, 0], |(cells, terms, _)| [*cells, *terms]));
                s.list(&sizes.flatten().map(|x| x as u64).collect::<Vec<_>>());
                numbers.iter().flatten().for_each(|(_, _, numbers)| s.array(numbers));
                s.list(&free.parts);
                s.list(&flat(free.frames.as_flattened()));
            })?;
        }
        to.section(*b"ROWS", |s| {
            s.list(&self.rows.vertex_end);
            s.list(self.rows.weight.as_flattened());
            s.list(&self.rows.term);
            s.list(&self.rows.row_end);
            s.list(&self.rows.index);
            match &self.rows.values {
                Values::Full(values) => {
                    s.field(32u8);
                    s.array(values);
                }
                Values::Bits16(values) => {
                    s.field(16u8);
                    s.array(values);
                }
            }
        })
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut s = from.section(*b"FACE")?;
        let (size, cells) = (s.field("the size of a face")?, s.count("cells of a face")?);
        let face = TopFace::new(size, cells).map_err(|e| s.wrong(e.to_string()))?;
        if !cells.is_power_of_two() || cells > 256 {
            return Err(s.wrong(format!("{cells} is not a number of cells of a face")));
        }
        let axes = s.array("the axes of a face", 9)?;
        let axes = vectors(&s, &axes)?;
        let frame = LocalFrame { tangent: axes[0], bitangent: axes[1], normal: axes[2] };
        let view = View::read(&mut s)?;
        let is_free = match s.field::<u8>("whether the view is free")? {
            0 => false,
            1 if view.is_none() => true,
            _ => return Err(s.wrong("does not say whether the view is free")),
        };
        s.end()?;
        let mut s = from.section(*b"POSN")?;
        let numbers: Vec<f32> = s.list("positions")?;
        let positions = vectors(&s, &numbers)?;
        s.end()?;
        let free = if is_free { Some(read_free(from, positions.len())?) } else { None };
        let mut s = from.section(*b"ROWS")?;
        let vertex_end = s.list("ends of vertices")?;
        let weights: Vec<f32> = s.list("weights")?;
        let (weight, rest) = weights.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(s.wrong("weights are cut"));
        }
        let (weight, term) = (weight.to_vec(), s.list("products of rows")?);
        let (row_end, index): (_, Vec<u16>) = (s.list("ends of rows")?, s.list("wavelets")?);
        let values = match s.field::<u8>("bits of a value")? {
            32 => Values::Full(s.array("values", index.len())?),
            16 => Values::Bits16(s.array("values", index.len())?),
            bits => return Err(s.wrong(format!("{bits} is not a number of bits of a value"))),
        };
        let rows = Rows { vertex_end, weight, term, row_end, index, values };
        let terms = free.as_ref().map_or(1, FreeView::terms);
        let fault = match rows.vertices() == positions.len() {
            true => rows.fault(face.len(), terms),
            false => Some("there are not as many vertices as positions"),
        };
        if let Some(fault) = fault {
            return Err(s.wrong(format!("the rows contradict themselves: {fault}; bake the transport again")));
        }
        s.end()?;
        let transport = Self { face, frame, positions, view, free, rows };
        match transport.term_fault() {
            true => Err(from.wrong("a row is of a product that its BRDF has not; bake the transport again")),
            false => Ok(transport),
        }
    }
}

impl Transport {
    /// Whether a row is of a product that the BRDF of its vertex has not.
    fn term_fault(&self) -> bool {
        let Some(free) = &self.free else { return false };
        (0..self.vertices()).any(|vertex| {
            let terms = free.factors[free.parts[vertex] as usize].as_ref().map_or(1, FactoredBrdf::terms);
            self.rows.of(vertex).any(|row| usize::from(self.rows.term[row]) >= terms)
        })
    }
}

fn read_free(from: &mut Reader, vertices: usize) -> Result<FreeView> {
    let mut s = from.section(*b"FREE")?;
    let sizes: Vec<u64> = s.list("sizes of parts")?;
    let (sizes, rest) = sizes.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(s.wrong("sizes of parts are cut"));
    }
    let mut factors = Vec::new();
    for &size in sizes {
        let [cells, terms] = size.map(|x| usize::try_from(x).unwrap_or(usize::MAX));
        factors.push(match [cells, terms] {
            [0, 0] => None,
            _ => {
                let len = FactoredBrdf::numbers(cells, terms).ok_or_else(|| s.wrong("is no size of factors"))?;
                let numbers = s.array("factors", len)?;
                Some(FactoredBrdf::from_numbers(cells, terms, &numbers).ok_or_else(|| s.wrong("is no factor"))?)
            }
        });
    }
    let parts: Vec<u32> = s.list("parts of vertices")?;
    let numbers: Vec<f32> = s.list("frames of vertices")?;
    let (frames, rest) = (vectors(&s, &numbers)?, numbers.len() % 6);
    if parts.len() != vertices || frames.len() != 2 * vertices || rest != 0 {
        return Err(s.wrong("there is not one part and one frame a vertex"));
    }
    if !parts.iter().all(|&part| (part as usize) < factors.len()) {
        return Err(s.wrong("a part is not there"));
    }
    s.end()?;
    let frames = frames.as_chunks::<2>().0.to_vec();
    Ok(FreeView { factors, parts, frames })
}
