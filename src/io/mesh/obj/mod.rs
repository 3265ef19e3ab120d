//! Wavefront OBJ.
//!
//! A reader of our own: the crates for OBJ give no line number with an error and leave open what a face that names a
//! later vertex means. What a mesh needs of the format is four statements.

mod corners;

use nalgebra::{Vector2, Vector3};

use self::corners::{NONE, Named};

use super::assemble::Soup;
use super::split::{Smoothing, Splitter};
use super::{MeshOptions, number};
use crate::io::count::{Count, plural};
use crate::io::report::{Loaded, Report, excerpt};
use crate::scene::Mesh;
use crate::{Error, Result};

/// Reads a Wavefront OBJ file from its bytes; `name` is what messages call it.
///
/// Read are `v` (the first three numbers; a weight or a colour after them is skipped), `vn`, `vt` (the first two
/// numbers; a lone one is u, and v is 0) and `f` (`v`, `v/t`, `v//n`, `v/t/n`; negative indices count back from the
/// line; a face may name vertices of later lines). Everything else is skipped: groups, materials, lines, points,
/// curves. Lines may end in LF, CRLF or CR, be continued with a backslash and be of any length.
///
/// Coordinates are read in `f64`. Where rounding them to `f32` would cost shape, as far from zero, an origin is taken
/// off first, with a warning: [`Mesh::origin`].
///
/// A position keeps its place in the vertex list. Where faces give it several different normals, further vertices are
/// appended for them (equal normals under different indices do not split). Corners without a normal get the
/// angle-weighted one of the faces around them: of all faces in a file that never says `s`; of those of the same
/// smoothing group in one that does. `s off` and `s 0` make faces flat, each with its own normal.
///
/// Texture coordinates are those of the corners: [`Mesh::uv`], with v upwards. Where faces give a vertex several
/// different ones, further vertices are appended for them, as [`Mesh::with_corner_uv`] does, with the same normal: a
/// seam of the texture is no edge of the surface. A file whose faces name none has no [`Mesh::uv`].
///
/// A backslash at the end of a line, blanks behind it or not, joins the next one, unless the next one is a statement:
/// the backslash was the last character of a name then. In a comment it means nothing.
///
/// Repaired with a warning: faces with fewer than three corners, normals and texture coordinates that a face names and
/// the file does not have, texture coordinates that are no numbers or that some corners lack, unknown statements, and
/// what is repaired in [every format](crate::io#meshes). NaN and infinity are understood as other programs spell them
/// (`-nan(ind)`, `1.#QNAN`, …).
///
/// # Errors
/// [`Error::File`] with the line for everything else that cannot be read: a missing or malformed number, a coordinate
/// of a face that is NaN or infinite, a vertex index that is zero or out of range.
pub fn read_obj(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Mesh>> {
    read_obj_with(bytes, name, &MeshOptions::default())
}

/// [`read_obj`] as the options say.
///
/// # Errors
/// Those of [`read_obj`].
pub fn read_obj_with(bytes: &[u8], name: impl AsRef<std::path::Path>, options: &MeshOptions) -> Result<Loaded<Mesh>> {
    let mut reader = Reader::new(Report::new(name), options);
    if bytes.is_empty() {
        return Err(reader.report.error("", "the file is empty"));
    }
    let mut lines = Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), next: 1 };
    let mut joined = Vec::new();
    while let Some((number, line)) = lines.next() {
        reader.line = number;
        let statement = statement_of(line);
        let Some(start) = statement.strip_suffix(b"\\") else {
            reader.statement(statement)?;
            continue;
        };
        joined.clear();
        joined.extend_from_slice(start);
        // Blank lines and comments do not end the statement, another statement does.
        loop {
            let before = lines.clone();
            let Some((_, line)) = lines.next() else { break };
            let statement = statement_of(line);
            if begins_statement(statement) {
                lines = before;
                reader.unjoined(start);
                break;
            }
            joined.push(b' ');
            let goes_on = statement.strip_suffix(b"\\");
            joined.extend_from_slice(goes_on.unwrap_or(statement));
            if goes_on.is_none() && !statement.is_empty() {
                break;
            }
        }
        reader.statement(&joined)?;
    }
    reader.finish()
}

/// A line without its comment and the blanks around it.
fn statement_of(line: &[u8]) -> &[u8] {
    // In a word such as 1.#QNAN no comment begins.
    let is_number = |at: usize| {
        let start = line[..at].iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
        let end = line[at..].iter().position(u8::is_ascii_whitespace).map_or(line.len(), |i| at + i);
        number::parse(&line[start..end]).is_some()
    };
    let mut end = line.iter().position(|&b| b == b'#');
    while let Some(at) = end.filter(|&at| is_number(at)) {
        end = line[at + 1..].iter().position(|&b| b == b'#').map(|i| at + 1 + i);
    }
    line[..end.unwrap_or(line.len())].trim_ascii()
}

/// Whether a line begins with a keyword, and so does not go on with the statement of the line before.
fn begins_statement(line: &[u8]) -> bool {
    let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    [&b"v"[..], b"vn", b"vt", b"f", b"fo"].contains(&word) || KNOWN.contains(&word)
}

/// The physical lines with their numbers, without their ends.
#[derive(Clone)]
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

struct Reader {
    report: Report,
    line: usize,
    soup: Soup,
    normals: Vec<Vector3<f32>>,
    corner_normals: Named,
    uv: Vec<Vector2<f32>>,
    corner_uv: Named,
    /// The highest position that a face names, and its line: faces may come before their vertices.
    highest: (u32, usize),
    bad_normals: Count,
    unknown: Count,
    unjoined: Count,
    polygon: Vec<u32>,
}

impl Reader {
    fn new(report: Report, options: &MeshOptions) -> Self {
        Self {
            report,
            line: 0,
            soup: Soup::new(options),
            normals: Vec::new(),
            corner_normals: Named::default(),
            uv: Vec::new(),
            corner_uv: Named::default(),
            highest: (0, 0),
            bad_normals: Count::default(),
            unknown: Count::default(),
            unjoined: Count::default(),
            polygon: Vec::new(),
        }
    }

    fn error(&self, reason: impl Into<String>) -> Error {
        self.report.error(format!("line {}", self.line), reason)
    }

    /// A backslash stood before another statement. At the end of a name it belongs there; elsewhere it was meant to
    /// continue the line.
    fn unjoined(&mut self, start: &[u8]) {
        if [&b"v"[..], b"vn", b"vt", b"f", b"fo"].iter().any(|k| start.split(u8::is_ascii_whitespace).next() == Some(k))
        {
            let line = self.line;
            self.unjoined.add(|| format!("line {line}"));
        }
    }

    /// Reads a statement without its comment.
    fn statement(&mut self, line: &[u8]) -> Result<()> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        // A backslash within a line of numbers is one that an editor has joined.
        let numbers = line.split(|b| b.is_ascii_whitespace() || *b == b'\\').filter(|w| !w.is_empty()).skip(1);
        match words.next() {
            None => {}
            Some(b"v") => {
                let position = self.vector(numbers, "a vertex")?;
                let line = self.line;
                self.soup.push_position(position, || format!("line {line}"));
            }
            Some(b"vn") => {
                let normal = self.vector(numbers, "a normal")?;
                let normal = self.finite_normal(&normal);
                self.normals.push(normal);
            }
            Some(b"vt") => {
                let pair = texture_coordinates(numbers);
                let line = self.line;
                let pair = self.soup.finite_uv(pair, || format!("line {line}"));
                self.uv.push(pair);
            }
            // `fo` is the old spelling of `f`.
            Some(b"f" | b"fo") => self.face(numbers)?,
            Some(b"s") => self.smoothing(words.next()),
            Some(word) if KNOWN.contains(&word) => {}
            Some(word) => self.unknown(word),
        }
        Ok(())
    }

    fn unknown(&mut self, word: &[u8]) {
        let line = self.line;
        self.unknown.add(|| format!("line {line}: \"{}\"", excerpt(word)));
    }

    fn smoothing(&mut self, group: Option<&[u8]>) {
        let number = |word: &[u8]| std::str::from_utf8(word).ok()?.parse::<i64>().ok();
        match group.map(|word| (word, number(word))) {
            Some((b"off" | b"OFF" | b"Off", _) | (_, Some(0))) => self.soup.set_smoothing(Smoothing::Flat),
            Some((b"on" | b"ON" | b"On", _)) => self.soup.set_smoothing(Smoothing::Group(1)),
            Some((_, Some(n))) => self.soup.set_smoothing(Smoothing::Group(n)),
            Some((word, None)) => self.unknown(&[b"s ", word].concat()),
            None => self.unknown(b"s"),
        }
    }

    /// The normal in `f32`; zero, which is none, if it is not finite.
    fn finite_normal(&mut self, normal: &Vector3<f64>) -> Vector3<f32> {
        let rounded = normal.cast::<f32>();
        if rounded.iter().all(|c| c.is_finite()) {
            return rounded;
        }
        if normal.iter().all(|c| c.is_finite()) {
            return (normal / normal.amax()).cast();
        }
        let line = self.line;
        self.bad_normals.add(|| format!("line {line}"));
        Vector3::zeros()
    }

    fn vector<'a>(&self, mut words: impl Iterator<Item = &'a [u8]>, what: &str) -> Result<Vector3<f64>> {
        let mut out = Vector3::zeros();
        for i in 0..3 {
            let word = words.next().ok_or_else(|| self.error(format!("{what} has {i} of 3 numbers")))?;
            out[i] = number::parse(word).ok_or_else(|| self.error(format!("\"{}\" is not a number", excerpt(word))))?;
        }
        Ok(out)
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<()> {
        self.polygon.clear();
        self.corner_normals.begin_polygon();
        self.corner_uv.begin_polygon();
        let line = self.line;
        for word in words {
            let mut parts = word.splitn(3, |&b| b == b'/');
            let position = self.vertex_index(parts.next().unwrap_or_default())?;
            self.polygon.push(position);
            match parts.next().filter(|t| !t.is_empty()) {
                None => self.corner_uv.push_none(),
                Some(word) => {
                    // A word that is no number names nothing that is there.
                    let so_far = self.uv.len();
                    let index = self.index(word, "texture", so_far).map_or(None, |(_, index)| index);
                    self.corner_uv.push(index, so_far, line, || format!("texture index {}", excerpt(word)));
                }
            }
            match parts.next().filter(|n| !n.is_empty()) {
                None => self.corner_normals.push_none(),
                Some(word) => {
                    let so_far = self.normals.len();
                    let (number, index) = self.index(word, "normal", so_far)?;
                    self.corner_normals.push(index, so_far, line, || format!("normal index {number}"));
                }
            }
        }
        let before = self.soup.faces.len();
        self.soup.push_polygon(&self.polygon, || format!("line {line}"));
        let triangles = before..self.soup.faces.len();
        self.corner_normals.end_polygon(triangles.clone());
        self.corner_uv.end_polygon(triangles);
        Ok(())
    }

    /// The number of an index, and the zero-based one that it means: one below zero counts back from here. None for
    /// zero and what is out of range whatever follows.
    fn index(&self, word: &[u8], what: &str, so_far: usize) -> Result<(i64, Option<u32>)> {
        let number: i64 = (std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()))
            .ok_or_else(|| self.error(format!("\"{}\" is not a {what} index", excerpt(word))))?;
        let index = match number {
            0 => None,
            1.. => Some(number - 1),
            _ => (so_far as i64).checked_add(number),
        };
        // The last one stands for what a corner does not name.
        Ok((number, index.and_then(|i| u32::try_from(i).ok()).filter(|&i| i != NONE)))
    }

    fn vertex_index(&mut self, word: &[u8]) -> Result<u32> {
        let so_far = self.soup.positions.len();
        let index = match self.index(word, "vertex", so_far)? {
            (_, Some(index)) => index,
            (0, None) => return Err(self.error("vertex index 0; indices start at 1")),
            (number, None) => {
                return Err(self.error(format!("vertex index {number} is out of range; there are {so_far} so far")));
            }
        };
        if index >= self.highest.0 {
            self.highest = (index, self.line);
        }
        Ok(index)
    }

    fn finish(mut self) -> Result<Loaded<Mesh>> {
        let count = self.soup.positions.len();
        let (index, line) = self.highest;
        if line > 0 && index as usize >= count {
            self.line = line;
            let number = u64::from(index) + 1;
            return Err(self.error(format!("vertex index {number} is out of range; the file has {count}")));
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
        std::mem::take(&mut self.unjoined).warn(&mut self.report, |n| {
            format!(
                "{} in a backslash and before another statement; not joined with it",
                plural(n, "line ends", "lines end")
            )
        });
        std::mem::take(&mut self.bad_normals).warn(&mut self.report, |n| {
            format!("{} NaN or infinite; computed from the faces", plural(n, "normal is", "normals are"))
        });
        self.split_by_normal();
        self.set_corner_uv();
        self.soup.into_mesh(self.report)
    }

    /// One vertex for each pair of position and normal that the faces use.
    fn split_by_normal(&mut self) {
        let count = self.normals.len();
        self.corner_normals.take_absent(count, "normal").warn(&mut self.report, |n| {
            let corners = plural(n, "corner names a normal", "corners name normals");
            format!("{corners} that the file does not have (it has {count}); computed from the faces")
        });
        if !self.corner_normals.names_any(count) {
            return;
        }
        let corner_normals = std::mem::take(&mut self.corner_normals).into_triangles(self.soup.faces.len());
        let mut splitter = Splitter::new(self.soup.positions.len());
        let mut normals = vec![Vector3::zeros(); self.soup.positions.len()];
        for (face, corner_normals) in self.soup.faces.iter_mut().zip(&corner_normals) {
            for (corner, &n) in face.iter_mut().zip(corner_normals) {
                let normal = self.normals.get(n as usize).copied().unwrap_or_default();
                // Equal bits, but +0 and −0 are one.
                *corner = splitter.vertex(*corner, [0, 1, 2].map(|i| (normal[i] + 0.0).to_bits()));
                if *corner as usize == normals.len() {
                    normals.push(normal);
                } else {
                    normals[*corner as usize] = normal;
                }
            }
        }
        self.soup.push_copies(&splitter);
        self.soup.normals = Some(normals);
    }

    /// The texture coordinates of the corners, if any names one that is there.
    fn set_corner_uv(&mut self) {
        let count = self.uv.len();
        let any = self.corner_uv.names_any(count);
        self.corner_uv.take_absent(count, "texture").warn(&mut self.report, |n| {
            let corners = plural(n, "corner names texture coordinates", "corners name texture coordinates");
            let done = if any { "set to (0, 0)" } else { "left out" };
            format!("{corners} that the file does not have (it has {count}); {done}")
        });
        if any {
            let corners = std::mem::take(&mut self.corner_uv).into_triangles(self.soup.faces.len());
            let pair = |i: u32| match i {
                NONE => Soup::NO_UV,
                i => self.uv.get(i as usize).copied().unwrap_or_default(),
            };
            self.soup.corner_uv = corners.into_iter().map(|c| c.map(pair)).collect();
        }
    }
}

/// The numbers of a `vt`; NaN where they cannot be read.
fn texture_coordinates<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> [f64; 2] {
    let read = |word: &[u8]| number::parse(word).unwrap_or(f64::NAN);
    [words.next().map_or(f64::NAN, read), words.next().map_or(0.0, read)]
}

/// Statements that exist and are of no use to a mesh.
const KNOWN: &[&[u8]] = &[
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
