//! Files of wavelet double products that contradict themselves, put together by hand.

use haarmonic::Result;
use haarmonic::backend::wavelet_double::{Relighter, Settings, Transport};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Lambert, Materials, View};
use haarmonic::sphere::{CubeGrid, CubeMap};
use haarmonic::store::Stored;

/// A transport of two vertices on a cube map of side 4.
struct File {
    view: (u8, [f64; 3]),
    weights: [f32; 9],
    starts: Vec<u32>,
    values: [f32; 5],
}

impl Default for File {
    fn default() -> Self {
        Self { view: (0, [0.0; 3]), weights: [0.5; 9], starts: vec![0, 2, 3, 5], values: [1.0, 2.0, -1.0, 0.5, 3.0] }
    }
}

impl File {
    fn read(&self) -> Result<Transport> {
        let list = |len: usize, bytes: Vec<u8>| [&(len as u64).to_le_bytes()[..], &bytes].concat();
        let view = [&[self.view.0][..], &self.view.1.map(f64::to_le_bytes).concat()].concat();
        let size = [&[4_u64, 2].map(u64::to_le_bytes).concat()[..], &view].concat();
        let block = [
            list(3, [0_u16, 1, 1].map(u16::to_le_bytes).concat()),
            list(9, self.weights.map(f32::to_le_bytes).concat()),
            list(3, [0_u32, 5, 40].map(u32::to_le_bytes).concat()),
            list(self.starts.len(), self.starts.iter().flat_map(|start| start.to_le_bytes()).collect()),
            list(5, [0_u16, 1, 2, 1, 0].map(u16::to_le_bytes).concat()),
            vec![32],
            self.values.map(f32::to_le_bytes).concat(),
        ]
        .concat();
        let section = |tag: &[u8; 4], bytes: &[u8]| [&tag[..], &(bytes.len() as u64).to_le_bytes(), bytes].concat();
        let head = [&b"haarmonic\0WDBL"[..], &Transport::kind().version().to_le_bytes()].concat();
        let mut file = [head, section(b"SIZE", &size), section(b"BLOK", &block), section(b"END.", &[])].concat();
        // The last section has a checksum of 4 bytes, of all that is before it.
        let at = file.len() - 8;
        file[at] = 4;
        file.extend(crc32fast::hash(&file).to_le_bytes());
        Transport::read_from(&file[..])
    }

    #[track_caller]
    fn refused(&self, message: &str) {
        let error = self.read().unwrap_err().to_string();
        assert!(error.starts_with("stream, byte ") && error.contains(message), "{error}");
    }

    fn lit(&self, light: f32) -> Vec<Vector3<f32>> {
        let transport = self.read().unwrap();
        let settings = Settings { light_terms: Keep::Fraction(1.0), ..Settings::default() };
        let mut relighter = Relighter::new(&transport, settings).unwrap();
        // No two texels are alike, so that no coefficient is 0.
        let texel = |i: usize| Vector3::repeat(light * ((1 + i * i % 89) as f32 / 89.0));
        let texels = (0..96).map(texel).collect();
        relighter.set_light(&CubeMap::new(CubeGrid::new(4).unwrap(), texels).unwrap()).unwrap();
        let (view, materials) = (View::towards(Vector3::y()), Materials::uniform(Lambert::new([0.5; 3]).unwrap()));
        let mut out = vec![Vector3::repeat(f32::NAN); 2];
        relighter.relight(&view.unwrap(), &materials, &mut out).unwrap();
        out
    }
}

#[test]
fn every_column_has_a_start() {
    assert!(File::default().read().is_ok());
    for starts in [vec![0, 5], vec![0, 2, 5], vec![0, 2, 3, 4, 5], vec![]] {
        File { starts, ..File::default() }.refused("a block contradicts itself: there is not one start a column");
    }
    File { starts: vec![0, 3, 2, 5], ..File::default() }.refused("a column ends before it starts");
    File { starts: vec![0, 2, 3, 4], ..File::default() }.refused("columns do not begin and end where their rows do");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = File::default();
        file.values[3] = bad;
        file.refused("a value is NaN or infinite");
        let mut file = File::default();
        file.weights[8] = bad;
        file.refused("a weight is NaN or infinite");
    }
}

#[test]
fn there_is_no_place_without_a_view() {
    for place in [1.0, -0.0, f64::NAN] {
        File { view: (0, [0.0, place, 0.0]), ..File::default() }.refused("has the place of a view, but no view");
    }
}

/// Sums that leave `f32` end at its largest number, with their sign, and none is NaN.
#[test]
fn radiance_beyond_the_range_is_its_end() {
    let moderate = File::default().lit(1.0);
    for (scale, light) in [(f32::MAX / 4.0, 1.0), (f32::MAX / 4.0, f32::MAX), (1e30, 1e20)] {
        let file = File { values: File::default().values.map(|x| x * scale), ..File::default() };
        for (out, moderate) in file.lit(light).iter().zip(&moderate) {
            for c in 0..3 {
                assert_eq!(out[c].signum(), moderate[c].signum());
                assert!(out[c].is_finite() && out[c].abs() > 1e35, "{} at {scale}, {light}", out[c]);
            }
        }
    }
}
