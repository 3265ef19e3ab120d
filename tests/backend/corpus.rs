//! What every method for distant light per vertex promises. A method joins by a line at the end of this file and by
//! saying how it is baked and what it does when it leaves nothing out ([`Method`]).

use std::fmt::Debug;
use std::sync::Arc;

use haarmonic::Error;
use haarmonic::backend::{DistantRelighter, Freedom, block_product, wavelet_double, wavelet_triple};
use haarmonic::compress::ScanOrder;
use haarmonic::haar::{Keep, Weighting};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    BinaryVisibility, Brdf, BrdfFn, Comparison, EnvironmentLight, GroundTruth, Lambert, Materials, Mesh, Phong,
    Procedural, Sky, Sum, TexelVisibility, View, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};
use haarmonic::store::{Kind, Stored};

type Light = CubeMap<Vector3<f32>>;
type Radiance = Vec<Vector3<f32>>;

/// A scene without light.
struct Stage {
    mesh: Mesh,
    visibility: BinaryVisibility,
    view: View,
    materials: Materials,
}

/// A material with a colour, one without, one that is no lobe at all.
fn materials(part: &[u32]) -> Materials {
    let red: Arc<dyn Brdf> = Arc::new(Lambert::new([0.7, 0.2, 0.1]).unwrap());
    let gloss: Arc<dyn Brdf> = Arc::new(Phong::new([0.3, 0.3, 0.3], 20.0).unwrap());
    let both: Arc<dyn Brdf> = Arc::new(Sum::new(vec![(1.0, red.clone()), (1.0, gloss.clone())]).unwrap());
    Materials::new(vec![red, both, gloss], part.to_vec()).unwrap()
}

impl Stage {
    fn new(side: usize) -> Self {
        let model = Procedural::StackedSpheres.build(1000).unwrap();
        let parts: Vec<u32> = model.parts.iter().map(|&part| u32::from(part) % 3).collect();
        Self::of(model.mesh, side, materials(&parts))
    }

    fn of(mesh: Mesh, side: usize, materials: Materials) -> Self {
        let baker = VisibilityBaker::new(&mesh, CubeGrid::new(side).unwrap(), VisibilitySettings::default()).unwrap();
        let visibility = baker.bake(&()).unwrap();
        Self { mesh, visibility, view: View::eye(Vector3::new(2.0, 3.0, 5.0)).unwrap(), materials }
    }

    fn sky(&self, sky: Sky) -> Light {
        EnvironmentLight::from_sky(sky).unwrap().to_cube(self.visibility.grid())
    }

    fn truth(&self, light: &Light) -> Vec<Vector3<f64>> {
        let Self { mesh, materials, view, visibility } = self;
        GroundTruth { mesh, materials, view, light }.radiance(&TexelVisibility::Binary(visibility), &()).unwrap()
    }

    fn frame(&self, relighter: &mut dyn DistantRelighter, light: &Light) -> Radiance {
        relighter.set_light(light).unwrap();
        let mut out = vec![Vector3::repeat(f32::NAN); self.mesh.positions().len()];
        relighter.relight(&self.view, &self.materials, &mut out).unwrap();
        out
    }
}

/// A method, as it is when it leaves nothing out.
trait Method {
    type Transport: Stored + PartialEq + Debug + Send;
    const KIND: Kind;
    const FREEDOM: Freedom;
    /// The relative L2 difference from ground truth that rounding makes; some three times what was measured.
    const ROUNDING: f64;
    fn bake(stage: &Stage) -> Self::Transport;
    fn relighter<'a>(stage: &'a Stage, transport: &'a Self::Transport) -> Box<dyn DistantRelighter + 'a>;
}

struct WaveletDouble;

impl Method for WaveletDouble {
    type Transport = wavelet_double::Transport;
    const KIND: Kind = Kind::WaveletDouble;
    const FREEDOM: Freedom = Freedom::Light;
    const ROUNDING: f64 = 1e-6;

    fn bake(stage: &Stage) -> Self::Transport {
        let settings = wavelet_double::BakeSettings { tolerance: 0.0, precision: wavelet_double::Precision::Full };
        wavelet_double::Transport::bake(&stage.mesh, &stage.visibility, &stage.view, &stage.materials, settings, &())
            .unwrap()
    }

    fn relighter<'a>(_: &'a Stage, transport: &'a Self::Transport) -> Box<dyn DistantRelighter + 'a> {
        let settings = wavelet_double::Settings { light_terms: Keep::Fraction(1.0), weighting: Weighting::Magnitude };
        Box::new(wavelet_double::Relighter::new(transport, settings).unwrap())
    }
}

struct WaveletTriple;

impl Method for WaveletTriple {
    type Transport = wavelet_triple::Transport;
    const KIND: Kind = Kind::WaveletTriple;
    const FREEDOM: Freedom = Freedom::LightViewMaterials;
    const ROUNDING: f64 = 1e-6;

    fn bake(stage: &Stage) -> Self::Transport {
        wavelet_triple::Transport::from_binary(stage.visibility.clone()).unwrap()
    }

    fn relighter<'a>(stage: &'a Stage, transport: &'a Self::Transport) -> Box<dyn DistantRelighter + 'a> {
        let all = Keep::Fraction(1.0);
        let settings = wavelet_triple::Settings { light_terms: all, brdf_terms: all, ..Default::default() };
        Box::new(wavelet_triple::Relighter::new(&stage.mesh, transport, settings).unwrap())
    }
}

struct BlockProduct;

impl Method for BlockProduct {
    type Transport = block_product::Transport;
    const KIND: Kind = Kind::BlockProduct;
    const FREEDOM: Freedom = Freedom::LightViewMaterials;
    const ROUNDING: f64 = 1e-6;

    fn bake(stage: &Stage) -> Self::Transport {
        let grid = stage.visibility.grid();
        let layout = block_product::BlockLayout::new(grid, 8, ScanOrder::Serpentine).unwrap();
        block_product::Transport::from_binary(&stage.mesh, &stage.visibility, &layout).unwrap()
    }

    fn relighter<'a>(stage: &'a Stage, transport: &'a Self::Transport) -> Box<dyn DistantRelighter + 'a> {
        let settings = block_product::Settings { rule: block_product::Rule::Pixels, ..Default::default() };
        Box::new(block_product::Relighter::new(&stage.mesh, transport, settings).unwrap())
    }
}

fn difference(truth: &[Vector3<f64>], radiance: &[Vector3<f32>]) -> f64 {
    Comparison::new(truth, radiance).unwrap().rel_l2
}

fn it_is_the_ground_truth_with_nothing_left_out<M: Method>() {
    for side in [8, 16] {
        let stage = Stage::new(side);
        let (transport, light) = (M::bake(&stage), stage.sky(Sky::studio()));
        let mut relighter = M::relighter(&stage, &transport);
        assert_eq!((relighter.vertices(), relighter.grid().side()), (stage.mesh.positions().len(), side));
        assert_eq!(relighter.freedom(), M::FREEDOM);
        let error = difference(&stage.truth(&light), &stage.frame(&mut *relighter, &light));
        assert!(error < M::ROUNDING, "side {side}: {error:e}");
    }
}

fn it_is_linear_in_the_light<M: Method>() {
    let stage = Stage::new(8);
    let transport = M::bake(&stage);
    let mut relighter = M::relighter(&stage, &transport);
    let (one, other) = (stage.sky(Sky::studio()), stage.sky(Sky::default()));
    // Light may be taken away, too.
    let both = one.zip_map(&other, |a, b| a * 2.0 - b);
    let [one, other, both] = [&one, &other, &both].map(|light| stage.frame(&mut *relighter, light));
    let sum: Vec<Vector3<f64>> = one.iter().zip(&other).map(|(a, b)| a.cast() * 2.0 - b.cast()).collect();
    let error = difference(&sum, &both);
    assert!(error < 3.0 * M::ROUNDING, "{error:e}");
    assert!(both.iter().any(|l| l.min() < 0.0), "some of it is negative");
}

fn lights_that_are_dark_or_not_finite<M: Method>() {
    let stage = Stage::new(8);
    let transport = M::bake(&stage);
    let mut relighter = M::relighter(&stage, &transport);
    let mut out = vec![Vector3::repeat(f32::NAN); stage.mesh.positions().len()];
    relighter.relight(&stage.view, &stage.materials, &mut out).unwrap();
    assert!(out.iter().all(|l| *l == Vector3::zeros()), "there is no light yet");
    let light = stage.sky(Sky::studio());
    let lit = stage.frame(&mut *relighter, &light);
    assert!(lit.iter().any(|l| l.min() > 0.0));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut refused = light.clone();
        refused.texels_mut()[100].z = bad;
        assert!(matches!(relighter.set_light(&refused), Err(Error::NotFinite { index: 100, .. })), "{bad}");
    }
    let other = CubeMap::from_fn(CubeGrid::new(4).unwrap(), |_| Vector3::repeat(1.0));
    assert!(matches!(relighter.set_light(&other), Err(Error::Length { expected: 8, got: 4, .. })));
    relighter.relight(&stage.view, &stage.materials, &mut out).unwrap();
    assert_eq!(out, lit, "what is refused leaves the light before");
    let dark = stage.frame(&mut *relighter, &light.map(|_| Vector3::zeros()));
    assert!(dark.iter().all(|l| *l == Vector3::zeros()));
    let brightest = stage.frame(&mut *relighter, &light.map(|_| Vector3::repeat(f32::MAX)));
    assert!(brightest.iter().all(|l| l.iter().all(|c| c.is_finite())));
}

fn frames_that_do_not_fit_are_refused<M: Method>() {
    let stage = Stage::new(8);
    let transport = M::bake(&stage);
    let mut relighter = M::relighter(&stage, &transport);
    relighter.set_light(&stage.sky(Sky::default())).unwrap();
    let vertices = stage.mesh.positions().len();
    let mut out = vec![Vector3::zeros(); vertices];
    let few = materials(&vec![0; vertices - 1]);
    assert!(matches!(relighter.relight(&stage.view, &few, &mut out), Err(Error::Length { .. })));
    let from_the_side = View::towards(Vector3::new(1.0, 0.2, 0.0)).unwrap();
    let other_view = relighter.relight(&from_the_side, &stage.materials, &mut out);
    match M::FREEDOM {
        Freedom::Light => assert_eq!(other_view, Err(Error::Baked { what: "view" })),
        _ => assert_eq!(other_view, Ok(())),
    }
    if M::FREEDOM == Freedom::LightViewMaterials {
        let nan = Materials::uniform(BrdfFn::new(|_: &Vector3<f64>, _: &Vector3<f64>| Vector3::repeat(f64::NAN)));
        let refused = relighter.relight(&stage.view, &nan, &mut out);
        assert!(matches!(refused, Err(Error::NotFinite { index: 0, .. })), "{refused:?}");
    }
    let length = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let _ = relighter.relight(&stage.view, &stage.materials, &mut out[1..]);
    }));
    assert!(length.is_err(), "one vertex too few");
}

fn a_lone_triangle<M: Method>() {
    let corners = vec![Vector3::zeros(), Vector3::z(), Vector3::x()];
    for vertices in [0, 1] {
        let none = Mesh::new(corners[..vertices].to_vec(), Vec::new());
        assert!(matches!(none, Err(Error::Empty { .. })), "a mesh has a face");
    }
    let stage = Stage::of(Mesh::new(corners, vec![[0, 1, 2]]).unwrap(), 8, materials(&[1; 3]));
    let (transport, light) = (M::bake(&stage), stage.sky(Sky::default()));
    let out = stage.frame(&mut *M::relighter(&stage, &transport), &light);
    let error = difference(&stage.truth(&light), &out);
    assert!(error < 3.0 * M::ROUNDING, "{error:e}");
    let mut bytes = Vec::new();
    transport.write_to(&mut bytes).unwrap();
    assert_eq!(M::Transport::read_from(&bytes[..]).unwrap(), transport);
}

fn any_number_of_threads_gives_the_same_bits<M: Method>() {
    let stage = Stage::new(8);
    let light = stage.sky(Sky::studio());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let transport = M::bake(&stage);
            let frame = stage.frame(&mut *M::relighter(&stage, &transport), &light);
            (transport, frame)
        })
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}

fn frames_allocate_nothing_after_the_first<M: Method>() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| {
        let stage = Stage::new(8);
        let (transport, light) = (M::bake(&stage), stage.sky(Sky::studio()));
        let mut relighter = M::relighter(&stage, &transport);
        let mut out = stage.frame(&mut *relighter, &light);
        for frame in 0..3 {
            let relight = || relighter.relight(&stage.view, &stage.materials, &mut out).unwrap();
            assert_eq!(allocation_counter::measure(relight).count_total, 0, "frame {frame}");
        }
    });
}

fn it_survives_a_file_and_damaged_files_are_refused<M: Method>() {
    let stage = Stage::of(
        Procedural::StackedSpheres.build(1000).unwrap().mesh,
        8,
        Materials::uniform(Lambert::new([0.5; 3]).unwrap()),
    );
    let transport = M::bake(&stage);
    assert_eq!(M::Transport::kind(), M::KIND);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("transport.bin");
    transport.save(&path).unwrap();
    assert_eq!(Kind::of(&path), Ok(M::KIND));
    let loaded = M::Transport::load(&path).unwrap();
    assert_eq!(loaded, transport);
    let light = stage.sky(Sky::default());
    let [before, after] =
        [&transport, &loaded].map(|transport| stage.frame(&mut *M::relighter(&stage, transport), &light));
    assert!(before == after);
    let good = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8], what: &str| match M::Transport::read_from(bytes) {
        Err(Error::File { .. }) => {}
        other => panic!("{what}: {:?}", other.map(drop)),
    };
    for cut in (0..64).chain((64..good.len()).step_by(good.len() / 50)) {
        refused(&good[..cut], "cut short");
    }
    for bit in (0..8 * 64).chain((8 * 64..8 * good.len()).step_by(good.len() / 6)) {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        refused(&bad, "a flipped bit");
    }
    refused(&[&good[..], b"more"].concat(), "followed by more");
    let absent = M::Transport::load(folder.path().join("absent")).unwrap_err().to_string();
    assert!(absent.contains("absent") && absent.contains("cannot be opened"), "{absent}");
}

macro_rules! corpus {
    ($($module:ident: $method:ident;)*) => {$(
        mod $module {
            use super::super::$method;

            #[test]
            fn it_is_the_ground_truth_with_nothing_left_out() {
                super::super::it_is_the_ground_truth_with_nothing_left_out::<$method>();
            }
            #[test]
            fn it_is_linear_in_the_light() {
                super::super::it_is_linear_in_the_light::<$method>();
            }
            #[test]
            fn lights_that_are_dark_or_not_finite() {
                super::super::lights_that_are_dark_or_not_finite::<$method>();
            }
            #[test]
            fn frames_that_do_not_fit_are_refused() {
                super::super::frames_that_do_not_fit_are_refused::<$method>();
            }
            #[test]
            fn a_lone_triangle() {
                super::super::a_lone_triangle::<$method>();
            }
            #[test]
            fn any_number_of_threads_gives_the_same_bits() {
                super::super::any_number_of_threads_gives_the_same_bits::<$method>();
            }
            #[test]
            fn frames_allocate_nothing_after_the_first() {
                super::super::frames_allocate_nothing_after_the_first::<$method>();
            }
            #[test]
            fn it_survives_a_file_and_damaged_files_are_refused() {
                super::super::it_survives_a_file_and_damaged_files_are_refused::<$method>();
            }
        }
    )*};
}

mod every_method_keeps {
    corpus! {
        wavelet_double: WaveletDouble;
        wavelet_triple: WaveletTriple;
        block_product: BlockProduct;
    }
}
