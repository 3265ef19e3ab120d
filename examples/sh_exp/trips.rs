//! From visibility to its logarithm and back.

use haarmonic::sh::{ExpMethod, Exponential, LogMethod, Logarithm};
use serde_json::{Value, json};

use crate::measure::relative;
use crate::scenes::{BANDS, Scenes, disc};
use crate::support::{Failure, table};

const METHODS: [(&str, LogMethod, ExpMethod); 3] = [
    ("eigenvalues, then PS*-2", LogMethod::Eigenvalues { floor: 0.02 }, ExpMethod::ScaledSeries { degree: 2 }),
    ("eigenvalues, then exp(M)1", LogMethod::Eigenvalues { floor: 0.02 }, ExpMethod::Eigen),
    ("clipped values, then grid", LogMethod::Clipped { floor: 0.02 }, ExpMethod::Grid),
];
/// Half angles of the single discs: below and above where eigenvalues come to be clipped.
const ANGLES: [f64; 3] = [0.2, 0.5, 1.0];

/// Mean errors: for each bands and method, of each disc and of the unions.
pub struct Trips {
    rows: Vec<(usize, &'static str, [f64; 4])>,
}

/// Measures them.
pub fn measure(scenes: &Scenes) -> Result<Trips, Failure> {
    let mut rows = Vec::new();
    for bands in BANDS {
        for (name, log, exp) in METHODS {
            let (log, exp) = (Logarithm::new(bands, log)?, Exponential::<f64>::new(bands, exp)?);
            let trip = |g: &[f64]| -> Result<f64, Failure> {
                let (mut f, mut back) = (vec![0.0; g.len()], vec![0.0; g.len()]);
                log.apply(g, &mut f)?;
                exp.apply(&f, &mut back);
                Ok(relative(&back, g))
            };
            let mut errors = [0.0; 4];
            for (error, angle) in errors.iter_mut().zip(ANGLES) {
                let mut g = vec![0.0; bands * bands];
                disc(bands, angle).into_iter().enumerate().for_each(|(l, x)| g[l * l + l] = x);
                *error = trip(&g)?;
            }
            let count = scenes.len().min(64);
            for k in 0..count {
                errors[3] += trip(scenes.visibility(k, bands))? / count as f64;
            }
            rows.push((bands, name, errors));
        }
    }
    Ok(Trips { rows })
}

impl Trips {
    pub fn table(&self) -> String {
        let mut header = vec!["bands".to_owned(), "log, then exp".to_owned()];
        header.extend(ANGLES.map(|angle| format!("{angle} rad")));
        header.push("unions".to_owned());
        let row = |(bands, name, errors): &(usize, &str, [f64; 4])| {
            let mut cells = vec![bands.to_string(), (*name).to_owned()];
            cells.extend(errors.map(|e| format!("{e:.1e}")));
            cells
        };
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        table::format(&header, &self.rows.iter().map(row).collect::<Vec<_>>())
    }

    pub fn report(&self) -> Value {
        let row = |(bands, name, [a, b, c, unions]): &(usize, &str, [f64; 4])| json!({ "bands": bands, "methods": name, "disc_angles": ANGLES, "disc_errors": [a, b, c], "unions_error": unions });
        json!(self.rows.iter().map(row).collect::<Vec<_>>())
    }
}
