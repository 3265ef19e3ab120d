//! Atom × atom: always an atom again.

use super::atom::root_power;
use super::{Atom, Mother};

/// ±2^{e/2} times an atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ScaledAtom {
    /// Whether the sign is −.
    pub negative: bool,
    /// e.
    pub half_exponent: u32,
    /// The atom.
    pub atom: Atom,
}

impl ScaledAtom {
    /// ±2^{e/2}, correctly rounded.
    #[inline]
    pub fn factor(self) -> f64 {
        let magnitude = root_power(self.half_exponent as i32);
        if self.negative { -magnitude } else { magnitude }
    }
}

impl Atom {
    /// The product of two atoms of any level: none where they do not meet, else ±2^{l/2} times an atom, l the coarser
    /// level.
    ///
    /// | f coarse, g fine | f g |
    /// |---|---|
    /// | the support of g outside that of f | 0 |
    /// | φ_{l,t}, g inside | 2^{l/2} g |
    /// | ψ_{l,t}, g in its first, second half | 2^{l/2} g, −2^{l/2} g |
    /// | φ φ or ψ ψ, of one support | 2^{l/2} φ_{l,t} |
    /// | φ ψ, of one support | 2^{l/2} ψ_{l,t} |
    ///
    /// # Panics
    /// If a level is above 63.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{Atom, Mother};
    /// let product = Atom::from_flat(2).product(Atom::from_flat(5)).unwrap(); // ψ_{1,0} on its second half
    /// assert_eq!((product.factor(), product.atom), (-(2f64.sqrt()), Atom::from_flat(5)));
    /// assert_eq!(Atom::from_flat(2).product(Atom::from_flat(3)), None);
    /// let square = Atom::from_flat(2).product(Atom::from_flat(2)).unwrap();
    /// assert_eq!(square.atom.mother, Mother::Scaling);
    /// ```
    #[inline]
    #[track_caller]
    pub fn product(self, other: Self) -> Option<ScaledAtom> {
        let (coarse, fine) = if self.level <= other.level { (self, other) } else { (other, self) };
        fine.check();
        let below = fine.level - coarse.level;
        if fine.offset >> below != coarse.offset {
            return None;
        }
        let mut product = ScaledAtom { negative: false, half_exponent: coarse.level, atom: fine };
        if below == 0 {
            product.atom.mother = if coarse.mother == fine.mother { Mother::Scaling } else { Mother::Wavelet };
        } else if coarse.mother == Mother::Wavelet {
            product.negative = fine.offset >> (below - 1) & 1 == 1;
        }
        Some(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(atom: Atom, v: f64) -> f64 {
        let u = v * 2f64.powi(atom.level as i32) - atom.offset as f64;
        let mother = match atom.mother {
            _ if !(0.0..1.0).contains(&u) => 0.0,
            Mother::Wavelet if u >= 0.5 => -1.0,
            _ => 1.0,
        };
        mother * 2f64.powf(f64::from(atom.level) / 2.0)
    }

    #[test]
    fn a_product_of_atoms_has_the_product_of_their_values() {
        let atoms: Vec<Atom> = (0..4)
            .flat_map(|level| (0..1 << level).map(move |offset| (level, offset)))
            .flat_map(|(level, offset)| Mother::ALL.map(|mother| Atom { mother, level, offset }))
            .collect();
        for &f in &atoms {
            for &g in &atoms {
                let product = f.product(g);
                for k in 0..32 {
                    let v = (f64::from(k) + 0.5) / 32.0;
                    let got = product.map_or(0.0, |p| p.factor() * value(p.atom, v));
                    let want = value(f, v) * value(g, v);
                    assert!((got - want).abs() <= 4.0 * f64::EPSILON * want.abs(), "{f:?} {g:?} at {v}: {got} {want}");
                }
            }
        }
    }
}
