//! The error of a reflectance that is read at few samples a block: measured once for each lobe, looked up in every
//! frame.
//!
//! The error of l × l samples on a block of N pixels is e = ρ̃ − Σ_j ρ̃(node_j) φ_j. What it does to the radiance is,
//! by Cauchy and Schwarz and by Hölder for 0 ≤ V ≤ 1, at most
//! ```math
//! free          |Σ L e|   ≤ |Σ L| |mean e| + √(N Σ (L − mean L)²) rms e
//! partly hidden |Σ L V e| ≤ the less of  √(N Σ L²) rms e  and  N max |L| mean |e|
//! ```
//! The three norms of e are tabulated for l = 0 (nothing at all), 1, 2 and 4; those of the light are numbers a block,
//! new with each light. Under a smooth sky a free block so needs few samples of a sharp lobe, where the sun stands it
//! needs them all.
//!
//! | lobe | table over | why that is enough |
//! |---|---|---|
//! | about the mirror direction m | angle of the block's centre to m | ρ̃ = f(m·ω) n·ω: the error is n · (error of f(m·ω) ω), so that the norm of that *vector* bounds all normals |
//! | any other | the viewer's direction and the block's relative to m; see `wide` | three sizes of block, straight and askew; the largest of the viewer's neighbours, interpolated between places |

mod errors;
mod gauge;
mod grid;
mod lanes;
mod mirror;
mod wide;

pub(super) use errors::{Checks, Errors, Limits, Norms, offset, spread};
pub(super) use gauge::Gauge;
pub(super) use grid::Symmetry;
pub(super) use mirror::MirrorBounds;
pub(super) use wide::{Position, WideBounds, WideNodes, WideView};

/// The cell of a number in [0, 1], of `count` equal ones.
#[inline(always)]
fn cell_of(at: f32, count: usize) -> usize {
    ((at * count as f32) as usize).min(count - 1)
}

/// sin(θ/2) from cos θ.
#[inline(always)]
fn half_sine(cosine: f32) -> f32 {
    (0.5 - 0.5 * cosine).max(0.0).sqrt()
}
