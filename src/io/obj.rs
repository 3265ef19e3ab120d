//! Wavefront OBJ.
//!
//! A reader of our own: the crates for OBJ give no line number with an error and leave open what a face that names a
//! later vertex means. What a mesh needs of the format is three statements.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::assemble::{Count, Soup};
use super::{Loaded, Report, excerpt};
use crate::scene::Mesh;
use crate::{Error, Result};

/// Reads a Wavefront OBJ file from its bytes; `name` is what messages call it.
///
/// Read are `v` (the first three numbers; a weight or a colour after them is skipped), `vn` and `f` (`v`, `v/t`,
/// `v//n`, `v/t/n`; negative indices count back from the line; a face may name vertices of later lines). Everything
/// else is skipped: texture coordinates, groups, materials, lines, points, curves. Lines may end in LF, CRLF or CR,
/// be continued with a backslash and be of any length.
///
/// Coordinates are read in `f64`. Where rounding them to `f32` would cost shape, as far from zero, an origin is taken off
/// first, with a warning: [`Mesh::origin`].
///
/// Polygons are cut as fans around their first corner; a concave one gives overlapping triangles and a warning.
/// A position keeps its place in the vertex list. Where faces give it several different normals, further vertices are
/// appended for them (equal normals under different indices do not split). Corners without a normal get the
/// angle-weighted one.
///
/// Repaired with a warning: faces with fewer than three corners or no area, vertices without a face, normals that are
/// zero or not finite, unknown statements.
///
/// # Errors
/// [`Error::File`] with the line for everything else that cannot be read: a missing or malformed number, a coordinate
/// that is NaN or infinite (in `f32`), an index that is zero or out of range.
pub fn read_obj(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Mesh>> {
    let mut reader = Reader::new(Report::new(name));
    if bytes.is_empty() {
        return Err(reader.report.error("", "the file is empty"));
    }
    let mut lines = Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), next: 1 };
    let mut joined = Vec::new();
    while let Some((number, line)) = lines.next() {
        reader.line = number;
        if line.last() != Some(&b'\\') || line.first() == Some(&b'#') {
            reader.statement(line)?;
            continue;
        }
        joined.clear();
        joined.extend_from_slice(&line[..line.len() - 1]);
        for (_, more) in lines.by_ref() {
            joined.push(b' ');
            joined.extend_from_slice(more.strip_suffix(b"\\").unwrap_or(more));
            if more.last() != Some(&b'\\') {
                break;
            }
        }
        reader.statement(&joined)?;
    }
    reader.finish()
}

/// The physical lines with their numbers, without their ends.
struct Lines<'a> {
    rest: &'a [u8],
    next: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, after) = self.rest.split_at(end);
        self.rest = after.strip_prefix(b"\r\n").unwrap_or(after.get(1..).unwrap_or_default());
        self.next += 1;
        Some((self.next - 1, line))
    }
}

/// Index of a normal that a corner does not have.
const NONE: u32 = u32::MAX;

struct Reader {
    report: Report,
    line: usize,
    soup: Soup,
    normals: Vec<Vector3<f32>>,
    /// Per triangle corner, the index of its normal; empty until a face names one.
    corner_normals: Vec<[u32; 3]>,
    /// The highest position and normal that a face names, and its line: faces may come before their vertices.
    highest: [(u32, usize); 2],
    unknown: Count,
    polygon: Vec<u32>,
    polygon_normals: Vec<u32>,
}

impl Reader {
    fn new(report: Report) -> Self {
        Self {
            report,
            line: 0,
            soup: Soup::default(),
            normals: Vec::new(),
            corner_normals: Vec::new(),
            highest: [(0, 0); 2],
            unknown: Count::default(),
            polygon: Vec::new(),
            polygon_normals: Vec::new(),
        }
    }

    fn error(&self, reason: impl Into<String>) -> Error {
        self.report.error(format!("line {}", self.line), reason)
    }

    fn statement(&mut self, line: &[u8]) -> Result<()> {
        let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        let mut words = line[..end].split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            None => {}
            Some(b"v") => {
                let position = self.vector(words, "a vertex")?;
                let line = self.line;
                self.soup.push_position(position, || format!("line {line}"));
            }
            Some(b"vn") => {
                let normal = self.vector(words, "a normal")?;
                self.normals.push(normal.cast());
            }
            // `fo` is the old spelling of `f`.
            Some(b"f" | b"fo") => self.face(words)?,
            Some(word) if KNOWN.contains(&word) => {}
            Some(word) => {
                let line = self.line;
                self.unknown.add(|| format!("line {line}: \"{}\"", excerpt(word)));
            }
        }
        Ok(())
    }

    fn vector<'a>(&self, mut words: impl Iterator<Item = &'a [u8]>, what: &str) -> Result<Vector3<f64>> {
        let mut out = Vector3::zeros();
        for i in 0..3 {
            let word = words.next().ok_or_else(|| self.error(format!("{what} has {i} of 3 numbers")))?;
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            out[i] = number.ok_or_else(|| self.error(format!("\"{}\" is not a number", excerpt(word))))?;
        }
        Ok(out)
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<()> {
        self.polygon.clear();
        self.polygon_normals.clear();
        for word in words {
            let mut parts = word.splitn(3, |&b| b == b'/');
            let position = parts.next().unwrap_or_default();
            let normal = parts.nth(1).filter(|n| !n.is_empty());
            let position = self.index(position, 0)?;
            let normal = normal.map_or(Ok(NONE), |n| self.index(n, 1))?;
            self.polygon.push(position);
            self.polygon_normals.push(normal);
        }
        let line = self.line;
        let before = self.soup.faces.len();
        self.soup.push_polygon(&self.polygon, || format!("line {line}"));
        let has_normal = self.polygon_normals.iter().any(|&n| n != NONE);
        if !self.corner_normals.is_empty() || has_normal {
            self.corner_normals.resize(before, [NONE; 3]);
            let n = &self.polygon_normals;
            self.corner_normals
                .extend((before..self.soup.faces.len()).map(|f| [n[0], n[f - before + 1], n[f - before + 2]]));
        }
        Ok(())
    }

    /// A zero-based index into the positions (`list` 0) or the normals (1).
    fn index(&mut self, word: &[u8], list: usize) -> Result<u32> {
        let what = ["vertex", "normal"][list];
        let so_far = [self.soup.positions.len(), self.normals.len()][list];
        let number: i64 = (std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()))
            .ok_or_else(|| self.error(format!("\"{}\" is not a {what} index", excerpt(word))))?;
        let index = match number {
            0 => return Err(self.error(format!("{what} index 0; indices start at 1"))),
            1.. => number - 1,
            _ => so_far as i64 + number,
        };
        // The last one stands for a normal that is not there.
        let index = u32::try_from(index)
            .ok()
            .filter(|&i| i != NONE)
            .ok_or_else(|| self.error(format!("{what} index {number} is out of range; there are {so_far} so far")))?;
        if index >= self.highest[list].0 {
            self.highest[list] = (index, self.line);
        }
        Ok(index)
    }

    fn finish(mut self) -> Result<Loaded<Mesh>> {
        for (list, count) in [self.soup.positions.len(), self.normals.len()].into_iter().enumerate() {
            let (index, line) = self.highest[list];
            if line > 0 && index as usize >= count {
                let what = ["vertex", "normal"][list];
                self.line = line;
                return Err(
                    self.error(format!("{what} index {} is out of range; the file has {count}", u64::from(index) + 1))
                );
            }
        }
        let nothing = self.soup.positions.is_empty() && self.soup.faces.is_empty();
        if nothing && self.unknown.n > 0 {
            return Err(self
                .report
                .error(self.unknown.first, "not a statement of an OBJ file, and no vertices anywhere"));
        }
        std::mem::take(&mut self.unknown).warn(&mut self.report, |n| match n {
            1 => "unknown statement skipped".into(),
            _ => format!("{n} unknown statements skipped"),
        });
        if !self.corner_normals.is_empty() {
            self.split_by_normal();
        }
        self.soup.into_mesh(self.report)
    }

    /// One vertex for each pair of position and normal that the faces use.
    fn split_by_normal(&mut self) {
        self.corner_normals.resize(self.soup.faces.len(), [NONE; 3]);
        let mut first: Vec<Option<[u32; 3]>> = vec![None; self.soup.positions.len()];
        let mut further: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        let mut normals = vec![Vector3::zeros(); self.soup.positions.len()];
        for (face, corner_normals) in self.soup.faces.iter_mut().zip(&self.corner_normals) {
            for (corner, &n) in face.iter_mut().zip(corner_normals) {
                let normal = if n == NONE { Vector3::zeros() } else { self.normals[n as usize] };
                // Equal bits, but +0 and −0 are one.
                let bits = [0, 1, 2].map(|i| (normal[i] + 0.0).to_bits());
                match first[*corner as usize] {
                    None => {
                        first[*corner as usize] = Some(bits);
                        normals[*corner as usize] = normal;
                    }
                    Some(b) if b == bits => {}
                    Some(_) => {
                        *corner = *further.entry((*corner, bits)).or_insert_with(|| {
                            self.soup.positions.push(self.soup.positions[*corner as usize]);
                            normals.push(normal);
                            (normals.len() - 1) as u32
                        });
                    }
                }
            }
        }
        self.soup.normals = Some(normals);
    }
}

/// Statements that exist and are of no use to a mesh.
const KNOWN: &[&[u8]] = &[
    b"vt",
    b"vp",
    b"g",
    b"o",
    b"s",
    b"mg",
    b"usemtl",
    b"mtllib",
    b"l",
    b"p",
    b"maplib",
    b"usemap",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"call",
    b"csh",
];
