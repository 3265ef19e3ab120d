//! The header: elements, their properties, and which of them a mesh needs.

use crate::Result;
use crate::io::report::{Report, excerpt};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
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

    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property is to a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Coordinate 0…2 of the position, 3…5 of the normal, 6 and 7 of the texture.
    Coordinate(usize),
    Polygon,
    /// Texture coordinates of the corners of the polygon, u and v of one after the other.
    CornerUv,
    Strips,
    Skipped,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's count; none for a scalar.
    pub(super) count: Option<Scalar>,
    pub(super) scalar: Scalar,
    pub(super) role: Role,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    /// The header line that declares it.
    pub(super) line: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Byte offset of the body.
    pub(super) end: usize,
    /// Number of header lines.
    pub(super) lines: usize,
}

/// The header's lines, whatever they end in.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
    /// Where no line ends in LF, one after a CR is the first byte of a binary body.
    has_newlines: bool,
}

impl<'a> Lines<'a> {
    /// The next line without its end, and whether that is a CR alone. Without an end only `end_header` is a line.
    fn next(&mut self) -> Option<(&'a [u8], bool)> {
        self.number += 1;
        let rest = &self.bytes[self.at..];
        let Some(length) = rest.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
            self.at = self.bytes.len();
            return (rest.trim_ascii() == b"end_header").then_some((rest, false));
        };
        let (line, end) = rest.split_at(length);
        let pair = self.has_newlines && end.starts_with(b"\r\n");
        self.at += length + if pair { 2 } else { 1 };
        Some((line, end[0] == b'\r' && !pair))
    }
}

/// The byte after the word that a PLY file begins with, and the blanks behind it, if a line ends there.
pub(super) fn magic(bytes: &[u8]) -> Option<usize> {
    let after = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).strip_prefix(b"ply")?;
    let blanks = after.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    matches!(after.get(blanks), Some(b'\n' | b'\r')).then_some(bytes.len() - after.len() + blanks)
}

impl Header {
    pub(super) fn read(bytes: &[u8], report: &mut Report) -> Result<Self> {
        let at = magic(bytes)
            .ok_or_else(|| report.error("line 1", "not a PLY file: it does not begin with a line \"ply\""))?;
        let end = bytes.windows(10).position(|w| w == b"end_header").unwrap_or(bytes.len());
        let mut lines = Lines { bytes, at, number: 0, has_newlines: bytes[..end].contains(&b'\n') };
        // The rest of the first line.
        lines.next();
        let mut elements: Vec<Element> = Vec::new();
        let mut format = None;
        let mut in_comment = false;
        loop {
            let Some((bytes, ends_in_cr)) = lines.next() else {
                return Err(report.error(format!("line {}", lines.number), "the header has no end_header"));
            };
            let error = |reason: String| report.error(format!("line {}", lines.number), reason);
            let line = String::from_utf8_lossy(bytes);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            // Where other lines end in LF, a CR alone may also be a part of a comment.
            let may_be_comment = std::mem::take(&mut in_comment);
            match words[..] {
                [] => {}
                ["comment" | "obj_info", ..] => in_comment = ends_in_cr && lines.has_newlines,
                ["end_header"] => break,
                ["format", name, version] => format = Some(parse_format(name, version).map_err(error)?),
                ["element", name, count] => {
                    let count = count
                        .parse()
                        .map_err(|_| error(format!("\"{}\" is not a count of elements", excerpt(count.as_bytes()))))?;
                    elements.push(Element { name: name.into(), count, line: lines.number, properties: Vec::new() });
                }
                ["property", ..] => {
                    let element = elements.last_mut().ok_or_else(|| error("a property before any element".into()))?;
                    element.properties.push(Property::parse(&words[1..], &element.name).map_err(error)?);
                }
                _ if may_be_comment => in_comment = ends_in_cr,
                _ => {
                    let what = excerpt(bytes.trim_ascii());
                    return Err(error(format!("\"{what}\" is not a line of a PLY header")));
                }
            }
        }
        let format = format.ok_or_else(|| report.error("header", "no format line"))?;
        let mut header = Self { format, elements, end: lines.at, lines: lines.number };
        header.check(report)?;
        Ok(header)
    }

    /// The elements that take bytes of the body.
    pub(super) fn elements(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter().filter(|e| !e.properties.is_empty())
    }

    /// Checks that there is a mesh, gives up normals that are not complete and chooses the texture coordinates.
    fn check(&mut self, report: &mut Report) -> Result<()> {
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
        choose_uv(vertex, report);
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

/// Gives the first complete pair of texture coordinates of the vertices its role, and warns of halves.
fn choose_uv(vertex: &mut Element, report: &mut Report) {
    let mut chosen = false;
    for pair in UV {
        let is_scalar = |p: &Property, name: &str| p.count.is_none() && p.name == name;
        let counts = pair.map(|name| vertex.properties.iter().filter(|p| is_scalar(p, name)).count());
        if counts == [1, 1] {
            if !std::mem::replace(&mut chosen, true) {
                for (name, role) in pair.into_iter().zip([6, 7].map(Role::Coordinate)) {
                    vertex.properties.iter_mut().filter(|p| is_scalar(p, name)).for_each(|p| p.role = role);
                }
            }
        } else if counts != [0, 0] {
            let [(a, n), (b, m)] = [(pair[0], counts[0]), (pair[1], counts[1])];
            report.warn(
                format!("line {}", vertex.line),
                format!("element \"vertex\" has {n} properties \"{a}\" and {m} \"{b}\", not one each; left out"),
            );
        }
    }
}

/// Names of texture coordinates, the first pair that is there.
const UV: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

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
                    ("face", "texcoord") if item.is_float() => Role::CornerUv,
                    ("tristrips", "vertex_indices" | "vertex_index") => Role::Strips,
                    _ => Role::Skipped,
                };
                if matches!(role, Role::Polygon | Role::Strips) && item.is_float() {
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
