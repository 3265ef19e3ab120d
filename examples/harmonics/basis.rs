//! The basis on spheres: a row for each degree.

use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::sh::{Basis, index};

use crate::support::Failure;
use crate::support::sheet::{DARK, Panel, Sheet};

const BANDS: usize = 5;
const SIZE: usize = 96;
/// The value that is drawn in full colour.
const FULL: f64 = 1.0;

/// Orange where a function is positive, blue where it is negative; +z upwards, +x towards the reader, turned a little.
pub fn draw() -> Result<Sheet, Failure> {
    let basis = Basis::<f64>::new(BANDS)?;
    let turn = Rotation3::from_euler_angles(0.0, 0.45, 0.0) * Rotation3::from_euler_angles(0.0, 0.0, -0.6);
    let mut rows: Vec<Vec<Option<Panel>>> = Vec::new();
    for l in 0..BANDS as isize {
        let cell = |column: isize| {
            let m = column - (BANDS as isize - 1);
            (m.abs() <= l).then(|| ball(&basis, &turn, l as usize, m))
        };
        rows.push((0..2 * BANDS as isize - 1).map(cell).collect());
    }
    Ok(Sheet::new("Real spherical harmonics y(l, m): orange positive, blue negative; +z up", &rows))
}

fn ball(basis: &Basis<f64>, turn: &Rotation3<f64>, l: usize, m: isize) -> Panel {
    let mut y = vec![0.0; basis.coefficient_count()];
    let pixels = (0..SIZE * SIZE).map(|i| {
        let at = |k: usize| (k as f64 + 0.5) / (0.5 * SIZE as f64) - 1.0;
        let (right, up) = (at(i % SIZE), -at(i / SIZE));
        let near = 1.0 - right * right - up * up;
        if near < 0.0 {
            return DARK;
        }
        let seen = Vector3::new(near.sqrt(), right, up);
        basis.eval(&turn.inverse_transform_vector(&seen), &mut y);
        shade(y[index(l, m)] / FULL, 0.55 + 0.45 * near.sqrt())
    });
    let pixels = pixels.collect();
    Panel { caption: vec![format!("{l}, {m}").replace('-', "−")], width: SIZE, height: SIZE, pixels }
}

/// From grey at 0 to a hue at ±1.
fn shade(value: f64, light: f64) -> [u8; 3] {
    let hue = if value > 0.0 { [255.0, 150.0, 30.0] } else { [40.0, 120.0, 255.0] };
    let t = value.abs().min(1.0).sqrt();
    hue.map(|h| (light * (70.0 + t * (h - 70.0))) as u8)
}
