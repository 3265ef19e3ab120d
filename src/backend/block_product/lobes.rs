//! Materials taken apart: one cosine term, and lobes with the errors that few samples make of them.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::Vector3;

use super::bounds::{Checks, Errors, Gauge, Limits, MirrorBounds, Symmetry, WideBounds, WideNodes, local_axes, offset};
use super::rule::Rule;
use super::tables::Radii;
use crate::Result;
use crate::scene::{BlinnPhong, Brdf, CookTorrance, Eval, Materials, Phong, Reflectance, Structure, Ward};

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
            // The limit must hold for every pixel of a group, so the angle grows by the group's radius.
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
    nodes: HashMap<(Kind, Corner), Arc<WideNodes>>,
    wide: HashMap<(Kind, Parameters), Arc<WideBounds>>,
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
        let (edges, mirror, nodes, wide) = (HashMap::new(), HashMap::new(), HashMap::new(), HashMap::new());
        Self { gauge, rule, brdfs, plans, edges, mirror, nodes, wide }
    }

    /// [block]: the group of its shape.
    pub(super) fn groups(&self) -> &[u8] {
        self.gauge.groups()
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
                return Err(Materials::part_not_finite(index));
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
                    let (axes, brdf) = (local_axes(), brdf.as_ref());
                    let symmetry = if is_isotropic(brdf) { Symmetry::Turned } else { Symmetry::None };
                    let nodes = WideNodes::measure(&self.gauge, symmetry, |wo| Eval { brdf, axes: &axes, wo: *wo });
                    Sampling::Wide { bounds: Arc::new(WideBounds::new(&nodes)), offset: offset(weight) }
                }
                Model::BlinnPhong(phong) => {
                    let bounds = self.wide(Kind::BlinnPhong, Parameters::exponent(phong.exponent()))?;
                    Sampling::Wide { bounds, offset: offset(factor) }
                }
                Model::Ward(ward) => {
                    let bounds = self.wide(Kind::Ward, Parameters::roughness(ward.alpha()))?;
                    Sampling::Wide { bounds, offset: offset(factor) }
                }
                Model::CookTorrance(ggx) => {
                    let parameters = Parameters::roughness(ggx.alpha()).reflecting(&ggx.f0());
                    let bounds = self.wide(Kind::CookTorrance, parameters)?;
                    Sampling::Wide { bounds, offset: offset(factor) }
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
    fn wide(&mut self, kind: Kind, cell: Parameters) -> Result<Arc<WideBounds>> {
        if let Some(bounds) = self.wide.get(&(kind, cell)) {
            return Ok(Arc::clone(bounds));
        }
        let mut all: Option<WideNodes> = None;
        for corner in cell.corners() {
            let nodes = self.nodes(kind, corner)?;
            all = Some(match all {
                Some(all) => all.worse(&nodes),
                None => WideNodes::clone(&nodes),
            });
        }
        let bounds = Arc::new(WideBounds::new(&all.expect("a cell has corners")));
        self.wide.insert((kind, cell), Arc::clone(&bounds));
        Ok(bounds)
    }

    /// Errors at a corner; kept only if they are few.
    fn nodes(&mut self, kind: Kind, corner: Corner) -> Result<Arc<WideNodes>> {
        if let Some(nodes) = self.nodes.get(&(kind, corner)) {
            return Ok(Arc::clone(nodes));
        }
        let Corner { across: [u, v], f0, symmetry } = corner;
        let (axes, gauge) = (local_axes(), &self.gauge);
        let white = Vector3::repeat(1.0);
        const ABOVE: &str = "tables have no viewer at or below the horizon";
        let nodes = match kind {
            Kind::BlinnPhong => {
                let model = BlinnPhong::new(white, exponent_at(u))?;
                WideNodes::measure(gauge, symmetry, |wo| model.kernel(&axes, wo).expect(ABOVE))
            }
            Kind::Ward => {
                let model = Ward::new(white, alpha_at(u, symmetry), alpha_at(v, symmetry))?;
                WideNodes::measure(gauge, symmetry, |wo| model.kernel(&axes, wo).expect(ABOVE))
            }
            Kind::CookTorrance => {
                let model = CookTorrance::new([f0_at(f0); 3], alpha_at(u, symmetry), alpha_at(v, symmetry))?;
                WideNodes::measure(gauge, symmetry, |wo| match model.facets(&axes, wo).expect(ABOVE) {
                    Reflectance::Grey(kernel) => kernel,
                    Reflectance::Coloured(_) => unreachable!("three equal channels are grey"),
                })
            }
        };
        let nodes = Arc::new(nodes);
        if symmetry == Symmetry::Turned {
            self.nodes.insert((kind, corner), Arc::clone(&nodes));
        }
        Ok(nodes)
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

/// A cell of the parameters of lobes about the half vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Parameters {
    /// Exponents or roughnesses.
    lowest: [i32; 2],
    highest: [i32; 2],
    /// Reflectances at normal incidence: of the channels' least and largest.
    f0: [i32; 2],
    symmetry: Symmetry,
}

/// A corner of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    across: [i32; 2],
    f0: i32,
    symmetry: Symmetry,
}

impl Parameters {
    fn exponent(exponent: f64) -> Self {
        let at = exponent_index(exponent);
        Self { lowest: [at; 2], highest: [at + 1; 2], f0: [0; 2], symmetry: Symmetry::Turned }
    }

    /// Sixteenths of an octave if isotropic, quarters if not.
    fn roughness(alpha: [f64; 2]) -> Self {
        let symmetry = if alpha[0] == alpha[1] { Symmetry::Turned } else { Symmetry::Mirrored };
        let end = |round: fn(f64) -> f64| alpha.map(|alpha| round(alpha.log2() * steps(symmetry)) as i32);
        Self { lowest: end(f64::floor), highest: end(f64::ceil), f0: [0; 2], symmetry }
    }

    /// The lobe is linear in the reflectance at normal incidence, so that a norm of its error is largest at an end.
    fn reflecting(self, f0: &Vector3<f64>) -> Self {
        Self { f0: [f0_index(f0.min(), f64::floor), f0_index(f0.max(), f64::ceil)], ..self }
    }

    fn corners(self) -> Vec<Corner> {
        let Self { lowest, highest, symmetry, .. } = self;
        let mut across: Vec<[i32; 2]> = match symmetry {
            Symmetry::Turned => vec![lowest, highest],
            _ => [lowest[0], highest[0]].iter().flat_map(|&u| [[u, lowest[1]], [u, highest[1]]]).collect(),
        };
        let mut f0 = self.f0.to_vec();
        across.sort_unstable();
        across.dedup();
        f0.dedup();
        across.iter().flat_map(|&across| f0.iter().map(move |&f0| Corner { across, f0, symmetry })).collect()
    }
}

/// Reflectances 0, 2⁻⁸, … 2^(−1/2), 1.
fn f0_at(index: i32) -> f64 {
    if index < LEAST_F0 { 0.0 } else { (f64::from(index) / 2.0).exp2() }
}

fn f0_index(f0: f64, round: fn(f64) -> f64) -> i32 {
    (round(f0.log2() * 2.0)).max(f64::from(LEAST_F0 - 1)) as i32
}

const LEAST_F0: i32 = -16;

/// Whether a BRDF says that it is isotropic, or is so wherever it is looked at: a closure says nothing.
fn is_isotropic(brdf: &dyn Brdf) -> bool {
    const PAIRS: usize = 2048;
    let direction = |i: usize| {
        // Points of the golden spiral, of equal solid angle each.
        let (z, azimuth) = ((i % PAIRS) as f64 + 0.5, i as f64 * 2.399_963_229_728_653);
        let z = 1.0 - z / PAIRS as f64;
        let flat = (1.0 - z * z).sqrt();
        Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), z)
    };
    let is_same = |i: usize| {
        let (wi, wo) = (direction(i), direction(i * 1_237 + 511));
        let (s, c) = (1.0 + i as f64).sin_cos();
        let turned = |d: &Vector3<f64>| Vector3::new(c * d.x - s * d.y, s * d.x + c * d.y, d.z);
        let mirrored = |d: &Vector3<f64>| Vector3::new(d.x, -d.y, d.z);
        let value = brdf.eval(&wi, &wo);
        let is_near = |other: Vector3<f64>| (other - value).amax() <= 1e-9 * value.amax();
        is_near(brdf.eval(&turned(&wi), &turned(&wo))) && is_near(brdf.eval(&mirrored(&wi), &mirrored(&wo)))
    };
    brdf.is_isotropic() || (0..PAIRS).all(is_same)
}

/// Exponents 0, 1/8, …, 1, 2^(1/8), 2^(2/8), ….
fn exponent_at(index: i32) -> f64 {
    if index <= 8 { f64::from(index.max(0)) / 8.0 } else { (f64::from(index - 8) / 8.0).exp2() }.min(1e7)
}

fn exponent_index(exponent: f64) -> i32 {
    if exponent < 1.0 { (exponent * 8.0) as i32 } else { 8 + (exponent.log2() * 8.0).floor() as i32 }
}

/// Roughnesses of a grid, per octave.
fn steps(symmetry: Symmetry) -> f64 {
    if symmetry == Symmetry::Turned { 16.0 } else { 4.0 }
}

/// Roughnesses 2^(k/steps) in [1e-4, 1].
fn alpha_at(index: i32, symmetry: Symmetry) -> f64 {
    (f64::from(index) / steps(symmetry)).exp2().clamp(1e-4, 1.0)
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
