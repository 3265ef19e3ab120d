//! BRDF slices: brdf_cos of one normal and one view over all directions, sampled, thinned, tabulated.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::haar::{Decomposition, Factor, Keep, Selection, SelectionScratch, SparseVector, Transform2d, Weighting};
use crate::scene::{Brdf, DirectionTable, LocalFrame, Materials, Mesh, View};
use crate::sphere::CubeGrid;
use crate::{Result, parallel};

/// Samples slices and thins them to few wavelets; memory for one slice at a time.
#[derive(Debug, Clone)]
pub(super) struct SliceSampler {
    directions: DirectionTable,
    transform: Transform2d<f32>,
    keep: Keep,
    samples: Vec<f32>,
    coefficients: Vec<f32>,
    thinned: Vec<f32>,
    scratch: Vec<f32>,
    selection: SelectionScratch,
}

impl SliceSampler {
    pub(super) fn new(grid: CubeGrid, keep: Keep) -> Result<Self> {
        let transform = Transform2d::new(grid.side(), grid.side(), Decomposition::Nonstandard)?;
        let planes = || vec![0.0; 3 * grid.len()];
        Ok(Self {
            directions: DirectionTable::new(grid),
            keep,
            samples: planes(),
            coefficients: planes(),
            thinned: planes(),
            scratch: vec![0.0; transform.scratch_len()],
            transform,
            selection: SelectionScratch::default(),
        })
    }

    /// `part` is the BRDF's index, for an error.
    fn sample(&mut self, (part, brdf): (usize, &dyn Brdf), frame: &LocalFrame, wo: &Vector3<f64>) -> Result<usize> {
        let len = brdf.planes() * self.directions.len();
        brdf.sample_cos(frame, wo, &self.directions, &mut self.samples[..len]);
        if !self.samples[..len].iter().all(|x| x.is_finite()) {
            return Err(Materials::part_not_finite(part));
        }
        Ok(len)
    }

    /// Transforms the first `len` samples and chooses the indices to keep, the same in each plane.
    fn select(&mut self, len: usize, weighting: Weighting<'_, f32>) -> Result<&[u32]> {
        let n = self.directions.len();
        self.transform.forward_batch(&self.samples[..len], &mut self.coefficients[..len], &mut self.scratch);
        let mut planes = [&self.coefficients[..n]; 3];
        let count = len / n;
        for (c, plane) in planes.iter_mut().enumerate().take(count) {
            *plane = &self.coefficients[c * n..][..n];
        }
        let selection = Selection::new(self.keep).with_weighting(weighting).with_blocks_of(n / 6);
        selection.indices(&planes[..count], &mut self.selection)
    }

    /// A slice as texels, of its kept wavelets only: one plane for a BRDF with a colour, else three.
    pub(super) fn texels(
        &mut self,
        brdf: (usize, &dyn Brdf),
        frame: &LocalFrame,
        wo: &Vector3<f64>,
        weighting: Weighting<'_, f32>,
    ) -> Result<&[f32]> {
        let len = self.sample(brdf, frame, wo)?;
        let n = self.directions.len();
        if self.keep.of(n) >= n {
            return Ok(&self.samples[..len]);
        }
        self.select(len, weighting)?;
        self.thinned[..len].fill(0.0);
        for &i in self.selection.kept() {
            for at in (i as usize..len).step_by(n) {
                self.thinned[at] = self.coefficients[at];
            }
        }
        self.transform.inverse_batch(&self.thinned[..len], &mut self.samples[..len], &mut self.scratch);
        Ok(&self.samples[..len])
    }

    /// A slice as factors of a product integral.
    fn factors(
        &mut self,
        brdf: (usize, &dyn Brdf),
        frame: &LocalFrame,
        wo: &Vector3<f64>,
        w: Weighting<'_, f32>,
    ) -> Result<Slice> {
        let len = self.sample(brdf, frame, wo)?;
        let n = self.directions.len();
        self.select(len, w)?;
        let mut planes = Vec::with_capacity(3);
        for plane in self.coefficients[..len].chunks_exact(n) {
            planes.push(SparseVector::gather(plane, self.selection.kept())?);
        }
        let mut faces = Vec::with_capacity(6);
        for face in 0..6 {
            let parts = planes.iter().map(|p| slice_of(p, face * n / 6, n / 6));
            let dark = parts.clone().all(|p| p.values().iter().all(|&v| v == 0.0));
            let factors = if dark { Vec::new() } else { parts.map(|p| Factor::new([&p])).collect::<Result<_>>()? };
            faces.push(factors);
        }
        Ok(Slice { faces })
    }
}

/// One slice: for each face a factor a plane, or none where the slice is zero.
#[derive(Debug, Clone)]
pub(super) struct Slice {
    faces: Vec<Vec<Factor<f32>>>,
}

impl Slice {
    pub(super) fn is_dark(&self, face: usize) -> bool {
        self.faces[face].is_empty()
    }

    pub(super) fn face(&self, face: usize) -> &[Factor<f32>] {
        &self.faces[face]
    }
}

/// Material, texel of the normal, texel of the view (0 for materials that do not depend on it).
type Key = (u32, u32, u32);

/// Slices at the texel centres of a cube map of normals, and one of views where the material depends on it.
#[derive(Debug, Clone, Default)]
pub(super) struct SliceTable {
    cells: Option<CubeGrid>,
    /// The materials that the slices were made of.
    made_of: Option<Materials>,
    slots: HashMap<Key, u32>,
    slices: Vec<Slice>,
    of_vertex: Vec<u32>,
}

impl SliceTable {
    pub(super) fn new(cells: CubeGrid) -> Self {
        Self { cells: Some(cells), ..Self::default() }
    }

    pub(super) fn bytes(&self) -> usize {
        self.slices.iter().flat_map(|s| s.faces.iter().flatten()).map(Factor::bytes).sum()
    }

    /// The slice of a vertex, as of the last [`fill`](Self::fill).
    pub(super) fn slice(&self, vertex: usize) -> &Slice {
        &self.slices[self.of_vertex[vertex] as usize]
    }

    /// Finds each vertex's slice and makes those that are missing. Other materials than last time empty the table.
    pub(super) fn fill(
        &mut self,
        mesh: &Mesh,
        view: &View,
        materials: &Materials,
        grid: CubeGrid,
        keep: Keep,
        weighting: Weighting<'_, f32>,
    ) -> Result<()> {
        let Some(cells) = self.cells else { return Ok(()) };
        if !self.made_of.as_ref().is_some_and(|m| m.is_same(materials)) {
            self.slots.clear();
            self.slices.clear();
            self.made_of = Some(materials.clone());
        }
        let mut missing: Vec<Key> = Vec::new();
        self.of_vertex.clear();
        for v in 0..mesh.positions().len() {
            let normal = mesh.normals()[v].cast();
            let brdf = materials.brdf(v);
            let view =
                if brdf.is_view_independent() { 0 } else { cells.nearest(&view.wo(&mesh.positions()[v])) as u32 };
            let key = (materials.part(v) as u32, cells.nearest(&normal) as u32, view);
            let next = (self.slices.len() + missing.len()) as u32;
            let slot = *self.slots.entry(key).or_insert_with(|| {
                missing.push(key);
                next
            });
            self.of_vertex.push(slot);
        }
        if missing.is_empty() {
            return Ok(());
        }
        let sampler = SliceSampler::new(grid, keep)?;
        let made = parallel::try_map(
            missing.len(),
            || sampler.clone(),
            |k, sampler| {
                let (part, normal, view) = missing[k];
                let brdf = &*materials.brdfs()[part as usize];
                let frame = LocalFrame::around(&cells.direction(normal as usize));
                let wo = match brdf.is_view_independent() {
                    true => frame.normal.cast(),
                    false => cells.direction(view as usize).into_inner(),
                };
                sampler.factors((part as usize, brdf), &frame, &wo, weighting)
            },
        );
        match made {
            Ok(made) => self.slices.extend(made),
            Err(e) => {
                // Slots of slices that were not made must not stay.
                self.slots.retain(|key, _| !missing.contains(key));
                return Err(e);
            }
        }
        Ok(())
    }
}

/// The `len` coefficients from `start` on, as a vector of their own.
pub(super) fn slice_of(whole: &SparseVector<f32>, start: usize, len: usize) -> SparseVector<f32> {
    let from = whole.indices().partition_point(|&i| (i as usize) < start);
    let to = whole.indices().partition_point(|&i| (i as usize) < start + len);
    let indices = whole.indices()[from..to].iter().map(|&i| i - start as u32).collect();
    SparseVector::new(len, indices, whole.values()[from..to].to_vec()).expect("a run of a sparse vector is one")
}
