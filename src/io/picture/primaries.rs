//! The colours that red, green and blue of a picture are.

use nalgebra::{Matrix3, Vector3};

use crate::io::report::Report;

/// Chromaticities x, y (CIE 1931) of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Primaries(pub(super) [[f64; 2]; 4]);

/// D65.
const D65: [f64; 2] = [0.3127, 0.3290];
/// The white of equal energy.
const E: [f64; 2] = [1.0 / 3.0, 1.0 / 3.0];
/// The white of DCI projectors.
const DCI: [f64; 2] = [0.314, 0.351];
const D50: [f64; 2] = [0.3457, 0.3585];
/// The white of ACES, near D60.
const ACES: [f64; 2] = [0.32168, 0.33767];

/// The primaries of CIE XYZ as colours.
pub(super) const XYZ: Primaries = Primaries([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], E]);

/// Those of Rec. 709 and sRGB, which all pictures here have.
const REC_709: Primaries = Primaries([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65]);

/// Sets that have a name.
const NAMED: [(&str, Primaries); 9] = [
    ("CIE XYZ", XYZ),
    ("Rec. 2020", Primaries([[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65])),
    ("Display P3", Primaries([[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65])),
    ("DCI-P3", Primaries([[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], DCI])),
    ("ACES AP0", Primaries([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES])),
    ("ACES AP1", Primaries([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], ACES])),
    ("Adobe RGB", Primaries([[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65])),
    ("ProPhoto RGB", Primaries([[0.734699, 0.265301], [0.159597, 0.840403], [0.036598, 0.000105], D50])),
    ("Radiance", Primaries([[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], E])),
];

/// Files round chromaticities to three or four digits.
const ROUNDING: f64 = 0.001;

/// The cone responses of XYZ by Lam's Bradford transform, by which white is adapted.
const BRADFORD: Matrix3<f64> = Matrix3::new(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296);

impl Primaries {
    /// From the eight numbers of a file.
    pub(super) fn new(numbers: [f64; 8]) -> Self {
        let [[rx, ry], [gx, gy], [bx, by], [wx, wy]] = [0, 2, 4, 6].map(|i| [numbers[i], numbers[i + 1]]);
        Self([[rx, ry], [gx, gy], [bx, by], [wx, wy]])
    }

    fn is_near(&self, other: &Self) -> bool {
        self.0.as_flattened().iter().zip(other.0.as_flattened()).all(|(a, b)| (a - b).abs() <= ROUNDING)
    }

    /// Whether these are, within what files round, the primaries of Rec. 709.
    pub(super) fn is_rec_709(&self) -> bool {
        self.is_near(&REC_709)
    }

    /// What turns linear RGB into XYZ, white having Y = 1.
    ///
    /// Column i is S_i (x_i, y_i, 1 − x_i − y_i), with the S for which (1, 1, 1) is white. Written without a division
    /// by y_i, which is 0 for two of the primaries of XYZ itself. None for primaries on a line, or a white that is no
    /// mixture of positive shares of them.
    fn to_xyz(self) -> Option<Matrix3<f64>> {
        let colour = |[x, y]: [f64; 2]| Vector3::new(x, y, 1.0 - x - y);
        let [red, green, blue, white] = self.0.map(colour);
        let primaries = Matrix3::from_columns(&[red, green, blue]);
        // Twice the area of the triangle; the smallest in use has 0.1.
        let area = primaries.determinant().abs();
        if !(area > 1e-4 && area < 1e4 && white.y > 1e-4) {
            return None;
        }
        let shares = primaries.try_inverse()? * (white / white.y);
        shares.iter().all(|s| *s > 0.0 && s.is_finite()).then(|| primaries * Matrix3::from_diagonal(&shares))
    }

    /// What turns linear RGB of these primaries into that of Rec. 709; white becomes white. None if the primaries span
    /// no colours.
    ///
    /// Only XYZ is taken as it is: the white of equal energy that files of it name is that of the axes, not of the
    /// picture, as OpenEXR's own examples show (XYZ.exr and Rec709.exr are one picture).
    pub(super) fn to_rec_709(self) -> Option<Matrix3<f64>> {
        let from_xyz = REC_709.to_xyz()?.try_inverse()?;
        if self.is_near(&XYZ) {
            return Some(from_xyz);
        }
        let white = |p: Self| BRADFORD * p.to_xyz().map(|m| m * Vector3::repeat(1.0)).unwrap_or_default();
        let (from, to) = (white(self), white(REC_709));
        // Cone responses to a white outside of all colours may be negative: nothing to adapt by.
        if !from.iter().all(|c| *c > 0.0) {
            return None;
        }
        let adapt = BRADFORD.try_inverse()? * Matrix3::from_diagonal(&to.component_div(&from)) * BRADFORD;
        let matrix = from_xyz * adapt * self.to_xyz()?;
        matrix.iter().all(|m| m.is_finite()).then_some(matrix)
    }

    /// Turns pixels into those of Rec. 709, with a warning that names the primaries; if these are Rec. 709's, leaves
    /// them alone. `place` is where the file names them.
    pub(super) fn convert(self, place: &str, report: &mut Report, pixels: &mut [Vector3<f32>]) {
        if self.is_rec_709() {
            return;
        }
        let Some(matrix) = self.to_rec_709() else {
            report.warn(place, format!("the primaries ({self}) span no colours; ignored"));
            return;
        };
        report.warn(place, format!("pixels converted from the primaries {self} to those of Rec. 709"));
        for pixel in pixels {
            // What is finite stays so, and what is not is left for the check of all pixels.
            let finite = pixel.iter().all(|c| c.is_finite());
            let limit = if finite { f64::from(f32::MAX) } else { f64::INFINITY };
            *pixel = (matrix * pixel.cast::<f64>()).map(|c| c.clamp(-limit, limit) as f32);
        }
    }
}

impl std::fmt::Display for Primaries {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some((name, _)) = NAMED.iter().find(|(_, p)| self.is_near(p)) {
            return f.write_str(name);
        }
        // Most files hold f32: their digits, not those that f64 adds.
        let [r, g, b, w] = self.0.map(|xy| xy.map(|c| c as f32));
        write!(f, "red {} {}, green {} {}, blue {} {}, white {} {}", r[0], r[1], g[0], g[1], b[0], b[1], w[0], w[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_the_published_ones() {
        // Rec. 709 to XYZ, IEC 61966-2-1; ACES AP0 to Rec. 709 by Bradford, as ACES' own transforms have it.
        let expected = Matrix3::new(0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505);
        assert!((REC_709.to_xyz().unwrap() - expected).amax() < 1e-4);
        let aces = NAMED[4].1.to_rec_709().unwrap();
        let expected = Matrix3::new(2.5216, -1.1341, -0.3875, -0.2765, 1.3727, -0.0962, -0.0154, -0.1530, 1.1684);
        assert!((aces - expected).amax() < 3e-4, "{aces}");
        // Rec. 2020 to Rec. 709, ITU-R BT.2087.
        let wide = NAMED[1].1.to_rec_709().unwrap();
        let expected = Matrix3::new(1.6605, -0.5876, -0.0728, -0.1246, 1.1329, -0.0083, -0.0182, -0.1006, 1.1187);
        assert!((wide - expected).amax() < 1e-4, "{wide}");
    }

    #[test]
    fn white_stays_white() {
        for (name, primaries) in NAMED.into_iter().filter(|(_, p)| *p != XYZ) {
            let white = primaries.to_rec_709().unwrap() * Vector3::repeat(1.0);
            // A dozen products and an inverse in f64; measured 4e-16.
            assert!((white - Vector3::repeat(1.0)).amax() < 1e-14, "{name}: {white}");
        }
        // D65 as XYZ.
        let white = XYZ.to_rec_709().unwrap() * Vector3::new(0.3127 / 0.329, 1.0, 0.3583 / 0.329);
        assert!((white - Vector3::repeat(1.0)).amax() < 1e-14, "{white}");
    }
}
