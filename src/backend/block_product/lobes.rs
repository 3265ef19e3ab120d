//! Materials taken apart: one cosine term, and lobes with the errors that few samples make of them.

use std::collections::HashMap;
use std::mem::{Discriminant, discriminant};
use std::sync::Arc;

use nalgebra::Vector3;

use super::bounds::{Checks, Errors, Gauge, Limits, MirrorBounds, Symmetry, WideBounds, WideNodes, offset};
use super::parameters::{Corner, Parameters, exponent_at, exponent_index};
use super::rule::Rule;
use super::source::{LobeSource, is_finite, is_isotropic};
use super::tables::Radii;
use crate::Result;
use crate::scene::{Brdf, Lobe, Materials, Shape, Structure};

/// A material as a frame uses it.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Σ albedo/π of the cosine terms that are integrated exactly.
    pub(super) diffuse: Vector3<f64>,
    pub(super) lobes: Vec<PlannedLobe>,
}

impl Plan {
    /// Whether only values are known of a part of it.
    pub(super) fn has_opaque(&self) -> bool {
        self.lobes.iter().any(|lobe| lobe.source.is_opaque())
    }
}

/// One lobe of a material.
#[derive(Debug, Clone)]
pub(super) struct PlannedLobe {
    pub(super) source: LobeSource,
    pub(super) factor: Vector3<f64>,
    pub(super) sampling: Sampling,
    /// [block]: the errors that the light allows.
    pub(super) checks: Vec<Checks>,
    /// [block]: the least cosines to the mirror direction of a block and of a tile that count; for Phong.
    pub(super) reach: Vec<f32>,
    pub(super) least: Vec<f32>,
}

impl PlannedLobe {
    fn new(source: LobeSource, factor: Vector3<f64>, sampling: Sampling) -> Self {
        Self { source, factor, sampling, checks: Vec::new(), reach: Vec::new(), least: Vec::new() }
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
            // The limit must hold for every pixel of a tile, so the angle grows by the tile's radius.
            let angle = limits.least_cosine(factor, *exponent, radii.pixel).acos() + radii.tile;
            if angle < std::f64::consts::PI { angle.cos() as f32 } else { -1.0 }
        }));
    }
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
    nodes: HashMap<(Discriminant<Lobe>, Corner), Arc<WideNodes>>,
    wide: HashMap<(Discriminant<Lobe>, Parameters), Arc<WideBounds>>,
}

impl Planner {
    pub(super) fn new(gauge: Gauge, rule: Rule) -> Self {
        let (brdfs, plans) = (Vec::new(), Vec::new());
        let (edges, mirror, nodes, wide) = (HashMap::new(), HashMap::new(), HashMap::new(), HashMap::new());
        Self { gauge, rule, brdfs, plans, edges, mirror, nodes, wide }
    }

    /// [block]: the family of its shape.
    pub(super) fn families(&self) -> &[u8] {
        self.gauge.families()
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
        let (source, factor) = match brdf.structure() {
            Structure::Sum(terms) => {
                return terms.iter().try_for_each(|(w, brdf)| self.take_apart(brdf, weight * w, plan));
            }
            Structure::Lobe(lobe) => {
                if matches!((self.rule, lobe.shape()), (Rule::Bounded { .. }, Shape::Cosine)) {
                    plan.diffuse += lobe.factor() * weight;
                    return Ok(());
                }
                (LobeSource::Known(lobe), lobe.factor())
            }
            Structure::Opaque => (LobeSource::Opaque(Arc::clone(brdf)), Vector3::repeat(1.0)),
        };
        let factor = factor * weight;
        if factor.max() > 0.0 {
            let sampling = self.sampling(&source, factor.max())?;
            plan.lobes.push(PlannedLobe::new(source, factor, sampling));
        }
        Ok(())
    }

    fn sampling(&mut self, source: &LobeSource, factor: f64) -> Result<Sampling> {
        match self.rule {
            Rule::Pixels => Ok(Sampling::Pixels),
            Rule::Fixed { .. } => Ok(Sampling::Fixed(source.equivalent_exponent())),
            Rule::Bounded { .. } => {
                let offset = offset(factor);
                Ok(match source {
                    LobeSource::Opaque(brdf) => {
                        let symmetry = if is_isotropic(brdf.as_ref()) { Symmetry::Turned } else { Symmetry::None };
                        let nodes = WideNodes::measure(&self.gauge, symmetry, source);
                        Sampling::Wide { bounds: Arc::new(WideBounds::new(&nodes)), offset }
                    }
                    LobeSource::Known(lobe) => match lobe.shape() {
                        Shape::Mirror { exponent } => {
                            Sampling::Mirror { bounds: self.mirror(exponent), offset, exponent }
                        }
                        _ => Sampling::Wide { bounds: self.wide(lobe)?, offset },
                    },
                })
            }
        }
    }

    /// Errors of a lobe of this exponent, from those of the exponents below and above it on a grid of eighths of an
    /// octave.
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

    /// The same for any other lobe, over the corners of the cell of its parameters.
    fn wide(&mut self, lobe: &Lobe) -> Result<Arc<WideBounds>> {
        let (model, cell) = (discriminant(lobe), Parameters::of(lobe.shape()));
        if let Some(bounds) = self.wide.get(&(model, cell)) {
            return Ok(Arc::clone(bounds));
        }
        let mut all: Option<WideNodes> = None;
        for corner in cell.corners() {
            let nodes = self.nodes(lobe, corner)?;
            all = Some(match all {
                Some(all) => all.worse(&nodes),
                None => WideNodes::clone(&nodes),
            });
        }
        let bounds = Arc::new(WideBounds::new(&all.expect("a cell has corners")));
        self.wide.insert((model, cell), Arc::clone(&bounds));
        Ok(bounds)
    }

    /// Errors at a corner; kept only if they are few.
    fn nodes(&mut self, lobe: &Lobe, corner: Corner) -> Result<Arc<WideNodes>> {
        let key = (discriminant(lobe), corner);
        if let Some(nodes) = self.nodes.get(&key) {
            return Ok(Arc::clone(nodes));
        }
        let source = LobeSource::Known(lobe.reshaped(corner.shape(lobe.shape()))?);
        let nodes = Arc::new(WideNodes::measure(&self.gauge, corner.symmetry, &source));
        if corner.symmetry == Symmetry::Turned {
            self.nodes.insert(key, Arc::clone(&nodes));
        }
        Ok(nodes)
    }
}
