//! Stanford PLY.
//!
//! A reader of our own: the crate for PLY is unmaintained, believes the counts of the header when it takes memory and
//! says neither line nor offset when something is wrong. What a mesh needs of the format is small.

mod ascii;
mod binary;
mod header;

use nalgebra::{Vector2, Vector3};

use self::ascii::{Ascii, Layout};
use self::binary::Binary;
use self::header::{Element, Format, Header, Role, Scalar};
use super::MeshOptions;
use super::assemble::Soup;
use crate::Result;
use crate::io::count::plural;
use crate::io::report::{Loaded, Report, excerpt};
use crate::scene::Mesh;

/// Reads a PLY file from its bytes; `name` is what messages call it.
///
/// ASCII and binary of both byte orders. Read are `x y z` and, if all three are there, `nx ny nz` of the element
/// `vertex`, the lists `vertex_indices` or `vertex_index` of the element `face`, and those of `tristrips` (−1 separates
/// strips). Texture coordinates, [`Mesh::uv`] with v upwards, are `s t`, `u v` or `texture_u texture_v` of the
/// vertices, the first pair of these that is complete (a half of one is a warning), or the lists `texcoord` of the
/// faces, two numbers a corner, which go before those of the vertices; vertices are split where they differ, as
/// [`Mesh::with_corner_uv`] does. Properties may have any of the format's types and any order; other properties and
/// elements are skipped. The header's lines may end in LF, CRLF or CR, each in its own way; blanks around words, a byte
/// order mark, comments and blank lines do no harm.
///
/// In ASCII, where there are as many lines as elements (blank ones not counted), each is an element, and values beyond
/// the declared ones are dropped with a warning. Otherwise the values are one stream, separated by any white space;
/// a warning says where elements go over from one line into another and share one with others. NaN may be spelt as
/// any C library prints it.
///
/// Repaired with a warning: faces with fewer than three corners, texture coordinates that are NaN or infinite or not
/// two a corner, bytes after the end, and what is repaired in [every format](crate::io#meshes).
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the line, or the element and byte offset, for everything else that cannot
/// be read: counts beyond the bytes that are there, a coordinate of a face that is NaN or infinite (in `f32`), an index
/// out of range, a file cut short, an ASCII body that is neither lines nor a stream of the declared values.
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
    let header = Header::read(bytes, &mut report)?;
    let (soup, rest) = match header.format {
        Format::Ascii => read_ascii(&header, bytes, options, &mut report)?,
        Format::Little | Format::Big => {
            let mut body = Binary { bytes, at: header.end, big: header.format == Format::Big };
            (read_elements(&header, &mut body, options, &report)?, bytes.len() - body.at)
        }
    };
    if rest > 0 {
        report.warn(format!("byte {}", bytes.len() - rest), format!("{rest} bytes after the last element skipped"));
    }
    soup.into_mesh(report)
}

/// Whether a file begins like PLY.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    header::magic(bytes).is_some()
}

/// Reads an ASCII body; also how many bytes are left over.
fn read_ascii(header: &Header, bytes: &[u8], options: &MeshOptions, report: &mut Report) -> Result<(Soup, usize)> {
    let text = &bytes[header.end..];
    let elements = header.elements().fold(0, |n: usize, e| n.saturating_add(e.count));
    let read = |layout| {
        let mut body = Ascii::new(text, header.lines, layout);
        read_elements(header, &mut body, options, report).map(|soup| (soup, body))
    };
    let (soup, body) = match ascii::count_lines(text) {
        lines if lines == elements => read(Layout::Lines)?,
        lines => match read(Layout::Stream) {
            Ok((soup, body)) if body.rest() == 0 => (soup, body),
            // There may be lines after the last element, or a fault.
            stream => match (read(Layout::Lines), stream) {
                (Ok(lined), _) if lines > elements => lined,
                (_, Ok((soup, body))) if body.straddling.n == 0 => (soup, body),
                (_, Ok((_, body))) => {
                    let reason = format!(
                        "the body has neither a line for each element nor just the declared values: {lines} lines for \
                         {elements} elements, and {} left over",
                        plural(body.rest(), "byte", "bytes")
                    );
                    return Err(report.error(body.straddling.first, reason));
                }
                (_, Err(e)) => return Err(e),
            },
        },
    };
    let rest = body.rest();
    let Ascii { longer, straddling, .. } = body;
    longer.warn(report, |n| {
        format!("{} more values than the header declares; dropped", plural(n, "line has", "lines have"))
    });
    straddling.warn(report, |n| {
        let elements = plural(n, "element goes", "elements go");
        format!("{elements} over from one line into another; the body was read as a stream of values")
    });
    Ok((soup, rest))
}

/// Where the values come from. A reason is returned where they cannot be read.
trait Body {
    /// Bytes that are left.
    fn left(&self) -> usize;
    /// The fewest bytes that an element can take.
    fn least(&self, element: &Element) -> usize;
    fn start_row(&mut self) -> Result<(), String>;
    fn end_row(&mut self);
    /// The next value; f64 holds every type of the format exactly.
    fn value(&mut self, scalar: Scalar) -> Result<f64, String>;
    fn skip(&mut self, scalar: Scalar, n: usize) -> Result<(), String>;
    /// The fewest bytes that `n` values take.
    fn least_values(&self, scalar: Scalar, n: usize) -> usize;
    fn place(&self, element: &Element, index: usize) -> String;
}

fn read_elements<B: Body>(header: &Header, body: &mut B, options: &MeshOptions, report: &Report) -> Result<Soup> {
    let mut soup = Soup::new(options);
    // Faces may come before the vertices, but their number is known.
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut row = Row { coordinates: [0.0; 8], list: Vec::new(), uv: Vec::new(), vertices };
    let mut vertex_uv = Vec::new();
    for element in header.elements() {
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
        let has = |role| element.properties.iter().any(|p| p.role == role);
        let (has_normals, has_uv) = (has(Role::Coordinate(3)), has(Role::Coordinate(6)));
        if is_vertex {
            soup.positions.reserve_exact(element.count);
            soup.normals = has_normals.then(|| Vec::with_capacity(element.count));
            vertex_uv.reserve_exact(if has_uv { element.count } else { 0 });
        }
        for index in 0..element.count {
            row.read(element, index, body, &mut soup)
                .map_err(|reason| report.error(body.place(element, index), reason))?;
            if is_vertex {
                let [x, y, z, nx, ny, nz, u, v] = row.coordinates;
                soup.push_position(Vector3::new(x, y, z), || body.place(element, index));
                soup.normals.iter_mut().for_each(|n| n.push(Vector3::new(nx, ny, nz).cast()));
                if has_uv {
                    vertex_uv.push(soup.finite_uv([u, v], || body.place(element, index)));
                }
            }
        }
    }
    if soup.corner_uv.is_empty() && !vertex_uv.is_empty() {
        soup.set_vertex_uv(&vertex_uv);
    }
    Ok(soup)
}

/// One element, as it is being read.
struct Row {
    coordinates: [f64; 8],
    list: Vec<u32>,
    /// Texture coordinates of the corners of a polygon.
    uv: Vec<Vector2<f32>>,
    vertices: usize,
}

impl Row {
    fn read<B: Body>(&mut self, element: &Element, index: usize, body: &mut B, soup: &mut Soup) -> Result<(), String> {
        body.start_row()?;
        let first = soup.faces.len();
        self.uv.clear();
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
                Role::CornerUv => {
                    for _ in 0..n / 2 {
                        let pair = [body.value(property.scalar)?, body.value(property.scalar)?];
                        self.uv.push(soup.finite_uv(pair, || body.place(element, index)));
                    }
                    // A list that does not fit is as good as none.
                    if n % 2 == 1 {
                        body.skip(property.scalar, 1)?;
                        self.uv.clear();
                    }
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
        if !self.uv.is_empty() && self.uv.len() == self.list.len() {
            soup.push_corner_uv(first, &self.uv);
        }
        body.end_row();
        Ok(())
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
