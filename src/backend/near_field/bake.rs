//! Computing the rows of some vertices.

use nalgebra::Vector3;

use super::rows::Rows;
use super::settings::BakeSettings;
use crate::Result;
use crate::haar::{Transform2d, threshold_for_error};
use crate::scene::{
    Brdf, DirectionTable, FactoredBrdf, Materials, Mesh, View, Viewpoint, VisibilityScratch, VisibilityTracer,
};
use crate::sphere::TopFace;

/// What reflects.
pub(super) enum Reflectance<'a> {
    /// BRDFs, seen from one view.
    Seen(&'a View),
    /// The products that each BRDF was taken apart into, from any view; none for BRDFs that do not depend on it.
    Factored(&'a [Option<FactoredBrdf>]),
}

pub(super) struct Baker<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) materials: &'a Materials,
    pub(super) reflectance: Reflectance<'a>,
    pub(super) settings: BakeSettings,
    pub(super) face: TopFace,
    pub(super) tracer: VisibilityTracer,
    pub(super) viewpoints: Vec<Viewpoint>,
    /// The directions of rays, `samples`² a cell.
    pub(super) directions: DirectionTable,
    pub(super) transform: Transform2d<f32>,
}

/// What a thread has for its vertices.
pub(super) struct Memory {
    words: Vec<u64>,
    visibility: VisibilityScratch,
    samples: Vec<f32>,
    incident: Vec<Vector3<f64>>,
    cells: Vec<f32>,
    transform: Vec<f32>,
}

impl Baker<'_> {
    pub(super) fn memory(&self) -> Memory {
        let terms = match self.reflectance {
            Reflectance::Seen(_) => 1,
            Reflectance::Factored(factors) => factors.iter().flatten().map(FactoredBrdf::terms).max().unwrap_or(1),
        };
        Memory {
            words: vec![0; self.tracer.directions().words()],
            visibility: self.tracer.scratch(),
            samples: vec![0.0; 3 * self.directions.len()],
            incident: vec![Vector3::zeros(); terms],
            cells: vec![0.0; 3 * terms * self.face.len()],
            transform: vec![0.0; self.transform.scratch_len()],
        }
    }

    /// Adds the rows of a vertex.
    pub(super) fn vertex(&self, vertex: usize, rows: &mut Rows, memory: &mut Memory) -> Result<()> {
        self.tracer.trace(&self.viewpoints[vertex], &mut memory.words, &mut memory.visibility);
        let brdf = self.materials.brdf(vertex);
        let factored = match self.reflectance {
            Reflectance::Seen(_) => None,
            Reflectance::Factored(factors) => factors[self.materials.part(vertex)].as_ref(),
        };
        let planes = match factored {
            None => self.sample(vertex, brdf, memory)?,
            Some(factored) => self.factor(vertex, brdf, factored, memory),
        };
        let (n, per_term) = (self.face.len(), brdf.planes());
        for (k, plane) in memory.cells[..planes * n].chunks_exact_mut(n).enumerate() {
            self.transform.forward_in_place(plane, &mut memory.transform);
            let weight = match brdf.colour() {
                Some(colour) => colour.cast::<f32>().into(),
                None => Vector3::ith(k % per_term, 1.0).into(),
            };
            rows.push(plane, threshold_for_error(plane, self.settings.tolerance), weight, k / per_term);
        }
        rows.end_vertex();
        Ok(())
    }

    /// Visibility × brdf_cos of one view, summed over the rays of each cell; how many planes there are.
    fn sample(&self, vertex: usize, brdf: &dyn Brdf, memory: &mut Memory) -> Result<usize> {
        let planes = brdf.planes();
        let frame = self.mesh.local_frame(vertex);
        let wo = match self.reflectance {
            Reflectance::Seen(view) => view.outgoing(brdf, &self.mesh.positions()[vertex], &frame),
            Reflectance::Factored(_) => frame.normal.cast(),
        };
        let rays = self.directions.len();
        brdf.sample_cos(&frame, &wo, &self.directions, &mut memory.samples[..planes * rays]);
        let Memory { words, samples, cells, .. } = memory;
        cells[..planes * self.face.len()].fill(0.0);
        // A NaN below the horizon or in the shade is a NaN of the BRDF all the same.
        if !samples[..planes * rays].iter().all(|x| x.is_finite()) {
            return Err(self.materials.not_finite(vertex));
        }
        self.each_free(words, |ray, cell, measure| {
            for k in 0..planes {
                cells[k * self.face.len() + cell] += samples[k * rays + ray] * measure;
            }
        });
        Ok(planes)
    }

    /// Visibility × cosine × the factors of light, summed over the rays of each cell; how many planes there are.
    fn factor(&self, vertex: usize, brdf: &dyn Brdf, factored: &FactoredBrdf, memory: &mut Memory) -> usize {
        let frame = self.mesh.local_frame(vertex);
        let (terms, n) = (factored.terms(), self.face.len());
        // The channel in which the colour is 1 is the scalar.
        let scalar = brdf.colour().map(|colour| colour.imax());
        let planes = terms * if scalar.is_some() { 1 } else { 3 };
        let Memory { words, incident, cells, .. } = memory;
        cells[..planes * n].fill(0.0);
        let [x, y, z] = [self.directions.x(), self.directions.y(), self.directions.z()];
        self.each_free(words, |ray, cell, measure| {
            let wi = frame.to_local(&Vector3::new(x[ray], y[ray], z[ray]).cast());
            if !(wi.z > 0.0) {
                return;
            }
            factored.incident_terms(&wi, &mut incident[..terms]);
            let measure = f64::from(measure) * wi.z;
            for (k, g) in incident[..terms].iter().enumerate() {
                match scalar {
                    Some(channel) => cells[k * n + cell] += (g[channel] * measure) as f32,
                    None => (0..3).for_each(|c| cells[(3 * k + c) * n + cell] += (g[c] * measure) as f32),
                }
            }
        });
        planes
    }

    /// Calls `each(ray, cell, measure)` for the rays that are free: their solid angle, times the number of cells, so
    /// that integrals over the unit square of the face are those over directions.
    fn each_free(&self, words: &[u64], mut each: impl FnMut(usize, usize, f32)) {
        let (fine, cells, samples) =
            (self.face.cells() * self.settings.samples, self.face.cells(), self.settings.samples);
        let measures = self.directions.face_solid_angles();
        let scale = self.face.len() as f32;
        for (at, &word) in words.iter().enumerate() {
            let mut left = word;
            while left != 0 {
                let ray = 64 * at + left.trailing_zeros() as usize;
                left &= left - 1;
                let cell = ray / fine / samples * cells + ray % fine / samples;
                each(ray, cell, measures[ray] * scale);
            }
        }
    }
}
