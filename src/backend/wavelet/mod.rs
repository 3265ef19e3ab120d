//! All-frequency relighting in Haar wavelets: the double product of Ng 2003 and the triple product of Ng 2004.
//!
//! Both integrate light × visibility × brdf_cos over a cube map around each vertex, face by face, in the 2D nonstandard Haar
//! basis. They differ in what is precomputed:
//!
//! | | [`DoubleRelighter`] | [`TripleRelighter`] |
//! |---|---|---|
//! | precomputed per vertex | visibility × brdf_cos, sparse | visibility, one bit a texel |
//! | may change each frame | light | light, view, materials |
//! | view-dependent materials | for the view that was baked | for any view |
//! | cost of a frame | entries in the columns of the kept light terms | a BRDF slice and six product integrals a vertex |
//!
//! A face's light is weighted by side² × solid angle of each texel, so that the mean over the face of
//! light × visibility × brdf_cos is the integral over its solid angle. Which terms of the light to keep: see [`Selection`](crate::haar::Selection); by magnitude alone 1 % of the terms is too few (docs/performance.md has the figures).
//!
//! Sources: [Ng 2003], [Ng 2004]; docs/references.md names a patent on product integrals by wavelet trees.

mod double;
mod light;
mod slices;
mod triple;

pub use double::{DoubleRelighter, DoubleSettings, DoubleTransport, Precision};
pub use light::ProjectedLight;
pub use triple::{Slices, TripleRelighter, TripleSettings, TripleTransport};

use crate::haar::{Decomposition, MaskedSum, SparseVector, Transform2d};
use crate::scene::{Materials, Mesh};
use crate::sphere::CubeGrid;
use crate::{Error, Result};

/// The transform of one face.
fn face_transform(grid: CubeGrid) -> Result<Transform2d<f32>> {
    Transform2d::new(grid.side(), grid.side(), Decomposition::Nonstandard)
}

/// Checks that mesh, visibility and materials speak of the same vertices.
fn check_scene(mesh: &Mesh, visible: usize, materials: &Materials) -> Result<()> {
    let expected = mesh.positions().len();
    if visible != expected {
        return Err(Error::Length { what: "visibility maps", expected, got: visible });
    }
    materials.check(expected)
}

/// The `len` coefficients from `start` on, as a vector of their own.
fn slice_of(whole: &SparseVector<f32>, start: usize, len: usize) -> SparseVector<f32> {
    let from = whole.indices().partition_point(|&i| (i as usize) < start);
    let to = whole.indices().partition_point(|&i| (i as usize) < start + len);
    let indices = whole.indices()[from..to].iter().map(|&i| i - start as u32).collect();
    SparseVector::new(len, indices, whole.values()[from..to].to_vec()).expect("a run of a sparse vector is one")
}

/// Copies what a vertex sees and sets the rest to 0. Shapes: six faces of words, six of values.
fn mask(masked: &MaskedSum, words: &[u64], values: &[f32], out: &mut [f32]) {
    let faces = values.chunks_exact(values.len() / 6).zip(out.chunks_exact_mut(values.len() / 6));
    for ((values, out), words) in faces.zip(words.chunks_exact(words.len() / 6)) {
        masked.mask(values, words, out);
    }
}
