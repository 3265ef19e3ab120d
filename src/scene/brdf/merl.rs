//! Measured isotropic BRDFs in the MERL binary format.

use std::f64::consts::{FRAC_PI_2, PI};
use std::io::Read;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::{Brdf, above_horizon, half_vector, off_surface};
use crate::{Error, Result};

const THETA_H: usize = 90;
const THETA_D: usize = 90;
const PHI_D: usize = 180;
const CELLS: usize = THETA_H * THETA_D * PHI_D;
/// What a stored number is multiplied with, by channel.
const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// How [`Merl`] reads between its cells.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MerlLookup {
    /// The value of the cell, as the database's own reader does.
    Nearest,
    /// Trilinear between the cells' centres; cells that hold no measurement are left out and the rest re-weighted.
    #[default]
    Trilinear,
}

/// A measured isotropic BRDF of the MERL database [Matusik 2003].
///
/// The file: three little-endian 32-bit integers 90, 90, 180, then 90·90·180 little-endian 64-bit floats for red, as
/// many for green and for blue, index (i_θh · 90 + i_θd) · 180 + i_φd in the half/difference angles of Rusinkiewicz
/// (1998); i_θh = 90 √(θ_h/90°), i_θd = θ_d in degrees, i_φd = φ_d in degrees modulo 180 (reciprocity). The channels
/// are scaled by 1/1500, 1.15/1500 and 1.66/1500.
///
/// Negative numbers mark cells without a measurement: they read as 0, and [`missing`](Self::missing) counts them.
/// Values are kept as `f32` (17.5 MB). Energy and reciprocity are the measurement's.
#[derive(Clone, PartialEq)]
pub struct Merl {
    /// Scaled RGB; −1 where a cell has no measurement.
    cells: Vec<[f32; 3]>,
    missing: usize,
    lookup: MerlLookup,
}

impl std::fmt::Debug for Merl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Merl").field("missing", &self.missing).field("lookup", &self.lookup).finish_non_exhaustive()
    }
}

impl Merl {
    /// The size of a file in bytes: 34,992,012.
    pub const FILE_LEN: usize = 12 + 3 * 8 * CELLS;

    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::File`], with the place, if it cannot be read, is truncated, has other dimensions, bytes after its end,
    /// or a number that is NaN, infinite or, scaled, above the largest `f32`.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let file = std::fs::File::open(path).map_err(|e| file_error(path, String::new(), e.to_string()))?;
        Self::read(std::io::BufReader::with_capacity(1 << 16, file), path)
    }

    /// Reads from a stream up to its end; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn read(mut reader: impl Read, name: impl AsRef<Path>) -> Result<Self> {
        let name = name.as_ref();
        let mut bytes = Vec::new();
        // One byte more than a file has shows that there is more, without reading all of a stream that never ends.
        let limit = Self::FILE_LEN as u64 + 1;
        let mut header = [0; 12];
        let got = read_up_to(&mut reader, &mut header).map_err(|e| file_error(name, String::new(), e.to_string()))?;
        bytes.extend_from_slice(&header[..got]);
        // Other dimensions are refused before 33 MB are read.
        check_header(&bytes, name)?;
        let rest = limit - 12;
        reader.take(rest).read_to_end(&mut bytes).map_err(|e| file_error(name, String::new(), e.to_string()))?;
        Self::parse(&bytes, name)
    }

    /// Reads from memory.
    ///
    /// # Errors
    /// As [`open`](Self::open), with the file's name given as "MERL data".
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        Self::parse(bytes, Path::new("MERL data"))
    }

    fn parse(bytes: &[u8], name: &Path) -> Result<Self> {
        check_header(bytes, name)?;
        if bytes.len() != Self::FILE_LEN {
            let reason = if bytes.len() < Self::FILE_LEN {
                format!("truncated: a MERL file has {} bytes, this one {}", Self::FILE_LEN, bytes.len())
            } else {
                format!("there are bytes after the {} of a MERL file", Self::FILE_LEN)
            };
            return Err(file_error(name, format!("byte {}", bytes.len().min(Self::FILE_LEN)), reason));
        }
        let mut cells = vec![[0.0_f32; 3]; CELLS];
        let (numbers, _) = bytes[12..].as_chunks::<8>();
        for (channel, plane) in numbers.chunks_exact(CELLS).enumerate() {
            for (i, (cell, number)) in cells.iter_mut().zip(plane).enumerate() {
                let stored = f64::from_le_bytes(*number);
                let value = (stored * SCALE[channel]) as f32;
                if !value.is_finite() {
                    let place = format!("byte {}", 12 + 8 * (channel * CELLS + i));
                    let reason = format!("{} number {i} is {stored}", ["red", "green", "blue"][channel]);
                    return Err(file_error(name, place, reason));
                }
                cell[channel] = value;
            }
        }
        let mut missing = 0;
        for cell in &mut cells {
            if cell.iter().any(|c| *c < 0.0) {
                *cell = [-1.0; 3];
                missing += 1;
            }
        }
        Ok(Self { cells, missing, lookup: MerlLookup::default() })
    }

    /// The same data, read in another way.
    #[must_use]
    pub fn with_lookup(mut self, lookup: MerlLookup) -> Self {
        self.lookup = lookup;
        self
    }

    /// How many of the 1,458,000 cells hold no measurement (a negative number in any channel).
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// The bytes of a MERL file that samples `brdf` at the centres of the cells; a cell whose centre has a direction
    /// below the horizon gets −1.
    ///
    /// The model should be isotropic and reciprocal: the format can hold nothing else.
    pub fn bytes_from(brdf: &dyn Brdf) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(Self::FILE_LEN);
        for n in [THETA_H, THETA_D, PHI_D] {
            bytes.extend_from_slice(&(n as i32).to_le_bytes());
        }
        let mut values = Vec::with_capacity(CELLS);
        for h in 0..THETA_H {
            for d in 0..THETA_D {
                for p in 0..PHI_D {
                    let (wi, wo) = directions(
                        ((h as f64 + 0.5) / THETA_H as f64).powi(2) * FRAC_PI_2,
                        (d as f64 + 0.5) / THETA_D as f64 * FRAC_PI_2,
                        (p as f64 + 0.5) / PHI_D as f64 * PI,
                    );
                    values.push(if above_horizon(&wi, &wo) { brdf.eval(&wi, &wo) } else { Vector3::repeat(-1.0) });
                }
            }
        }
        for channel in 0..3 {
            for value in &values {
                let stored = if value[channel] < 0.0 { -1.0 } else { value[channel] / SCALE[channel] };
                bytes.extend_from_slice(&stored.to_le_bytes());
            }
        }
        bytes
    }

    /// The cell's RGB, `None` if it holds no measurement.
    fn cell(&self, h: usize, d: usize, p: usize) -> Option<Vector3<f64>> {
        let cell = self.cells[(h * THETA_D + d) * PHI_D + p];
        (cell[0] >= 0.0).then(|| Vector3::from(cell).cast())
    }

    fn nearest(&self, at: [f64; 3]) -> Vector3<f64> {
        let h = (at[0] as usize).min(THETA_H - 1);
        let d = (at[1] as usize).min(THETA_D - 1);
        let p = (at[2] as usize).min(PHI_D - 1);
        self.cell(h, d, p).unwrap_or_else(Vector3::zeros)
    }

    fn trilinear(&self, at: [f64; 3]) -> Vector3<f64> {
        let clamped = |x: f64, n: usize| {
            let x = (x - 0.5).clamp(0.0, (n - 1) as f64);
            let low = (x as usize).min(n - 2);
            ([low, low + 1], x - low as f64)
        };
        let (h, fh) = clamped(at[0], THETA_H);
        let (d, fd) = clamped(at[1], THETA_D);
        // φ_d is periodic.
        let x = at[2] - 0.5;
        let low = x.floor();
        let fp = x - low;
        let low = (low as i64).rem_euclid(PHI_D as i64) as usize;
        let p = [low, (low + 1) % PHI_D];
        let (mut sum, mut total) = (Vector3::zeros(), 0.0);
        for corner in 0..8 {
            let bit = |k: usize| corner >> k & 1;
            let part = |f: f64, b: usize| if b == 1 { f } else { 1.0 - f };
            let weight = part(fh, bit(0)) * part(fd, bit(1)) * part(fp, bit(2));
            if let Some(value) = self.cell(h[bit(0)], d[bit(1)], p[bit(2)]) {
                sum += value * weight;
                total += weight;
            }
        }
        if total > 0.0 { sum / total } else { Vector3::zeros() }
    }
}

impl Brdf for Merl {
    fn is_isotropic(&self) -> bool {
        true
    }

    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let at = coordinates(wi, wo);
        match self.lookup {
            MerlLookup::Nearest => self.nearest(at),
            MerlLookup::Trilinear => self.trilinear(at),
        }
    }
}

/// (i_θh, i_θd, i_φd) as real numbers: in [0, 90], [0, 90], [0, 180).
///
/// The difference vector is wi turned by −φ_h about z, then by −θ_h about y. At θ_h = 0, φ_h is 0 and φ_d the azimuth
/// of wi.
fn coordinates(wi: &Vector3<f64>, wo: &Vector3<f64>) -> [f64; 3] {
    let (h, _) = half_vector(wi, wo);
    let sin_h = h.x.hypot(h.y);
    let theta_h = sin_h.atan2(h.z);
    let (cos_phi, sin_phi) = if sin_h > 0.0 { (h.x / sin_h, h.y / sin_h) } else { (1.0, 0.0) };
    let (x, y) = (cos_phi * wi.x + sin_phi * wi.y, cos_phi * wi.y - sin_phi * wi.x);
    let difference = Vector3::new(h.z * x - sin_h * wi.z, y, sin_h * x + h.z * wi.z);
    let theta_d = difference.x.hypot(difference.y).atan2(difference.z.max(0.0));
    let phi_d = difference.y.atan2(difference.x).rem_euclid(PI);
    [(theta_h / FRAC_PI_2).sqrt() * THETA_H as f64, theta_d / FRAC_PI_2 * THETA_D as f64, phi_d / PI * PHI_D as f64]
}

/// The inverse of [`coordinates`] with φ_h = 0: wi and its mirror image about h.
fn directions(theta_h: f64, theta_d: f64, phi_d: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sin_h, cos_h) = theta_h.sin_cos();
    let turn = |x: f64, y: f64, z: f64| Vector3::new(cos_h * x + sin_h * z, y, cos_h * z - sin_h * x);
    let (x, y, z) = (theta_d.sin() * phi_d.cos(), theta_d.sin() * phi_d.sin(), theta_d.cos());
    (turn(x, y, z), turn(-x, -y, z))
}

fn check_header(bytes: &[u8], name: &Path) -> Result<()> {
    let (dimensions, _) = bytes[..bytes.len().min(12)].as_chunks::<4>();
    if dimensions.len() < 3 {
        let reason = format!("truncated: the header has 12 bytes, the file {}", bytes.len());
        return Err(file_error(name, format!("byte {}", bytes.len()), reason));
    }
    let got: Vec<i32> = dimensions.iter().map(|d| i32::from_le_bytes(*d)).collect();
    if got != [THETA_H as i32, THETA_D as i32, PHI_D as i32] {
        let reason = format!("not a MERL BRDF: its dimensions are {got:?}, they must be [90, 90, 180]");
        return Err(file_error(name, "byte 0".into(), reason));
    }
    Ok(())
}

fn read_up_to(reader: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut got = 0;
    while got < buffer.len() {
        match reader.read(&mut buffer[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(got)
}

fn file_error(path: &Path, place: String, reason: String) -> Error {
    Error::File { path: PathBuf::from(path), place, reason }
}
