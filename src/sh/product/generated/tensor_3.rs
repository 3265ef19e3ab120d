//! 3 bands in straight lines. Written by `cargo run -p haarmonic-generate`.

use super::super::text::{Site, Straight};

pub(in super::super) struct Tensor3;

#[rustfmt::skip]
impl Straight for Tensor3 {
    const PRODUCT: usize = 96;

    /// 96 multiplications, 74 additions.
    #[inline(always)]
    fn product<P: Site>(p: &mut P) {
        let a0 = p.a(0);
        let a1 = p.a(1);
        let a2 = p.a(2);
        let a3 = p.a(3);
        let a4 = p.a(4);
        let a5 = p.a(5);
        let a6 = p.a(6);
        let a7 = p.a(7);
        let a8 = p.a(8);
        let b0 = p.b(0);
        let b1 = p.b(1);
        let b2 = p.b(2);
        let b3 = p.b(3);
        let b4 = p.b(4);
        let b5 = p.b(5);
        let b6 = p.b(6);
        let b7 = p.b(7);
        let b8 = p.b(8);
        let a_mean = p.literal(0.28209479177387814) * a0;
        let b_mean = p.literal(0.28209479177387814) * b0;
        let p0_0 = a0 * b0;
        let p1_1 = a1 * b1;
        let p2_2 = a2 * b2;
        let p3_3 = a3 * b3;
        let p4_4 = a4 * b4;
        let p5_5 = a5 * b5;
        let p6_6 = a6 * b6;
        let p7_7 = a7 * b7;
        let p8_8 = a8 * b8;
        let sum = p0_0 + p1_1 + p2_2 + p3_3 + p4_4 + p5_5 + p6_6 + p7_7 + p8_8;
        p.give(0, p.literal(0.28209479177387814) * sum);
        let p1_6 = a1 * b6 + a6 * b1;
        let p1_8 = a1 * b8 + a8 * b1;
        let p2_5 = a2 * b5 + a5 * b2;
        let p3_4 = a3 * b4 + a4 * b3;
        let s0 = p1_8 - p2_5 - p3_4;
        p.give(1, a_mean * b1 + b_mean * a1 + p.literal(-0.126156626101008) * p1_6 + p.literal(-0.21850968611841587) * s0);
        let p1_5 = a1 * b5 + a5 * b1;
        let p3_7 = a3 * b7 + a7 * b3;
        let s1 = p1_5 + p3_7;
        let p2_6 = a2 * b6 + a6 * b2;
        p.give(2, a_mean * b2 + b_mean * a2 + p.literal(0.2185096861184158) * s1 + p.literal(0.252313252202016) * p2_6);
        let p1_4 = a1 * b4 + a4 * b1;
        let p2_7 = a2 * b7 + a7 * b2;
        let p3_8 = a3 * b8 + a8 * b3;
        let s2 = p1_4 + p2_7 + p3_8;
        let p3_6 = a3 * b6 + a6 * b3;
        p.give(3, a_mean * b3 + b_mean * a3 + p.literal(0.21850968611841587) * s2 + p.literal(-0.126156626101008) * p3_6);
        let p1_3 = a1 * b3 + a3 * b1;
        let p4_6 = a4 * b6 + a6 * b4;
        let p5_7 = a5 * b7 + a7 * b5;
        p.give(4, a_mean * b4 + b_mean * a4 + p.literal(0.21850968611841587) * p1_3 + p.literal(-0.18022375157286857) * p4_6 + p.literal(0.15607834722743988) * p5_7);
        let p1_2 = a1 * b2 + a2 * b1;
        let p4_7 = a4 * b7 + a7 * b4;
        let p5_8 = a5 * b8 + a8 * b5;
        let s3 = p4_7 - p5_8;
        let p5_6 = a5 * b6 + a6 * b5;
        p.give(5, a_mean * b5 + b_mean * a5 + p.literal(0.2185096861184158) * p1_2 + p.literal(0.15607834722743988) * s3 + p.literal(0.09011187578643429) * p5_6);
        let s4 = p1_1 + p3_3;
        let s5 = p4_4 - p6_6 + p8_8;
        let s6 = p5_5 + p7_7;
        p.give(6, a_mean * b6 + b_mean * a6 + p.literal(-0.126156626101008) * s4 + p.literal(0.252313252202016) * p2_2 + p.literal(-0.18022375157286857) * s5 + p.literal(0.09011187578643429) * s6);
        let p2_3 = a2 * b3 + a3 * b2;
        let p4_5 = a4 * b5 + a5 * b4;
        let p7_8 = a7 * b8 + a8 * b7;
        let s7 = p4_5 + p7_8;
        let p6_7 = a6 * b7 + a7 * b6;
        p.give(7, a_mean * b7 + b_mean * a7 + p.literal(0.2185096861184158) * p2_3 + p.literal(0.15607834722743988) * s7 + p.literal(0.09011187578643429) * p6_7);
        let s8 = p1_1 - p3_3;
        let s9 = p5_5 - p7_7;
        let p6_8 = a6 * b8 + a8 * b6;
        p.give(8, a_mean * b8 + b_mean * a8 + p.literal(-0.21850968611841587) * s8 + p.literal(-0.15607834722743988) * s9 + p.literal(-0.18022375157286857) * p6_8);
    }

    const SQUARE: usize = 64;

    /// 64 multiplications, 43 additions.
    #[inline(always)]
    fn square<P: Site>(p: &mut P) {
        let a0 = p.a(0);
        let a1 = p.a(1);
        let a2 = p.a(2);
        let a3 = p.a(3);
        let a4 = p.a(4);
        let a5 = p.a(5);
        let a6 = p.a(6);
        let a7 = p.a(7);
        let a8 = p.a(8);
        let a_mean = p.literal(0.5641895835477563) * a0;
        let p0_0 = a0 * a0;
        let p1_1 = a1 * a1;
        let p2_2 = a2 * a2;
        let p3_3 = a3 * a3;
        let p4_4 = a4 * a4;
        let p5_5 = a5 * a5;
        let p6_6 = a6 * a6;
        let p7_7 = a7 * a7;
        let p8_8 = a8 * a8;
        let sum = p0_0 + p1_1 + p2_2 + p3_3 + p4_4 + p5_5 + p6_6 + p7_7 + p8_8;
        p.give(0, p.literal(0.28209479177387814) * sum);
        let p1_6 = a1 * a6;
        let p1_8 = a1 * a8;
        let p2_5 = a2 * a5;
        let p3_4 = a3 * a4;
        let s0 = p1_8 - p2_5 - p3_4;
        p.give(1, a_mean * a1 + p.literal(-0.252313252202016) * p1_6 + p.literal(-0.43701937223683174) * s0);
        let p1_5 = a1 * a5;
        let p3_7 = a3 * a7;
        let s1 = p1_5 + p3_7;
        let p2_6 = a2 * a6;
        p.give(2, a_mean * a2 + p.literal(0.4370193722368316) * s1 + p.literal(0.504626504404032) * p2_6);
        let p1_4 = a1 * a4;
        let p2_7 = a2 * a7;
        let p3_8 = a3 * a8;
        let s2 = p1_4 + p2_7 + p3_8;
        let p3_6 = a3 * a6;
        p.give(3, a_mean * a3 + p.literal(0.43701937223683174) * s2 + p.literal(-0.252313252202016) * p3_6);
        let p1_3 = a1 * a3;
        let p4_6 = a4 * a6;
        let p5_7 = a5 * a7;
        p.give(4, a_mean * a4 + p.literal(0.43701937223683174) * p1_3 + p.literal(-0.36044750314573715) * p4_6 + p.literal(0.31215669445487976) * p5_7);
        let p1_2 = a1 * a2;
        let p4_7 = a4 * a7;
        let p5_8 = a5 * a8;
        let s3 = p4_7 - p5_8;
        let p5_6 = a5 * a6;
        p.give(5, a_mean * a5 + p.literal(0.4370193722368316) * p1_2 + p.literal(0.31215669445487976) * s3 + p.literal(0.18022375157286857) * p5_6);
        let s4 = p1_1 + p3_3;
        let s5 = p4_4 - p6_6 + p8_8;
        let s6 = p5_5 + p7_7;
        p.give(6, a_mean * a6 + p.literal(-0.126156626101008) * s4 + p.literal(0.252313252202016) * p2_2 + p.literal(-0.18022375157286857) * s5 + p.literal(0.09011187578643429) * s6);
        let p2_3 = a2 * a3;
        let p4_5 = a4 * a5;
        let p7_8 = a7 * a8;
        let s7 = p4_5 + p7_8;
        let p6_7 = a6 * a7;
        p.give(7, a_mean * a7 + p.literal(0.4370193722368316) * p2_3 + p.literal(0.31215669445487976) * s7 + p.literal(0.18022375157286857) * p6_7);
        let s8 = p1_1 - p3_3;
        let s9 = p5_5 - p7_7;
        let p6_8 = a6 * a8;
        p.give(8, a_mean * a8 + p.literal(-0.21850968611841587) * s8 + p.literal(-0.15607834722743988) * s9 + p.literal(-0.36044750314573715) * p6_8);
    }
}
