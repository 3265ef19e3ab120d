//! All y of 1 to 8 bands at one direction, in straight lines. Written by `cargo run -p haarmonic-generate`.

use crate::Real;

/// 0 multiplications, 0 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_1<T: Real>([_, _, _]: [T; 3], out: &mut [T; 1]) {
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
}

/// 3 multiplications, 0 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_2<T: Real>([x, y, z]: [T; 3], out: &mut [T; 4]) {
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
}

/// 14 multiplications, 3 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_3<T: Real>([x, y, z]: [T; 3], out: &mut [T; 9]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
}

/// 28 multiplications, 7 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_4<T: Real>([x, y, z]: [T; 3], out: &mut [T; 16]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let q3 = z * (T::of(1.865881662950577) * square - T::of(1.119528997770346));
    out[12] = q3;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let q3 = T::of(2.2852289973223288) * square - T::of(0.4570457994644657);
    out[13] = q3 * c;
    out[11] = q3 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
    let q3 = T::of(1.4453057213202773) * z;
    out[14] = q3 * c;
    out[10] = q3 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q3 = T::of(0.5900435899266435);
    out[15] = q3 * c;
    out[9] = q3 * s;
}

/// 47 multiplications, 12 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_5<T: Real>([x, y, z]: [T; 3], out: &mut [T; 25]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let q3 = z * (T::of(1.865881662950577) * square - T::of(1.119528997770346));
    out[12] = q3;
    let q4 = (T::of(1.984313483298443) * z) * q3 - T::of(1.0062305898749053) * q2;
    out[20] = q4;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let q3 = T::of(2.2852289973223288) * square - T::of(0.4570457994644657);
    out[13] = q3 * c;
    out[11] = q3 * s;
    let q4 = z * (T::of(4.683325804901025) * square - T::of(2.0071396306718676));
    out[21] = q4 * c;
    out[19] = q4 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
    let q3 = T::of(1.4453057213202773) * z;
    out[14] = q3 * c;
    out[10] = q3 * s;
    let q4 = T::of(3.3116114351514603) * square - T::of(0.47308734787878004);
    out[22] = q4 * c;
    out[18] = q4 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q3 = T::of(0.5900435899266435);
    out[15] = q3 * c;
    out[9] = q3 * s;
    let q4 = T::of(1.7701307697799304) * z;
    out[23] = q4 * c;
    out[17] = q4 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q4 = T::of(0.6258357354491761);
    out[24] = q4 * c;
    out[16] = q4 * s;
}

/// 71 multiplications, 18 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_6<T: Real>([x, y, z]: [T; 3], out: &mut [T; 36]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let q3 = z * (T::of(1.865881662950577) * square - T::of(1.119528997770346));
    out[12] = q3;
    let q4 = (T::of(1.984313483298443) * z) * q3 - T::of(1.0062305898749053) * q2;
    out[20] = q4;
    let q5 = (T::of(1.98997487421324) * z) * q4 - T::of(1.002853072844814) * q3;
    out[30] = q5;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let q3 = T::of(2.2852289973223288) * square - T::of(0.4570457994644657);
    out[13] = q3 * c;
    out[11] = q3 * s;
    let q4 = z * (T::of(4.683325804901025) * square - T::of(2.0071396306718676));
    out[21] = q4 * c;
    out[19] = q4 * s;
    let q5 = (T::of(2.03100960115899) * z) * q4 - T::of(0.9910312089651149) * q3;
    out[31] = q5 * c;
    out[29] = q5 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
    let q3 = T::of(1.4453057213202773) * z;
    out[14] = q3 * c;
    out[10] = q3 * s;
    let q4 = T::of(3.3116114351514603) * square - T::of(0.47308734787878004);
    out[22] = q4 * c;
    out[18] = q4 * s;
    let q5 = z * (T::of(7.190305177459987) * square - T::of(2.396768392486662));
    out[32] = q5 * c;
    out[28] = q5 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q3 = T::of(0.5900435899266435);
    out[15] = q3 * c;
    out[9] = q3 * s;
    let q4 = T::of(1.7701307697799304) * z;
    out[23] = q4 * c;
    out[17] = q4 * s;
    let q5 = T::of(4.403144694917253) * square - T::of(0.4892382994352504);
    out[33] = q5 * c;
    out[27] = q5 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q4 = T::of(0.6258357354491761);
    out[24] = q4 * c;
    out[16] = q4 * s;
    let q5 = T::of(2.075662314881041) * z;
    out[34] = q5 * c;
    out[26] = q5 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q5 = T::of(0.6563820568401701);
    out[35] = q5 * c;
    out[25] = q5 * s;
}

/// 100 multiplications, 25 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_7<T: Real>([x, y, z]: [T; 3], out: &mut [T; 49]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let q3 = z * (T::of(1.865881662950577) * square - T::of(1.119528997770346));
    out[12] = q3;
    let q4 = (T::of(1.984313483298443) * z) * q3 - T::of(1.0062305898749053) * q2;
    out[20] = q4;
    let q5 = (T::of(1.98997487421324) * z) * q4 - T::of(1.002853072844814) * q3;
    out[30] = q5;
    let q6 = (T::of(1.9930434571835665) * z) * q5 - T::of(1.0015420209622192) * q4;
    out[42] = q6;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let q3 = T::of(2.2852289973223288) * square - T::of(0.4570457994644657);
    out[13] = q3 * c;
    out[11] = q3 * s;
    let q4 = z * (T::of(4.683325804901025) * square - T::of(2.0071396306718676));
    out[21] = q4 * c;
    out[19] = q4 * s;
    let q5 = (T::of(2.03100960115899) * z) * q4 - T::of(0.9910312089651149) * q3;
    out[31] = q5 * c;
    out[29] = q5 * s;
    let q6 = (T::of(2.0213149892370277) * z) * q5 - T::of(0.9952267030562386) * q4;
    out[43] = q6 * c;
    out[41] = q6 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
    let q3 = T::of(1.4453057213202773) * z;
    out[14] = q3 * c;
    out[10] = q3 * s;
    let q4 = T::of(3.3116114351514603) * square - T::of(0.47308734787878004);
    out[22] = q4 * c;
    out[18] = q4 * s;
    let q5 = z * (T::of(7.190305177459987) * square - T::of(2.396768392486662));
    out[32] = q5 * c;
    out[28] = q5 * s;
    let q6 = (T::of(2.1139418156609704) * z) * q5 - T::of(0.9736101204623269) * q4;
    out[44] = q6 * c;
    out[40] = q6 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q3 = T::of(0.5900435899266435);
    out[15] = q3 * c;
    out[9] = q3 * s;
    let q4 = T::of(1.7701307697799304) * z;
    out[23] = q4 * c;
    out[17] = q4 * s;
    let q5 = T::of(4.403144694917253) * square - T::of(0.4892382994352504);
    out[33] = q5 * c;
    out[27] = q5 * s;
    let q6 = z * (T::of(10.133257854664159) * square - T::of(2.763615778544771));
    out[45] = q6 * c;
    out[39] = q6 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q4 = T::of(0.6258357354491761);
    out[24] = q4 * c;
    out[16] = q4 * s;
    let q5 = T::of(2.075662314881041) * z;
    out[34] = q5 * c;
    out[26] = q5 * s;
    let q6 = T::of(5.550213908015966) * square - T::of(0.5045649007287242);
    out[46] = q6 * c;
    out[38] = q6 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q5 = T::of(0.6563820568401701);
    out[35] = q5 * c;
    out[25] = q5 * s;
    let q6 = T::of(2.366619162231752) * z;
    out[47] = q6 * c;
    out[37] = q6 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q6 = T::of(0.6831841051919143);
    out[48] = q6 * c;
    out[36] = q6 * s;
}

/// 134 multiplications, 33 additions.
#[rustfmt::skip]
#[inline(always)]
pub(super) fn eval_8<T: Real>([x, y, z]: [T; 3], out: &mut [T; 64]) {
    let square = z * z;
    let q0 = T::of(0.28209479177387814);
    out[0] = q0;
    let q1 = T::of(0.48860251190291987) * z;
    out[2] = q1;
    let q2 = T::of(0.94617469575756) * square - T::of(0.31539156525252);
    out[6] = q2;
    let q3 = z * (T::of(1.865881662950577) * square - T::of(1.119528997770346));
    out[12] = q3;
    let q4 = (T::of(1.984313483298443) * z) * q3 - T::of(1.0062305898749053) * q2;
    out[20] = q4;
    let q5 = (T::of(1.98997487421324) * z) * q4 - T::of(1.002853072844814) * q3;
    out[30] = q5;
    let q6 = (T::of(1.9930434571835665) * z) * q5 - T::of(1.0015420209622192) * q4;
    out[42] = q6;
    let q7 = (T::of(1.9948914348241344) * z) * q6 - T::of(1.000927213921958) * q5;
    out[56] = q7;
    let (c, s) = (x, y);
    let q1 = T::of(0.4886025119029199);
    out[3] = q1 * c;
    out[1] = q1 * s;
    let q2 = T::of(1.0925484305920792) * z;
    out[7] = q2 * c;
    out[5] = q2 * s;
    let q3 = T::of(2.2852289973223288) * square - T::of(0.4570457994644657);
    out[13] = q3 * c;
    out[11] = q3 * s;
    let q4 = z * (T::of(4.683325804901025) * square - T::of(2.0071396306718676));
    out[21] = q4 * c;
    out[19] = q4 * s;
    let q5 = (T::of(2.03100960115899) * z) * q4 - T::of(0.9910312089651149) * q3;
    out[31] = q5 * c;
    out[29] = q5 * s;
    let q6 = (T::of(2.0213149892370277) * z) * q5 - T::of(0.9952267030562386) * q4;
    out[43] = q6 * c;
    out[41] = q6 * s;
    let q7 = (T::of(2.0155644370746373) * z) * q6 - T::of(0.9971550440218321) * q5;
    out[57] = q7 * c;
    out[55] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q2 = T::of(0.5462742152960396);
    out[8] = q2 * c;
    out[4] = q2 * s;
    let q3 = T::of(1.4453057213202773) * z;
    out[14] = q3 * c;
    out[10] = q3 * s;
    let q4 = T::of(3.3116114351514603) * square - T::of(0.47308734787878004);
    out[22] = q4 * c;
    out[18] = q4 * s;
    let q5 = z * (T::of(7.190305177459987) * square - T::of(2.396768392486662));
    out[32] = q5 * c;
    out[28] = q5 * s;
    let q6 = (T::of(2.1139418156609704) * z) * q5 - T::of(0.9736101204623269) * q4;
    out[44] = q6 * c;
    out[40] = q6 * s;
    let q7 = (T::of(2.0816659994661326) * z) * q6 - T::of(0.9847319278346619) * q5;
    out[58] = q7 * c;
    out[54] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q3 = T::of(0.5900435899266435);
    out[15] = q3 * c;
    out[9] = q3 * s;
    let q4 = T::of(1.7701307697799304) * z;
    out[23] = q4 * c;
    out[17] = q4 * s;
    let q5 = T::of(4.403144694917253) * square - T::of(0.4892382994352504);
    out[33] = q5 * c;
    out[27] = q5 * s;
    let q6 = z * (T::of(10.133257854664159) * square - T::of(2.763615778544771));
    out[45] = q6 * c;
    out[39] = q6 * s;
    let q7 = (T::of(2.207940216581962) * z) * q6 - T::of(0.9594032236002469) * q5;
    out[59] = q7 * c;
    out[53] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q4 = T::of(0.6258357354491761);
    out[24] = q4 * c;
    out[16] = q4 * s;
    let q5 = T::of(2.075662314881041) * z;
    out[34] = q5 * c;
    out[26] = q5 * s;
    let q6 = T::of(5.550213908015966) * square - T::of(0.5045649007287242);
    out[46] = q6 * c;
    out[38] = q6 * s;
    let q7 = z * (T::of(13.491805046726768) * square - T::of(3.113493472321562));
    out[60] = q7 * c;
    out[52] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q5 = T::of(0.6563820568401701);
    out[35] = q5 * c;
    out[25] = q5 * s;
    let q6 = T::of(2.366619162231752) * z;
    out[47] = q6 * c;
    out[37] = q6 * s;
    let q7 = T::of(6.745902523363385) * square - T::of(0.5189155787202604);
    out[61] = q7 * c;
    out[51] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q6 = T::of(0.6831841051919143);
    out[48] = q6 * c;
    out[36] = q6 * s;
    let q7 = T::of(2.6459606618019) * z;
    out[62] = q7 * c;
    out[50] = q7 * s;
    let (c, s) = (x * c - y * s, x * s + y * c);
    let q7 = T::of(0.7071627325245963);
    out[63] = q7 * c;
    out[49] = q7 * s;
}
