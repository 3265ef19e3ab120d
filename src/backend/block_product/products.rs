//! The sums of one vertex: algorithm 1 [Inger 2013] for one lobe, and the cosine of all lobes together.

use std::ops::Range;

use super::cases::{Case, Cases};
use super::interpolation::NODES;
use super::light::LightForms;
use super::samples::{Samples, Sums, above, reflect};
use super::schedule::{GROUP, Group};
use super::suffix::{MomentSums, MomentTable, Table};
use super::tables::Directions;
use super::tiles::TILE;
use super::visible::{MOST_PLACES, Room, TileBits, Visible};
use crate::scene::Kernel;

/// Σ L V ω of a group of vertices.
pub(super) struct Moments<'a, V: Visible> {
    pub(super) maps: &'a V,
    pub(super) light: &'a LightForms,
    pub(super) group: Group<'a, V::Change>,
    pub(super) wanted: &'a [bool; GROUP],
    pub(super) sums: &'a mut [MomentSums; GROUP],
}

impl<V: Visible> pulp::WithSimd for Moments<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let len = self.light.layout().block_len();
        for (eights, ninths) in self.light.moments.chunks_exact(len).zip(self.light.ninths.chunks_exact(len)) {
            // A table of as many rows as a byte can say needs no check of each look-up.
            match (eights.first_chunk::<256>(), ninths.first_chunk()) {
                (Some(eights), Some(ninths)) if len == 256 => {
                    self.course(MomentTable::<_, [f32; 256]> { eights, ninths })
                }
                _ => self.course(MomentTable { eights, ninths }),
            }
        }
    }
}

impl<V: Visible> Moments<'_, V> {
    #[inline(always)]
    fn course<T: Table<Sum = MomentSums>>(&mut self, table: T) {
        for &batch in self.group.next_course() {
            let (vertices, changes) = self.group.next_maps(batch);
            for (&vertex, changes) in vertices.iter().zip(changes.chunks_exact(usize::from(batch.changes))) {
                if self.wanted[usize::from(vertex)] {
                    self.maps.add_changes(changes, table, &mut self.sums[usize::from(vertex)]);
                }
            }
        }
    }
}

/// Σ L V ρ cos of one vertex and lobe.
pub(super) struct LobeSum<'a, const N: usize, K, V> {
    pub(super) kernel: K,
    pub(super) normal: [f32; 3],
    pub(super) maps: &'a V,
    /// The vertex's map of block 0.
    pub(super) first: usize,
    pub(super) cases: &'a Cases,
    pub(super) light: &'a LightForms,
    pub(super) directions: &'a Directions,
    pub(super) samples: &'a mut Samples,
    pub(super) room: &'a mut Room,
    pub(super) cut: Option<Cut<'a>>,
    /// Whether samples below the horizon are what goes on smoothly, not 0.
    pub(super) goes_on: bool,
}

impl<const N: usize, K: Kernel<N>, V: Visible> pulp::WithSimd for LobeSum<'_, N, K, V> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> [f64; 3] {
        let (mut total, cases) = ([0.0; 3], self.cases);
        if K::APART && self.goes_on {
            self.each(cases.list(Case::Free1), &mut total, true, Self::cosines_of_free);
            self.each(cases.list(Case::Partly1), &mut total, true, Self::cosines_of_partly);
            self.drain(&mut total, true);
        } else {
            self.each(cases.list(Case::Free1), &mut total, false, |sum, block| sum.coefficients::<1>(block, 0));
            self.each(cases.list(Case::Partly1), &mut total, false, |sum, course| sum.sums(course, true));
        }
        self.each(cases.list(Case::Free4), &mut total, false, |sum, block| sum.coefficients::<4>(block, 1));
        self.each(cases.list(Case::Free16), &mut total, false, |sum, block| sum.coefficients::<16>(block, 5));
        self.each(cases.list(Case::Partly4), &mut total, false, |sum, course| sum.sums(course, false));
        self.drain(&mut total, false);
        for (case, free) in [(Case::FreePixels, true), (Case::PartlyPixels, false)] {
            for &course in cases.list(case) {
                self.pixels(course as usize, free, &mut total);
            }
        }
        total
    }
}

impl<const N: usize, K: Kernel<N>, V: Visible> LobeSum<'_, N, K, V> {
    /// Collects samples of blocks, and sums them up when the list is full.
    #[inline(always)]
    fn each(&mut self, courses: &[u32], total: &mut [f64; 3], apart: bool, collect: impl Fn(&mut Self, usize)) {
        for &course in courses {
            if !self.samples.has_room(16) {
                self.drain(total, apart);
            }
            collect(self, course as usize);
        }
    }

    /// Sums the list up: of reflectance alone if weights hold the cosine.
    #[inline(always)]
    fn drain(&mut self, total: &mut [f64; 3], apart: bool) {
        let sum = if apart {
            self.samples.drain(Apart(self.kernel), self.normal)
        } else if self.goes_on && !K::SMOOTH {
            self.samples.drain(Continued(self.kernel), self.normal)
        } else {
            self.samples.drain(self.kernel, self.normal)
        };
        add(total, sum);
    }

    /// One sample of the reflectance of a free block, weighted with its light × cosine: exact for one that is constant.
    #[inline(always)]
    fn cosines_of_free(&mut self, block: usize) {
        let at = block * self.light.layout().block_len();
        let sums = MomentSums { eight: self.light.moments[at], ninth: self.light.ninths[at] };
        self.push_cosines(block, &sums);
    }

    /// The same for what is not hidden of a block.
    #[inline(always)]
    fn cosines_of_partly(&mut self, course: usize) {
        let (block, len) = (self.block(course), self.light.layout().block_len());
        let (eights, ninths) = (&self.light.moments[course * len..][..len], &self.light.ninths[course * len..][..len]);
        let sums = self.maps.moments(self.first + block, MomentTable { eights, ninths });
        self.push_cosines(block, &sums);
    }

    #[inline(always)]
    fn push_cosines(&mut self, block: usize, sums: &MomentSums) {
        let [r, g, b] = sums.along(self.normal.map(f64::from)).map(|x| [x as f32]);
        let [x, y, z] = self.directions.nodes.each_ref().map(|plane| [plane[block * NODES]]);
        self.samples.push([&x, &y, &z, &r, &g, &b]);
    }

    /// The block of a course.
    #[inline(always)]
    fn block(&self, course: usize) -> usize {
        let blocks = self.light.layout().blocks();
        if course < blocks { course } else { course - blocks }
    }

    /// Line 6: N samples, weighted with the light of the whole block.
    #[inline(always)]
    fn coefficients<const M: usize>(&mut self, block: usize, level: usize) {
        let at = block * NODES + level;
        let ([x, y, z], [r, g, b]) = (&self.directions.nodes, &self.light.weights);
        let from =
            [x, y, z, r, g, b].map(|plane| plane[at..].first_chunk::<M>().expect("tables have all nodes of a block"));
        self.samples.push(from);
    }

    /// Line 9: one sample or four, weighted with the light that is not hidden.
    #[inline(always)]
    fn sums(&mut self, course: usize, constant: bool) {
        let (block, len) = (self.block(course), self.light.layout().block_len());
        let sums = self.maps.sum(self.first + block, &self.light.nodes[course * len..][..len]);
        let weights: [&[f32; 4]; 3] = [0, 4, 8].map(|k| sums[k..].first_chunk().expect("a row has twelve numbers"));
        let [x, y, z] = &self.directions.nodes;
        if constant {
            let at = block * NODES;
            let [r, g, b] = weights.map(|w| [w[0] + w[1] + w[2] + w[3]]);
            self.samples.push([&[x[at]], &[y[at]], &[z[at]], &r, &g, &b]);
        } else {
            let [x, y, z] =
                [x, y, z].map(|plane| plane[block * NODES + 1..].first_chunk().expect("tables have all nodes"));
            self.samples.push([x, y, z, weights[0], weights[1], weights[2]]);
        }
    }

    /// Line 11: every pixel that is not hidden and not left out.
    #[inline(always)]
    fn pixels(&mut self, course: usize, free: bool, total: &mut [f64; 3]) {
        let (block, len) = (self.block(course), self.light.layout().block_len());
        let (count, first) = (len / TILE, block * len / TILE);
        let mut tiles = TileBits::all(count);
        if let Some(cut) = self.cut {
            tiles = cut.near(first..first + count, self.directions, cut.least[block]);
        }
        if !free {
            let path = self.light.tiles().path(course != block);
            tiles = tiles.and(self.maps.expand(self.first + block, path, self.room));
        }
        let mut sums = Sums::default();
        while let Some(tile) = tiles.pop() {
            let mut values = reflect(self.kernel, self.normal, &self.directions.pixels[first + tile]);
            if !free {
                let levels = self.maps.levels(self.room, tile);
                for values in &mut values {
                    for lane in 0..TILE {
                        values[lane] *= levels[lane];
                    }
                }
            }
            let texels = &self.light.texels[first + tile];
            sums.add(&values, [&texels[0], &texels[1], &texels[2]]);
        }
        add(total, sums.total());
    }
}

/// A kernel as it goes on below the horizon.
#[derive(Clone, Copy)]
struct Continued<K>(K);

impl<const N: usize, K: Kernel<N>> Kernel<N> for Continued<K> {
    const SMOOTH: bool = true;

    #[inline(always)]
    fn at(&self, d: [f32; 3], up: f32, z: f32) -> [f32; N] {
        self.0.at(d, above(up), z)
    }
}

/// A kernel without its cosine.
#[derive(Clone, Copy)]
struct Apart<K>(K);

impl<const N: usize, K: Kernel<N>> Kernel<N> for Apart<K> {
    const SMOOTH: bool = true;

    #[inline(always)]
    fn at(&self, d: [f32; 3], up: f32, _: f32) -> [f32; N] {
        self.0.at(d, above(up), 1.0)
    }
}

/// Leaves out tiles that are too far from the mirror direction to matter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut<'a> {
    pub(super) mirror: [f32; 3],
    /// [block]: the least cosine of a tile's centre.
    pub(super) least: &'a [f32],
}

impl Cut<'_> {
    /// The tiles that count, of some of one block.
    #[inline(always)]
    fn near(self, tiles: Range<usize>, directions: &Directions, least: f32) -> TileBits {
        let [x, y, z] = directions.tiles.each_ref().map(|plane| &plane[tiles.clone()]);
        let mut near = [0_u32; MOST_PLACES / TILE];
        for (((&x, &y), &z), near) in x.iter().zip(y).zip(z).zip(&mut near) {
            *near = u32::from(x * self.mirror[0] + y * self.mirror[1] + z * self.mirror[2] >= least);
        }
        TileBits::of(&near[..tiles.len()])
    }
}

#[inline(always)]
fn add(total: &mut [f64; 3], part: [f64; 3]) {
    total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
}
