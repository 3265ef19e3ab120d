//! Products in straight lines, written by `haarmonic-generate`.

pub(super) mod quadrature_4;
pub(super) mod quadrature_5;
pub(super) mod quadrature_6;
pub(super) mod quadrature_7;
pub(super) mod quadrature_8;
pub(super) mod tensor_2;
pub(super) mod tensor_3;
