//! Sums over the texels that a 1-bit mask keeps.

use pulp::{Arch, NullaryFnOnce};

use crate::Real;
use crate::error::{check_length, length_mismatch};

/// Words (of 64 texels) whose sums in T are folded into f64 at once.
const BLOCK: usize = 16;
/// A word that keeps all its texels.
const FULL: u64 = !0;
/// Independent partial sums under a mask: two AVX registers of f32. More of them spoil the expansion of bits to lanes.
const LANES: usize = 16;
/// Independent partial sums without one: four registers hide the latency of the additions.
const WIDE: usize = 32;

/// Dot products under a 1-bit mask, vectorised for the machine it runs on.
///
/// Texel i is kept if bit i mod 64 of word i / 64 is set; one that is not adds nothing, NaN and infinities included.
/// Any order of texels will do as long as texels and bits share it. Spare bits of the last word are ignored. All-zero
/// words are skipped, all-one words take a path without a mask.
/// Accuracy: f32 texels are summed in 16 or 32 lanes of f32 over blocks of 1024 texels, then in f64: relative to Σ
/// |terms| within 64 · 2⁻²⁴ at worst and about 4 · 2⁻²⁴ in practice. f64 texels: the same lanes in f64.
#[derive(Debug, Clone, Copy)]
pub struct MaskedSum {
    arch: Arch,
}

impl Default for MaskedSum {
    fn default() -> Self {
        Self::new()
    }
}

impl MaskedSum {
    /// A plan for the instruction sets of the machine that it runs on.
    pub fn new() -> Self {
        Self { arch: Arch::new() }
    }

    /// Σ over kept texels of x.
    ///
    /// # Panics
    /// If there are not ⌈texels / 64⌉ words.
    #[track_caller]
    pub fn sum<T: Real>(&self, x: &[T], words: &[u64]) -> f64 {
        check_length("mask words", x.len().div_ceil(64), words.len());
        self.arch.dispatch(Single { x, words })
    }

    /// Σ over kept texels of x · y.
    ///
    /// # Panics
    /// If x and y differ in length or there are not ⌈texels / 64⌉ words.
    #[track_caller]
    pub fn dot<T: Real>(&self, x: &[T], y: &[T], words: &[u64]) -> f64 {
        self.dots([x], y, words)[0]
    }

    /// Σ over kept texels of x_c · y for several channels x_c (an RGB light against one BRDF).
    ///
    /// # Panics
    /// If a channel and y differ in length or there are not ⌈texels / 64⌉ words.
    #[track_caller]
    pub fn dots<T: Real, const C: usize>(&self, x: [&[T]; C], y: &[T], words: &[u64]) -> [f64; C] {
        for channel in x {
            if channel.len() != y.len() {
                length_mismatch("texels of a channel", y.len(), channel.len());
            }
        }
        check_length("mask words", y.len().div_ceil(64), words.len());
        self.arch.dispatch(Several { x, y, words })
    }

    /// Σ x · y, every texel kept.
    ///
    /// For when x is a light already masked ([`Self::mask`]) and only y changes.
    ///
    /// # Panics
    /// If x and y differ in length.
    #[track_caller]
    pub fn dot_unmasked<T: Real>(&self, x: &[T], y: &[T]) -> f64 {
        check_length("texels", x.len(), y.len());
        self.arch.dispatch(Unmasked { x, y, z: None })
    }

    /// Σ x · y · z.
    ///
    /// # Panics
    /// If lengths differ.
    #[track_caller]
    pub fn dot_three<T: Real>(&self, x: &[T], y: &[T], z: &[T]) -> f64 {
        check_length("texels", x.len(), y.len());
        check_length("texels", x.len(), z.len());
        self.arch.dispatch(Unmasked { x, y, z: Some(z) })
    }

    /// out = x where kept, 0 elsewhere.
    ///
    /// # Panics
    /// If x and out differ in length or there are not ⌈texels / 64⌉ words.
    #[track_caller]
    pub fn mask<T: Real>(&self, x: &[T], words: &[u64], out: &mut [T]) {
        check_length("texels", x.len(), out.len());
        check_length("mask words", x.len().div_ceil(64), words.len());
        self.arch.dispatch(Select { x, words, out });
    }
}

struct Single<'a, T> {
    x: &'a [T],
    words: &'a [u64],
}

struct Several<'a, T, const C: usize> {
    x: [&'a [T]; C],
    y: &'a [T],
    words: &'a [u64],
}

struct Unmasked<'a, T> {
    x: &'a [T],
    y: &'a [T],
    z: Option<&'a [T]>,
}

struct Select<'a, T> {
    x: &'a [T],
    words: &'a [u64],
    out: &'a mut [T],
}

/// Partial sums of a block. Only ever indexed by loop counters, so that they stay in registers.
type Lanes<T, const N: usize = LANES> = [T; N];

#[inline(always)]
fn fold<T: Real, const N: usize>(lanes: Lanes<T, N>) -> f64 {
    let mut total = 0.0;
    for lane in lanes {
        total += lane.widen();
    }
    total
}

/// The value where bit `lane` of `bits` is set, else 0: a compare and a blend once vectorised.
#[inline(always)]
fn keep<T: Real>(bits: u32, lane: usize, value: T) -> T {
    if bits & 1 << lane == 0 { T::zero() } else { value }
}

/// lanes += the kept x, for 64 texels.
#[inline(always)]
fn add_kept<T: Real>(lanes: &mut Lanes<T>, x: &[T; 64], word: u64) {
    for group in 0..64 / LANES {
        let bits = (word >> (LANES * group)) as u32;
        for lane in 0..LANES {
            lanes[lane] += keep(bits, lane, x[LANES * group + lane]);
        }
    }
}

/// lanes += the kept x · y, for 64 texels.
#[inline(always)]
fn add_kept_products<T: Real>(lanes: &mut Lanes<T>, x: &[T; 64], y: &[T; 64], word: u64) {
    for group in 0..64 / LANES {
        let bits = (word >> (LANES * group)) as u32;
        for lane in 0..LANES {
            let i = LANES * group + lane;
            lanes[lane] += keep(bits, lane, x[i] * y[i]);
        }
    }
}

/// lanes += x · y, for 64 texels.
#[inline(always)]
fn add_products<T: Real, const N: usize>(lanes: &mut Lanes<T, N>, x: &[T; 64], y: &[T; 64]) {
    for group in 0..64 / N {
        for lane in 0..N {
            let i = N * group + lane;
            lanes[lane] += x[i] * y[i];
        }
    }
}

/// out = the kept x, for 64 texels.
#[inline(always)]
fn select<T: Real>(out: &mut [T; 64], x: &[T; 64], word: u64) {
    for group in 0..64 / LANES {
        let bits = (word >> (LANES * group)) as u32;
        for lane in 0..LANES {
            let i = LANES * group + lane;
            out[i] = keep(bits, lane, x[i]);
        }
    }
}

/// Σ over the kept of fewer than 64 texels, in f64.
#[inline(always)]
fn rest<T: Real>(len: usize, word: u64, value: impl Fn(usize) -> T) -> f64 {
    let mut total = 0.0;
    for i in 0..len {
        if word >> i & 1 == 1 {
            total += value(i).widen();
        }
    }
    total
}

impl<T: Real> NullaryFnOnce for Single<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let (whole, tail) = self.x.as_chunks::<64>();
        let mut total = 0.0;
        for (x, words) in whole.chunks(BLOCK).zip(self.words.chunks(BLOCK)) {
            let mut lanes = [T::zero(); LANES];
            for (x, &word) in x.iter().zip(words) {
                match word {
                    0 => {}
                    FULL => {
                        for group in 0..64 / LANES {
                            for lane in 0..LANES {
                                lanes[lane] += x[LANES * group + lane];
                            }
                        }
                    }
                    _ => add_kept(&mut lanes, x, word),
                }
            }
            total += fold(lanes);
        }
        if !tail.is_empty() {
            total += rest(tail.len(), self.words[whole.len()], |i| tail[i]);
        }
        total
    }
}

impl<T: Real, const C: usize> NullaryFnOnce for Several<'_, T, C> {
    type Output = [f64; C];

    #[inline(always)]
    fn call(self) -> [f64; C] {
        let Self { x, y, words } = self;
        let (whole, tail) = y.as_chunks::<64>();
        let mut total = [0.0; C];
        for (block, (y, words)) in whole.chunks(BLOCK).zip(words.chunks(BLOCK)).enumerate() {
            // Channel by channel: expanding the mask again is cheaper than storing the kept y between channels.
            for c in 0..C {
                let x = &x[c].as_chunks::<64>().0[BLOCK * block..][..y.len()];
                let mut lanes = [T::zero(); LANES];
                for ((x, y), &word) in x.iter().zip(y).zip(words) {
                    match word {
                        0 => {}
                        FULL => add_products(&mut lanes, x, y),
                        _ => add_kept_products(&mut lanes, x, y, word),
                    }
                }
                total[c] += fold(lanes);
            }
        }
        if !tail.is_empty() {
            let start = 64 * whole.len();
            for c in 0..C {
                total[c] += rest(tail.len(), words[whole.len()], |i| x[c][start + i] * tail[i]);
            }
        }
        total
    }
}

impl<T: Real> NullaryFnOnce for Unmasked<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { x, y, z } = self;
        let ((xs, x), (ys, y)) = (x.as_chunks::<64>(), y.as_chunks::<64>());
        let Some(z) = z else {
            let mut total = rest(x.len(), FULL, |i| x[i] * y[i]);
            for (xs, ys) in xs.chunks(BLOCK).zip(ys.chunks(BLOCK)) {
                let mut lanes = [T::zero(); WIDE];
                for (x, y) in xs.iter().zip(ys) {
                    add_products(&mut lanes, x, y);
                }
                total += fold(lanes);
            }
            return total;
        };
        let (zs, z) = z.as_chunks::<64>();
        let mut total = rest(x.len(), FULL, |i| x[i] * y[i] * z[i]);
        for ((xs, ys), zs) in xs.chunks(BLOCK).zip(ys.chunks(BLOCK)).zip(zs.chunks(BLOCK)) {
            let mut lanes = [T::zero(); WIDE];
            for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
                for group in 0..64 / WIDE {
                    for lane in 0..WIDE {
                        let i = WIDE * group + lane;
                        lanes[lane] += x[i] * y[i] * z[i];
                    }
                }
            }
            total += fold(lanes);
        }
        total
    }
}

impl<T: Real> NullaryFnOnce for Select<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (xs, x) = self.x.as_chunks::<64>();
        let (outs, out) = self.out.as_chunks_mut::<64>();
        for ((x, out), &word) in xs.iter().zip(outs).zip(self.words) {
            select(out, x, word);
        }
        for i in 0..x.len() {
            out[i] = keep((self.words[xs.len()] >> i) as u32, 0, x[i]);
        }
    }
}
