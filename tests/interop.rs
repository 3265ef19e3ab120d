//! What other crates can do with the types of this one: `serde`, `bytemuck`, `mint`.

use haarmonic::nalgebra::Vector3;
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap};

/// A map of no two texels alike.
#[cfg(any(feature = "serde", feature = "bytemuck"))]
fn cube() -> CubeMap<Vector3<f32>> {
    CubeMap::from_fn(CubeGrid::new(2).unwrap(), |d| d.map(|x| x as f32) * 1.25)
}

#[cfg(any(feature = "serde", feature = "bytemuck"))]
fn lat_long() -> LatLongMap<f64> {
    LatLongMap::from_fn(LatLongGrid::new(3, 2).unwrap(), |d| d.x - 2.0 * d.y)
}

#[cfg(feature = "serde")]
mod serde {
    use std::fmt::Debug;

    use ::serde::Serialize;
    use ::serde::de::DeserializeOwned;
    use haarmonic::affine::{AffineMap, Filter, ImageRoute, Kernel, WaveletImage, ZoomWindow};
    use haarmonic::compress::{BiclusterSettings, Centre, PcaSettings, ScanOrder, Seeds};
    use haarmonic::haar::{ChannelRule, Decomposition, Keep, ScalingTerms, SparseVector};
    use haarmonic::sh::{Convention, DiffuseProbe, ExpMethod, Window};
    use haarmonic::sphere::{Axes, Face, LatLongConvention, Resampling, SignedAxis};
    use serde_json::{Value, from_value, json, to_value};

    use super::*;

    /// There and back, through the value that is expected in between.
    #[track_caller]
    fn stored<T: Serialize + DeserializeOwned + PartialEq + Debug>(what: &T, as_value: Value) {
        assert_eq!(to_value(what).unwrap(), as_value);
        assert_eq!(&from_value::<T>(as_value).unwrap(), what);
    }

    #[track_caller]
    fn refused<T: DeserializeOwned + Debug>(value: Value, why: &str) {
        let error = from_value::<T>(value).expect_err("it must be refused").to_string();
        assert!(error.contains(why), "{error}");
    }

    #[test]
    fn conventions_and_choices() {
        let fuma = json!({
            "phase": "Plain", "normalization": "FurseMalham", "layout": "FurseMalham", "axes": ["NegZ", "NegX", "PosY"],
        });
        stored(&Convention::FUMA, fuma);
        stored(&Axes::RIGHT_HANDED_Z_UP, json!(["PosX", "NegZ", "PosY"]));
        refused::<Axes>(json!(["PosX", "NegX", "PosY"]), "axis must be at right angles");
        refused::<Axes>(json!(["PosX", "PosY"]), "length");
        stored(&[SignedAxis::NegY], json!(["NegY"]));
        stored(&DiffuseProbe::Unity, json!("Unity"));
        stored(&LatLongConvention::PbrtV3, json!("PbrtV3"));
        refused::<LatLongConvention>(json!("PbrtV4"), "unknown variant");
        stored(&(Face::NegY, Resampling::Area), json!(["NegY", "Area"]));
        stored(&(Decomposition::Standard, ScalingTerms::Compete), json!(["Standard", "Compete"]));
        stored(&ChannelRule::Norm, json!("Norm"));
    }

    #[test]
    fn settings() {
        stored(&Keep::Terms(246), json!({ "Terms": 246 }));
        stored(&Keep::Fraction(0.5), json!({ "Fraction": 0.5 }));
        refused::<Keep>(json!({ "Fraction": 1.5 }), "in [0, 1]");
        stored(&AffineMap::new(-0.5, 0.25).unwrap(), json!({ "scale": -0.5, "offset": 0.25 }));
        refused::<AffineMap>(json!({ "scale": 0.0, "offset": 0.25 }), "not zero");
        let seeds = BiclusterSettings::default().with_seeds(Seeds::Random(7)).with_group_rows(8);
        stored(&seeds, json!({ "seeds": { "Random": 7 }, "group_rows": 8 }));
        refused::<BiclusterSettings>(json!({ "seeds": "First", "group_rows": 0 }), "at least 1");
        stored(&ExpMethod::Series { degree: 3 }, json!({ "Series": { "degree": 3 } }));
        stored(&Window::Hanning { width: 4.5 }, json!({ "Hanning": { "width": 4.5 } }));
        stored(&(Filter::LinearFixed(8), ScanOrder::Hilbert), json!([{ "LinearFixed": 8 }, "Hilbert"]));
        let pca = PcaSettings::new(3).with_centre(Centre::Origin);
        assert_eq!(from_value::<PcaSettings>(to_value(pca).unwrap()).unwrap(), pca);
    }

    #[test]
    fn compressed_images() {
        let image = WaveletImage::new([3, 2], vec![0, 5], vec![[1.0, 2.0], [0.5, 0.0]]).unwrap();
        let value = json!({ "width": 3, "height": 2, "indices": [0, 5], "channels": [[1.0, 0.5], [2.0, 0.0]] });
        stored(&image, value.clone());
        refused::<WaveletImage<f64, 3>>(value.clone(), "channels of an image: expected 3");
        let with = |key: &str, part: Value| {
            let mut value = value.clone();
            value[key] = part;
            value
        };
        refused::<WaveletImage<f64, 2>>(with("channels", json!([[1.0, 0.5], [2.0]])), "values of a channel");
        refused::<WaveletImage<f64, 2>>(with("indices", json!([5, 0])), "above the index before it");
        refused::<WaveletImage<f64, 2>>(with("indices", json!([0, 8])), "below the area of the grid");
        refused::<WaveletImage<f64, 2>>(with("width", json!(0)), "empty");
        refused::<WaveletImage<f64, 2>>(with("height", json!(1 << 20)), "at most 32768");
        stored(&Kernel::from_taps(-1, &[0.5, 0.25]).unwrap(), json!({ "first": -1, "taps": [0.5, 0.25] }));
        refused::<Kernel>(json!({ "first": 0, "taps": [] }), "empty");
        let map = json!({ "scale": 0.5, "offset": 0.25 });
        stored(&ZoomWindow::new([0.5; 2], [2.0; 2]).unwrap(), json!({ "maps": [map, map] }));
        refused::<ZoomWindow>(json!({ "maps": [map, { "scale": 0.0, "offset": 0.0 }] }), "not zero");
        stored(&ImageRoute::Pixels, json!("Pixels"));
    }

    #[test]
    fn cube_maps() {
        let map = cube();
        let value = to_value(&map).unwrap();
        assert_eq!(value["grid"], 2);
        assert_eq!(value["texels"].as_array().unwrap().len(), 24);
        stored(&map, value.clone());
        stored(&map.grid(), json!(2));
        refused::<CubeGrid>(json!(0), "cube map side");
        refused::<CubeGrid>(json!(1 << 20), "cube map side");
        // One texel too few or too many, and a side that is not there.
        let mut short = value.clone();
        short["texels"].as_array_mut().unwrap().pop();
        refused::<CubeMap<Vector3<f32>>>(short, "cube map texels: expected 24, got 23");
        let mut long = value.clone();
        long["texels"].as_array_mut().unwrap().push(json!([0.0, 0.0, 0.0]));
        refused::<CubeMap<Vector3<f32>>>(long, "expected 24, got 25");
        let mut huge = value.clone();
        huge["grid"] = json!(1 << 14);
        refused::<CubeMap<Vector3<f32>>>(huge, "cube map texels");
        // What is not a number is not a texel: JSON writes NaN as null.
        let mut gap = value;
        gap["texels"][3] = json!([0.0, null, 0.0]);
        refused::<CubeMap<Vector3<f32>>>(gap, "null");
    }

    #[test]
    fn lat_long_maps() {
        let map = lat_long();
        let value = to_value(&map).unwrap();
        assert_eq!(value["grid"], json!([3, 2]));
        assert_eq!(value.as_object().unwrap().len(), 2, "the means at the poles are computed");
        stored(&map, value.clone());
        refused::<LatLongGrid>(json!([3, 0]), "lat-long height");
        let mut short = value;
        short["pixels"].as_array_mut().unwrap().pop();
        refused::<LatLongMap<f64>>(short, "lat-long pixels: expected 6, got 5");
    }

    #[test]
    fn sparse_vectors() {
        let vector = SparseVector::new(9, vec![1, 4], vec![0.5f32, -2.0]).unwrap();
        stored(&vector, json!({ "len": 9, "indices": [1, 4], "values": [0.5, -2.0] }));
        stored(&SparseVector::<f64>::default(), json!({ "len": 0, "indices": [], "values": [] }));
        refused::<SparseVector<f32>>(json!({ "len": 9, "indices": [4, 1], "values": [1.0, 2.0] }), "sparse index");
        refused::<SparseVector<f32>>(json!({ "len": 4, "indices": [1, 4], "values": [1.0, 2.0] }), "sparse index");
        refused::<SparseVector<f32>>(json!({ "len": 9, "indices": [1, 4], "values": [1.0] }), "sparse values");
    }
}

#[cfg(feature = "bytemuck")]
#[test]
fn maps_and_coefficients_as_bytes() {
    use haarmonic::nalgebra::Complex;

    // Three floats a texel, without gaps: what an upload to a buffer wants.
    let map = cube();
    let floats: &[f32] = bytemuck::cast_slice(map.texels());
    assert_eq!(floats.len(), 3 * map.texels().len());
    assert!(map.texels().iter().zip(floats.chunks_exact(3)).all(|(texel, floats)| texel.as_slice() == floats));
    let bytes: &[u8] = bytemuck::cast_slice(map.texels());
    assert_eq!(bytes[4..8], map.texels()[0].y.to_ne_bytes());
    assert_eq!(bytemuck::cast_slice::<_, u8>(lat_long().pixels()).len(), 6 * 8);
    // And back, from what was read from a buffer.
    let texels = bytes.chunks_exact(12).map(bytemuck::pod_read_unaligned::<Vector3<f32>>).collect();
    assert_eq!(CubeMap::new(map.grid(), texels).unwrap(), map);
    let complex = haarmonic::sh::to_complex(2, &[1.0f32, 2.0, 3.0, 4.0]);
    assert_eq!(bytemuck::cast_slice::<Complex<f32>, f32>(&complex)[0], 1.0);
}

/// Any crate that speaks mint, here the present glam: no version of it is named by this crate.
#[cfg(feature = "mint")]
#[test]
fn glam_comes_and_goes_through_mint() {
    use haarmonic::nalgebra::{Matrix3, Rotation3, UnitQuaternion};
    use haarmonic::sphere::LatLongConvention;

    let direction = glam::DVec3::new(1.0, 2.0, 3.0);
    let ours = Vector3::from(mint::Vector3::from(direction));
    assert_eq!(ours, Vector3::new(1.0, 2.0, 3.0));
    let mint: mint::Vector3<f64> = ours.into();
    assert_eq!(glam::DVec3::from(mint), direction);
    // Rotations: columns stay columns, and a quaternion's real part its real part.
    let turn = LatLongConvention::ThreeJs.rotation();
    let columns: mint::ColumnMatrix3<f64> = (*turn.matrix()).into();
    let matrix = glam::DMat3::from(columns);
    assert_eq!((matrix * glam::DVec3::NEG_Z).to_array(), <[f64; 3]>::from(turn * -Vector3::z()));
    let back = Matrix3::from(mint::ColumnMatrix3::from(matrix));
    assert_eq!(Rotation3::from_matrix_unchecked(back), turn);
    let quaternion = glam::DQuat::from_rotation_y(0.5);
    let ours = UnitQuaternion::from_quaternion(mint::Quaternion::from(quaternion).into());
    let gap = ours * Vector3::x() - Vector3::from(mint::Vector3::from(quaternion * glam::DVec3::X));
    assert!(gap.norm() < 1e-15, "{gap}");
    let texel = glam::Vec3::new(0.25, 0.5, 1.0);
    let map = CubeMap::new(CubeGrid::new(1).unwrap(), vec![Vector3::from(mint::Vector3::from(texel)); 6]).unwrap();
    assert_eq!(map.nearest(&Vector3::x()).z, texel.z);
    let image = LatLongMap::new(LatLongGrid::new(1, 1).unwrap(), vec![1.0f32]).unwrap();
    assert_eq!(image.pixels(), [1.0]);
}
