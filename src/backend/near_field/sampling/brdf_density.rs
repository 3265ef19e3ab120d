//! BRDF sampling: the rows of a table, warped over the hemisphere.

use nalgebra::Vector3;

use super::brdf_table::BrdfTable;
use super::{DirectionSample, DirectionSampler, ShadingPoint, hemisphere};
use crate::haar::{Decomposition, SampleWarp2d, Transform2d};

/// BRDF sampling about one point: directions as likely as the tabulated BRDF times the cosine is large.
///
/// The density is constant over each cell of the table, but for the solid angle of a part of it. It is 0 everywhere for
/// a viewer below the surface or with NaN or ∞, and for a black BRDF.
#[derive(Debug, Clone)]
pub struct BrdfDensity<'a> {
    warp: &'a SampleWarp2d,
    /// The surface's axes; `None` if there is nothing to draw from.
    axes: Option<[Vector3<f64>; 3]>,
}

/// Working memory of [`BrdfTable::density`]; grows on first use, then is used again. One for each thread.
#[derive(Debug, Clone, Default)]
pub struct BrdfScratch {
    plan: Option<Plan>,
    slice: Vec<f32>,
}

#[derive(Debug, Clone)]
struct Plan {
    transform: Transform2d<f32>,
    warp: SampleWarp2d,
    /// Cosine times solid angle of each cell.
    measure: Vec<f32>,
    scratch: Vec<f32>,
}

impl BrdfScratch {
    /// Working memory that has not grown yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Plan {
    fn new(cells: usize) -> Self {
        let transform = Transform2d::new(cells, cells, Decomposition::Standard).expect("a table has 2^k cells");
        let zeros = vec![0.0_f32; cells * cells];
        let warp = SampleWarp2d::new(&zeros, cells, cells, Decomposition::Standard).expect("2^k cells of zeros");
        let centre = |i: usize| (i as f64 + 0.5) / cells as f64;
        let measure = |cell: usize| {
            let q = hemisphere::point([centre(cell % cells), centre(cell / cells)]);
            (q.z / q.norm() * hemisphere::solid_angle(&q)) as f32
        };
        let scratch = vec![0.0; transform.scratch_len()];
        Self { transform, warp, measure: (0..cells * cells).map(measure).collect(), scratch }
    }
}

impl BrdfTable {
    /// BRDF sampling about a point.
    ///
    /// Cost: an interpolation of two rows of the table, or four, and a transform.
    pub fn density<'a>(&self, point: &ShadingPoint, scratch: &'a mut BrdfScratch) -> BrdfDensity<'a> {
        let BrdfScratch { plan, slice } = scratch;
        if plan.as_ref().is_none_or(|plan| plan.transform.width() != self.cells()) {
            *plan = Some(Plan::new(self.cells()));
        }
        let plan = plan.as_mut().expect("it was made above");
        let axes = self.slice(&point.frame, &point.wo, slice).map(|slice| slice.axes);
        let mut sum = 0.0;
        if axes.is_some() {
            slice.iter_mut().zip(&plan.measure).for_each(|(value, measure)| {
                *value *= measure;
                sum += *value;
            });
            if sum > 0.0 {
                plan.transform.forward_in_place(slice, &mut plan.scratch);
                plan.warp.set(slice).expect("a table is finite");
            }
        }
        BrdfDensity { warp: &plan.warp, axes: axes.filter(|_| sum > 0.0) }
    }
}

impl BrdfDensity<'_> {
    /// Whether there is nothing to draw from.
    pub fn is_empty(&self) -> bool {
        self.axes.is_none()
    }
}

impl DirectionSampler for BrdfDensity<'_> {
    fn sample(&self, uniform: [f64; 2]) -> Option<DirectionSample> {
        let [x, y, z] = self.axes?;
        let (w, density) = self.warp.sample(uniform);
        let q = hemisphere::point(w);
        let d = q.normalize();
        Some(DirectionSample { direction: x * d.x + y * d.y + z * d.z, pdf: density / hemisphere::solid_angle(&q) })
    }

    fn pdf(&self, direction: &Vector3<f64>) -> f64 {
        let Some(axes) = self.axes else { return 0.0 };
        let local = Vector3::from(axes.map(|axis| axis.dot(direction)));
        if !(local.z > 0.0) {
            return 0.0;
        }
        let w = hemisphere::coordinate(&local);
        self.warp.density(w) / hemisphere::solid_angle(&hemisphere::point(w))
    }
}
