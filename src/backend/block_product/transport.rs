//! The database: visibility of every vertex in blocks, differentially coded.

use nalgebra::Vector3;

use super::coding::{BitCutter, Coded, GrayCutter, Pathed, count_samples};
use super::layout::BlockLayout;
use super::paths::Paths;
use crate::backend::distant::check_vertices;
use crate::compress::{CodedBinaryMaps, CodedGrayMaps, RunStats};
use crate::parallel::Watch;
use crate::scene::{BinaryVisibility, FractionalVisibility, Mesh, VisibilityBaker};
use crate::sphere::{CubeGrid, Face};
use crate::{Error, Progress, Result, parallel};

/// The visibility around every vertex of a static scene: for each block of the cube map the places where it changes
/// [Inger 2013, §4.2]. Lossless for binary maps.
///
/// A block that is hidden has no change, one that is free a single one at place 0; in others a change takes a byte (two
/// for blocks of 32², and one more for its level in maps of several levels), and every block four bytes for where its
/// changes end and a bit for its path, that of the layout's two along which it changes less often. It knows neither
/// light, nor view, nor materials.
///
/// # Example
/// ```
/// use haarmonic::backend::block_product::{BlockLayout, Transport};
/// use haarmonic::compress::ScanOrder;
/// use haarmonic::scene::{Procedural, VisibilityBaker, VisibilitySettings};
/// use haarmonic::sphere::CubeGrid;
/// let mesh = Procedural::StackedSpheres.build(1_000)?.mesh;
/// let layout = BlockLayout::new(CubeGrid::new(16)?, 16, ScanOrder::Serpentine)?;
/// let baker = VisibilityBaker::new(&mesh, layout.grid(), VisibilitySettings::default())?;
/// let transport = Transport::bake(&baker, &layout, &())?;
/// assert!(transport.stats().coded.bytes_in_memory < baker.bake(&())?.words().len() * 8);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transport {
    layout: BlockLayout,
    maps: Maps,
    paths: Paths,
}

/// Coded maps, [vertex][block].
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Maps {
    Binary8(CodedBinaryMaps<u8>),
    Binary16(CodedBinaryMaps<u16>),
    Gray8(CodedGrayMaps<u8>),
    Gray16(CodedGrayMaps<u16>),
}

/// Runs `$body` with `$maps` bound to whichever maps there are.
macro_rules! with_maps {
    ($enum:expr, $maps:ident => $body:expr) => {
        match $enum {
            $crate::backend::block_product::transport::Maps::Binary8($maps) => $body,
            $crate::backend::block_product::transport::Maps::Binary16($maps) => $body,
            $crate::backend::block_product::transport::Maps::Gray8($maps) => $body,
            $crate::backend::block_product::transport::Maps::Gray16($maps) => $body,
        }
    };
}
pub(super) use with_maps;

/// What a transport holds, as table 3 [Inger 2013] counts it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TransportStats {
    /// Vertices.
    pub vertices: usize,
    /// Blocks a vertex.
    pub blocks: usize,
    /// Counts and sizes of the coded maps; [`RunStats::mean_changes_of_mixed`] are the paper's coefficients a block.
    pub coded: RunStats,
}

impl Transport {
    /// Traces and codes binary visibility, vertex by vertex: the maps are never all there uncoded.
    ///
    /// `progress` counts vertices. The same bits for any number of threads.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::OutOfRange`] if the baker's grid is not the layout's, and beyond 2³² changes.
    pub fn bake(baker: &VisibilityBaker, layout: &BlockLayout, progress: &dyn Progress) -> Result<Self> {
        check_grid("side of the baker's cube map", baker.grid(), layout.grid())?;
        let scratch = || (BitCutter::new(layout), baker.scratch(), vec![0; baker.words_per_vertex()]);
        binary(layout, baker.vertices(), progress, scratch, |vertex, (cutter, rays, words)| {
            baker.bake_vertex(vertex, words, rays);
            (cutter, words)
        })
    }

    /// Traces `samples`² rays a texel, quantises the share that is free to `bits` and codes it: shadows without steps
    /// under small bright lights.
    ///
    /// `mesh` is the baker's. `progress` counts vertices.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::OutOfRange`] if the baker's grid is not the layout's, unless 1 ≤ `samples` ≤ 15
    /// and 2 ≤ `bits` ≤ 8, and beyond 2³² changes; [`Error::Length`] for another mesh.
    pub fn bake_gray(
        mesh: &Mesh,
        baker: &VisibilityBaker,
        layout: &BlockLayout,
        (samples, bits): (usize, u32),
        progress: &dyn Progress,
    ) -> Result<Self> {
        check_grid("side of the baker's cube map", baker.grid(), layout.grid())?;
        check_vertices("visibility maps", mesh.positions().len(), baker.vertices())?;
        if !(1..=15).contains(&samples) {
            let what = "visibility samples along a texel's edge";
            return Err(Error::OutOfRange { what, got: samples as f64, allowed: "in 1…15" });
        }
        let side = layout.grid().side();
        let fine = baker.with_grid(CubeGrid::new(side * samples)?);
        let scratch = || (fine.scratch(), vec![0; fine.words_per_vertex()], vec![0; layout.grid().len()]);
        gray(layout, mesh, (samples, bits), progress, scratch, |vertex, (rays, words, counts)| {
            fine.bake_vertex(vertex, words, rays);
            let faces = words.chunks_exact(words.len() / 6).zip(counts.chunks_exact_mut(side * side));
            faces.for_each(|(words, counts)| count_samples(words, side, samples, counts));
            counts
        })
    }

    /// Codes binary visibility that is there, of whatever origin; `mesh` has the normals.
    ///
    /// A texel whose centre is not above the horizon of its vertex reflects nothing and counts as hidden; of maps that
    /// [`VisibilityBaker`] has made, none is.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if its grid is not the layout's, and beyond 2³² changes; [`Error::Length`] for another
    /// mesh.
    pub fn from_binary(mesh: &Mesh, visibility: &BinaryVisibility, layout: &BlockLayout) -> Result<Self> {
        check_grid("side of the visibility's cube map", visibility.grid(), layout.grid())?;
        check_vertices("visibility maps", mesh.positions().len(), visibility.vertices())?;
        let centres: Vec<f64> = (0..layout.grid().side()).map(|i| layout.grid().centre(i)).collect();
        let scratch = || (BitCutter::new(layout), Vec::new());
        binary(layout, visibility.vertices(), &(), scratch, |vertex, (cutter, words)| {
            words.clear();
            words.extend_from_slice(visibility.vertex(vertex));
            clip(words, &mesh.normals()[vertex].cast(), &centres);
            (cutter, words)
        })
    }

    /// As [`from_binary`](Self::from_binary) of maps that end at the horizon of their vertex's normal already, as those
    /// of [`VisibilityBaker`] do: they are coded as they are.
    ///
    /// What is visible below the horizon all the same takes light away, because cosines go on there: a relit vertex
    /// gets black.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if its grid is not the layout's, and beyond 2³² changes.
    pub fn from_clipped(visibility: &BinaryVisibility, layout: &BlockLayout) -> Result<Self> {
        check_grid("side of the visibility's cube map", visibility.grid(), layout.grid())?;
        let scratch = || (BitCutter::new(layout), Vec::new());
        binary(layout, visibility.vertices(), &(), scratch, |vertex, (cutter, words)| {
            words.clear();
            words.extend_from_slice(visibility.vertex(vertex));
            (cutter, words)
        })
    }

    /// Codes fractional visibility that is there, quantised to `bits`; `mesh` has the normals.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if its grid is not the layout's, unless 2 ≤ `bits` ≤ 8, and beyond 2³² changes;
    /// [`Error::Length`] for another mesh.
    pub fn from_fractional(
        mesh: &Mesh,
        visibility: &FractionalVisibility,
        layout: &BlockLayout,
        bits: u32,
    ) -> Result<Self> {
        check_grid("side of the visibility's cube map", visibility.grid(), layout.grid())?;
        check_vertices("visibility maps", mesh.positions().len(), visibility.vertices())?;
        gray(layout, mesh, (visibility.samples(), bits), &(), Vec::new, |vertex, counts: &mut Vec<u8>| {
            counts.clear();
            counts.extend_from_slice(visibility.vertex(vertex));
            counts
        })
    }

    /// A transport of maps, [vertex][block], and of their paths.
    pub(super) fn from_maps(layout: BlockLayout, maps: Maps, paths: Paths) -> Self {
        Self { layout, maps, paths }
    }

    /// The layout.
    pub fn layout(&self) -> &BlockLayout {
        &self.layout
    }

    pub(super) fn maps(&self) -> &Maps {
        &self.maps
    }

    pub(super) fn paths(&self) -> &Paths {
        &self.paths
    }

    /// Which of the layout's paths a block of a vertex is coded along: 0, or 1 if that has fewer changes.
    ///
    /// # Panics
    /// If `vertex` or `block` is out of range.
    #[track_caller]
    pub fn path(&self, vertex: usize, block: usize) -> usize {
        let blocks = self.layout.blocks();
        assert!(vertex < self.vertices() && block < blocks, "block {block} of vertex {vertex}");
        self.paths.of(vertex, block, blocks)
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        with_maps!(&self.maps, maps => maps.len()) / self.layout.blocks()
    }

    /// The top level: 1 for binary maps.
    pub fn top(&self) -> u8 {
        match &self.maps {
            Maps::Binary8(_) | Maps::Binary16(_) => 1,
            Maps::Gray8(maps) => maps.top(),
            Maps::Gray16(maps) => maps.top(),
        }
    }

    /// Visibility of each texel of a vertex, in the order of the grid.
    ///
    /// # Panics
    /// If `vertex` is out of range or `out` is not one number a texel.
    #[track_caller]
    pub fn decode(&self, vertex: usize, out: &mut [f32]) {
        crate::error::check_length("texels of a vertex", self.layout.grid().len(), out.len());
        let mut block = vec![0.0_f32; self.layout.block_len()];
        for b in 0..self.layout.blocks() {
            with_maps!(&self.maps, maps => maps.map(vertex * self.layout.blocks() + b).decode(&mut block));
            for (&texel, &value) in self.layout.texels(self.path(vertex, b), b).iter().zip(&block) {
                out[texel as usize] = value;
            }
        }
    }

    /// Counts and sizes. Cost: codes the file once.
    pub fn stats(&self) -> TransportStats {
        let mut coded = with_maps!(&self.maps, maps => maps.stats());
        coded.bytes_in_memory += self.paths.bytes();
        coded.bytes_in_file += self.paths.bytes();
        TransportStats { vertices: self.vertices(), blocks: self.layout.blocks(), coded }
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        with_maps!(&self.maps, maps => maps.bytes()) + self.paths.bytes()
    }
}

fn check_grid(what: &'static str, got: CubeGrid, layout: CubeGrid) -> Result<()> {
    if got == layout {
        return Ok(());
    }
    Err(Error::OutOfRange { what, got: got.side() as f64, allowed: "that of the block layout" })
}

/// Hides what is not above the plane of a normal, in the words of a vertex: by the baker's own predicate, to the bit.
fn clip(words: &mut [u64], normal: &Vector3<f64>, centres: &[f64]) {
    let (side, per_face) = (centres.len(), words.len() / 6);
    for (face, words) in Face::ALL.into_iter().zip(words.chunks_exact_mut(per_face)) {
        let n = face.axes().map(|axis| Vector3::from(axis).dot(normal));
        for (w, word) in words.iter_mut().enumerate() {
            let mut bits = *word;
            while bits != 0 {
                let (bit, at) = (bits & bits.wrapping_neg(), w * 64 + bits.trailing_zeros() as usize);
                bits ^= bit;
                let above = n[0] * centres[at % side] + (n[1] * centres[at / side] + n[2]) > 0.0;
                if !above {
                    *word ^= bit;
                }
            }
        }
    }
}

/// Codes binary maps; `words` makes those of a vertex in its scratch.
fn binary<S: Send>(
    layout: &BlockLayout,
    vertices: usize,
    progress: &dyn Progress,
    scratch: impl Fn() -> S + Sync,
    words: impl Fn(usize, &mut S) -> (&mut BitCutter, &mut Vec<u64>) + Sync,
) -> Result<Transport> {
    let len = layout.block_len();
    let (maps, paths) = if len <= 256 {
        let all = code(vertices, (len, 1), progress, &scratch, |vertex, s, to: &mut Pathed<CodedBinaryMaps<u8>>| {
            let (cutter, words) = words(vertex, s);
            cutter.code(words, to);
        })?;
        (Maps::Binary8(all.maps), all.paths)
    } else {
        let all = code(vertices, (len, 1), progress, &scratch, |vertex, s, to: &mut Pathed<CodedBinaryMaps<u16>>| {
            let (cutter, words) = words(vertex, s);
            cutter.code(words, to);
        })?;
        (Maps::Binary16(all.maps), all.paths)
    };
    Ok(Transport { layout: layout.clone(), maps, paths })
}

/// Codes maps of several levels; `counts` makes those of a vertex in its scratch.
fn gray<S: Send>(
    layout: &BlockLayout,
    mesh: &Mesh,
    (samples, bits): (usize, u32),
    progress: &dyn Progress,
    scratch: impl Fn() -> S + Sync,
    counts: impl Fn(usize, &mut S) -> &mut Vec<u8> + Sync,
) -> Result<Transport> {
    if !(2..=8).contains(&bits) {
        return Err(Error::OutOfRange {
            what: "bits of gray visibility",
            got: f64::from(bits),
            allowed: "from 2 to 8",
        });
    }
    let (len, top, normals) = (layout.block_len(), ((1_u32 << bits) - 1) as u8, mesh.normals());
    let scratch = || (GrayCutter::new(layout, samples, top), scratch());
    let (maps, paths) = if len <= 256 {
        let one = |vertex: usize, (cutter, s): &mut (GrayCutter, S), to: &mut Pathed<CodedGrayMaps<u8>>| {
            cutter.code(counts(vertex, s), &normals[vertex], to);
        };
        let all = code(normals.len(), (len, top), progress, &scratch, one)?;
        (Maps::Gray8(all.maps), all.paths)
    } else {
        let one = |vertex: usize, (cutter, s): &mut (GrayCutter, S), to: &mut Pathed<CodedGrayMaps<u16>>| {
            cutter.code(counts(vertex, s), &normals[vertex], to);
        };
        let all = code(normals.len(), (len, top), progress, &scratch, one)?;
        (Maps::Gray16(all.maps), all.paths)
    };
    Ok(Transport { layout: layout.clone(), maps, paths })
}

/// Codes all vertices, a piece at a time, in parallel, and joins the pieces in order.
fn code<M: Coded, S: Send>(
    vertices: usize,
    (len, top): (usize, u8),
    progress: &dyn Progress,
    scratch: &(impl Fn() -> S + Sync),
    one: impl Fn(usize, &mut S, &mut Pathed<M>) + Sync,
) -> Result<Pathed<M>> {
    // A few hundred pieces: enough to balance threads, few enough to report each.
    let piece = vertices.div_ceil(256).max(1);
    let watch = Watch::new(progress, vertices);
    let pieces = parallel::try_map(vertices.div_ceil(piece), scratch, |k, s| {
        let mut part = Pathed::empty(len, top)?;
        let (first, end) = (k * piece, (k * piece + piece).min(vertices));
        for vertex in first..end {
            if vertex % 8 == 0 {
                watch.check()?;
            }
            one(vertex, s, &mut part);
        }
        watch.advance(end - first);
        Ok(part)
    })?;
    let mut all = Pathed::empty(len, top)?;
    pieces.iter().try_for_each(|part| all.join(part))?;
    Ok(all)
}
