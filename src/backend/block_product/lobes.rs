//! Materials taken apart: one cosine term, and lobes with the errors that few samples make of them.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::Vector3;

use super::bounds::{Checks, Errors, Gauge, Limits, MirrorBounds, WideBounds, offset};
use super::rule::Rule;
use super::tables::Radii;
use crate::scene::{BRDF_VALUE, BlinnPhong, Brdf, CookTorrance, Phong, Structure, Ward};
use crate::{Error, Result};

/// A material as a frame uses it.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Σ albedo/π of the cosine terms that are integrated exactly.
    pub(super) diffuse: Vector3<f64>,
    pub(super) lobes: Vec<Lobe>,
}

impl Plan {
    /// Whether only values are known of a part of it.
    pub(super) fn has_opaque(&self) -> bool {
        self.lobes.iter().any(|lobe| matches!(lobe.model, Model::Other(_)))
    }
}

/// One lobe of a material.
#[derive(Debug, Clone)]
pub(super) struct Lobe {
    pub(super) model: Model,
    pub(super) factor: Vector3<f64>,
    pub(super) sampling: Sampling,
    /// [block]: the errors that the light allows.
    pub(super) checks: Vec<Checks>,
    /// [block]: the least cosines to the mirror direction of a block and of a group of places that count; for Phong.
    pub(super) reach: Vec<f32>,
    pub(super) least: Vec<f32>,
}

impl Lobe {
    fn new(model: Model, factor: Vector3<f64>, sampling: Sampling) -> Self {
        Self { model, factor, sampling, checks: Vec::new(), reach: Vec::new(), least: Vec::new() }
    }

    /// Sets what depends on the light.
    fn weigh(&mut self, limits: &[Limits], radii: Radii) {
        let (Sampling::Mirror { offset, .. } | Sampling::Wide { offset, .. }) = self.sampling else { return };
        self.checks.clear();
        self.checks.extend(limits.iter().map(|limits| limits.checks(offset)));
        let Sampling::Mirror { bounds, exponent, .. } = &self.sampling else { return };
        self.reach.clear();
        self.reach.extend(self.checks.iter().map(|checks| bounds.reach(checks)));
        let factor = self.factor.max();
        self.least.clear();
        self.least.extend(limits.iter().map(|limits| {
            // For all of a group.
            let angle = limits.least_cosine(factor, *exponent, radii.pixel).acos() + radii.group;
            if angle < std::f64::consts::PI { angle.cos() as f32 } else { -1.0 }
        }));
    }
}

/// Whose values.
#[derive(Debug, Clone)]
pub(super) enum Model {
    Lambert,
    Phong(Phong),
    BlinnPhong(BlinnPhong),
    Ward(Ward),
    CookTorrance(CookTorrance),
    Other(Arc<dyn Brdf>),
}

/// How a lobe's samples are chosen.
#[derive(Debug, Clone)]
pub(super) enum Sampling {
    Pixels,
    /// By a Phong exponent; None: one sample.
    Fixed(Option<f64>),
    Mirror {
        bounds: Arc<MirrorBounds>,
        offset: f32,
        exponent: f64,
    },
    Wide {
        bounds: Arc<WideBounds>,
        offset: f32,
    },
}

/// Plans of the materials of the last frame, and tables of errors of all lobes that were met.
#[derive(Debug, Clone)]
pub(super) struct Planner {
    gauge: Gauge,
    rule: Rule,
    brdfs: Vec<Arc<dyn Brdf>>,
    plans: Vec<Plan>,
    edges: HashMap<i32, Arc<Vec<Errors>>>,
    mirror: HashMap<i32, Arc<MirrorBounds>>,
    wide: HashMap<(Kind, [i32; 2]), Arc<WideBounds>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    BlinnPhong,
    Ward,
    CookTorrance,
}

impl Planner {
    pub(super) fn new(gauge: Gauge, rule: Rule) -> Self {
        let (brdfs, plans) = (Vec::new(), Vec::new());
        let (edges, mirror, wide) = (HashMap::new(), HashMap::new(), HashMap::new());
        Self { gauge, rule, brdfs, plans, edges, mirror, wide }
    }

    pub(super) fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Plans for `brdfs`; nothing is done for the same as last time. Returns whether they are new.
    pub(super) fn set(&mut self, brdfs: &[Arc<dyn Brdf>]) -> Result<bool> {
        let same = |(a, b): (&Arc<dyn Brdf>, &Arc<dyn Brdf>)| std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b));
        if brdfs.len() == self.brdfs.len() && brdfs.iter().zip(&self.brdfs).all(same) {
            return Ok(false);
        }
        for (index, brdf) in brdfs.iter().enumerate() {
            if !is_finite(brdf.as_ref()) {
                return Err(Error::NotFinite { what: BRDF_VALUE, index });
            }
        }
        let plans: Result<Vec<Plan>> = brdfs.iter().map(|brdf| self.plan(brdf)).collect();
        self.plans = plans?;
        self.brdfs = brdfs.to_vec();
        Ok(true)
    }

    /// Tells the lobes what the light allows; to be called for a new light and for new plans.
    pub(super) fn weigh(&mut self, limits: &[Limits], radii: Radii) {
        let lobes = self.plans.iter_mut().flat_map(|plan| &mut plan.lobes);
        lobes.for_each(|lobe| lobe.weigh(limits, radii));
    }

    fn plan(&mut self, brdf: &Arc<dyn Brdf>) -> Result<Plan> {
        let mut plan = Plan { diffuse: Vector3::zeros(), lobes: Vec::new() };
        self.take_apart(brdf, 1.0, &mut plan)?;
        Ok(plan)
    }

    fn take_apart(&mut self, brdf: &Arc<dyn Brdf>, weight: f64, plan: &mut Plan) -> Result<()> {
        let (model, factor) = match brdf.structure() {
            Structure::Sum(terms) => {
                return terms.iter().try_for_each(|(w, brdf)| self.take_apart(brdf, weight * w, plan));
            }
            Structure::Lambert(lambert) => {
                if let Rule::Bounded { .. } = self.rule {
                    plan.diffuse += lambert.factor() * weight;
                    return Ok(());
                }
                (Model::Lambert, lambert.factor())
            }
            Structure::Phong(phong) => (Model::Phong(*phong), phong.factor()),
            Structure::BlinnPhong(phong) => (Model::BlinnPhong(*phong), phong.factor()),
            Structure::Ward(ward) => (Model::Ward(*ward), ward.factor()),
            Structure::CookTorrance(ggx) => (Model::CookTorrance(*ggx), Vector3::repeat(ggx.constant())),
            Structure::Opaque => (Model::Other(Arc::clone(brdf)), Vector3::repeat(1.0)),
        };
        let factor = factor * weight;
        if factor.max() > 0.0 {
            let sampling = self.sampling(&model, factor.max(), weight)?;
            plan.lobes.push(Lobe::new(model, factor, sampling));
        }
        Ok(())
    }

    fn sampling(&mut self, model: &Model, factor: f64, weight: f64) -> Result<Sampling> {
        match self.rule {
            Rule::Pixels => Ok(Sampling::Pixels),
            Rule::Fixed { .. } => Ok(Sampling::Fixed(equivalent_exponent(model))),
            Rule::Bounded { .. } => Ok(match model {
                // Cosines are not lobes under this rule.
                Model::Lambert => Sampling::Pixels,
                Model::Phong(phong) => Sampling::Mirror {
                    bounds: self.mirror(phong.exponent()),
                    offset: offset(factor),
                    exponent: phong.exponent(),
                },
                Model::Other(brdf) => {
                    let bounds = Arc::new(WideBounds::new(&self.gauge, brdf.as_ref(), brdf.is_isotropic()));
                    Sampling::Wide { bounds, offset: offset(weight) }
                }
                Model::BlinnPhong(phong) => {
                    let at = exponent_index(phong.exponent());
                    let bounds = self.wide(Kind::BlinnPhong, [at, at])?;
                    Sampling::Wide { bounds, offset: offset(weight * phong.albedo().max()) }
                }
                Model::Ward(ward) => {
                    let bounds = self.wide(Kind::Ward, ward.alpha().map(alpha_index))?;
                    Sampling::Wide { bounds, offset: offset(weight * ward.albedo().max()) }
                }
                Model::CookTorrance(ggx) => {
                    let bounds = self.wide(Kind::CookTorrance, ggx.alpha().map(alpha_index))?;
                    Sampling::Wide { bounds, offset: offset(weight) }
                }
            }),
        }
    }

    /// Errors of a lobe of this exponent, from those of the exponents below and above it on a grid of eighths of an octave.
    fn mirror(&mut self, exponent: f64) -> Arc<MirrorBounds> {
        let at = exponent_index(exponent);
        if let Some(bounds) = self.mirror.get(&at) {
            return Arc::clone(bounds);
        }
        let gauge = &self.gauge;
        let mut edges = |at: i32| {
            let make = || Arc::new(MirrorBounds::edges(gauge, exponent_at(at)));
            Arc::clone(self.edges.entry(at).or_insert_with(make))
        };
        let bounds = Arc::new(MirrorBounds::between(&edges(at), &edges(at + 1)));
        self.mirror.insert(at, Arc::clone(&bounds));
        bounds
    }

    /// The same for a lobe about the half vector, over the corners of a cell of its parameters.
    fn wide(&mut self, kind: Kind, at: [i32; 2]) -> Result<Arc<WideBounds>> {
        if let Some(bounds) = self.wide.get(&(kind, at)) {
            return Ok(Arc::clone(bounds));
        }
        let ends = if at[0] == at[1] { vec![at, at.map(|i| i + 1)] } else { corners(at) };
        let mut all: Option<WideBounds> = None;
        for [u, v] in ends {
            let (ax, ay) = (alpha_at(u), alpha_at(v));
            let white = Vector3::repeat(1.0);
            let models: Vec<Box<dyn Brdf>> = match kind {
                Kind::BlinnPhong => vec![Box::new(BlinnPhong::new(white, exponent_at(u))?)],
                Kind::Ward => vec![Box::new(Ward::new(white, ax, ay)?)],
                // A reflectance between 0 and 1 lies between these two.
                Kind::CookTorrance => {
                    vec![Box::new(CookTorrance::new(white, ax, ay)?), Box::new(CookTorrance::new([0.0; 3], ax, ay)?)]
                }
            };
            for model in models {
                let bounds = WideBounds::new(&self.gauge, model.as_ref(), at[0] == at[1]);
                all = Some(match all {
                    Some(all) => all.worse(&bounds),
                    None => bounds,
                });
            }
        }
        let bounds = Arc::new(all.expect("a cell has corners"));
        self.wide.insert((kind, at), Arc::clone(&bounds));
        Ok(bounds)
    }
}

/// Whether a BRDF of which only values are known is finite wherever some thousands of them are asked for; the others are.
fn is_finite(brdf: &dyn Brdf) -> bool {
    if !matches!(brdf.structure(), Structure::Opaque | Structure::Sum(_)) {
        return true;
    }
    // Rings from the zenith to just above the horizon, of odd numbers of directions: no plane of symmetry holds all.
    let rings = |rings: usize, around: usize| {
        (0..rings * around).map(move |i| {
            let z = 1.0 - (i / around) as f64 / rings as f64 * 0.999;
            let (sin, cos) = ((i % around) as f64 / around as f64 * std::f64::consts::TAU + 0.1).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            Vector3::new(flat * cos, flat * sin, z)
        })
    };
    rings(4, 7).all(|wo| rings(10, 15).all(|wi| brdf.eval(&wi, &wo).iter().all(|c| c.is_finite())))
}

fn corners([u, v]: [i32; 2]) -> Vec<[i32; 2]> {
    vec![[u, v], [u + 1, v], [u, v + 1], [u + 1, v + 1]]
}

/// Exponents 0, 1/8, …, 1, 2^(1/8), 2^(2/8), ….
fn exponent_at(index: i32) -> f64 {
    if index <= 8 { f64::from(index.max(0)) / 8.0 } else { (f64::from(index - 8) / 8.0).exp2() }.min(1e7)
}

fn exponent_index(exponent: f64) -> i32 {
    if exponent < 1.0 { (exponent * 8.0) as i32 } else { 8 + (exponent.log2() * 8.0).floor() as i32 }
}

/// Roughnesses 2^(k/4) in [1e-4, 1].
fn alpha_at(index: i32) -> f64 {
    (f64::from(index) / 4.0).exp2().clamp(1e-4, 1.0)
}

fn alpha_index(alpha: f64) -> i32 {
    (alpha.log2() * 4.0).floor() as i32
}

/// The exponent of a Phong lobe about as wide, for the fixed rule; None: as smooth as a cosine.
fn equivalent_exponent(model: &Model) -> Option<f64> {
    // A half vector turns half as far as the direction: exponents are four times as large for the same width.
    let rough = |alpha: [f64; 2]| 0.5 / alpha[0].min(alpha[1]).powi(2);
    match model {
        Model::Lambert | Model::Other(_) => None,
        Model::Phong(phong) => Some(phong.exponent()),
        Model::BlinnPhong(phong) => Some(phong.exponent() / 4.0),
        Model::Ward(ward) => Some(rough(ward.alpha())),
        Model::CookTorrance(ggx) => Some(rough(ggx.alpha())),
    }
}
