//! BRDFs from command-line strings.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use nalgebra::Vector3;

use super::{AshikhminShirley, Beckmann, BlinnPhong, Brdf, CookTorrance, Lambert, Merl, OrenNayar, Phong, Sum, Ward};
use crate::{Error, Result};

/// A BRDF as a command line names it.
///
/// | form | model |
/// |---|---|
/// | `lambert:ALBEDO` | [`Lambert`] |
/// | `phong:N[:ALBEDO]`, `blinn-phong:N[:ALBEDO]` | [`Phong`], [`BlinnPhong`] of exponent N |
/// | `ward:ALPHA[:ALPHA_Y[:ALBEDO]]` | [`Ward`] |
/// | `ggx:ALPHA[:ALPHA_Y[:F0]]` | [`CookTorrance`], F0 = 1 unless given |
/// | `beckmann:M[:F0]` | [`Beckmann`], F0 = 1 unless given |
/// | `oren-nayar:SIGMA[:ALBEDO]` | [`OrenNayar`], SIGMA in radians |
/// | `ashikhmin:N_U[:N_V[:R_S]]` | [`AshikhminShirley`] without its diffuse term, R_S = 1 unless given |
/// | `merl:FILE` | [`Merl`]; FILE is the rest of the string |
///
/// An albedo is one number or three, `0.8,0.3,0.2`. Forms joined by `+` are summed; one without an albedo (`ggx`,
/// `beckmann` and `ashikhmin` always) gets in equal shares what the others leave of 1, so that a sum never reflects
/// more than it gets.
///
/// # Example
/// ```
/// use haarmonic::scene::{Brdf, BrdfSpec};
/// let spec: BrdfSpec = "phong:50+lambert:0.4".parse()?;
/// let brdf = spec.build()?;
/// let up = nalgebra::Vector3::z();
/// let value = brdf.eval(&up, &up).x;
/// let expected = (0.4 + 0.6 * 52.0 / 2.0) / std::f64::consts::PI;
/// assert!((value - expected).abs() < 1e-12);
/// # use haarmonic::nalgebra;
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfSpec {
    text: String,
    source: Source,
}

#[derive(Debug, Clone, PartialEq)]
enum Source {
    File(PathBuf),
    Parts(Vec<Part>),
}

#[derive(Debug, Clone, PartialEq)]
struct Part {
    model: Model,
    /// `None`: a share of what the others leave.
    albedo: Option<Vector3<f64>>,
}

#[derive(Debug, Clone, PartialEq)]
enum Model {
    Lambert,
    Phong(f64),
    BlinnPhong(f64),
    Ward([f64; 2]),
    Ggx([f64; 2], Vector3<f64>),
    Beckmann(f64, Vector3<f64>),
    OrenNayar(f64),
    Ashikhmin([f64; 2], Vector3<f64>),
}

impl BrdfSpec {
    /// The forms, one line, for help texts.
    pub const FORMS: &'static str = "lambert:ALBEDO, phong:N[:ALBEDO], blinn-phong:N[:ALBEDO], \
        ward:ALPHA[:ALPHA_Y[:ALBEDO]], ggx:ALPHA[:ALPHA_Y[:F0]], beckmann:M[:F0], oren-nayar:SIGMA[:ALBEDO], ashikhmin:N_U[:N_V[:R_S]], merl:FILE; an albedo, F0 \
        or R_S is one number or three (0.8,0.3,0.2); all but merl can be joined by +";

    /// Makes the BRDF; `merl:FILE` is read here.
    ///
    /// # Errors
    /// Those of the models' constructors and of [`Merl::open`].
    pub fn build(&self) -> Result<Arc<dyn Brdf>> {
        let parts = match &self.source {
            Source::File(path) => return Ok(Arc::new(Merl::open(path)?)),
            Source::Parts(parts) => parts,
        };
        let given: Vector3<f64> = parts.iter().filter_map(|p| p.albedo).sum();
        let open = parts.iter().filter(|p| p.albedo.is_none()).count();
        let share = if open > 0 { ((1.0 - given.max()) / open as f64).clamp(0.0, 1.0) } else { 0.0 };
        if let [part] = parts.as_slice() {
            return part.build(share).map(|(_, brdf)| brdf);
        }
        Ok(Arc::new(Sum::new(parts.iter().map(|p| p.build(share)).collect::<Result<_>>()?)?))
    }
}

impl Part {
    /// Weight and BRDF.
    fn build(&self, share: f64) -> Result<(f64, Arc<dyn Brdf>)> {
        let albedo = self.albedo.unwrap_or_else(|| Vector3::repeat(share));
        Ok(match &self.model {
            Model::Lambert => (1.0, Arc::new(Lambert::new(albedo)?)),
            Model::Phong(n) => (1.0, Arc::new(Phong::new(albedo, *n)?)),
            Model::BlinnPhong(n) => (1.0, Arc::new(BlinnPhong::new(albedo, *n)?)),
            Model::Ward([x, y]) => (1.0, Arc::new(Ward::new(albedo, *x, *y)?)),
            Model::Ggx([x, y], f0) => (share, Arc::new(CookTorrance::new(*f0, *x, *y)?)),
            Model::Beckmann(m, f0) => (share, Arc::new(Beckmann::new(*f0, *m)?)),
            Model::OrenNayar(sigma) => (1.0, Arc::new(OrenNayar::new(albedo, *sigma)?)),
            Model::Ashikhmin([u, v], rs) => (share, Arc::new(AshikhminShirley::new([0.0; 3], *rs, *u, *v)?)),
        })
    }
}

impl fmt::Display for BrdfSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for BrdfSpec {
    type Err = Error;

    /// Reads one of the forms and checks its numbers; opens no file.
    ///
    /// # Errors
    /// [`Error::Syntax`] that says what is wrong and lists the forms.
    fn from_str(text: &str) -> Result<Self> {
        let fail = |reason: String| Error::Syntax {
            what: "BRDF",
            given: text.to_owned(),
            reason: format!("{reason}; the forms are {}", Self::FORMS),
        };
        if let Some(file) = text.strip_prefix("merl:") {
            if file.is_empty() {
                return Err(fail("merl: needs a file name".into()));
            }
            return Ok(Self { text: text.to_owned(), source: Source::File(file.into()) });
        }
        let parts = text.split('+').map(parse_part).collect::<Result<Vec<_>, String>>().map_err(fail)?;
        let given: Vector3<f64> = parts.iter().filter_map(|p| p.albedo).sum();
        let rounding = 1e-12;
        if given.max() > 1.0 + rounding {
            return Err(fail(format!("its parts reflect {} in all, more than 1", given.max())));
        }
        if given.max() >= 1.0 && parts.iter().any(|p| p.albedo.is_none()) {
            return Err(fail("its parts with an albedo leave nothing for those without one".into()));
        }
        let spec = Self { text: text.to_owned(), source: Source::Parts(parts) };
        // Builds it once, so that a number out of range is found here; nothing is read.
        spec.build().map_err(|e| fail(e.to_string()))?;
        Ok(spec)
    }
}

fn parse_part(text: &str) -> Result<Part, String> {
    let text = text.trim();
    let mut fields = text.split(':');
    let name = fields.next().unwrap_or_default();
    let fields: Vec<&str> = fields.collect();
    let count = |allowed: std::ops::RangeInclusive<usize>| {
        if allowed.contains(&fields.len()) {
            return Ok(());
        }
        let (low, high) = allowed.into_inner();
        let range = if low == high { format!("{low}") } else { format!("{low} to {high}") };
        Err(format!("{name} takes {range} parameters, '{text}' has {}", fields.len()))
    };
    let rgb = |i: usize| fields.get(i).map(|f| parse_rgb(f)).transpose();
    let lobe = || -> Result<[f64; 2], String> {
        let first = parse_number(fields[0])?;
        Ok([first, fields.get(1).map_or(Ok(first), |f| parse_number(f))?])
    };
    let white = Vector3::repeat(1.0);
    let (model, albedo) = match name {
        "lambert" => {
            count(1..=1)?;
            (Model::Lambert, rgb(0)?)
        }
        "phong" => {
            count(1..=2)?;
            (Model::Phong(parse_number(fields[0])?), rgb(1)?)
        }
        "blinn-phong" => {
            count(1..=2)?;
            (Model::BlinnPhong(parse_number(fields[0])?), rgb(1)?)
        }
        "ward" => {
            count(1..=3)?;
            (Model::Ward(lobe()?), rgb(2)?)
        }
        "ggx" => {
            count(1..=3)?;
            (Model::Ggx(lobe()?, rgb(2)?.unwrap_or(white)), None)
        }
        "beckmann" => {
            count(1..=2)?;
            (Model::Beckmann(parse_number(fields[0])?, rgb(1)?.unwrap_or(white)), None)
        }
        "oren-nayar" => {
            count(1..=2)?;
            (Model::OrenNayar(parse_number(fields[0])?), rgb(1)?)
        }
        "ashikhmin" => {
            count(1..=3)?;
            (Model::Ashikhmin(lobe()?, rgb(2)?.unwrap_or(white)), None)
        }
        "merl" => return Err("merl:FILE cannot be summed".into()),
        "" => return Err("a part is empty".into()),
        _ => return Err(format!("there is no model '{name}'")),
    };
    Ok(Part { model, albedo })
}

fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("'{text}' is not finite")),
        Err(_) => Err(format!("'{text}' is not a number")),
    }
}

fn parse_rgb(text: &str) -> Result<Vector3<f64>, String> {
    let numbers = text.split(',').map(parse_number).collect::<Result<Vec<_>, _>>()?;
    match numbers.as_slice() {
        [grey] => Ok(Vector3::repeat(*grey)),
        [r, g, b] => Ok(Vector3::new(*r, *g, *b)),
        _ => Err(format!("'{text}' has {} numbers, an albedo has 1 or 3", numbers.len())),
    }
}
