//! The three turns of a rotation, R = R_z(α) R_y(β) R_z(γ), for W rotations at once.
//!
//! Of a quaternion, whatever its length: with p = w² + z² and q = x² + y²
//!
//! ```math
//! e^{iα} = (w + iz)(y − ix)/√(pq),  e^{iγ} = (w + iz)(y + ix)/√(pq),  e^{iβ} = (p − q + 2i√(pq))/(p + q)
//! ```
//!
//! No angle is formed. Where pq vanishes the axis of the second turn is lost, β is 0 or π, and α alone is left:
//! [`Flat`].

use nalgebra::{Rotation3, UnitQuaternion};

use crate::Real;

/// Unit complex numbers [cos, sin] of each turn.
pub(super) struct Turns<T, const W: usize> {
    pub alpha: [[T; W]; 2],
    pub beta: [[T; W]; 2],
    pub gamma: [[T; W]; 2],
}

/// A rotation that keeps the z axis, or reverses it: a half turn about y (if `reverses`), then a turn about z by [cos,
/// sin].
pub(super) struct Flat<T> {
    pub reverses: bool,
    pub turn: [T; 2],
}

impl<T: Real, const W: usize> Turns<T, W> {
    /// One step of Newton towards length 1, u (3 − |u|²)/2: a power m has m times the error of the length.
    #[inline(always)]
    fn normalized(mut self) -> Self {
        let (half, more) = (T::of(0.5), T::of(1.5));
        for unit in [&mut self.alpha, &mut self.beta, &mut self.gamma] {
            for i in 0..W {
                let (c, s) = (unit[0][i], unit[1][i]);
                let scale = more - half * (c * c + s * s);
                unit[0][i] = c * scale;
                unit[1][i] = s * scale;
            }
        }
        self
    }
}

/// Rotations in structure-of-arrays form.
pub(super) enum Poses<'a, T> {
    /// Components x, y, z, w.
    Quaternions([&'a [T]; 4]),
    /// The nine entries, row by row.
    Matrices([&'a [T]; 9]),
}

impl<T: Real> Poses<'_, T> {
    /// The turns of rotations first..first + W, and sin²β up to a factor: below [`tiny`], the rotation is to be taken
    /// from [`flat`](Self::flat) and its turns mean nothing.
    #[inline(always)]
    pub(super) fn turns<const W: usize>(&self, first: usize) -> (Turns<T, W>, [T; W]) {
        let at = |c: &[T]| load::<T, W>(c, first, T::one());
        match self {
            Self::Quaternions([x, y, z, w]) => quaternion_turns(&[at(x), at(y), at(z), at(w)]),
            Self::Matrices([a, b, c, d, e, f, g, h, i]) => {
                matrix_turns(&[at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h), at(i)])
            }
        }
    }

    /// Rotation `at`, one whose axis is lost.
    pub(super) fn flat(&self, at: usize) -> Flat<T> {
        match self {
            Self::Quaternions(q) => quaternion_flat(q.map(|c| c[at])),
            Self::Matrices(r) => matrix_flat(&r.map(|c| c[at])),
        }
    }
}

/// sin²β that is taken for 0: far below eps², and its relative accuracy is full.
#[inline(always)]
pub(super) fn tiny<T: Real>() -> T {
    T::min_positive_value() / (T::epsilon() * T::epsilon())
}

fn unit<T: Real>(re: T, im: T) -> [T; 2] {
    let size = (re * re + im * im).sqrt();
    // A NaN stays one.
    if size == T::zero() { [T::one(), T::zero()] } else { [re / size, im / size] }
}

/// W values from `first`, padded with `pad` beyond the end.
#[inline(always)]
pub(super) fn load<T: Real, const W: usize>(values: &[T], first: usize, pad: T) -> [T; W] {
    let rest = &values[first..];
    match rest.first_chunk::<W>() {
        Some(block) => *block,
        None => {
            let mut block = [pad; W];
            block[..rest.len()].copy_from_slice(rest);
            block
        }
    }
}

/// The turns of quaternions and their p q.
#[inline(always)]
pub(super) fn quaternion_turns<T: Real, const W: usize>([x, y, z, w]: &[[T; W]; 4]) -> (Turns<T, W>, [T; W]) {
    let one = T::one();
    let zero = [[T::zero(); W]; 2];
    let mut turns = Turns { alpha: zero, beta: zero, gamma: zero };
    let mut across = [T::zero(); W];
    for i in 0..W {
        let (p, q) = (w[i] * w[i] + z[i] * z[i], x[i] * x[i] + y[i] * y[i]);
        across[i] = p * q;
        let root = across[i].sqrt();
        let (scale, whole) = (one / root, one / (p + q));
        let (wy, zx, zy, wx) = (w[i] * y[i], z[i] * x[i], z[i] * y[i], w[i] * x[i]);
        turns.alpha[0][i] = (wy + zx) * scale;
        turns.alpha[1][i] = (zy - wx) * scale;
        turns.beta[0][i] = (p - q) * whole;
        turns.beta[1][i] = (root + root) * whole;
        turns.gamma[0][i] = (wy - zx) * scale;
        turns.gamma[1][i] = (zy + wx) * scale;
    }
    (turns.normalized(), across)
}

pub(super) fn quaternion_flat<T: Real>([x, y, z, w]: [T; 4]) -> Flat<T> {
    let reverses = w * w + z * z < x * x + y * y;
    let (re, im) = if reverses { (y, -x) } else { (w, z) };
    // The square of the unit number: squares of (re, im) themselves may underflow.
    let [c, s] = unit(re, im);
    Flat { reverses, turn: [c * c - s * s, c * s + s * c] }
}

/// α and β are the third column's direction, (R02 + iR12, R22). γ must fit α where both are ill-defined, so it is taken
/// from what the other entries know best: (R00 + R11, R10 − R01) = (1 + cos β) e^{i(α+γ)} above the equator, (R11 −
/// R00, −R10 − R01) = (1 − cos β) e^{i(α−γ)} below.
#[inline(always)]
pub(super) fn matrix_turns<T: Real, const W: usize>(r: &[[T; W]; 9]) -> (Turns<T, W>, [T; W]) {
    let one = T::one();
    let [r00, r01, r02, r10, r11, r12, _, _, r22] = r;
    let zero = [[T::zero(); W]; 2];
    let mut turns = Turns { alpha: zero, beta: zero, gamma: zero };
    let mut across = [T::zero(); W];
    for i in 0..W {
        across[i] = r02[i] * r02[i] + r12[i] * r12[i];
        let root = across[i].sqrt();
        let (scale, whole) = (one / root, one / (across[i] + r22[i] * r22[i]).sqrt());
        let (c, s) = (r02[i] * scale, r12[i] * scale);
        let up = if r22[i] >= T::zero() { one } else { -one };
        let (re, im) = (r11[i] + up * r00[i], r10[i] - up * r01[i]);
        let size = one / (re * re + im * im).sqrt();
        // Above: (re + i im) e^{−iα}. Below: e^{iα} (re + i im).
        let turned = up * s;
        turns.alpha[0][i] = c;
        turns.alpha[1][i] = s;
        turns.beta[0][i] = r22[i] * whole;
        turns.beta[1][i] = root * whole;
        turns.gamma[0][i] = (re * c + im * turned) * size;
        turns.gamma[1][i] = (im * c - re * turned) * size;
    }
    (turns.normalized(), across)
}

pub(super) fn matrix_flat<T: Real>(r: &[T; 9]) -> Flat<T> {
    let reverses = r[8] < T::zero();
    let turn = if reverses { unit(r[4] - r[0], -r[3] - r[1]) } else { unit(r[0] + r[4], r[3] - r[1]) };
    Flat { reverses, turn }
}

/// One rotation's nine numbers, as [`Poses`] wants them.
#[inline(always)]
pub(super) fn entries<T: Real>(rotation: &Rotation3<T>) -> [T; 9] {
    let r = rotation.matrix();
    [r.m11, r.m12, r.m13, r.m21, r.m22, r.m23, r.m31, r.m32, r.m33]
}

/// One rotation's four numbers, as [`Poses`] wants them.
#[inline(always)]
pub(super) fn components<T: Real>(rotation: &UnitQuaternion<T>) -> [T; 4] {
    let q = rotation.as_ref().coords;
    [q.x, q.y, q.z, q.w]
}
