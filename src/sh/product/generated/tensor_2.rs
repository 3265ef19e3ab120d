//! 2 bands in straight lines. Written by `cargo run -p haarmonic-generate`.

use super::super::text::{Site, Straight};

pub(in super::super) struct Tensor2;

#[rustfmt::skip]
impl Straight for Tensor2 {
    const PRODUCT: usize = 13;

    /// 13 multiplications, 6 additions.
    #[inline(always)]
    fn product<P: Site>(p: &mut P) {
        let a0 = p.a(0);
        let a1 = p.a(1);
        let a2 = p.a(2);
        let a3 = p.a(3);
        let b0 = p.b(0);
        let b1 = p.b(1);
        let b2 = p.b(2);
        let b3 = p.b(3);
        let a_mean = p.literal(0.28209479177387814) * a0;
        let b_mean = p.literal(0.28209479177387814) * b0;
        let p0_0 = a0 * b0;
        let p1_1 = a1 * b1;
        let p2_2 = a2 * b2;
        let p3_3 = a3 * b3;
        let sum = p0_0 + p1_1 + p2_2 + p3_3;
        p.give(0, p.literal(0.28209479177387814) * sum);
        p.give(1, a_mean * b1 + b_mean * a1);
        p.give(2, a_mean * b2 + b_mean * a2);
        p.give(3, a_mean * b3 + b_mean * a3);
    }

    const SQUARE: usize = 9;

    /// 9 multiplications, 3 additions.
    #[inline(always)]
    fn square<P: Site>(p: &mut P) {
        let a0 = p.a(0);
        let a1 = p.a(1);
        let a2 = p.a(2);
        let a3 = p.a(3);
        let a_mean = p.literal(0.5641895835477563) * a0;
        let p0_0 = a0 * a0;
        let p1_1 = a1 * a1;
        let p2_2 = a2 * a2;
        let p3_3 = a3 * a3;
        let sum = p0_0 + p1_1 + p2_2 + p3_3;
        p.give(0, p.literal(0.28209479177387814) * sum);
        p.give(1, a_mean * a1);
        p.give(2, a_mean * a2);
        p.give(3, a_mean * a3);
    }
}
