//! Comparisons with a tolerance.

use approx::{AbsDiffEq, RelativeEq};
use nalgebra::Vector3;

use super::{Bounds, LocalFrame, Mesh};

/// Compares vectors one by one; lists of different length differ.
fn all_alike<'a>(
    a: impl IntoIterator<Item = &'a Vector3<f32>, IntoIter: ExactSizeIterator>,
    b: impl IntoIterator<Item = &'a Vector3<f32>, IntoIter: ExactSizeIterator>,
    alike: impl Fn(&Vector3<f32>, &Vector3<f32>) -> bool,
) -> bool {
    let (a, b) = (a.into_iter(), b.into_iter());
    a.len() == b.len() && a.zip(b).all(|(x, y)| alike(x, y))
}

macro_rules! approx_by_vectors {
    ($type:ty, |$value:ident| [$($part:expr),+], |$a:ident, $b:ident| $also:expr) => {
        impl AbsDiffEq for $type {
            type Epsilon = f32;
            fn default_epsilon() -> f32 {
                f32::default_epsilon()
            }
            fn abs_diff_eq(&self, other: &Self, epsilon: f32) -> bool {
                let alike = |x: &Vector3<f32>, y: &Vector3<f32>| x.abs_diff_eq(y, epsilon);
                let ($a, $b) = (self, other);
                $also $(&& all_alike({ let $value = self; $part }, { let $value = other; $part }, alike))+
            }
        }

        impl RelativeEq for $type {
            fn default_max_relative() -> f32 {
                f32::default_max_relative()
            }
            fn relative_eq(&self, other: &Self, epsilon: f32, max_relative: f32) -> bool {
                let alike = |x: &Vector3<f32>, y: &Vector3<f32>| x.relative_eq(y, epsilon, max_relative);
                let ($a, $b) = (self, other);
                $also $(&& all_alike({ let $value = self; $part }, { let $value = other; $part }, alike))+
            }
        }
    };
}

approx_by_vectors!(LocalFrame, |f| [[&f.tangent], [&f.bitangent], [&f.normal]], |_a, _b| true);
approx_by_vectors!(Bounds, |b| [[&b.min], [&b.max]], |_a, _b| true);
approx_by_vectors!(Mesh, |m| [&m.positions, &m.normals, &m.tangents], |a, b| a.faces == b.faces
    && a.origin == b.origin);
