//! Sums over the texels that a 1-bit mask keeps.

use pulp::{Arch, NullaryFnOnce};

use crate::Real;
use crate::error::{check_length, length_mismatch};

/// Texels whose f32 sums are folded into f64 at once.
const BLOCK: usize = 1024;
/// Independent partial sums.
const LANES: usize = 16;

/// Dot products under a 1-bit mask, vectorised for the machine it runs on.
///
/// Texel i is kept if bit i mod 64 of word i / 64 is set. Any order of texels will do as long as texels and bits share it.
/// Spare bits of the last word are ignored. All-zero words are skipped, all-one words take a path without a mask.
/// Accuracy: f32 texels are summed in 16 lanes of f32 over blocks of 1024 texels, then in f64: relative to Σ |terms| within
/// 64 · 2⁻²⁴ at worst and about 4 · 2⁻²⁴ in practice. f64 texels: the same lanes in f64.
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
    /// Looks up what the machine can do.
    pub fn new() -> Self {
        Self { arch: Arch::new() }
    }

    /// Σ over kept texels of x.
    ///
    /// # Panics
    /// If there are not ⌈texels / 64⌉ words.
    pub fn sum<T: Real>(&self, x: &[T], words: &[u64]) -> f64 {
        check_length("mask words", x.len().div_ceil(64), words.len());
        self.arch.dispatch(Single { x, words })
    }

    /// Σ over kept texels of x · y.
    ///
    /// # Panics
    /// If x and y differ in length or there are not ⌈texels / 64⌉ words.
    pub fn dot<T: Real>(&self, x: &[T], y: &[T], words: &[u64]) -> f64 {
        self.dots([x], y, words)[0]
    }

    /// Σ over kept texels of x_c · y for several channels x_c (an RGB light against one BRDF).
    ///
    /// # Panics
    /// If a channel and y differ in length or there are not ⌈texels / 64⌉ words.
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
    pub fn dot_unmasked<T: Real>(&self, x: &[T], y: &[T]) -> f64 {
        check_length("texels", x.len(), y.len());
        self.arch.dispatch(Unmasked { x, y, z: None })
    }

    /// Σ x · y · z.
    ///
    /// # Panics
    /// If lengths differ.
    pub fn dot_three<T: Real>(&self, x: &[T], y: &[T], z: &[T]) -> f64 {
        check_length("texels", x.len(), y.len());
        check_length("texels", x.len(), z.len());
        self.arch.dispatch(Unmasked { x, y, z: Some(z) })
    }

    /// out = x where kept, 0 elsewhere.
    ///
    /// # Panics
    /// If x and out differ in length or there are not ⌈texels / 64⌉ words.
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

#[inline(always)]
fn fold<T: Real>(lanes: &[T; LANES]) -> f64 {
    lanes.iter().map(|x| x.widen()).sum()
}

/// The value where bit `lane` of `bits` is set, else 0: a compare and a blend once vectorised.
#[inline(always)]
fn keep<T: Real>(bits: u32, lane: usize, value: T) -> T {
    if bits & 1 << lane == 0 { T::zero() } else { value }
}

/// Adds the kept `value(i)` of 64 texels to the lanes.
#[inline(always)]
fn add_word<T: Real>(word: u64, lanes: &mut [T; LANES], value: impl Fn(usize) -> T) {
    if word == 0 {
        return;
    }
    for group in 0..64 / LANES {
        let bits = (word >> (LANES * group)) as u32;
        for lane in 0..LANES {
            let v = value(LANES * group + lane);
            lanes[lane] += if word == !0 { v } else { keep(bits, lane, v) };
        }
    }
}

impl<T: Real> NullaryFnOnce for Single<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut total = 0.0;
        for (x, words) in self.x.chunks(BLOCK).zip(self.words.chunks(BLOCK / 64)) {
            let mut lanes = [T::zero(); LANES];
            let (whole, rest) = x.as_chunks::<64>();
            for (x, &word) in whole.iter().zip(words) {
                add_word(word, &mut lanes, |i| x[i]);
            }
            for (i, &x) in rest.iter().enumerate() {
                lanes[i % LANES] += keep((words[whole.len()] >> i) as u32, 0, x);
            }
            total += fold(&lanes);
        }
        total
    }
}

impl<T: Real, const C: usize> NullaryFnOnce for Several<'_, T, C> {
    type Output = [f64; C];

    #[inline(always)]
    fn call(self) -> [f64; C] {
        let Self { x, y, words } = self;
        let mut total = [0.0; C];
        for (block, (y, words)) in y.chunks(BLOCK).zip(words.chunks(BLOCK / 64)).enumerate() {
            let x = x.map(|x| &x[block * BLOCK..][..y.len()]);
            let mut lanes = [[T::zero(); LANES]; C];
            let (whole, rest) = y.as_chunks::<64>();
            let wholes = x.map(|x| x.as_chunks::<64>().0);
            for (n, (y, &word)) in whole.iter().zip(words).enumerate() {
                for (lanes, x) in lanes.iter_mut().zip(wholes) {
                    let x = &x[n];
                    add_word(word, lanes, |i| x[i] * y[i]);
                }
            }
            for (i, &y) in rest.iter().enumerate() {
                for (lanes, x) in lanes.iter_mut().zip(x) {
                    lanes[i % LANES] += keep((words[whole.len()] >> i) as u32, 0, x[64 * whole.len() + i] * y);
                }
            }
            for (total, lanes) in total.iter_mut().zip(&lanes) {
                *total += fold(lanes);
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
        let mut total = 0.0;
        for start in (0..x.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(x.len());
            let mut lanes = [T::zero(); LANES];
            let (x, y) = (&x[start..end], &y[start..end]);
            let ((xs, x_rest), (ys, y_rest)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
            if let Some(z) = z {
                let (zs, z_rest) = z[start..end].as_chunks::<LANES>();
                for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
                    (0..LANES).for_each(|i| lanes[i] += x[i] * y[i] * z[i]);
                }
                (0..x_rest.len()).for_each(|i| lanes[i] += x_rest[i] * y_rest[i] * z_rest[i]);
            } else {
                for (x, y) in xs.iter().zip(ys) {
                    (0..LANES).for_each(|i| lanes[i] += x[i] * y[i]);
                }
                (0..x_rest.len()).for_each(|i| lanes[i] += x_rest[i] * y_rest[i]);
            }
            total += fold(&lanes);
        }
        total
    }
}

impl<T: Real> NullaryFnOnce for Select<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for ((x, out), &word) in self.x.chunks(64).zip(self.out.chunks_mut(64)).zip(self.words) {
            if let (Ok(x), Ok(out)) = (<&[T; 64]>::try_from(x), <&mut [T; 64]>::try_from(&mut *out)) {
                for group in 0..64 / LANES {
                    let bits = (word >> (LANES * group)) as u32;
                    (0..LANES).for_each(|i| out[LANES * group + i] = keep(bits, i, x[LANES * group + i]));
                }
            } else {
                x.iter().zip(out).enumerate().for_each(|(i, (&x, out))| *out = keep((word >> i) as u32, 0, x));
            }
        }
    }
}
