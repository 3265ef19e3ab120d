//! The matrices of a rotation, degree by degree.
//!
//! y(Rω) = M y(ω) splits into a block M_l for each degree. x, y and z times degree l − 1 reach degree l, which determines M_l
//! by M_{l−1} and M_1 = R. In M_l's entry (m, m'), z y_{l−1,m'} stands for y_{l,m'}, and (x ± iy) times y_{l−1,±(l−1)} where m' = ±l;
//! on the side of m all neighbours at distance 1 contribute:
//!
//!   M_l(m, m') = u P_0(m, m') + v V(m, m') + w W(m, m'),   P_i(a, b) = Σ_j M_1(i, j)·M_{l−1}(a, b')
//!                        [Ivanic & Ruedenberg 1996 with the corrections of 1998; holds for reflections too]
//!
//! u, v, w are ratios of the Clebsch–Gordan numbers of both sides. For |m| > |m'| they are below 1, for |m| < |m'| up to
//! √(l/2), which loses digits, while M_l(m, m')'s sums below |m'| cancel: so only the columns |m'| ≤ |m| … are taken from it.

