//! Stanford PLY.
//!
//! A reader of our own: the crate for PLY is unmaintained, believes the counts of the header when it takes memory and
//! says neither line nor offset when something is wrong. What a mesh needs of the format is small.

use nalgebra::Vector3;

use super::assemble::Soup;
use super::{Loaded, MeshOptions, Report, excerpt};
use crate::Result;
use crate::scene::Mesh;

/// Reads a PLY file from its bytes; `name` is what messages call it.
///
/// ASCII and binary of both byte orders. Read are `x y z` and, if all three are there, `nx ny nz` of the element
/// `vertex`, the lists `vertex_indices` or `vertex_index` of the element `face`, and those of `tristrips` (−1
/// separates strips). Properties may have any of the format's types and any order; other properties and elements are
/// skipped. In ASCII an element is a line, blank lines are skipped, and the header's lines may end in LF, CRLF or CR.
///
/// Repaired with a warning: faces with fewer than three corners, bytes after the end, and what is repaired in
/// [every format](super#meshes).
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the line, or the element and byte offset, for everything else that cannot be read: counts beyond
/// the bytes that are there, a coordinate that is NaN or infinite (in `f32`), an index out of range, a file cut short.
pub fn read_ply(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Mesh>> {
    read_ply_with(bytes, name, &MeshOptions::default())
}

/// [`read_ply`] as the options say.
///
/// # Errors
/// Those of [`read_ply`].
pub fn read_ply_with(bytes: &[u8], name: impl AsRef<std::path::Path>, options: &MeshOptions) -> Result<Loaded<Mesh>> {
    let mut report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    let header = Header::read(bytes, &report)?;
    let mut soup = Soup::new(options);
    let rest = match header.format {
        Format::Ascii => {
            let mut body = Ascii { rest: &bytes[header.end..], line: header.lines, row: &[] };
            read_elements(&header, &mut body, &mut soup, &report)?;
            body.rest.trim_ascii_start().len()
        }
        Format::Little | Format::Big => {
            let mut body = Binary { bytes, at: header.end, big: header.format == Format::Big };
            read_elements(&header, &mut body, &mut soup, &report)?;
            bytes.len() - body.at
        }
    };
    if rest > 0 {
        report.warn(format!("byte {}", bytes.len() - rest), format!("{rest} bytes after the last element skipped"));
    }
    soup.into_mesh(report)
}

/// Whether a file begins like PLY.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    matches!(bytes, [b'p', b'l', b'y', b'\n' | b'\r', ..])
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property is to a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Coordinate 0…2 of the position, 3…5 of the normal.
    Coordinate(usize),
    Polygon,
    Strips,
    Skipped,
}

#[derive(Debug)]
struct Property {
    name: String,
    /// The type of a list's count; none for a scalar.
    count: Option<Scalar>,
    scalar: Scalar,
    role: Role,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: usize,
    /// The header line that declares it.
    line: usize,
    properties: Vec<Property>,
}

#[derive(Debug)]
struct Header {
    format: Format,
    elements: Vec<Element>,
    /// Byte offset of the body.
    end: usize,
    /// Number of header lines.
    lines: usize,
}

impl Header {
    fn read(bytes: &[u8], report: &Report) -> Result<Self> {
        // The first line says how lines end: the body of a binary file may begin with any byte.
        let ending: &[u8] = match bytes {
            [b'p', b'l', b'y', b'\r', b'\n', ..] => b"\r\n",
            [b'p', b'l', b'y', b'\r', ..] => b"\r",
            [b'p', b'l', b'y', b'\n', ..] => b"\n",
            _ => return Err(report.error("line 1", "not a PLY file: it does not begin with a line \"ply\"")),
        };
        let mut header = Self { format: Format::Ascii, elements: Vec::new(), end: 3 + ending.len(), lines: 1 };
        let mut format = None;
        loop {
            header.lines += 1;
            let rest = &bytes[header.end..];
            let place = || format!("line {}", header.lines);
            let length = (rest.windows(ending.len()).position(|w| w == ending))
                .or(rest.strip_prefix(b"end_header").filter(|r| r.is_empty()).map(|_| rest.len()))
                .ok_or_else(|| report.error(place(), "the header has no end_header"))?;
            let line = String::from_utf8_lossy(&rest[..length]);
            header.end = (header.end + length + ending.len()).min(bytes.len());
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => break,
                ["format", name, version] => {
                    format = Some(parse_format(name, version).map_err(|e| report.error(place(), e))?)
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| {
                        report.error(place(), format!("\"{}\" is not a count of elements", excerpt(count.as_bytes())))
                    })?;
                    let line = header.lines;
                    header.elements.push(Element { name: name.into(), count, line, properties: Vec::new() });
                }
                ["property", ..] => {
                    let element = (header.elements.last_mut()).ok_or_else(|| {
                        report.error(format!("line {}", header.lines), "a property before any element")
                    })?;
                    let property = Property::parse(&words[1..], &element.name)
                        .map_err(|e| report.error(format!("line {}", header.lines), e))?;
                    element.properties.push(property);
                }
                _ => {
                    let what = excerpt(rest[..length].trim_ascii());
                    return Err(report.error(place(), format!("\"{what}\" is not a line of a PLY header")));
                }
            }
        }
        let missing = || report.error("header", "no format line");
        header.format = format.ok_or_else(missing)?;
        header.check(report)?;
        Ok(header)
    }

    /// Checks that there is a mesh and gives up normals that are not complete.
    fn check(&mut self, report: &Report) -> Result<()> {
        let vertex = self.elements.iter_mut().filter(|e| e.name == "vertex").collect::<Vec<_>>();
        let [vertex] = <[_; 1]>::try_from(vertex)
            .map_err(|v| report.error("header", format!("{} elements \"vertex\"; there must be one", v.len())))?;
        let has = |vertex: &Element, i| vertex.properties.iter().filter(|p| p.role == Role::Coordinate(i)).count();
        for i in 0..3 {
            if has(vertex, i) != 1 {
                let place = format!("line {}", vertex.line);
                let reason = format!(
                    "element \"vertex\" has {} scalar properties \"{}\"; there must be one",
                    has(vertex, i),
                    COORDINATES[i]
                );
                return Err(report.error(place, reason));
            }
        }
        if (3..6).any(|i| has(vertex, i) != 1) {
            let normals = vertex.properties.iter_mut().filter(|p| matches!(p.role, Role::Coordinate(3..)));
            normals.for_each(|p| p.role = Role::Skipped);
        }
        let has_faces = |p: &Property| matches!(p.role, Role::Polygon | Role::Strips);
        if !self.elements.iter().flat_map(|e| &e.properties).any(has_faces) {
            return Err(report.error(
                "header",
                "no faces (element \"face\" with a list \"vertex_indices\"); a point cloud is no mesh",
            ));
        }
        Ok(())
    }
}

const COORDINATES: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

fn parse_format(name: &str, version: &str) -> Result<Format, String> {
    if version != "1.0" {
        return Err(format!("PLY version \"{}\"; only 1.0 is known", excerpt(version.as_bytes())));
    }
    match name {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::Little),
        "binary_big_endian" => Ok(Format::Big),
        _ => Err(format!("\"{}\" is not a PLY format", excerpt(name.as_bytes()))),
    }
}

impl Property {
    /// Parses the words after `property`.
    fn parse(words: &[&str], element: &str) -> Result<Self, String> {
        let scalar = |word: &str| {
            Scalar::parse(word).ok_or_else(|| format!("\"{}\" is not a PLY type", excerpt(word.as_bytes())))
        };
        match *words {
            ["list", count, item, name] => {
                let (count, item) = (scalar(count)?, scalar(item)?);
                if count.is_float() {
                    return Err(format!("the count of list \"{}\" is not an integer", excerpt(name.as_bytes())));
                }
                let role = match (element, name) {
                    ("face", "vertex_indices" | "vertex_index") => Role::Polygon,
                    ("tristrips", "vertex_indices" | "vertex_index") => Role::Strips,
                    _ => Role::Skipped,
                };
                if role != Role::Skipped && item.is_float() {
                    return Err(format!("list \"{name}\" holds floating-point numbers, not indices"));
                }
                Ok(Self { name: name.into(), count: Some(count), scalar: item, role })
            }
            [kind, name] => {
                let role = (COORDINATES.iter().position(|c| *c == name))
                    .filter(|_| element == "vertex")
                    .map_or(Role::Skipped, Role::Coordinate);
                Ok(Self { name: name.into(), count: None, scalar: scalar(kind)?, role })
            }
            _ => Err("a property is \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"".into()),
        }
    }
}

/// Where the values come from. A reason is returned where they cannot be read.
trait Body {
    /// Bytes that are left.
    fn left(&self) -> usize;
    /// The fewest bytes that an element can take.
    fn least(&self, element: &Element) -> usize;
    fn start_row(&mut self, columns: usize) -> Result<(), String>;
    fn end_row(&mut self) -> Result<(), String>;
    /// The next value; f64 holds every type of the format exactly.
    fn value(&mut self, scalar: Scalar) -> Result<f64, String>;
    fn skip(&mut self, scalar: Scalar, n: usize) -> Result<(), String>;
    /// The fewest bytes that `n` values take.
    fn least_values(&self, scalar: Scalar, n: usize) -> usize;
    fn place(&self, element: &Element, index: usize) -> String;
}

fn read_elements<B: Body>(header: &Header, body: &mut B, soup: &mut Soup, report: &Report) -> Result<()> {
    // Faces may come before the vertices, but their number is known.
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut row = Row { coordinates: [0.0; 6], list: Vec::new(), vertices };
    for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
        let least = body.least(element);
        // A text without a newline at its end is one byte short.
        if element.count.checked_mul(least).is_none_or(|n| n > body.left() + 1) {
            let reason = format!(
                "{} elements \"{}\" of at least {least} bytes each, but only {} bytes are there",
                element.count,
                excerpt(element.name.as_bytes()),
                body.left()
            );
            return Err(report.error(format!("line {}", element.line), reason));
        }
        let is_vertex = element.name == "vertex";
        let has_normals = element.properties.iter().any(|p| p.role == Role::Coordinate(3));
        if is_vertex {
            soup.positions.reserve_exact(element.count);
            soup.normals = has_normals.then(|| Vec::with_capacity(element.count));
        }
        for index in 0..element.count {
            let error = |body: &B, reason: String| report.error(body.place(element, index), reason);
            row.read(element, index, body, soup).map_err(|reason| error(body, reason))?;
            if is_vertex {
                let [x, y, z, nx, ny, nz] = row.coordinates;
                soup.push_position(Vector3::new(x, y, z), || body.place(element, index));
                soup.normals.iter_mut().for_each(|n| n.push(Vector3::new(nx, ny, nz).cast()));
            }
        }
    }
    Ok(())
}

/// One element, as it is being read.
struct Row {
    coordinates: [f64; 6],
    list: Vec<u32>,
    vertices: usize,
}

impl Row {
    fn read<B: Body>(&mut self, element: &Element, index: usize, body: &mut B, soup: &mut Soup) -> Result<(), String> {
        body.start_row(element.properties.len())?;
        for property in &element.properties {
            let Some(count) = property.count else {
                match property.role {
                    Role::Coordinate(i) => self.coordinates[i] = body.value(property.scalar)?,
                    _ => body.skip(property.scalar, 1)?,
                }
                continue;
            };
            let n = body.value(count)?;
            if !(n >= 0.0 && n.fract() == 0.0) {
                return Err(format!("list \"{}\" has a count of {n}", excerpt(property.name.as_bytes())));
            }
            let n = n as usize;
            if body.least_values(property.scalar, n) > body.left() {
                let name = excerpt(property.name.as_bytes());
                return Err(format!("list \"{name}\" of {n} values, but only {} bytes are there", body.left()));
            }
            match property.role {
                Role::Polygon => {
                    self.list.clear();
                    for _ in 0..n {
                        let i = body.value(property.scalar)?;
                        self.list.push(self.vertex(i)?);
                    }
                    soup.push_polygon(&self.list, || body.place(element, index));
                }
                Role::Strips => {
                    self.list.clear();
                    for _ in 0..n {
                        match body.value(property.scalar)? {
                            -1.0 => self.strip(soup),
                            i => {
                                let i = self.vertex(i)?;
                                self.list.push(i);
                            }
                        }
                    }
                    self.strip(soup);
                }
                _ => body.skip(property.scalar, n)?,
            }
        }
        body.end_row()
    }

    fn vertex(&self, index: f64) -> Result<u32, String> {
        if index >= 0.0 && index < self.vertices as f64 && index.fract() == 0.0 && index <= f64::from(u32::MAX) {
            Ok(index as u32)
        } else {
            Err(format!("vertex index {index} is out of range; there are {}", self.vertices))
        }
    }

    /// Ends a triangle strip: every other triangle turns round.
    fn strip(&mut self, soup: &mut Soup) {
        let triangles = self.list.windows(3).enumerate();
        soup.faces.extend(triangles.map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }));
        self.list.clear();
    }
}

struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
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

    fn start_row(&mut self, _: usize) -> Result<(), String> {
        Ok(())
    }

    fn end_row(&mut self) -> Result<(), String> {
        Ok(())
    }

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

struct Ascii<'a> {
    rest: &'a [u8],
    line: usize,
    row: &'a [u8],
}

impl<'a> Ascii<'a> {
    fn word(&mut self) -> Result<&'a [u8], String> {
        let row = self.row.trim_ascii_start();
        if row.is_empty() {
            return Err("the line has too few values".into());
        }
        let end = row.iter().position(u8::is_ascii_whitespace).unwrap_or(row.len());
        let (word, rest) = row.split_at(end);
        self.row = rest;
        Ok(word)
    }
}

impl Body for Ascii<'_> {
    fn left(&self) -> usize {
        self.row.len() + self.rest.len()
    }

    fn least(&self, element: &Element) -> usize {
        2 * element.properties.len()
    }

    fn start_row(&mut self, _: usize) -> Result<(), String> {
        loop {
            if self.rest.is_empty() {
                return Err("the file ends here".into());
            }
            self.line += 1;
            let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
            let (row, after) = self.rest.split_at(end);
            self.rest = after.strip_prefix(b"\r\n").unwrap_or(after.get(1..).unwrap_or_default());
            self.row = row.trim_ascii();
            if !self.row.is_empty() {
                return Ok(());
            }
        }
    }

    fn end_row(&mut self) -> Result<(), String> {
        match self.row.trim_ascii() {
            [] => Ok(()),
            more => Err(format!("the line has more values than the header says, from \"{}\" on", excerpt(more))),
        }
    }

    fn value(&mut self, scalar: Scalar) -> Result<f64, String> {
        let word = self.word()?;
        let number: Option<f64> = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.filter(|n| scalar.is_float() || n.fract() == 0.0).ok_or_else(|| {
            format!("\"{}\" is not {} number", excerpt(word), if scalar.is_float() { "a" } else { "a whole" })
        })
    }

    fn skip(&mut self, _: Scalar, n: usize) -> Result<(), String> {
        (0..n).try_for_each(|_| self.word().map(|_| ()))
    }

    fn least_values(&self, _: Scalar, n: usize) -> usize {
        n.saturating_mul(2).saturating_sub(1)
    }

    fn place(&self, element: &Element, index: usize) -> String {
        format!("line {} ({} {index})", self.line, excerpt(element.name.as_bytes()))
    }
}
