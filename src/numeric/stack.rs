//! Where spilled registers go.

use std::hint::black_box;

/// As aligned as the widest register.
#[repr(align(64))]
struct Aligned(u8);

/// Has the function that this is inlined into keep its stack frame aligned to its vector registers; call it first in
/// `with_simd`.
///
/// LLVM aligns a frame for what is declared in it, not for registers that it spills later: those would lie across cache
/// lines whenever the caller's frame happens to end between two, and long straight-line kernels would be slower, or
/// not, by the luck of a build.
#[inline(always)]
pub(crate) fn align_stack() {
    let aligned = Aligned(0);
    black_box(&aligned.0);
}
