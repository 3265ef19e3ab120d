//! The vertices and triangles of one primitive.

use nalgebra::{Matrix3, Matrix4, Vector3};

use super::Reader;
use super::accessor::{Component, Elements, Shape};
use super::document::{Object, extension, field, index};
use crate::Result;
use crate::io::mesh::assemble::Soup;
use crate::io::mesh::split::Smoothing;

/// The most vertices, and the most triangles, that the instances of a scene may add up to: 2²⁶.
const MOST: usize = 1 << 26;

/// Modes of a primitive; a list of triangles is 4.
const STRIP: usize = 5;
const FAN: usize = 6;

/// A primitive, checked: corners are indices into the positions.
struct Geometry<'a> {
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    uv: Option<Elements<'a>>,
    corners: Vec<u32>,
    mode: usize,
}

impl Geometry<'_> {
    fn triangles(&self) -> usize {
        if matches!(self.mode, STRIP | FAN) { self.corners.len().saturating_sub(2) } else { self.corners.len() / 3 }
    }

    fn triangle(&self, k: usize) -> [u32; 3] {
        let c = &self.corners;
        match self.mode {
            STRIP if k % 2 == 1 => [c[k + 1], c[k], c[k + 2]],
            STRIP => [c[k], c[k + 1], c[k + 2]],
            FAN => [c[0], c[k + 1], c[k + 2]],
            _ => [c[3 * k], c[3 * k + 1], c[3 * k + 2]],
        }
    }
}

impl<'a> Reader<'a> {
    /// Adds a primitive of triangles, once for each transform.
    pub(super) fn primitive(
        &mut self,
        primitive: &'a Object,
        mode: Option<usize>,
        transforms: &[Matrix4<f64>],
        place: &str,
    ) -> Result<()> {
        let mut geometry = self.geometry(primitive, mode.unwrap_or(4), place)?;
        geometry.uv = self.texture_coordinates(primitive, geometry.positions.count).unwrap_or_else(|reason| {
            self.skipped.uv.add(|| format!("{place} TEXCOORD_0: {reason}"));
            None
        });
        let n = transforms.len();
        let beyond = |so_far: usize, more: usize| more.checked_mul(n).is_none_or(|m| m > MOST - so_far);
        let (vertices, triangles) = (geometry.positions.count, geometry.triangles());
        if beyond(self.soup.positions.len(), vertices) || beyond(self.soup.faces.len(), triangles) {
            let instances = if n == 1 { String::new() } else { format!("{n} instances of {triangles} triangles: ") };
            return Err(self.report.error(place, format!("{instances}more than 2^26 vertices or triangles so far")));
        }
        if !matches!(geometry.mode, STRIP | FAN) && geometry.corners.len() % 3 != 0 {
            self.skipped.uneven.add(|| place.to_owned());
        }
        transforms.iter().for_each(|transform| self.instance(&geometry, transform, place));
        Ok(())
    }

    fn geometry(&self, primitive: &'a Object, mode: usize, place: &str) -> Result<Geometry<'a>> {
        let at = |part: &str| format!("{place} {part}");
        let error = |part: &str, reason: String| self.report.error(at(part), reason);
        let elements = |part: &str, number, shape| {
            Elements::new(self.buffers, number, shape)
                .and_then(|e| match extension(primitive, DRACO) {
                    // Such data are not zeros: they are elsewhere.
                    Some(_) if e.are_absent() => Err(format!("its data are those of {DRACO}, which cannot be read")),
                    // There are as many normals as positions.
                    _ if part == "NORMAL" => Ok(e),
                    _ => e.warranted(),
                })
                .map_err(|e| error(part, format!("accessor {number}: {e}")))
        };
        let attributes = field(primitive, "attributes").and_then(|a| a.as_object());
        let attribute = |name: &str| match attributes {
            Some(attributes) => index(attributes, name).map_err(|e| self.report.error(place, e)),
            None => Ok(None),
        };
        let positions = attribute("POSITION")?
            .ok_or_else(|| self.report.error(place, "has no POSITION (compressed data cannot be read)"))?;
        let positions = elements("POSITION", positions, Shape::Vec3)?;
        if positions.component == Component::U32 {
            return Err(error("POSITION", "positions cannot be 32-bit integers".into()));
        }
        let normals = attribute("NORMAL")?.map(|i| elements("NORMAL", i, Shape::Vec3)).transpose()?;
        if let Some(n) = normals.as_ref().filter(|n| n.count != positions.count) {
            return Err(error("NORMAL", format!("{} normals for {} positions", n.count, positions.count)));
        }
        let indices = index(primitive, "indices").map_err(|e| self.report.error(place, e))?;
        let indices = indices.map(|i| elements("indices", i, Shape::Scalar)).transpose()?;
        let corners = corners(indices.as_ref(), positions.count).map_err(|e| error("indices", e))?;
        Ok(Geometry { positions, normals, uv: None, corners, mode })
    }

    /// The first set of texture coordinates, one a position; nothing that is wrong with it loses the mesh.
    fn texture_coordinates(&self, primitive: &'a Object, count: usize) -> Result<Option<Elements<'a>>, String> {
        let Some(attributes) = field(primitive, "attributes").and_then(|a| a.as_object()) else { return Ok(None) };
        let Some(number) = index(attributes, "TEXCOORD_0")? else { return Ok(None) };
        let at = |reason: String| format!("accessor {number}: {reason}");
        let elements = Elements::new(self.buffers, number, Shape::Vec2).map_err(at)?;
        if elements.component == Component::U32 {
            return Err(at("texture coordinates cannot be 32-bit integers".into()));
        }
        if elements.count != count {
            return Err(at(format!("{} pairs for {count} positions", elements.count)));
        }
        Ok(Some(elements))
    }

    fn instance(&mut self, geometry: &Geometry<'_>, transform: &Matrix4<f64>, place: &str) {
        let before = self.soup.positions.len();
        let linear: Matrix3<f64> = transform.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector3<f64> = transform.fixed_view::<3, 1>(0, 3).into_owned();
        for i in 0..geometry.positions.count {
            let position = linear * geometry.positions.vector(i) + shift;
            self.soup.push_position(position, || format!("{place} POSITION {i}"));
        }
        let mirrored = linear.determinant() < 0.0;
        match &geometry.normals {
            Some(stored) => {
                // Normals transform with the cofactors, det(M) · M⁻ᵀ, which need no inverse; the sign of a mirroring is
                // taken out again, since the triangles are turned round.
                let cofactors = cofactors(&linear) * if mirrored { -1.0 } else { 1.0 };
                let list = self.soup.normals.get_or_insert_default();
                list.resize(before, Vector3::zeros());
                let normal = |i| (cofactors * stored.vector(i)).try_normalize(0.0).unwrap_or_default().cast();
                list.extend((0..stored.count).map(normal));
                if self.has_flat {
                    self.soup.set_smoothing(Smoothing::Group(0));
                }
            }
            None => {
                self.has_flat = true;
                self.soup.set_smoothing(Smoothing::Flat);
            }
        }
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        if let Some(stored) = &geometry.uv {
            // In the file v runs downwards.
            let pair = |i| [stored.get(i, 0), 1.0 - stored.get(i, 1)];
            let uv: Vec<_> =
                (0..stored.count).map(|i| self.soup.finite_uv(pair(i), || format!("{place} TEXCOORD_0 {i}"))).collect();
            self.soup.corner_uv.resize(self.soup.faces.len(), [Soup::NO_UV; 3]);
            let corners = (0..geometry.triangles()).map(|k| turned(geometry.triangle(k)).map(|i| uv[i as usize]));
            self.soup.corner_uv.extend(corners);
        }
        let faces = (0..geometry.triangles()).map(|k| turned(geometry.triangle(k)).map(|i| i + before as u32));
        self.soup.faces.extend(faces);
    }
}

const DRACO: &str = "KHR_draco_mesh_compression";

/// The vertex indices of a primitive in order.
fn corners(indices: Option<&Elements<'_>>, vertices: usize) -> Result<Vec<u32>, String> {
    let Some(indices) = indices else {
        return u32::try_from(vertices).map(|n| (0..n).collect()).map_err(|_| "more vertices than indices".into());
    };
    if !indices.component.is_index() {
        return Err("indices must be unsigned integers".into());
    }
    (0..indices.count)
        .map(|i| {
            let index = indices.get(i, 0);
            (index < vertices as f64)
                .then_some(index as u32)
                .ok_or_else(|| format!("number {i}: vertex index {index} is out of range; there are {vertices}"))
        })
        .collect()
}

/// The matrix of cofactors: column i is the cross product of the other two columns.
fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |i: usize| m.column(i).into_owned();
    Matrix3::from_columns(&[column(1).cross(&column(2)), column(2).cross(&column(0)), column(0).cross(&column(1))])
}
